//! Moment of the boom cylinders as a measurement of the filter.
//!
//! Its model is [`crate::excavator::measurements::boom_moment`]. [`model`] predicts and updates, [`swinging`] observes a
//! load on a hook. This file initialises the states, and finds measurements that do not fit the load.

mod model;
mod swinging;

use self::swinging::Watched;
use super::bucket::Content;
use super::filter::{Filter, HELD, REST, SPAN, ZERO};
use super::trail::Trail;
use crate::excavator::cylinder::Cylinder;
use crate::excavator::drive::Drive;
use crate::excavator::measurements::boom_moment::{BoomMoment, Front, Moment};
use crate::excavator::settings::Settings;
use crate::kalman::Innovation;
use crate::math::sqrt;

/// Gate of the innovation [standard deviations]: a measurement beyond it is not of the expected load.
const GATE: f64 = 4.0;
/// Number of consecutive measurements beyond the gate that indicates another load. No digging is needed: a hook takes a load too.
pub(super) const LASTS: u32 = 5;
/// Time for which a measurement is valid \[s\].
const HOLDS: f64 = 1.0;
/// Time without pressures after which they count as missing \[s\].
const GONE: f64 = 10.0;
/// Share of the rated payload below which nothing in the bucket or on the hook can swing.
const EMPTY: f64 = 0.1;

/// Returns whether an innovation lies within the gate: the measurement is of the expected load.
pub(super) fn fits(innovation: Innovation) -> bool {
    innovation.nis() < GATE * GATE
}

/// Load measurement by the boom pressures: the second witness beside the torque.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Weigh {
    cylinder: Cylinder,
    moments: BoomMoment,
    /// The pressure states have their described values and variances.
    begun: bool,
    watched: Watched,
    /// Covariance of the moments of consecutive blocks while the machine stands, as shares of the moment.
    wavering: f64,
    /// Number of consecutive innovations beyond the gate.
    strange: u32,
    /// The last measurement was beyond the gate, or the first one of another load: that one fits any load.
    misfits: bool,
    /// The load is another one, and no measurement has confirmed it.
    unconfirmed: bool,
    /// The bucket has opened before.
    opened: bool,
    /// Angle of the bucket at the last measurement within the gate \[rad\].
    angle: f64,
    /// That angle did not change while the load left.
    frozen: bool,
    /// Time since the last measurement within the gate \[s\].
    age: f64,
}

impl Weigh {
    pub(super) fn new(cylinder: Cylinder) -> Self {
        Self {
            cylinder,
            moments: BoomMoment::new(),
            begun: false,
            watched: Watched::default(),
            wavering: 0.0,
            strange: 0,
            misfits: false,
            unconfirmed: false,
            opened: false,
            angle: f64::NAN,
            frozen: false,
            age: f64::INFINITY,
        }
    }

    /// Returns whether the source has pressures.
    pub(super) fn is_there(&self) -> bool {
        self.begun
    }

    /// Returns whether the pressures have been missing for long.
    pub(super) fn is_gone(&self) -> bool {
        self.moments.unread() > GONE
    }

    /// Returns whether the load was weighed just now.
    pub(super) fn is_fresh(&self) -> bool {
        self.age < HOLDS
    }

    /// Returns whether the last measurement does not fit: the load may be another one.
    pub(super) fn misfits(&self) -> bool {
        self.misfits && self.moments.unread() < HOLDS
    }

    /// Returns whether the bucket's angle repeats one value while the content changes.
    pub(super) fn is_frozen(&self) -> bool {
        self.frozen
    }

    /// Initialises the pressure states of the filters as described, at the first pressures. Then returns the standard deviations of span
    /// and zero.
    pub(super) fn begin(
        &mut self,
        drive: &Drive,
        filters: [&mut Filter; 3],
        trail: &mut Option<Trail>,
    ) -> Option<[f64; 2]> {
        if self.begun || drive.boom_pressure.is_none() {
            return None;
        }
        self.begun = true;
        let c = &self.cylinder;
        // The trail records the first filter.
        let (mut trail, mut none) = (trail, None);
        for filter in filters {
            for (i, std) in [
                (SPAN, c.span_std),
                (ZERO, c.zero_std),
                (REST, c.friction[0]),
            ] {
                filter.set(i, 0.0, std * std, trail);
            }
            filter.set(HELD, 0.0, c.held_variance(), trail);
            trail = &mut none;
            self.correlate(filter);
        }
        Some([c.span_std, c.zero_std])
    }

    /// Forgets what a gap may have changed: the cylinders may have moved, so that the rest of their friction is another.
    pub(super) fn goes_on(&mut self, filters: [&mut Filter; 3]) {
        (self.moments, self.age) = (BoomMoment::new(), f64::INFINITY);
        (self.wavering, self.frozen) = (0.0, false);
        if self.begun {
            let std = self.cylinder.friction[0];
            for filter in filters {
                filter.set(REST, 0.0, std * std, &mut None);
            }
        }
    }

    /// Correlates span and zero as a calibration has found their errors.
    pub(super) fn correlate(&self, filter: &mut Filter) {
        let c = &self.cylinder;
        let variances = filter.p[SPAN][SPAN] * filter.p[ZERO][ZERO];
        let together = c.correlation * sqrt(variances);
        (filter.p[SPAN][ZERO], filter.p[ZERO][SPAN]) = (together, together);
    }

    /// Processes one tick; returns the moment of a complete block. `turn`: sine and cosine of the swing angle; `velocity`: of the swing;
    /// `content`: its change; `opens`: the bucket opens; `touches`: the ground may carry part of it.
    pub(super) fn step(
        &mut self,
        settings: &Settings,
        drive: &Drive,
        (turn, velocity): ((f64, f64), f64),
        (content, opens, touches): (Content, bool, bool),
    ) -> Option<Moment> {
        if !self.begun {
            return None;
        }
        self.age += drive.period;
        if self.frozen && drive.posture[2] != self.angle {
            self.frozen = false;
        }
        self.opened |= opens;
        if touches {
            // A load on the ground no longer swings.
            self.forget();
        }
        let constant = content == Content::Unchanged && !opens;
        let front = Front {
            period: drive.period,
            posture: drive.posture,
            turns: drive.turns,
            posture_variance: drive.posture_variance,
            pressures: drive.boom_pressure,
            velocity,
            turn,
        };
        let moment = self.moments.step(
            &settings.geometry,
            &self.cylinder,
            &front,
            (constant, touches),
        )?;
        self.misfits = false;
        Some(moment)
    }

    /// Resets for another content of the bucket.
    pub(super) fn holds_another(&mut self) {
        self.forget();
        self.strange = 0;
        self.misfits = false;
    }

    /// Returns whether a load of this weight may have been set down, from an innovation in which the ground may carry part of it. A
    /// lowered hook or clamp leaves its load there. A bucket retains it, and weighs the same when lifted.
    pub(super) fn sets_down(
        &mut self,
        innovation: Innovation,
        (payload, rated): (f64, f64),
    ) -> bool {
        let lighter = innovation.value < 0.0 && !fits(innovation);
        if !lighter || payload < EMPTY * rated {
            self.strange = 0;
            return false;
        }
        self.strange = (self.strange + 1) % LASTS;
        self.strange == 0
    }

    /// Returns whether the load must be another one. `angle`: of the bucket \[rad\]. A bucket that has opened before, and whose angle
    /// repeats one value while its load leaves, has a frozen angle.
    pub(super) fn renews(&mut self, innovation: Innovation, angle: f64) -> bool {
        if fits(innovation) {
            self.age = 0.0;
            self.strange = 0;
            self.angle = angle;
            self.misfits = core::mem::take(&mut self.unconfirmed);
            return false;
        }
        self.misfits = true;
        self.strange = (self.strange + 1) % LASTS;
        let another = self.strange == 0;
        self.unconfirmed |= another;
        if another && innovation.value < 0.0 {
            self.frozen = self.opened && angle == self.angle;
        }
        another
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::excavator::keys::Description;

    pub(super) const MOMENT: f64 = 70e3;

    /// With one described cylinder.
    pub(super) fn described() -> Weigh {
        let mut d = Description::default();
        let c = &mut d.boom_cylinder;
        (c.count, c.head_area, c.rod_area) = (1.0, 0.01, 0.007);
        (c.base_distance, c.rod_distance) = (0.6, 1.3);
        Weigh::new(Cylinder::of_boom(&d).expect("a cylinder"))
    }

    /// One tick at a bucket angle [rad], with these pressures of the boom [Pa].
    fn tick(weigh: &mut Weigh, angle: f64, pressures: Option<[f64; 2]>) {
        let drive = Drive {
            period: 0.01,
            posture: [0.0, 0.0, angle],
            boom_pressure: pressures,
            ..Drive::default()
        };
        let settings = Settings::of(&Description::default());
        let motion = ((0.0, 1.0), 0.0);
        weigh.step(
            &settings,
            &drive,
            motion,
            (Content::Unchanged, false, false),
        );
    }

    /// An innovation of this many standard deviations.
    pub(super) fn innovation(value: f64) -> Innovation {
        Innovation {
            value,
            variance: 1.0,
        }
    }

    #[test]
    fn only_a_load_that_is_gone_for_a_second_was_set_down() {
        let mut weigh = described();
        let load = (800.0, 1000.0);
        // Every fourth block shows the full load: the ground carries part of it at times.
        for block in 0..40 {
            let value = if block % 4 == 3 { 0.0 } else { -10.0 };
            assert!(!weigh.sets_down(innovation(value), load), "{block}");
        }
        let gone = (0..LASTS).map(|_| weigh.sets_down(innovation(-10.0), load));
        assert_eq!(gone.filter(|gone| *gone).count(), 1);
        assert!((0..9).all(|_| !weigh.sets_down(innovation(-10.0), (20.0, 1000.0))));
    }

    #[test]
    fn another_weight_is_doubted_at_once_and_another_load_until_a_second_measurement_confirms_it() {
        let mut weigh = described();
        assert!(!weigh.renews(innovation(1.0), 0.0) && !weigh.misfits());
        for _ in 1..LASTS {
            assert!(!weigh.renews(innovation(-9.0), 0.0) && weigh.misfits());
        }
        assert!(weigh.renews(innovation(-9.0), 0.0) && weigh.misfits());
        weigh.holds_another();
        // The first measurement fits any load.
        assert!(!weigh.renews(innovation(1.0), 0.0) && weigh.misfits());
        assert!(!weigh.renews(innovation(1.0), 0.0) && !weigh.misfits());
        // Measurements beyond the gate count within one content.
        weigh.renews(innovation(-9.0), 0.0);
        weigh.holds_another();
        assert!(!weigh.misfits());
        assert!((1..LASTS).all(|_| !weigh.renews(innovation(-9.0), 0.0)));
    }

    #[test]
    fn a_bucket_that_opened_before_and_loses_its_load_without_turning_is_frozen() {
        let freezes = |opened: bool, turns: f64| {
            let mut weigh = described();
            weigh.opened = opened;
            weigh.renews(innovation(0.0), -1.5);
            (0..LASTS).for_each(|_| {
                weigh.renews(innovation(-9.0), -1.5 + turns);
            });
            let freezes = weigh.is_frozen();
            // It turns again, without pressures.
            weigh.begun = true;
            tick(&mut weigh, -1.4, None);
            assert!(!weigh.is_frozen());
            freezes
        };
        assert!(freezes(true, 0.0));
        assert!(!freezes(true, 0.01), "it turned");
        assert!(!freezes(false, 0.0), "a grapple: it never opened");
    }

    #[test]
    fn pressures_count_as_missing_after_a_while() {
        let mut weigh = described();
        weigh.begun = true;
        let mut gone_after = |seconds: u32, pressures| {
            (0..100 * seconds).for_each(|_| tick(&mut weigh, 0.0, pressures));
            weigh.is_gone()
        };
        assert!(!gone_after(20, Some([12e6, 1e6])));
        assert!(!gone_after(9, None));
        assert!(gone_after(2, None));
        assert!(!gone_after(1, Some([12e6, 1e6])));
    }
}

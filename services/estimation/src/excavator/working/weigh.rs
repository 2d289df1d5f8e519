//! Moment of the boom cylinders as a measurement of the filter.
//!
//! Its model is [`super::super::measurements::boom_moment`]. This module initialises the states of that model, and predicts the rest of
//! the friction. It also gates measurements that do not fit.

use super::super::cylinder::Cylinder;
use super::super::drive::Drive;
use super::super::measurements::boom_moment::{BoomMoment, Front, GRAVITY, Moment};
use super::super::settings::Settings;
use super::bucket::Content;
use super::filter::{BUCKET, Filter, GAIN, HELD, LINKS, M, N, REST, SLOPE, SPAN, ZERO};
use super::trail::Trail;
use crate::kalman::Innovation;
use crate::math::sqrt;

/// Standard deviation of the load's centre, as a share of its distance from the bucket pin.
const CENTRE: f64 = 0.12;
/// Time in which zero, span and held friction wander by their stated standard deviations \[s\].
const LASTING: f64 = 3600.0;
/// Gate of the innovation [standard deviations]: a measurement beyond it is not of the expected load.
const GATE: f64 = 4.0;
/// Number of consecutive measurements beyond the gate that indicates another load. No digging is needed: a hook takes a load too.
pub(super) const LASTS: u32 = 5;
/// Time for which a measurement is valid \[s\].
const HOLDS: f64 = 1.0;
/// Time without pressures after which they count as missing \[s\].
const GONE: f64 = 10.0;
/// Oscillation of the moment of a standing machine, as a share of it, above which the load swings. Loads that do not: at most .0015; one
/// on a hook: .0035 to .03.
const WAVERING: f64 = 0.003;
/// Time constant with which the oscillation is observed \[s\].
const WATCHED: f64 = 2.5;
/// Number of blocks in which joints that changed the content, and what swings with them, come to rest (0.6 s).
const SETTLES: u32 = 3;
/// Largest change of the load's lever from block to block during that observation \[m\].
const STILL: f64 = 0.02;
/// Share of the rated payload below which nothing in the bucket or on the hook can swing.
const EMPTY: f64 = 0.1;

/// Returns whether an innovation lies within the gate: the measurement is of the expected load.
pub(super) fn fits(innovation: Innovation) -> bool {
    innovation.nis() < GATE * GATE
}

/// Observation of the moment while the machine stands.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Watched {
    /// Content at the start of the stand \[kg\].
    payload: Option<f64>,
    /// Moment per kilogram of payload [N m/kg].
    lever: f64,
    /// Deviation of the moment from the expected one, as shares of the moment: its mean, and the last difference from that mean.
    mean: f64,
    last: f64,
    /// Number of blocks until the joints that changed the content are at rest.
    settling: u32,
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

    /// Predicts the rest of the friction, and adds the random walks of zero, span and held friction.
    fn wander(
        &self,
        m: &Moment,
        filter: &mut Filter,
        settings: &Settings,
        trail: &mut Option<Trail>,
    ) {
        let c = &self.cylinder;
        let doubt = if m.moves { c.friction[1] } else { 0.0 };
        let load = filter.load().max(0.0) * m.per_payload / m.lever;
        let centre =
            CENTRE * settings.geometry.payload_centre / settings.geometry.lengths[0] * load;
        let variance = m.rest(c.friction[0]) + doubt * doubt + centre * centre;
        let decay = m.kept();
        if let Some(trail) = trail {
            let mut row = [0.0; N];
            row[REST] = decay;
            trail.row(REST, &row);
        }
        filter.x[REST] *= decay;
        for i in 0..N {
            filter.p[REST][i] *= decay;
            filter.p[i][REST] *= decay;
        }
        // The unknown part of the seals' friction changes with the direction of motion.
        let turned = m.turned * c.friction[1];
        filter.p[REST][REST] += (1.0 - decay * decay) * variance + turned * turned;
        let lost = m.period / LASTING;
        filter.p[ZERO][ZERO] += lost * c.zero_std * c.zero_std;
        filter.p[SPAN][SPAN] += lost * c.span_std * c.span_std;
        filter.p[HELD][HELD] += lost * c.held_variance();
    }

    /// Returns the expected moment and its row.
    pub(super) fn model(&self, filter: &Filter, m: &Moment) -> (f64, [(usize, f64); 10]) {
        let x = &filter.x;
        let [sin, cos] = m.turn;
        // Pitch of the upper body, from the slope of the ground in the axes of the start.
        let pitch = -(x[SLOPE] * sin + x[SLOPE + 1] * cos);
        let [of_load, of_gain] = filter.load_row();
        let payload = filter.load();
        let tilt = m.tilt + payload * m.tilt_payload;
        let load = m.per_payload + pitch * m.tilt_payload;
        let tau = m.empty
            + x[LINKS] * m.links
            + x[BUCKET] * m.per_bucket
            + payload * load
            + pitch * m.tilt;
        let span = 1.0 + x[SPAN];
        let held = if m.moves { 0.0 } else { m.side };
        let friction = self.cylinder.friction[0] * m.direction + x[HELD] * held;
        let expected = span * tau + m.lever * (x[ZERO] + x[REST] + friction);
        let row = [
            (M, span * load * of_load.1),
            (GAIN, span * load * of_gain.1),
            (BUCKET, span * m.per_bucket),
            (LINKS, span * m.links),
            (SPAN, tau),
            (ZERO, m.lever),
            (REST, m.lever),
            (HELD, m.lever * held),
            (SLOPE, -span * tilt * sin),
            (SLOPE + 1, -span * tilt * cos),
        ];
        (expected, row)
    }

    /// Predicts the friction, updates the filter with a moment, and returns the innovation. There is no update where the filter does not
    /// trust the pressures, beyond the gate, or where the ground may carry part of the load.
    pub(super) fn measure(
        &self,
        settings: &Settings,
        m: &Moment,
        (filter, believes): (&mut Filter, bool),
        trail: &mut Option<Trail>,
    ) -> Innovation {
        self.wander(m, filter, settings, trail);
        let (expected, row) = self.model(filter, m);
        let value = m.measured - expected;
        let measured = filter.measured(row);
        let innovation = Innovation {
            value,
            variance: measured.variance + m.variance,
        };
        if believes && !m.touches && fits(innovation) {
            let before = filter.x[M];
            filter.absorb(&measured, innovation, GATE, trail);
            filter.weighs_true_mass(before, trail);
        }
        innovation
    }

    /// Observes the oscillation of the moment: a load that hangs or sloshes swings on while the machine stands. Friction, drawing and
    /// noise do not oscillate from block to block, nor does an empty bucket.
    pub(super) fn watch(
        &mut self,
        m: &Moment,
        innovation: Innovation,
        (payload, rated): (f64, f64),
        stands: bool,
    ) {
        if payload < EMPTY * rated {
            self.forget();
            return;
        }
        let watched = &mut self.watched;
        let share = (m.period / WATCHED).min(1.0);
        if m.moves {
            self.wavering *= 1.0 - 0.2 * share;
        }
        let moved = (m.still_payload - watched.lever).abs() > STILL * GRAVITY;
        watched.lever = m.still_payload;
        if !stands || m.moves || moved || m.period > HOLDS {
            watched.payload = None;
            return;
        }
        // A jump is no oscillation.
        if !fits(innovation) {
            return;
        }
        let begun = watched.payload.is_some();
        let payload = *watched.payload.get_or_insert(payload);
        let whole = m.measured.abs().max(f64::MIN_POSITIVE);
        let apart = (m.measured - m.still - payload * m.still_payload) / whole;
        watched.settling = watched.settling.saturating_sub(1);
        if !begun || watched.settling > 0 {
            (watched.mean, watched.last) = (apart, 0.0);
            return;
        }
        watched.mean += share * (apart - watched.mean);
        let away = apart - watched.mean;
        // Noise is independent from block to block: the mean of its products is zero.
        self.wavering += share * (away * watched.last - self.wavering);
        watched.last = away;
    }

    /// Resets for another content of the bucket.
    pub(super) fn holds_another(&mut self) {
        self.forget();
        self.strange = 0;
        self.misfits = false;
    }

    /// Restarts the observation of the oscillation.
    fn forget(&mut self) {
        self.wavering = 0.0;
        self.watched.payload = None;
        self.watched.settling = SETTLES;
    }

    /// Returns whether the load hangs, or swings for another reason.
    pub(super) fn swings(&self) -> bool {
        self.wavering > WAVERING * WAVERING
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
mod tests {
    use super::*;
    use crate::excavator::keys::Description;
    use crate::math::{exp, sin_cos};

    const MOMENT: f64 = 70e3;

    /// With one described cylinder.
    fn described() -> Weigh {
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
    fn innovation(value: f64) -> Innovation {
        Innovation {
            value,
            variance: 1.0,
        }
    }

    /// Whether the load swings, on a machine that stands for 6 s with a moment that differs by a share from block to block.
    fn stands(payload: f64, share: impl Fn(f64) -> f64) -> bool {
        let mut weigh = described();
        weigh.forget();
        for block in 0..30 {
            let moment = Moment {
                measured: MOMENT * (1.0 + share(0.2 * f64::from(block))),
                still: MOMENT,
                period: 0.2,
                ..Moment::default()
            };
            weigh.watch(&moment, innovation(0.0), (payload, 1000.0), true);
        }
        weigh.swings()
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
    fn a_bucket_that_settles_after_a_dump_does_not_hang() {
        let settles = |t: f64| 0.04 * exp(-t / 0.1);
        assert!(!stands(800.0, settles), "4 %, gone within half a second");
    }

    #[test]
    fn a_load_that_swings_wavers_slowly_and_noise_does_not() {
        assert!(
            stands(800.0, |t| 0.01 * sin_cos(2.0 * t).0),
            "1 % at 2 rad/s"
        );
        assert!(!stands(800.0, |_| 0.01), "another load");
        let relaxes = |t: f64| 0.04 * exp(-t / 3.0);
        assert!(!stands(20.0, relaxes), "nothing in it");
        let noise = [0.003, -0.002, -0.003, 0.001, 0.002, -0.001, 0.003, -0.003];
        assert!(
            !stands(800.0, |t| noise[(t * 5.0) as usize % 8]),
            "0.24 % of noise"
        );
    }

    /// Moments of a boom that is raised and lowered alternately for 1 s each, with stands of 1 s, under this load \[kg\]. A stop leaves
    /// the share `kept` of the friction \[N\].
    fn lifts(load: f64, friction: f64, kept: f64) -> impl Iterator<Item = Moment> {
        (0..800).map(move |block: u32| {
            let side = if (block / 10).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            };
            let moves = block % 10 < 5;
            let (lever, per_payload) = (0.5, 40.0);
            let left = if moves { friction } else { kept * friction };
            let starts = block.is_multiple_of(10);
            Moment {
                measured: MOMENT + per_payload * load + lever * side * left,
                empty: MOMENT,
                per_payload,
                lever,
                side,
                // The description states that half of it is left.
                direction: if moves { side } else { 0.5 * side },
                moves,
                turned: if starts || block % 10 == 5 { 1.0 } else { 0.0 },
                variance: 200.0 * 200.0,
                period: 0.2,
                ..Moment::default()
            }
        })
    }

    #[test]
    fn what_a_stop_leaves_of_the_friction_is_learnt_and_is_no_load() {
        for kept in [0.0, 1.0] {
            let weigh = described();
            let [friction, _] = weigh.cylinder.friction;
            let settings = Settings::of(&Description::default());
            let mut filter = Filter::new([0.0; N], &[0.0; N]);
            let before = weigh.cylinder.held_variance();
            filter.set(HELD, 0.0, before, &mut None);
            filter.set(M, 0.0, 1e6, &mut None);
            for moment in lifts(500.0, friction, kept) {
                weigh.measure(&settings, &moment, (&mut filter, true), &mut None);
            }
            let off = filter.x[HELD] - (kept - 0.5) * friction;
            let std = sqrt(filter.p[HELD][HELD]);
            assert!(off.abs() < 2.0 * std, "{kept}: {off} +- {std}");
            assert!(std < 0.5 * sqrt(before), "{kept}: {std}");
            let off = filter.load() - 500.0;
            assert!(off.abs() < 2.0 * sqrt(filter.p[M][M]), "{kept}: {off}");
        }
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

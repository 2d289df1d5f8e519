//! What makes an estimate doubtful, and which cause is named first.

use super::{Belief, CgFilter};
use crate::Quantity;
use crate::keys::Range;
use crate::loader::floors::{Learns, RATIO_PER_SENSITIVITY, ratio_with_floors};
use crate::loader::layout::{CG_HEIGHT, CG_RATIO, Each, Layout, SLIP_STIFFNESS, SPEED};
use crate::loader::load::axle_torque::RatioAway;
use crate::loader::load::mass_step::{Centre, HEIGHT_SPREAD};
use crate::loader::reason::Reason;
use crate::loader::settings::Settings;
use crate::loader::verdict::Doubt;
use crate::math::{norm, sqrt};

/// Standard deviations of the prior within which an estimate is as expected; twice as far it contradicts it by one more.
const EXPECTED: f64 = 2.0;
/// A state within this share of a bound is at it.
const NEAR: f64 = 0.02;
/// Standard deviations of the prior beyond which the delay of the speed is no sensor's.
const LATEST: f64 = 4.0;
/// Birge ratio beyond which the manoeuvres disagree.
const DISAGREE: f64 = 2.0;
/// A rolling radius so far from the described one is none of a worn or soft tyre, which is at most half as far away: a speed is wrong.
/// Sound machines show up to .016.
const OTHER_RADIUS: f64 = 0.04;
/// Where nobody states the radius it may be off by so many standard deviations of its prior.
const UNSTATED_RADIUS: f64 = 3.0;
/// A slip by steering or by unexplained forces that is named as the cause: a tenth of what the wheels do at work.
const NOTED_SLIP: f64 = 0.005;
/// An error of the slope beside its bias that is named as the cause [rad].
const NOTED_SLOPE: f64 = 0.02;
/// Where a load sits, in bucket reaches ahead of the front axle.
const LOAD_ARM: f64 = 0.75;
/// Height of a load over where it is driven, in heights of the machine's centre: anything up to a truck's board, 2.
const LIFTED: f64 = 1.15;
/// How long a load that nobody reported is felt [s], and what it may leave in the ratio, as a share of it.
const AFTER_UNREPORTED: f64 = 60.0;
const UNREPORTED: f64 = 0.06;
/// Standard deviation of an error that both slips share, as a share of how far the stiffness is from its prior: signals that do not come
/// together, or a speed that is not the body's, look like another stiffness. A millisecond at 1.5 m/s is a twelfth of the slip. Chosen so that a
/// good simulated machine stays trusted; .15 is wrong less often on machines by chance (docs/measurements, 24 November 2026).
const SHARED_SLIP: f64 = 0.07;
/// How long a change is shown [s].
const CHANGE_SHOWN: f64 = 5.0;

/// Signs of a model that does not hold.
struct Signs {
    /// The centre drive is locked, more probably than not.
    locked: bool,
    late: bool,
    at_limit: bool,
    /// A wheel rolls on another radius than a tyre may.
    radius: bool,
    /// The slip stiffness lies beyond its prior.
    stiffness: bool,
    /// Height or ratio lies beyond what is expected.
    contradicted: bool,
    /// The ratio changed while nothing was loaded.
    wandered: bool,
    /// One axle's torque is off, more probably than not.
    axle_torque: bool,
    /// By how much the machine is lighter than stated, as a share.
    lighter: f64,
    /// The load may be another one, as far as the wheels tell.
    changing: bool,
}

/// By how much a value lies beyond what is expected.
fn beyond(value: f64, (centre, std): (f64, f64)) -> f64 {
    ((value - centre).abs() - EXPECTED * std).max(0.0)
}

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// What makes the estimate doubtful beside its own covariance.
    pub(in crate::loader) fn doubt(&self, settings: &Settings, learns: &Learns) -> Doubt {
        let at_limit = Each::of(|i| self.is_at_limit(settings, i));
        if !settings.at_work() {
            return Doubt {
                ratio_std: self.belief.std(CG_RATIO),
                at_limit,
                ..Doubt::NONE
            };
        }
        let prior = &settings.prior;
        let expected = self.expected_centre(settings);
        let ratio_std = norm(&[expected[1].1, self.told(settings, learns)]);
        let away = self.away([expected[0], (expected[1].0, ratio_std)]);
        let stiffness = beyond(
            self.belief.state()[SLIP_STIFFNESS],
            (prior.slip_stiffness, prior.slip_stiffness_std),
        );
        let (axle_torque, by_axle_torque) = self.disturbance.mass.axle_torque.judge(&RatioAway {
            ratio: self.belief.state()[CG_RATIO],
            expected: expected[1].0,
            std: ratio_std,
            torque_std: settings.sensors.torque_gain_std,
        });
        let locked = self.coupling.locked();
        let lighter = self.disturbance.mass.lighter();
        let signs = Signs {
            locked: locked > 0.5,
            late: self.is_late(settings),
            radius: self.has_other_radius(settings),
            at_limit: at_limit.ratio
                || at_limit.height
                || self.is_at_limit(settings, SLIP_STIFFNESS),
            stiffness: stiffness > prior.slip_stiffness_std,
            contradicted: away.height > expected[0].1 || away.ratio > ratio_std,
            wandered: self.is_too_much(settings, self.constancy.std()),
            axle_torque: axle_torque > 0.5,
            lighter,
            changing: self.changed < CHANGE_SHOWN || lighter < 0.0,
        };
        let reason = self.cause(&signs);
        // Where the model does not hold, nothing is known but what was known before.
        let doubted = match reason {
            Reason::Locked
            | Reason::Radius
            | Reason::Torque
            | Reason::AtLimit
            | Reason::Stiffness => 1.0,
            _ if signs.contradicted => 1.0,
            _ => locked,
        };
        Doubt {
            ratio_std: self.ratio_std(settings, expected[1].1),
            birge: self.manoeuvres.ratio(),
            wavering: self.wheel_noise.wavering(&settings.estimator),
            beyond: self.mixed(settings, away, by_axle_torque, stiffness, doubted, expected),
            stated: self.stated_ratio(settings, expected[1]),
            spans: self.spanned(doubted, CG_RATIO, expected[1]),
            at_limit,
            unknown_height: self.lifts_unreported(settings),
            reason,
            changing: signs.changing,
            acts: self.acts(settings),
            one_way: self.wants_a_drive_back(settings, learns),
        }
    }

    /// What the filter estimates, so that no floor need hold it.
    pub(in crate::loader) fn learns(&self, settings: &Settings) -> Learns {
        Learns {
            radii: const { Layout::of(N) }.radii.is_some(),
            load_sensitivity: self.sensitivity_left(settings),
            acceleration: M > 3,
        }
    }

    /// How far the ratio of a sound machine may be told from the true one, however well that was known before: the filter's deviation
    /// and the floors.
    fn told(&self, settings: &Settings, learns: &Learns) -> f64 {
        let own = Each::of(|i| self.belief.state()[i]);
        ratio_with_floors(settings, learns, own, self.belief.std(CG_RATIO))
    }

    /// By how much height and ratio lie beyond what is expected; a payload that is reported in full may be stated wrongly.
    fn away(&self, [height, ratio]: Centre) -> Each<f64> {
        let state = self.belief.state();
        if self.known_load.is_some() {
            return Each::default();
        }
        Each {
            ratio: beyond(state[CG_RATIO], ratio),
            height: beyond(state[CG_HEIGHT], height),
        }
    }

    /// What is known of the ratio beside the slips, of the empty machine. Nothing where a payload is weighed by another witness, or a load was
    /// found that nobody reported.
    fn stated_ratio(&self, settings: &Settings, (value, std): (f64, f64)) -> Option<Quantity> {
        let mass = &self.disturbance.mass;
        let stated =
            mass.lighter() == 0.0 && mass.since_load().is_infinite() && self.load.is_empty();
        let std = norm(&[std, mass.other_load() * self.ahead(settings)]);
        (stated && !self.known_load.is_some()).then_some(Quantity { value, std })
    }

    /// How far ahead of the centre of gravity a load sits [wheelbases].
    fn ahead(&self, settings: &Settings) -> f64 {
        (1.0 + LOAD_ARM * self.reach(settings) - self.belief.state()[CG_RATIO]).abs()
    }

    /// A state is at one of its bounds, or nearly.
    fn is_at_limit(&self, settings: &Settings, i: usize) -> bool {
        let Range { low, high } = settings.bounds()[i - SLIP_STIFFNESS];
        let value = self.belief.state()[i];
        value <= (1.0 + NEAR) * low || value >= (1.0 - NEAR) * high
    }

    /// The speed comes later than a sensor may be.
    fn is_late(&self, settings: &Settings) -> bool {
        let delay = const { Layout::of(N) }
            .speed_delay
            .map_or(0.0, |i| self.belief.state()[i]);
        let sensors = &settings.sensors;
        (delay - sensors.speed_delay).abs() > LATEST * sensors.speed_delay_std
    }

    /// Speed and wheel speeds do not fit the described rolling radii.
    fn has_other_radius(&self, settings: &Settings) -> bool {
        let prior = &settings.prior;
        let described = [prior.front_radius_error, prior.rear_radius_error];
        let other = OTHER_RADIUS.max(UNSTATED_RADIUS * prior.radius_std);
        const { Layout::of(N) }.radii.is_some_and(|radii| {
            let learnt = radii.map(|i| self.belief.state()[i]);
            let mut both = learnt.iter().zip(described);
            both.any(|(learnt, described)| (learnt - described).abs() > other)
        })
    }

    /// How far height and ratio may be off: a mixture of what lies beyond what was known, and of that itself where the estimate is
    /// `doubted`.
    fn mixed(
        &self,
        settings: &Settings,
        away: Each<f64>,
        by_axle_torque: f64,
        stiffness: f64,
        doubted: f64,
        expected: Centre,
    ) -> Each<f64> {
        let state = self.belief.state();
        let Each { ratio, height } = self.with_other_load(settings, away, by_axle_torque);
        // Slips that a stiffness beyond its prior explains are not understood to that share, nor is the height that they tell.
        let unknown_slip = stiffness / state[SLIP_STIFFNESS];
        let height = norm(&[height, state[CG_HEIGHT] * unknown_slip]);
        let spans = self.spanned(doubted, CG_HEIGHT, expected[0]);
        Each {
            ratio,
            height: norm(&[height, spans]),
        }
    }

    /// What spans a state and what was known of it before, where the estimate is `doubted`.
    fn spanned(&self, doubted: f64, i: usize, (centre, std): (f64, f64)) -> f64 {
        let moved = self.belief.state()[i] - centre;
        sqrt(doubted * (moved * moved + std * std))
    }

    /// The first cause of doubt.
    fn cause(&self, signs: &Signs) -> Reason {
        if signs.locked {
            Reason::Locked
        } else if signs.radius {
            Reason::Radius
        } else if self.disturbance.gain.misfits() || signs.lighter > 0.0 || signs.axle_torque {
            Reason::Torque
        } else if signs.late {
            Reason::Latency
        } else if signs.at_limit {
            Reason::AtLimit
        } else if signs.stiffness {
            Reason::Stiffness
        } else if signs.changing {
            Reason::Load
        } else if self.manoeuvres.ratio() > DISAGREE || signs.contradicted || signs.wandered {
            Reason::Disagreement
        } else {
            Reason::None
        }
    }

    /// What is not known of the radii's load sensitivity keeps the ratio from being trusted, and a drive the other way tells it.
    fn wants_a_drive_back(&self, settings: &Settings, learns: &Learns) -> bool {
        let converged = settings.estimator.converged_ratio;
        const { Layout::of(N) }.load_sensitivity.is_some()
            && self.directions.one_way()
            && RATIO_PER_SENSITIVITY * learns.load_sensitivity > converged
    }

    /// What an error that both slips share does to the ratio, as a standard deviation: of a stiffness that is x off by it the ratio is
    /// x (lam - 1/2) off where both axles pull alike.
    fn by_shared_slip(&self, settings: &Settings) -> f64 {
        let (prior, state) = (&settings.prior, self.belief.state());
        let spread = prior.slip_stiffness_std / prior.slip_stiffness;
        let away = state[SLIP_STIFFNESS] / prior.slip_stiffness - 1.0;
        let shared = SHARED_SLIP * SHARED_SLIP;
        let part = shared / (shared + spread * spread);
        let square = part * part * away * away + part * spread * spread;
        sqrt(square) * (state[CG_RATIO] - 0.5).abs()
    }

    /// What a load that nobody reported, or may have stated wrongly, adds to the doubt of height and ratio.
    fn with_other_load(
        &self,
        settings: &Settings,
        Each { ratio, height }: Each<f64>,
        by_axle_torque: f64,
    ) -> Each<f64> {
        let state = self.belief.state();
        let lighter = self.disturbance.mass.lighter();
        // A load that nobody tells sits ahead of the front axle; a torque that is one axle's moves the ratio twice as far.
        let off = self.disturbance.mass.off();
        let ahead = self.ahead(settings);
        let ratio = match lighter {
            0.0 => ratio,
            x if x < 0.0 => ratio + off * ahead,
            _ => ratio + 2.0 * off * (1.0 - state[CG_RATIO]) * state[CG_RATIO],
        };
        // After a load that nobody reported, what slips and radii mean is known again only in part.
        let unreported = self.disturbance.mass.since_load() < AFTER_UNREPORTED;
        let ratio = if unreported && !self.known_load.is_some() {
            ratio + UNREPORTED * state[CG_RATIO]
        } else {
            ratio
        };
        let height = if lighter == 0.0 {
            height
        } else {
            height + off * state[CG_HEIGHT]
        };
        // The floor is what no doubt has a name for: those that have one take its place.
        let floor = settings.estimator.cg_ratio_floor * state[CG_RATIO];
        let named = norm(&[
            by_axle_torque,
            self.by_shared_slip(settings),
            self.by_wheel_lag(settings),
            self.curves.ratio_std(),
            self.constancy.std(),
        ]);
        let ratio = norm(&[ratio, sqrt((named * named - floor * floor).max(0.0))]);
        if self.known_load.is_some() {
            return Each { ratio, height };
        }
        // The bucket may have been filled or emptied since: a mixture of both.
        let other = self.disturbance.mass.other_load();
        // Whatever it carries may be lifted; who tells that the boom moves does not tell how far.
        let lifted = LIFTED * self.disturbance.mass.carried().max(self.load.share());
        let by_load = norm(&[other * HEIGHT_SPREAD, lifted]);
        Each {
            ratio: norm(&[ratio, other * ahead]),
            height: norm(&[height, by_load * state[CG_HEIGHT]]),
        }
    }

    /// What the time between both wheel speeds leaves of the ratio, as far as the slips have told it.
    fn by_wheel_lag(&self, settings: &Settings) -> f64 {
        let [stiffness, ratio] = [SLIP_STIFFNESS, CG_RATIO].map(|i| self.belief.state()[i]);
        let before = settings.prior.cg_ratio_std;
        let learnt = (1.0 - self.belief.variance(CG_RATIO) / (before * before)).max(0.0);
        learnt * self.wheel_lag.lag().std * self.shared_slip.ratio_by_lag(stiffness, ratio)
    }

    /// A doubt of this size alone keeps the ratio from being trusted.
    fn is_too_much(&self, settings: &Settings, ratio_std: f64) -> bool {
        ratio_std > settings.estimator.converged_ratio * self.belief.state()[CG_RATIO]
    }

    /// What acts on the machine that its model does not have.
    fn acts(&self, settings: &Settings) -> Reason {
        let slowed = self.disturbance.unexplained * self.belief.state()[SPEED] < 0.0;
        if self.effect.braking || self.effect.force > NOTED_SLIP && slowed {
            Reason::Brakes
        } else if self.effect.turn > NOTED_SLIP
            || self.is_too_much(settings, self.curves.ratio_std())
        {
            Reason::Steering
        } else if self.slope_error.size() > NOTED_SLOPE {
            Reason::Slope
        } else {
            Reason::None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ekf::Ekf;
    use crate::loader::Method;
    use crate::loader::doubts::coupling::Turning;

    type Filter = CgFilter<9, 3, Ekf<9, 3>>;

    /// Why a filter of these settings doubts a ratio that lies `ratio` beside its prior, and a front radius that is `radius` off.
    fn reason(settings: &Settings, ratio: f64, radius: f64) -> Reason {
        let mut filter = Filter::new(settings, Method::FullEkf);
        // The axles have turned apart: the centre drive is not locked.
        let apart = Turning {
            difference: 1.0,
            innovation: 0.0,
            predicted: 0.0,
            process: 0.0,
            noise: 1e-3,
            dt: 0.1,
        };
        filter.coupling.see(&apart);
        filter.belief.state_mut()[CG_RATIO] += ratio;
        filter.belief.state_mut()[6] += radius;
        filter.doubt(settings, &filter.learns(settings)).reason
    }

    #[test]
    fn a_well_known_ratio_is_not_contradicted_by_what_estimates_are_off() {
        let mut settings = Settings::DEFAULT;
        settings.prior.cg_ratio_std = 0.008;
        assert_eq!(reason(&settings, 0.03, 0.0), Reason::None);
        assert_eq!(reason(&settings, 0.3, 0.0), Reason::Disagreement);
    }

    #[test]
    fn a_radius_that_nobody_stated_may_be_off_by_its_spread() {
        let mut settings = Settings::DEFAULT;
        assert_eq!(reason(&settings, 0.0, 0.06), Reason::Radius);
        settings.prior.radius_std = 0.05;
        assert_eq!(reason(&settings, 0.0, 0.06), Reason::None);
        assert_eq!(reason(&settings, 0.0, 0.16), Reason::Radius);
    }
}

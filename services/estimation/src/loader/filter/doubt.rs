//! Errors of an estimate beside its covariance (*doubts*), and the cause that is reported first.

use super::{Belief, CgFilter};
use crate::Quantity;
use crate::keys::Range;
use crate::loader::floors::{Learns, RATIO_PER_SENSITIVITY, ratio_with_floors};
use crate::loader::layout::{CG_HEIGHT, CG_RATIO, Each, Layout, SLIP_STIFFNESS, SPEED};
use crate::loader::load::axle_torque::{self, RatioAway};
use crate::loader::load::mass_step::{Centre, HEIGHT_SPREAD};
use crate::loader::reason::Reason;
use crate::loader::settings::Settings;
use crate::loader::verdict::Doubt;
use crate::math::{norm, sqrt};

/// Standard deviations of the prior within which an estimate is as expected. One more beyond them contradicts the prior.
const EXPECTED: f64 = 2.0;
/// Share of a bound within which a state counts as at it.
const NEAR: f64 = 0.02;
/// Standard deviations of the prior beyond which the delay of the speed is no sensor's.
const LATEST: f64 = 4.0;
/// Birge ratio beyond which the manoeuvres disagree.
const DISAGREE: f64 = 2.0;
/// Relative error of a rolling radius that indicates a wrong speed: a worn or soft tyre has at most half of it. Sound machines show
/// up to .016.
const OTHER_RADIUS: f64 = 0.04;
/// The same for a radius that is not stated, in standard deviations of its prior.
const UNSTATED_RADIUS: f64 = 3.0;
/// Slip by steering or by unexplained forces from which on it is named as the cause: a tenth of the slips at work.
const NOTED_SLIP: f64 = 0.005;
/// Error of the slope beside its bias from which on it is named as the cause [rad].
const NOTED_SLOPE: f64 = 0.02;
/// Position of a load ahead of the front axle, in bucket reaches.
const LOAD_ARM: f64 = 0.75;
/// Rms height of a load above the height at which it is driven, in heights of the machine's centre: up to a truck's board, 2.
const LIFTED: f64 = 1.15;
/// Time for which an unreported load widens the interval of the ratio [s], and the deviation that it adds, as a share of the ratio.
const AFTER_UNREPORTED: f64 = 60.0;
const UNREPORTED: f64 = 0.06;
/// Standard deviation of an error common to both slips, as a share of the stiffness. Signals of different instants, or a speed that
/// is not the body's, look like another stiffness: a millisecond at 1.5 m/s is a twelfth of the slip. Chosen so that a good
/// simulated machine stays trusted; .15 is wrong less often on machines drawn at random (docs/measurements, 24 November 2026).
const SHARED_SLIP: f64 = 0.07;
/// Time for which a change is reported [s].
const CHANGE_SHOWN: f64 = 5.0;

/// Indications that the model does not hold.
struct Signs {
    /// The centre drive is locked, more probably than not.
    locked: bool,
    late: bool,
    at_limit: bool,
    /// A rolling radius is beyond what a tyre may have.
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
    /// The load may have changed, as far as the wheels show.
    changing: bool,
}

/// Distance of a value from its prior, less [`EXPECTED`] standard deviations of it, at least 0.
fn beyond(value: f64, (centre, std): (f64, f64)) -> f64 {
    ((value - centre).abs() - EXPECTED * std).max(0.0)
}

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// Returns the errors of the estimate beside its own covariance.
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
        let ratio_std = norm(&[expected[1].1, self.sound_ratio_std(settings, learns)]);
        let away = self.away([expected[0], (expected[1].0, ratio_std)]);
        let stiffness = beyond(
            self.belief.state()[SLIP_STIFFNESS],
            (prior.slip_stiffness, prior.slip_stiffness_std),
        );
        let (axle_torque, by_axle_torque) = axle_torque::judge(
            self.disturbance.gain.found(),
            &RatioAway {
                ratio: self.belief.state()[CG_RATIO],
                expected: expected[1].0,
                std: ratio_std,
                torque_std: settings.sensors.torque_gain_std,
                untold_load: !self.disturbance.states_mass && !self.known_load.is_some(),
            },
        );
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
        // Where the model does not hold, only the prior remains.
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

    /// Parameters that the filter estimates, so that no floor has to include them.
    pub(in crate::loader) fn learns(&self, settings: &Settings) -> Learns {
        Learns {
            radii: const { Layout::of(N) }.radii.is_some(),
            load_sensitivity: self.sensitivity_left(settings),
            acceleration: M > 3,
        }
    }

    /// Standard deviation of the ratio of a sound machine: that of the filter, with the floors. A narrower prior does not reduce
    /// it.
    fn sound_ratio_std(&self, settings: &Settings, learns: &Learns) -> f64 {
        let own = Each::of(|i| self.belief.state()[i]);
        ratio_with_floors(settings, learns, own, self.belief.std(CG_RATIO))
    }

    /// Distance of height and ratio beyond their priors; 0 with a known load, whose report may be wrong.
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

    /// Stated ratio of the empty machine. `None` where another witness weighs a payload, where the machine is loaded, or after an
    /// unreported load was found.
    fn stated_ratio(&self, settings: &Settings, (value, std): (f64, f64)) -> Option<Quantity> {
        let mass = &self.disturbance.mass;
        let stated =
            mass.lighter() == 0.0 && mass.since_load().is_infinite() && self.load.is_empty();
        let std = norm(&[std, mass.other_load() * self.ahead(settings)]);
        (stated && !self.known_load.is_some()).then_some(Quantity { value, std })
    }

    /// Distance of a load ahead of the centre of gravity [wheelbases].
    pub(super) fn ahead(&self, settings: &Settings) -> f64 {
        (1.0 + LOAD_ARM * self.reach(settings) - self.belief.state()[CG_RATIO]).abs()
    }

    /// Whether a state is at one of its bounds, or nearly.
    fn is_at_limit(&self, settings: &Settings, i: usize) -> bool {
        let Range { low, high } = settings.bounds()[i - SLIP_STIFFNESS];
        let value = self.belief.state()[i];
        value <= (1.0 + NEAR) * low || value >= (1.0 - NEAR) * high
    }

    /// Whether the estimated delay of the speed is beyond that of a sensor.
    fn is_late(&self, settings: &Settings) -> bool {
        let delay = const { Layout::of(N) }
            .speed_delay
            .map_or(0.0, |i| self.belief.state()[i]);
        let sensors = &settings.sensors;
        (delay - sensors.speed_delay).abs() > LATEST * sensors.speed_delay_std
    }

    /// Whether speed and wheel speeds contradict the stated rolling radii.
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

    /// Standard deviations of height and ratio by a mixture: the distance beyond the prior, and the prior itself with probability
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
        // A stiffness beyond its prior leaves that share of the slips unexplained, and of the height that they determine.
        let unknown_slip = stiffness / state[SLIP_STIFFNESS];
        let height = norm(&[height, state[CG_HEIGHT] * unknown_slip]);
        let spans = self.spanned(doubted, CG_HEIGHT, expected[0]);
        Each {
            ratio,
            height: norm(&[height, spans]),
        }
    }

    /// Standard deviation that spans a state and its prior, for the probability `doubted`.
    fn spanned(&self, doubted: f64, i: usize, (centre, std): (f64, f64)) -> f64 {
        let moved = self.belief.state()[i] - centre;
        sqrt(doubted * (moved * moved + std * std))
    }

    /// Returns the first cause of doubt.
    fn cause(&self, signs: &Signs) -> Reason {
        if signs.locked {
            Reason::Locked
        } else if signs.radius {
            Reason::Radius
        } else if signs.lighter > 0.0 || signs.axle_torque {
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

    /// Whether the unknown load sensitivity of the radii keeps the ratio from being trusted, and a drive in the other direction
    /// would identify it.
    fn wants_a_drive_back(&self, settings: &Settings, learns: &Learns) -> bool {
        let converged = settings.estimator.converged_ratio;
        const { Layout::of(N) }.load_sensitivity.is_some()
            && self.directions.one_way()
            && RATIO_PER_SENSITIVITY * learns.load_sensitivity > converged
    }

    /// Standard deviation of the ratio from an error common to both slips. An error of the stiffness by the share x shifts the
    /// ratio by x (lam - 1/2) where both axles pull equally.
    fn by_shared_slip(&self, settings: &Settings) -> f64 {
        let (prior, state) = (&settings.prior, self.belief.state());
        let spread = prior.slip_stiffness_std / prior.slip_stiffness;
        let away = state[SLIP_STIFFNESS] / prior.slip_stiffness - 1.0;
        let shared = SHARED_SLIP * SHARED_SLIP;
        let part = shared / (shared + spread * spread);
        let square = part * part * away * away + part * spread * spread;
        sqrt(square) * (state[CG_RATIO] - 0.5).abs()
    }

    /// Adds the doubt of a load that is not reported, or may be stated wrongly, to height and ratio.
    fn with_other_load(
        &self,
        settings: &Settings,
        Each { ratio, height }: Each<f64>,
        by_axle_torque: f64,
    ) -> Each<f64> {
        let state = self.belief.state();
        let lighter = self.disturbance.mass.lighter();
        // An unreported load sits ahead of the front axle. A wrong torque of one axle moves the ratio twice as far.
        let off = self.disturbance.mass.off();
        let ahead = self.ahead(settings);
        let ratio = match lighter {
            0.0 => ratio,
            x if x < 0.0 => ratio + off * ahead,
            _ => ratio + 2.0 * off * (1.0 - state[CG_RATIO]) * state[CG_RATIO],
        };
        // After an unreported load, stiffness and radii are learnt again only in part.
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
        // The floor stands for errors without a name. Those with a name replace it up to its size.
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
        // The bucket may have been filled or emptied since: a mixture of both hypotheses.
        let other = self.disturbance.mass.other_load();
        // The load may be lifted: a report that the boom moves does not state how far.
        let lifted = LIFTED * self.disturbance.mass.carried().max(self.load.share());
        let by_load = norm(&[other * HEIGHT_SPREAD, lifted]);
        Each {
            ratio: norm(&[ratio, other * ahead]),
            height: norm(&[height, by_load * state[CG_HEIGHT]]),
        }
    }

    /// Standard deviation of the ratio from the lag between the wheel speeds, as far as the slips have determined the ratio.
    fn by_wheel_lag(&self, settings: &Settings) -> f64 {
        let [stiffness, ratio] = [SLIP_STIFFNESS, CG_RATIO].map(|i| self.belief.state()[i]);
        let before = settings.prior.cg_ratio_std;
        let learnt = (1.0 - self.belief.variance(CG_RATIO) / (before * before)).max(0.0);
        learnt * self.wheel_lag.lag().std * self.shared_slip.ratio_by_lag(stiffness, ratio)
    }

    /// Whether a doubt of this size alone keeps the ratio from being trusted.
    fn is_too_much(&self, settings: &Settings, ratio_std: f64) -> bool {
        ratio_std > settings.estimator.converged_ratio * self.belief.state()[CG_RATIO]
    }

    /// Returns an action on the machine that its model does not contain.
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

    /// Reason of a filter with these settings whose ratio lies `ratio` beside its prior, and whose front radius is `radius` off.
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
    fn a_radius_that_is_not_stated_may_be_off_by_its_spread() {
        let mut settings = Settings::DEFAULT;
        assert_eq!(reason(&settings, 0.0, 0.06), Reason::Radius);
        settings.prior.radius_std = 0.05;
        assert_eq!(reason(&settings, 0.0, 0.06), Reason::None);
        assert_eq!(reason(&settings, 0.0, 0.16), Reason::Radius);
    }
}

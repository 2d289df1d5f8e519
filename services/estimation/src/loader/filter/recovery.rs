//! Start, gaps, restarts and bounds of the filter.

use super::{Belief, CgFilter, RowReport};
use crate::loader::doubts::axles::Axles;
use crate::loader::doubts::coupling::Coupling;
use crate::loader::doubts::curves::Curves;
use crate::loader::doubts::directions::Directions;
use crate::loader::doubts::relearning::Relearning;
use crate::loader::estimate::Status;
use crate::loader::layout::{CENTRE, CG_RATIO, FRONT_WHEEL, REAR_WHEEL, SLIP_STIFFNESS, SPEED};
use crate::loader::load::mass_step::is_load;
use crate::loader::measurements::conditions::Conditions;
use crate::loader::measurements::windup::Windup;
use crate::loader::sample::Sample;
use crate::loader::settings::Settings;
use crate::math::sqrt;

/// Time for which every measured speed is rejected before the filter is taken to be wrong, and not the sensors [s].
///
/// Rejected rows have no normalised innovation, so the reset rule alone would not detect this.
const LOCKED_OUT: f64 = 1.0;

/// Time constant of the mean that detects a diverged filter [s].
const JUDGED_OVER: f64 = 2.0;

/// Shortest time between the start, or a reset, and the next reset [s].
const HOLD_OFF: f64 = 3.0;

/// Magnitude of the centre of gravity beyond which it has no interval: the square of its square may overflow. The paper's filters
/// have no bounds.
const ENDLESS: f64 = 1e50;

/// Relative difference from the stated mass below which the first mass is that of the empty machine: no load is so small.
const EMPTY: f64 = 0.05;

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// Starts the filter with the first row that has a time.
    pub(super) fn first(&mut self, settings: &Settings, sample: &Sample) -> RowReport<M> {
        self.hold.advance(sample, false, false);
        let excess = self.hold.mass / self.dynamics.empty_mass - 1.0;
        if excess.abs() < EMPTY {
            self.dynamics.empty_mass = self.hold.mass;
        } else if settings.at_work() && settings.machine.mass != Settings::DEFAULT.machine.mass {
            self.starts_loaded(settings, excess);
        }
        self.evidence.receive(sample);
        self.spade_force_x = sample.spade_force_x.unwrap_or(0.0);
        let speed = sample.speed.unwrap_or(0.0);
        let rim = speed / self.dynamics.wheel_radius;
        let state = self.belief.state_mut();
        state[SPEED] = speed;
        state[FRONT_WHEEL] = sample.front_wheel_speed.unwrap_or(rim);
        state[REAR_WHEEL] = sample.rear_wheel_speed.unwrap_or(rim);
        RowReport::without_update(Status::First, false)
    }

    /// Starts with a load where the first mass exceeds the described one by this share, and a load is the likelier cause.
    fn starts_loaded(&mut self, settings: &Settings, excess: f64) {
        let loaded = is_load(excess);
        let moves = excess / (1.0 + excess) * self.ahead(settings);
        if loaded > 0.5 {
            self.load.starts(settings.machine.mass);
            self.loosen_by(CG_RATIO, sqrt(1.0 - loaded) * moves);
        } else {
            self.loosen_by(CG_RATIO, sqrt(loaded) * moves);
        }
    }

    /// Counts the row, and restarts a filter that has diverged.
    pub(super) fn finish(
        &mut self,
        settings: &Settings,
        mut report: RowReport<M>,
        sample: &Sample,
        dt: f64,
    ) -> RowReport<M> {
        self.frozen = report.frozen;
        let centre = CENTRE.map(|i| self.belief.state()[i]);
        let endless = centre.iter().any(|x| x.abs() > ENDLESS);
        if endless || !self.belief.is_sound() || !report.nis.is_finite() {
            *self.belief.state_mut() = Self::prior_state(settings);
            self.restart(settings, sample);
            return RowReport::without_update(Status::Diverged, report.frozen);
        }
        let came = [
            sample.speed,
            sample.front_wheel_speed,
            sample.rear_wheel_speed,
        ];
        self.evidence
            .admit(came.iter().any(Option::is_some), &report.accepted, dt);
        if report.set_aside {
            self.evidence.set_aside();
        }
        if self.evidence.locked_out > LOCKED_OUT {
            self.evidence.locked_out = 0.0;
            return self.bridge_gap(settings, sample, 0.0);
        }
        let used = report.accepted.iter().filter(|a| **a).count();
        let weight = (dt / JUDGED_OVER).min(1.0);
        self.evidence.judge(report.nis / used.max(1) as f64, weight);
        if settings.protected()
            && self.evidence.consistency > settings.estimator.reset_nis
            && self.evidence.since_reset > HOLD_OFF
        {
            self.restart(settings, sample);
            report.status = Status::Reset;
        }
        report
    }

    /// Resets the covariance to the prior and the speeds to their measurements; the parameters retain their values.
    pub(super) fn restart(&mut self, settings: &Settings, sample: &Sample) {
        self.anchor(sample);
        let prior: [(usize, f64); N] = {
            let std = Self::prior_std(settings);
            core::array::from_fn(|i| (i, std[i]))
        };
        self.belief.separate(&prior, &[0.0; N]);
        self.evidence.restart();
        self.axles = Axles::default();
        self.coupling = Coupling::default();
        self.curves = Curves::default();
        self.directions = Directions::default();
        let state = self.belief.state();
        self.relearning = Relearning::new([state[SLIP_STIFFNESS], state[CG_RATIO]]);
    }

    /// Bridges a clock that was set back: earlier measurements belong to another time, learnt parameters remain valid.
    pub(super) fn set_back(&mut self, settings: &Settings, sample: &Sample) -> RowReport<M> {
        self.evidence.restart();
        RowReport {
            status: Status::ClockSetBack,
            ..self.bridge_gap(settings, sample, 0.0)
        }
    }

    /// Resets the speeds after a gap, uncorrelated with the rest. The parameters and their joint covariance stay. Their random walk
    /// over the time `away` [s] without measurements is added, not beyond the prior.
    pub(super) fn bridge_gap(
        &mut self,
        settings: &Settings,
        sample: &Sample,
        away: f64,
    ) -> RowReport<M> {
        self.anchor(sample);
        let process = self.wandering(settings, away);
        self.wheel_lag.interrupt();
        self.windup = Windup::default();
        let prior = &settings.prior;
        let least = [
            prior.speed_std,
            prior.wheel_speed_std,
            prior.wheel_speed_std,
        ];
        let sensor = self.sensor_std(settings);
        let motion: [(usize, f64); 3] =
            core::array::from_fn(|i| (i, least[i].max(3.0 * sensor[i])));
        self.belief.separate(&motion, &process);
        RowReport::without_update(Status::Gap, self.frozen)
    }

    /// Process noise of the parameters over a time without rows, by state. What was loosened belongs to the next step.
    fn wandering(&self, settings: &Settings, away: f64) -> [f64; N] {
        if away <= 0.0 || !settings.at_work() {
            return [0.0; N];
        }
        let usual = self.walk_std(settings, &Conditions::default(), false, away);
        let prior = Self::prior_std(settings);
        core::array::from_fn(|i| {
            let room = (prior[i] * prior[i] - self.belief.variance(i)).max(0.0);
            if i <= REAR_WHEEL {
                0.0
            } else {
                usual[i].min(sqrt(room))
            }
        })
    }

    fn anchor(&mut self, sample: &Sample) {
        let measured = [
            sample.speed,
            sample.front_wheel_speed,
            sample.rear_wheel_speed,
        ];
        for (state, measured) in self.belief.state_mut().iter_mut().zip(measured) {
            *state = measured.unwrap_or(*state);
        }
    }

    /// Keeps the means of K, h, lam within their bounds.
    pub(super) fn clamp(&mut self, settings: &Settings) {
        let state = self.belief.state_mut();
        for (i, bounds) in (SLIP_STIFFNESS..=CG_RATIO).zip(settings.bounds()) {
            // Not f64::clamp: NaN must pass on to the check for it.
            state[i] = if state[i] < bounds.low {
                bounds.low
            } else if state[i] > bounds.high {
                bounds.high
            } else {
                state[i]
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ekf::Ekf;
    use crate::loader::Method;

    #[test]
    fn what_is_loosened_before_a_gap_is_added_once_and_after_it() {
        let settings = Settings::DEFAULT;
        let gap = |loosened: f64| {
            let mut filter = CgFilter::<12, 4, Ekf<12, 4>>::new(&settings, Method::FullEkf);
            filter.belief.separate(&[(CG_RATIO, 0.01)], &[0.0; 12]);
            filter.loosened[CG_RATIO] = loosened;
            filter.bridge_gap(&settings, &Sample::default(), 1.0);
            (filter.belief.variance(CG_RATIO), filter.loosened[CG_RATIO])
        };
        let (variance, left) = gap(0.02);
        assert_eq!((variance, left), (gap(0.0).0, 0.02));
    }
}

//! Additional process noise of the next step: for what must be learnt again, and for what is not observable yet.

use super::{Belief, CgFilter};
use crate::loader::doubts::directions::BothDirections;
use crate::loader::floors::RATIO_PER_SENSITIVITY;
use crate::loader::layout::{ByState, CG_HEIGHT, CG_RATIO, Layout, SLIP_STIFFNESS};
use crate::loader::settings::Settings;
use crate::math::sqrt;

/// Standard deviation of the load sensitivity once it is observable, whatever is stated: two drives determine it better than any
/// statement. With a wider one, the first drive back attributes other errors to the tyres
/// (docs/measurements/2026-11-27-loader-covers.md).
const LEARNT_STD: f64 = 0.005;

/// Standard deviation of an axle's load sensitivity about that of both axles, where the latter is a state: a tenth of the usual
/// .01.
const AXLES_DIFFER: f64 = 0.001;

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// Error of the radii's load sensitivity and its variance; 0 where it is no state.
    pub(super) fn sensitivity(&self) -> (f64, f64) {
        const { Layout::of(N) }
            .load_sensitivity
            .map_or((0.0, 0.0), |i| {
                (self.belief.state()[i], self.belief.variance(i))
            })
    }

    /// Sets the additional process noise of the next step; `sensitivity` is that before the row.
    pub(super) fn loosen(
        &mut self,
        settings: &Settings,
        sensitivity: (f64, f64),
        process_std: &[f64; N],
        speed: f64,
        dt: f64,
    ) {
        let layout = const { Layout::of(N) };
        self.loosened = self.relearnt(settings);
        let slowest = settings.estimator.v_freeze;
        let driven = self.directions.drive(speed, slowest, dt);
        if let Some(i) = layout.load_sensitivity {
            match driven {
                BothDirections::NotYet | BothDirections::LongAgo => {
                    self.consider(i, sensitivity, process_std[i])
                }
                BothDirections::JustNow => self.open_sensitivity(settings, i),
                BothDirections::Recently => {}
            }
        }
        if self.changed == 0.0 {
            let prior = &settings.prior;
            self.loosened[CG_HEIGHT] = prior.cg_height_std;
            self.loosened[CG_RATIO] = prior.cg_ratio_std;
            if core::mem::take(&mut self.reopens) {
                self.loosened[SLIP_STIFFNESS] = prior.slip_stiffness_std;
                for i in layout.radii.into_iter().flatten() {
                    self.loosened[i] = prior.radius_std;
                }
            }
        }
    }

    /// Process noise beyond the usual, for what must be learnt again.
    fn relearnt(&mut self, settings: &Settings) -> [f64; N] {
        let (prior, state) = (&settings.prior, self.belief.state());
        let (mut share, mut radius) = (0.0, 0.0);
        if settings.at_work() {
            let ratio_std = self.belief.std(CG_RATIO);
            share = self.relearning.loosening(
                settings.estimator.relearn,
                prior,
                [state[SLIP_STIFFNESS], state[CG_RATIO]],
                ratio_std,
            );
            let loading = self.loading(settings);
            let ratio = loading.share * state[CG_RATIO] + loading.ratio;
            let mut sensitivity_std = settings.machine.radius_load_sensitivity_std;
            if const { Layout::of(N) }.load_sensitivity.is_some() {
                sensitivity_std = sensitivity_std.min(AXLES_DIFFER);
            }
            radius = self.relearning.radius_std(sensitivity_std, ratio);
        }
        let learnt = prior.radius_std * share;
        let parameters = [
            prior.slip_stiffness_std,
            prior.cg_height_std,
            prior.cg_ratio_std,
        ];
        ByState {
            parameters: parameters.map(|std| std * share),
            radius: sqrt(learnt * learnt + radius * radius),
            ..ByState::default()
        }
        .state()
    }

    /// Mean and variance of each state.
    pub(super) fn moments(&self) -> [(f64, f64); N] {
        core::array::from_fn(|i| (self.belief.state()[i], self.belief.variance(i)))
    }

    /// Keeps what only the wheels show, in a row in which they carry no information.
    pub(super) fn hold_parameters(&mut self, held: &[(f64, f64); N], process_std: &[f64; N]) {
        let radii = const { Layout::of(N) }.radii.into_iter().flatten();
        for i in [SLIP_STIFFNESS, CG_HEIGHT, CG_RATIO]
            .into_iter()
            .chain(radii)
        {
            self.consider(i, held[i], process_std[i]);
        }
    }

    /// Makes state `i` a consider parameter: it retains value and variance of before the row, with its process noise. The variance
    /// that the row took from it returns with the noise of the next step. The updates of the other states account for its variance.
    fn consider(&mut self, i: usize, (value, variance): (f64, f64), process_std: f64) {
        self.belief.state_mut()[i] = value;
        let lost = variance + process_std * process_std - self.belief.variance(i);
        self.loosen_by(i, sqrt(lost.max(0.0)));
    }

    /// Opens the load sensitivity, which is observable from now on, and the ratio that is correlated with it. The height opens so
    /// that its product with the sensitivity, which moves the radii, stays. A sensitivity that is known exactly opens nothing.
    fn open_sensitivity(&mut self, settings: &Settings, i: usize) {
        if settings.load_sensitivity_std() == 0.0 {
            return;
        }
        let state = self.belief.state();
        let ratio = RATIO_PER_SENSITIVITY * LEARNT_STD * state[CG_RATIO];
        let sensitivity = settings.machine.radius_load_sensitivity + state[i];
        let height = (state[CG_HEIGHT] * LEARNT_STD / sensitivity).abs();
        // Where the tyres may be rigid, the radii carry no information about the height: the whole prior.
        let height = settings.prior.cg_height_std.min(height);
        for (i, std) in [(i, LEARNT_STD), (CG_RATIO, ratio), (CG_HEIGHT, height)] {
            self.loosen_by(i, std);
        }
    }

    /// Adds a standard deviation to the process noise of state `i` in the next step.
    pub(super) fn loosen_by(&mut self, i: usize, std: f64) {
        self.loosened[i] = sqrt(self.loosened[i] * self.loosened[i] + std * std);
    }

    /// Standard deviation of the radii's load sensitivity that the covariance does not include.
    pub(in crate::loader) fn sensitivity_left(&self, settings: &Settings) -> f64 {
        let before = settings.load_sensitivity_std();
        match const { Layout::of(N) }.load_sensitivity {
            Some(_) => self.directions.left(before, self.manoeuvres.ratio()),
            None => before,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ekf::Ekf;
    use crate::loader::Method;

    #[test]
    fn a_row_in_which_the_wheels_carry_no_information_leaves_the_parameters() {
        let mut filter = CgFilter::<9, 3, Ekf<9, 3>>::new(&Settings::DEFAULT, Method::FullEkf);
        let held = filter.moments();
        let (ratio, variance) = held[CG_RATIO];
        // The row has moved the ratio and taken three quarters of its variance.
        filter
            .belief
            .separate(&[(CG_RATIO, 0.5 * sqrt(variance))], &[0.0; 9]);
        filter.belief.state_mut()[CG_RATIO] += 0.1;
        filter.hold_parameters(&held, &[0.0; 9]);
        assert_eq!(filter.belief.state()[CG_RATIO], ratio);
        let returns = filter.loosened[CG_RATIO];
        assert!((returns * returns - 0.75 * variance).abs() < 1e-12);
    }

    /// Standard deviation by which a ratio that moves by .2, after it was known once, opens the radii.
    fn opened<const N: usize, const M: usize>() -> f64
    where
        Ekf<N, M>: Belief<N, M>,
    {
        let settings = Settings::DEFAULT;
        let mut filter = CgFilter::<N, M, Ekf<N, M>>::new(&settings, Method::FullEkf);
        filter.belief.separate(&[(CG_RATIO, 0.001)], &[0.0; N]);
        filter.relearnt(&settings);
        filter.relearnt(&settings);
        filter.belief.state_mut()[CG_RATIO] += 0.2;
        let radii = Layout::of(N).radii.expect("radii");
        filter.relearnt(&settings)[radii[0]]
    }

    #[test]
    fn a_load_opens_the_radii_by_the_part_of_their_sensitivity_that_is_no_state() {
        let stated = Settings::DEFAULT.machine.radius_load_sensitivity_std;
        assert!(stated > AXLES_DIFFER);
        for (opened, std) in [
            (opened::<9, 3>(), stated),
            (opened::<12, 4>(), AXLES_DIFFER),
        ] {
            assert!((opened - 0.4 * std).abs() < 1e-12, "{opened} {std}");
        }
    }

    #[test]
    fn the_height_is_opened_by_what_the_sensitivity_of_the_tyre_leaves_of_it() {
        let opened = |sensitivity: f64| {
            let mut settings = Settings::DEFAULT;
            settings.machine.radius_load_sensitivity = sensitivity;
            let mut filter = CgFilter::<12, 4, Ekf<12, 4>>::new(&settings, Method::FullEkf);
            filter.open_sensitivity(&settings, 10);
            filter.loosened[CG_HEIGHT] / settings.prior.cg_height_std
        };
        assert!((opened(0.1) - 0.9 * 0.05 / 0.13).abs() < 1e-12);
        assert_eq!((opened(0.012), opened(0.0)), (1.0, 1.0));
    }

    #[test]
    fn a_tyre_with_unstated_sensitivity_may_be_rigid_and_the_first_drive_back_opens_no_more_than_for_a_stated_one()
     {
        let machine = Settings::DEFAULT.machine;
        let rigid = machine.radius_load_sensitivity / machine.radius_load_sensitivity_std;
        assert!(rigid < 1.96, "{rigid}");
        let opened = |stated: f64| {
            let mut settings = Settings::DEFAULT;
            settings.machine.radius_load_sensitivity_std = stated;
            let mut filter = CgFilter::<12, 4, Ekf<12, 4>>::new(&settings, Method::FullEkf);
            filter.open_sensitivity(&settings, 10);
            filter.loosened
        };
        assert_eq!(opened(machine.radius_load_sensitivity_std), opened(0.001));
        assert_eq!(opened(0.001)[10], LEARNT_STD);
    }
}

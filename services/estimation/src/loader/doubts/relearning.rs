//! Loosening of parameters that the filter has learnt wrongly and must learn again.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | dK, dlam | - | distance from the initial value, in standard deviations of the prior |
//! | u | result of `loosening` | share of the prior's standard deviations that is added again |
//! | D | `distance` | how far the share of the front axle has moved since the radii were learnt |
//! | sigma_rho | `sensitivity_std` | standard deviation of the load sensitivity of the rolling radius |
//!
//! **The start.** Wheel speeds determine the slips to some 1e-5, while K and lam are known to a tenth. One acceleration leaves a
//! curved valley of K, lam, h and rolling radii that explain it equally well. A Kalman filter, linearised or with sigma points,
//! replaces the valley by its tangent at the initial guess, and becomes certain of a point beside it. An initial ratio that is 0.15
//! off ends in a height that is 0.4 m off, with a standard deviation of 0.09 m. So the parameters are loosened once, when the ratio
//! is known to a part of its prior, by
//! ```text
//! u = gain (dK^2 + dlam^2),  at most 1
//! ```
//! of their prior standard deviations: the error of a tangent grows with the square of the distance.
//!
//! **A shifted load.** The rolling radii are learnt under one share of the load. When a payload moves the share by D, the
//! uncertainty of the load sensitivity rho moves the radii by 2 sigma_rho D: down in front, up behind. Radii that are held fixed
//! turn that into a height that is wrong by a third.

use crate::loader::settings::Prior;

/// Share of the prior's standard deviation below which the ratio is known.
const KNOWN: f64 = 0.3;

/// Change of the share below which it is noise, of the estimate or of the weighing.
const LEAST_SHIFT: f64 = 0.02;

/// State of the relearning.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Relearning {
    /// Initial K and lam.
    start: [f64; 2],
    started_again: bool,
    /// Share of the front axle under which the radii were learnt.
    learnt_at: Option<f64>,
    distance: f64,
}

impl Relearning {
    /// State at the start, with these values of K and lam.
    pub fn new(start: [f64; 2]) -> Self {
        Self {
            start,
            started_again: false,
            learnt_at: None,
            distance: 0.0,
        }
    }

    /// Share of the prior's standard deviations by which this row loosens the parameters; nonzero at most once.
    pub fn loosening(
        &mut self,
        gain: f64,
        prior: &Prior,
        [stiffness, ratio]: [f64; 2],
        ratio_std: f64,
    ) -> f64 {
        if self.started_again || ratio_std > KNOWN * prior.cg_ratio_std {
            return 0.0;
        }
        self.started_again = true;
        let stiffness = (stiffness - self.start[0]) / prior.slip_stiffness_std;
        let ratio = (ratio - self.start[1]) / prior.cg_ratio_std;
        (gain * (stiffness * stiffness + ratio * ratio)).min(1.0)
    }

    /// Whether the ratio has been known once.
    pub fn settled(&self) -> bool {
        self.started_again
    }

    /// Standard deviation by which to loosen the relative radii under this share of the front axle.
    ///
    /// The variance belongs to the distance, not to the path: a slow shift counts like a fast one. A load that is set down loosens
    /// as much as one that is taken up, because the radii have been learnt again in between.
    pub fn radius_std(&mut self, sensitivity_std: f64, share: f64) -> f64 {
        if !self.started_again {
            return 0.0;
        }
        let distance = share - *self.learnt_at.get_or_insert(share);
        if (distance - self.distance).abs() < LEAST_SHIFT {
            return 0.0;
        }
        let squares = (distance * distance - self.distance * self.distance).abs();
        self.distance = distance;
        2.0 * sensitivity_std * crate::math::sqrt(squares)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAIN: f64 = 0.1;

    #[test]
    fn parameters_are_loosened_once_and_by_the_square_of_the_distance() {
        let prior = Prior::default();
        let loosened = |deviations: f64| {
            let mut relearning = Relearning::new([prior.slip_stiffness, prior.cg_ratio]);
            let now = [
                prior.slip_stiffness,
                prior.cg_ratio + deviations * prior.cg_ratio_std,
            ];
            let early = relearning.loosening(GAIN, &prior, now, 0.4 * prior.cg_ratio_std);
            let then = relearning.loosening(GAIN, &prior, now, 0.2 * prior.cg_ratio_std);
            let later = relearning.loosening(GAIN, &prior, now, 0.1 * prior.cg_ratio_std);
            assert_eq!((early, later), (0.0, 0.0));
            then
        };
        assert!((loosened(1.0) - 0.1).abs() < 1e-12 && (loosened(2.0) - 0.4).abs() < 1e-12);
        assert_eq!(loosened(9.0), 1.0);
    }

    #[test]
    fn a_shifted_load_loosens_the_radii_by_its_distance_however_slowly_it_shifts() {
        let total = |steps: u32| {
            let prior = Prior::default();
            let mut relearning = Relearning::new([19.0, 0.45]);
            relearning.loosening(GAIN, &prior, [19.0, 0.45], 0.0);
            (0..=steps)
                .map(|k| 0.45 + 0.27 * f64::from(k) / f64::from(steps))
                .map(|share| relearning.radius_std(0.001, share).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        // 2 sigma_rho D; a slow shift may leave one LEAST_SHIFT out at its end: 2 x 0.02/0.27 of the variance.
        assert!((total(1) - 5.4e-4).abs() < 1e-12);
        assert!((total(2000) / 5.4e-4 - 1.0).abs() < 0.08);
    }
}

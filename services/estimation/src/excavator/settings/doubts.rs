//! Doubts: modelled uncertainties of the description of a working machine.

use crate::CommonError;
use crate::excavator::geometry::Geometry;
use crate::excavator::keys::Description;

/// Standard deviations of the machine's parameters about their described values. Each enters the default estimator
/// as a state, so that the interval contains it and the motion can reduce it. 0 stands for an exact value.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Doubts {
    /// Gain of the torque measurement, about 1.
    pub gain_std: f64,
    /// The same where boom pressures weigh too.
    pub weighed_gain_std: f64,
    /// Described efficiency of the drive: driving torque is multiplied by it, braking torque divided by it.
    pub efficiency: f64,
    /// Standard deviation of the efficiency.
    pub efficiency_std: f64,
    /// Coulomb friction, about the described one [N m].
    pub friction_std: f64,
    /// Slope of the ground along each of two axes \[rad\].
    pub slope_std: f64,
    /// First moment of the upper body about the swing axis without boom, arm and bucket, forward positive
    /// [kg m]; `None` takes the usual counterweight for this attachment.
    pub upper_first_moment: Option<f64>,
    /// Standard deviation of this moment [kg m]; `None` takes 3 % of a stated one, the spread among machines of a guessed one.
    pub upper_first_moment_std: Option<f64>,
    /// Delay of the velocity behind the torque that remains after the alignment \[s\].
    pub delay: f64,
    /// Standard deviation of this delay \[s\].
    pub delay_std: f64,
    /// Torque that the model leaves out, per 0.01 s, as a share of the largest torque so far.
    pub torque_share: f64,
    /// Relative standard deviation of the described masses and inertias of boom and arm, including the effect of their
    /// lengths.
    pub links_share: f64,
    /// Relative standard deviation of the upper body's inertia.
    pub upper_share: f64,
    /// Relative standard deviation of the bucket's mass.
    pub bucket_share: f64,
    /// Error of the drawing in the inertia at each posture, as a share of boom, arm and bucket: lengths, and centres
    /// beside the lines of the pins.
    pub form_share: f64,
    /// Errors common to all loads, by the uncertainty of their radius and of the empty attachment.
    pub loads: CommonError,
    /// Correlations from a calibration.
    pub found: Option<Correlations>,
}

/// Correlations of the errors of parameters that were calibrated with the same swings.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Correlations {
    /// Between masses of boom and arm, and gain of the torque sensor (measured over true).
    pub links_gain: f64,
    /// Between inertia of the upper body, and that gain.
    pub upper_gain: f64,
    /// Between inertia of the upper body, and masses of boom and arm.
    pub upper_links: f64,
    /// Those of the bucket's mass; `None` where the calibration scaled it by the factor of boom and arm.
    pub bucket: Option<OfBucket>,
}

/// Correlations of the error of the bucket's mass.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OfBucket {
    /// With the gain of the torque sensor (measured over true).
    pub gain: f64,
    /// With the inertia of the upper body.
    pub upper: f64,
    /// With the masses of boom and arm.
    pub links: f64,
}

impl Correlations {
    /// Whether the correlation matrix is positive semidefinite.
    #[must_use]
    pub fn are_possible(&self) -> bool {
        let [a, b, c] = [self.links_gain, self.upper_gain, self.upper_links];
        // From the variances of masses, gain and upper body, in this order, and their covariances.
        let is_positive = |[d, e, f]: [f64; 3], [a, b, c]: [f64; 3]| {
            let determinant = d * e * f + 2.0 * a * b * c - d * b * b - e * c * c - f * a * a;
            determinant >= -ROUNDING
        };
        let OfBucket { gain, upper, links } = self.bucket.unwrap_or_default();
        let all = [a, b, c, gain, upper, links];
        // What the error of the bucket leaves of them.
        let variances = [links, gain, upper].map(|r| 1.0 - r * r);
        let rest = [a - links * gain, b - gain * upper, c - links * upper];
        all.iter().all(|r| r.abs() <= 1.0)
            && is_positive([1.0; 3], [a, b, c])
            && is_positive(variances, rest)
    }
}

/// Rounding of written correlations.
const ROUNDING: f64 = 1e-3;

/// First moment of counterweight and engine over that of the folded, empty attachment, and the standard deviation of this ratio: 1.05
/// to 1.65 on machines of 5 to 40 t. It balances the attachment at a posture between folded and stretched.
const COUNTERWEIGHT: [f64; 2] = [1.15, 0.4];

impl Doubts {
    /// First moment of the upper body and its standard deviation [kg m].
    #[must_use]
    pub fn upper_moment(&self, geometry: &Geometry) -> (f64, f64) {
        let [value, spread] = COUNTERWEIGHT.map(|ratio| ratio * geometry.folded_moment());
        match (self.upper_first_moment, self.upper_first_moment_std) {
            (Some(moment), std) => (moment, std.unwrap_or(0.03 * moment.abs())),
            (None, std) => (-value, std.unwrap_or(spread.abs())),
        }
    }
}

impl Default for Doubts {
    /// Doubts of a machine file that states none of them.
    fn default() -> Self {
        Self::of(&Description::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlations_that_contradict_each_other_are_refused() {
        let settings = |links: f64, upper: f64, both: f64| {
            let mut d = Description::default();
            d.machine.links_gain_correlation = Some(links);
            d.machine.upper_gain_correlation = upper;
            d.machine.upper_links_correlation = both;
            crate::excavator::Settings::of(&d).check()
        };
        assert_eq!(settings(-0.97, -0.94, 0.85), Ok(()));
        assert!(settings(-0.97, -0.94, -0.85).is_err());
        assert!(settings(-0.97, 0.0, 0.9).is_err());
    }

    #[test]
    fn an_unstated_counterweight_is_within_its_spread_on_machines_of_all_sizes() {
        // Operating mass, first moment of the upper body [kg m].
        for (mass, known) in [
            (14_000.0, -7176.0),
            (18_000.0, -10_200.0),
            (22_000.0, -14_100.0),
            (36_000.0, -27_236.0),
        ] {
            let mut d = Description::default();
            d.machine.operating_mass = Some(mass);
            let geometry = Geometry::of(&d.of_its_size());
            let (moment, std) = Doubts::default().upper_moment(&geometry);
            assert!((moment - known).abs() < 1.5 * std, "{mass} {moment} {std}");
        }
    }
}

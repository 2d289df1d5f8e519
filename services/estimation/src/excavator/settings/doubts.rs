//! What a description of a working machine leaves open, and how far.

use crate::CommonError;
use crate::excavator::geometry::Geometry;
use crate::excavator::keys::Description;

/// Standard deviations of what a described machine may differ by. Each enters the default estimator as a
/// state, so that its interval carries the doubt and the motion can remove it; 0 says that it is exactly so.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Doubts {
    /// Gain of the torque measurement about 1.
    pub gain_std: f64,
    /// The same where pressures weigh beside it.
    pub weighed_gain_std: f64,
    /// Efficiency of the drive: the described one; driving torque arrives times it, braking torque divided by it.
    pub efficiency: f64,
    /// Its standard deviation.
    pub efficiency_std: f64,
    /// Coulomb friction about the described one [N m].
    pub friction_std: f64,
    /// Slope of the ground along each of two axes \[rad\].
    pub slope_std: f64,
    /// First moment of the upper body about the swing axis without boom, arm and bucket, forward positive
    /// [kg m]; `None` takes the counterweight that machines have for their attachment.
    pub upper_first_moment: Option<f64>,
    /// Its standard deviation [kg m]; `None` takes 3 % of a stated moment, the spread among machines of a guessed one.
    pub upper_first_moment_std: Option<f64>,
    /// How much later the velocity comes than the torque, beside what is taken out exactly \[s\].
    pub delay: f64,
    /// Its standard deviation \[s\].
    pub delay_std: f64,
    /// What the model of the torque leaves out, per 0.01 s, as a share of the largest torque seen.
    pub torque_share: f64,
    /// Relative standard deviation of the described masses and inertias of boom and arm, with what their lengths
    /// do to them.
    pub links_share: f64,
    /// The same of the upper body's inertia.
    pub upper_share: f64,
    /// The same of the bucket's mass.
    pub bucket_share: f64,
    /// What the drawing misses of the inertia at each posture, as a share of boom, arm and bucket: lengths, and
    /// centres beside the lines of the pins.
    pub form_share: f64,
    /// What all loads are off together, by what is not known of their radius and of the empty attachment.
    pub loads: CommonError,
    /// What a calibration has found together.
    pub found: Option<Correlations>,
}

/// Correlations of the errors of what a calibration has found from the same swings.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Correlations {
    /// Masses of boom and arm, and the gain of the torque sensor (measured over true).
    pub links_gain: f64,
    /// Inertia of the upper body, and that gain.
    pub upper_gain: f64,
    /// Inertia of the upper body, and masses of boom and arm.
    pub upper_links: f64,
}

impl Correlations {
    /// Whether three quantities can have them.
    #[must_use]
    pub fn are_possible(&self) -> bool {
        let [a, b, c] = [self.links_gain, self.upper_gain, self.upper_links];
        let determinant = 1.0 + 2.0 * a * b * c - a * a - b * b - c * c;
        [a, b, c].iter().all(|r| r.abs() <= 1.0) && determinant >= -ROUNDING
    }
}

/// Correlations are written with so many digits.
const ROUNDING: f64 = 1e-3;

/// Counterweight and engine over what balances the folded, empty attachment, and the standard deviation of this ratio: 1.05 to 1.65
/// on machines of 5 to 40 t. They balance it at some way between folded and stretched.
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
    /// Those of a machine file that says nothing of them.
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

//! Covariances of the quantities that a calibration has identified together.

use super::filter::{BUCKET, Filter, GAIN, LINKS, UPPER};
use crate::excavator::doubts::{Correlations, Doubts, OfBucket};
use crate::math::sqrt;

/// Factor of the rounded correlations that keeps the covariance positive.
const SHARED: f64 = 0.99;

/// Sets the correlations that a calibration has found. One without those of the bucket scaled boom, arm and bucket by one factor, which is
/// part of the bucket's error. The gain state is the inverse of the sensor's gain, hence the opposite signs.
pub(super) fn correlate(filter: &mut Filter, doubts: &Doubts, found: Correlations) {
    let shared = (doubts.links_share / doubts.bucket_share.max(f64::MIN_POSITIVE)).min(1.0);
    let bucket = found.bucket.unwrap_or(OfBucket {
        gain: shared * found.links_gain,
        upper: shared * found.upper_links,
        links: shared,
    });
    for (i, j, correlation) in [
        (GAIN, LINKS, -found.links_gain),
        (GAIN, UPPER, -found.upper_gain),
        (GAIN, BUCKET, -bucket.gain),
        (UPPER, LINKS, found.upper_links),
        (UPPER, BUCKET, bucket.upper),
        (LINKS, BUCKET, bucket.links),
    ] {
        let covariance = SHARED * correlation * sqrt(filter.p[i][i] * filter.p[j][j]);
        (filter.p[i][j], filter.p[j][i]) = (covariance, covariance);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excavator::keys::Description;
    use crate::excavator::settings::Settings;
    use crate::excavator::working::Working;

    /// Relative standard deviation of the empty machine's inertia over the torque gain.
    fn of_the_ratio(correlated: bool) -> f64 {
        let mut d = Description::default();
        d.machine.mass_tolerance = 0.02;
        d.machine.upper_tolerance = Some(0.02);
        d.machine.bucket_tolerance = Some(0.02);
        // No soil sticks.
        (d.prior.payload, d.prior.payload_std) = (0.0, 1e-3);
        d.sensors.swing_torque_gain_std = Some(0.02);
        if correlated {
            d.machine.links_gain_correlation = Some(-0.97);
            d.machine.upper_gain_correlation = -0.94;
            d.machine.upper_links_correlation = 0.85;
        } else {
            d.machine.geometry_tolerance = 0.0;
        }
        let settings = Settings::of(&d);
        let doubts = settings.doubts.expect("doubts");
        let filter = Working::new(&settings, &doubts).filter;
        let now = settings.geometry.inertia([0.6, -1.8, -0.5]);
        // T (1 + k) = J w'.
        let row = [
            (GAIN, -now.empty),
            (UPPER, 1.0),
            (BUCKET, now.per_bucket),
            (LINKS, now.links),
        ];
        sqrt(filter.combination(&row).1) / now.empty
    }

    #[test]
    fn rounded_correlations_leave_no_combination_without_variance() {
        let mut d = Description::default();
        d.machine.links_gain_correlation = Some(1.0);
        d.machine.upper_gain_correlation = 1.0;
        d.machine.upper_links_correlation = 0.97;
        let settings = Settings::of(&d);
        assert_eq!(settings.check(), Ok(()));
        let filter = Working::new(&settings, &settings.doubts.expect("doubts")).filter;
        let share = |i: usize| 1.0 / sqrt(filter.p[i][i]);
        // The combination with the smallest variance.
        let row = [(GAIN, -2.0), (LINKS, 1.0), (UPPER, 1.0)].map(|(i, a)| {
            let sign = if i == GAIN { -1.0 } else { 1.0 };
            (i, sign * a * share(i))
        });
        let (_, variance) = filter.combination(&row);
        assert!(variance > 0.0, "{variance}");
    }

    #[test]
    fn masses_and_gain_that_were_found_together_err_together() {
        // The swings of the calibration determine inertia over gain far better than either.
        assert!(of_the_ratio(true) < 0.4 * of_the_ratio(false));
        assert!(of_the_ratio(false) > 0.02);
    }
}

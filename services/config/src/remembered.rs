//! Remaining certainty of a parameter that an earlier run has identified.

/// Least restored standard deviation, as a share of the described prior's: tyres are changed
/// and grease ages without notice.
pub const LEAST_SHARE: f64 = 0.6;
/// Length of a pause after which only the value is left [s]: 30 days.
const FORGOTTEN: f64 = 30.0 * 86_400.0;
/// Deviations from the stated prior beyond which a value contradicts it. A run's value differs from its sound prior by at most one
/// standard deviation of that in rms: of 370 Gaussian ones, one goes beyond.
const CONTRADICTS: f64 = 3.0;

/// Standard deviation of a parameter after a pause \[s\]: it was `std` when identified, and `prior` before.
/// It lies between a share of the prior's and all of it.
pub fn widened(std: f64, prior: f64, pause: f64) -> f64 {
    let grown = std * std + prior * prior * (pause / FORGOTTEN);
    grown.sqrt().clamp(LEAST_SHARE * prior, prior)
}

/// Whether a parameter identified as `value` with `std` serves as the prior of a later run, where the description states one.
///
/// # Errors
/// Why the stated prior stays: the run knew no more than it, or contradicts it.
pub fn serves([value, std]: [f64; 2], stated: [f64; 2]) -> Result<(), String> {
    let [expected, prior] = stated;
    // The run began with the prior: what it ended with contains it, so both together count it twice.
    if std >= prior {
        return Err(format!(
            "known to ± {std:.4}, no better than the stated ± {prior:.4}"
        ));
    }
    if (value - expected).abs() > CONTRADICTS * prior {
        return Err(format!(
            "{value:.4} contradicts the stated {expected:.4} ± {prior:.4}"
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_widens_up_to_the_prior() {
        assert_eq!(widened(0.01, 1.0, 0.0), LEAST_SHARE);
        let week = widened(0.7, 1.0, 7.0 * 86_400.0);
        assert!(week > 0.7 && week < 1.0, "{week}");
        assert_eq!(widened(0.01, 1.0, 1e12), 1.0);
        assert_eq!(widened(5.0, 1.0, 0.0), 1.0);
    }

    #[test]
    fn a_run_that_knows_no_more_or_contradicts_leaves_the_stated_prior() {
        let stated = [19.0, 2.5];
        assert_eq!(serves([24.0, 0.5], stated), Ok(()));
        let vague = serves([24.0, 12.0], stated).unwrap_err();
        assert!(vague.contains("no better than the stated ± 2.5"), "{vague}");
        let other = serves([34.6, 1.0], stated).unwrap_err();
        assert!(other.contains("contradicts the stated 19"), "{other}");
    }
}

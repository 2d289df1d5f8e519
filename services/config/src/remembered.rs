//! Remaining certainty of a parameter that an earlier run has identified.

/// Least restored standard deviation, as a share of the described prior's: tyres are changed
/// and grease ages without notice.
pub const LEAST_SHARE: f64 = 0.6;
/// Length of a pause after which only the value is left [s]: 30 days.
const FORGOTTEN: f64 = 30.0 * 86_400.0;

/// Standard deviation of a parameter after a pause \[s\]: it was `std` when identified, and `prior` before.
/// It lies between a share of the prior's and all of it.
pub fn widened(std: f64, prior: f64, pause: f64) -> f64 {
    let grown = std * std + prior * prior * (pause / FORGOTTEN);
    grown.sqrt().clamp(LEAST_SHARE * prior, prior)
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
}

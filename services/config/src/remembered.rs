//! What is left of a parameter that an earlier run has learnt.

/// Share of the described prior's standard deviation below which none is restored: tyres are changed,
/// grease ages, and nobody says so.
pub const LEAST_SHARE: f64 = 0.6;
/// After a pause of this length nothing is left but the value [s]: 30 days.
const FORGOTTEN: f64 = 30.0 * 86_400.0;

/// Standard deviation of a parameter, in its unit, that was known to `std` when it was learnt and `prior` before,
/// after a pause \[s\]: between a share of the prior's and all of it.
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

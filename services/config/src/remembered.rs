//! Remaining certainty of a parameter that an earlier run has identified.

/// Correlation of a parameter between two runs without a pause: tyres are changed and grease ages without notice.
pub const CORRELATION: f64 = 0.8;
/// Time in which the correlation falls to 1/e [s]: 60 days.
const FORGOTTEN: f64 = 60.0 * 86_400.0;
/// Deviations from the stated prior beyond which a value contradicts it. A run's value differs from its sound prior by at most one
/// standard deviation of that in rms: of 370 Gaussian ones, one goes beyond.
const CONTRADICTS: f64 = 3.0;

/// Prior of a run from a parameter that the run before identified, and from its stated prior; each a value and its standard deviation.
///
/// From run to run a parameter varies about its stated value, as a stationary process of first order:
/// ```text
/// x - m = c (x_0 - m),   var = c^2 std_0^2 + (1 - c^2) s^2,   c = 0.8 exp(-pause/60 d)
/// ```
/// With the mean of the run before instead, it would be a random walk: an error that all runs share grows from run to run. The
/// deviation remains between 0.6 of the stated one and all of it.
pub fn recalled([value, std]: [f64; 2], [expected, prior]: [f64; 2], pause: f64) -> [f64; 2] {
    let c = CORRELATION * (-pause / FORGOTTEN).exp();
    let variance = c * c * std * std + (1.0 - c * c) * prior * prior;
    [
        expected + c * (value - expected),
        variance.sqrt().min(prior),
    ]
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
    fn a_pause_widens_up_to_the_prior_and_returns_to_it() {
        let stated = [10.0, 1.0];
        let now = recalled([12.0, 1e-9], stated, 0.0);
        assert!((now[0] - 11.6).abs() < 1e-12 && (now[1] - 0.6).abs() < 1e-12);
        let week = recalled([12.0, 1e-9], stated, 7.0 * 86_400.0);
        assert!(week[0] < now[0] && week[1] > now[1], "{week:?}");
        let [value, std] = recalled([12.0, 0.1], stated, 1e12);
        assert!((value - 10.0).abs() < 1e-12 && (std - 1.0).abs() < 1e-12);
        assert_eq!(recalled([12.0, 5.0], stated, 0.0)[1], 1.0);
    }

    #[test]
    fn an_error_that_all_runs_share_stays_bounded() {
        // Each run measures 3 stated deviations below the stated value, to a deviation of the stated one.
        let stated = [0.0, 1.0_f64];
        let mut prior = stated;
        for _ in 0..100 {
            let precision = prior[1].powi(-2) + 1.0;
            let run = [
                (prior[0] * prior[1].powi(-2) - 3.0) / precision,
                precision.sqrt().recip(),
            ];
            prior = recalled(run, stated, 0.0);
        }
        assert!((-1.8..-1.2).contains(&prior[0]), "{prior:?}");
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

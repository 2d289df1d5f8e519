//! Means, deviations, percentiles.

/// Arithmetic mean; 0 of nothing.
pub fn mean(values: &[f64]) -> f64 {
    if values.is_empty() {
        0.0
    } else {
        values.iter().sum::<f64>() / values.len() as f64
    }
}

/// Population standard deviation; 0 of nothing.
pub fn deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    let squares: Vec<f64> = values.iter().map(|v| (v - centre).powi(2)).collect();
    mean(&squares).sqrt()
}

/// Largest absolute value; 0 of nothing.
pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, v| v.abs().max(largest))
}

/// The percentile `share` (0 to 1), interpolated between neighbours; 0 of nothing.
pub fn percentile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let position = share.clamp(0.0, 1.0) * sorted.len().saturating_sub(1) as f64;
    let (below, rest) = (position.floor() as usize, position.fract());
    match (sorted.get(below), sorted.get(below + 1)) {
        (Some(a), Some(b)) => a + rest * (b - a),
        (Some(a), None) => *a,
        _ => 0.0,
    }
}

/// The median; 0 of nothing.
pub fn median(values: &[f64]) -> f64 {
    percentile(values, 0.5)
}

/// The 95th percentile; 0 of nothing.
pub fn p95(values: &[f64]) -> f64 {
    percentile(values, 0.95)
}

/// Standard error of [`mean`]; 0 of nothing.
pub fn mean_error(values: &[f64]) -> f64 {
    deviation(values) / (values.len().max(1) as f64).sqrt()
}

/// Standard error of [`p95`]: half the distance between the percentiles one standard deviation of the rank
/// below and above, without a law of distribution.
pub fn p95_error(values: &[f64]) -> f64 {
    let rank = (0.95 * 0.05 / values.len().max(1) as f64).sqrt();
    0.5 * (percentile(values, 0.95 + rank) - percentile(values, 0.95 - rank))
}

/// The percentage of true values; 0 of nothing.
pub fn percentage(values: impl IntoIterator<Item = bool>) -> f64 {
    let hits: Vec<f64> = values
        .into_iter()
        .map(|hit| if hit { 100.0 } else { 0.0 })
        .collect();
    mean(&hits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_interpolate_between_neighbours() {
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(
            [0.0, 0.5, 1.0].map(|p| percentile(&values, p)),
            [1.0, 2.5, 4.0]
        );
        assert_eq!(percentile(&[], 0.5), 0.0);
    }

    #[test]
    fn the_deviation_is_that_of_the_population() {
        assert_eq!(
            (
                mean(&[1.0, 3.0]),
                deviation(&[1.0, 3.0]),
                largest(&[-3.0, 1.0])
            ),
            (2.0, 1.0, 3.0)
        );
        assert_eq!(percentage([true, true, false, false]), 50.0);
    }
}

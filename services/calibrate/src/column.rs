//! Means and percentiles of columns of numbers.

/// Mean of the finite values within `half` of each time.
pub fn moving_mean(time: &[f64], values: &[f64], half: f64) -> Vec<f64> {
    let (mut first, mut last, mut sum, mut count) = (0, 0, 0.0, 0_usize);
    let mut out = Vec::with_capacity(time.len());
    for &t in time {
        while last < time.len() && time[last] <= t + half {
            if values[last].is_finite() {
                sum += values[last];
                count += 1;
            }
            last += 1;
        }
        while time[first] < t - half {
            if values[first].is_finite() {
                sum -= values[first];
                count -= 1;
            }
            first += 1;
        }
        out.push(if count > 0 { sum / count as f64 } else { 0.0 });
    }
    out
}

/// The value that this share of the values does not exceed; 0 of nothing.
pub fn percentile(mut values: Vec<f64>, share: f64) -> f64 {
    values.retain(|v| v.is_finite());
    values.sort_by(f64::total_cmp);
    let index = share * values.len().saturating_sub(1) as f64;
    values.get(index.round() as usize).copied().unwrap_or(0.0)
}

//! Moving means and percentiles of columns of numbers, and rows in the order of time.

/// Mean of the finite values within `half` of each time; NaN where there is none. Each window is summed separately, so that one huge
/// value spoils no other.
pub fn moving_mean(time: &[f64], values: &[f64], half: f64) -> Vec<f64> {
    let (mut first, mut last) = (0, 0);
    let mut mean = |t: f64| {
        last += time[last..].iter().take_while(|&&x| x <= t + half).count();
        first += time[first..].iter().take_while(|&&x| x < t - half).count();
        let there = values[first..last].iter().filter(|v| v.is_finite());
        let count = there.clone().count();
        there.sum::<f64>() / count as f64
    };
    time.iter().map(|&t| mean(t)).collect()
}

/// The rows whose time is finite and later than that of the previous accepted row.
pub fn increasing<R: Copy>(rows: &[R], time: impl Fn(&R) -> f64) -> Vec<R> {
    let mut accepted: Vec<R> = Vec::with_capacity(rows.len());
    for row in rows.iter().filter(|r| time(r).is_finite()) {
        if accepted.last().is_none_or(|last| time(row) > time(last)) {
            accepted.push(*row);
        }
    }
    accepted
}

/// The value that this share of the finite values does not exceed; 0 if there is none.
pub fn percentile(mut values: Vec<f64>, share: f64) -> f64 {
    values.retain(|v| v.is_finite());
    values.sort_by(f64::total_cmp);
    let index = share * values.len().saturating_sub(1) as f64;
    values.get(index.round() as usize).copied().unwrap_or(0.0)
}

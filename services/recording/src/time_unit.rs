//! Times that are in another unit than seconds.

const UNITS: [(&str, f64); 3] = [("ms", 1e3), ("us", 1e6), ("ns", 1e9)];

/// The usual step of these times \[s\] and the unit that they seem to be in: the rows are some power of thousand further
/// apart than the rate of the sensors \[Hz\] says.
#[must_use]
pub fn time_unit(times: &[f64], rate: f64) -> Option<(f64, &'static str)> {
    let mut steps: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    steps.retain(|step| *step > 0.0);
    steps.sort_by(f64::total_cmp);
    let step = *steps.get(steps.len() / 2)?;
    let apart = step * rate;
    // Sensors of a third to three times the described rate.
    let (unit, _) = UNITS
        .into_iter()
        .find(|(_, factor)| (0.3..=3.0).contains(&(apart / factor)))?;
    Some((step, unit))
}

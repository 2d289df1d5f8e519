//! Detects times in another unit than seconds.

use std::ops::RangeInclusive;

use crate::unit;

/// Units in which foreign files give times.
const UNITS: [&str; 7] = ["ms", "us", "100ns", "ns", "min", "h", "day"];

/// Rates that fit the described one, as its multiple: a third to three times.
const AS_STATED: RangeInclusive<f64> = 0.3..=3.0;

/// The usual step of these times \[s\] and the unit that they seem to have: the step differs from the sensors' period (`rate` \[Hz\])
/// by the ratio of this unit to a second.
pub fn time_unit(times: &[f64], rate: f64) -> Option<(f64, &'static str)> {
    let step = middle(times)?;
    let apart = step * rate;
    let unit = UNITS
        .into_iter()
        .filter_map(unit::find)
        .find(|unit| AS_STATED.contains(&(apart * unit.factor)))?;
    Some((rounded(step), unit.name))
}

/// Step of the rows above which no estimate is trusted, of either machine \[s\]: at 0.33 s some are, at 0.5 s none.
const FARTHEST: f64 = 0.4;

/// Message on rows so far apart that turning and lifting between them is not measured, for times in seconds.
pub fn too_slow(times: &[f64], rate: f64) -> Option<String> {
    let is_other = time_unit(times, rate).is_some();
    let step = usual_step(times).filter(|step| *step > FARTHEST && !is_other)?;
    Some(format!(
        "the rows are {step} s apart: of so few nothing is trusted, and loads are missed; record 10 or more a second, or check the unit of the time"
    ))
}

/// Step of the rows below which no sensor of a machine measures \[s\].
const NEAREST: f64 = 5e-4;

/// Message on rows so close that their times are hardly in seconds, for times without a likely unit.
pub fn too_fast(times: &[f64], rate: f64) -> Option<String> {
    let is_other = time_unit(times, rate).is_some();
    let is_stated = |step: f64| AS_STATED.contains(&(step * rate));
    let step =
        usual_step(times).filter(|step| *step < NEAREST && !is_other && !is_stated(*step))?;
    Some(format!(
        "the rows are {step} s apart: no sensor of a machine measures so often; check the unit of the time, or state sensors.rate"
    ))
}

/// The usual step of times \[s\], with three digits.
pub fn usual_step(times: &[f64]) -> Option<f64> {
    middle(times).map(rounded)
}

fn middle(times: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    steps.retain(|step| *step > 0.0);
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied()
}

/// A step with three digits.
pub(crate) fn rounded(step: f64) -> f64 {
    format!("{step:.2e}").parse().unwrap_or(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_are_too_far_apart_are_named_unless_their_times_are_in_another_unit() {
        let times = |step: f64| (0..9).map(|i| step * f64::from(i)).collect::<Vec<_>>();
        assert_eq!(too_slow(&times(0.2), 100.0), None);
        let words = too_slow(&times(1.0), 100.0).unwrap_or_default();
        assert!(words.contains("are 1 s apart"), "{words}");
        assert_eq!(too_slow(&times(10.0), 100.0), None);
    }

    #[test]
    fn rows_that_are_too_close_are_named_unless_the_stated_rate_is_theirs() {
        let times = |step: f64| (0..9).map(|i| step * f64::from(i)).collect::<Vec<_>>();
        assert_eq!(too_fast(&times(1e-3), 100.0), None);
        let words = too_fast(&times(1e-5), 100.0).unwrap_or_default();
        assert!(words.contains("are 0.00001 s apart"), "{words}");
        assert_eq!(too_fast(&times(1e-4), 1e4), None, "a stated rate");
        assert_eq!(too_fast(&times(0.01 / 3600.0), 100.0), None, "hours");
    }

    #[test]
    fn the_unit_is_that_in_which_the_rows_are_as_far_apart_as_the_sensors_say() {
        let times = |step: f64| (0..50).map(|i| f64::from(i) * step).collect::<Vec<_>>();
        let unit = |step| time_unit(&times(step), 100.0).map(|(_, unit)| unit);
        for (step, expected) in [
            (10.0, Some("ms")),
            (1e4, Some("us")),
            (1e5, Some("100ns")),
            (0.01 / 60.0, Some("min")),
            (0.01 / 3600.0, Some("h")),
            (0.01 / 86_400.0, Some("day")),
            (0.01, None),
            (0.1, None),
        ] {
            assert_eq!(unit(step), expected, "{step}");
        }
    }
}

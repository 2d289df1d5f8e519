//! The unit of a column, guessed from its name, else from its values.

use std::ops::Range;

use super::{shown, sizes};
use crate::time_unit::rounded;
use crate::unit::{self, Unit};

/// Steepest ground on which a machine drives \[rad\]: 35 degrees.
pub const STEEPEST: f64 = 0.61;

/// Fastest swing of an excavator \[rpm\]: data sheets state 5 to 14. In degrees per second the numbers are 30 and more.
const FASTEST_SWING: f64 = 15.0;

/// A unit and the reason for it.
pub(super) struct Guess {
    pub(super) unit: Option<&'static Unit>,
    pub(super) reason: String,
}

impl From<(Option<&'static Unit>, String)> for Guess {
    fn from((unit, reason): (Option<&'static Unit>, String)) -> Self {
        Self { unit, reason }
    }
}

/// The unit of a column: by its name (`speed [km/h]`, `boom_deg`), else by its values; and the text in the name's brackets if
/// it is no unit. Pressures without a unit are up to `largest_pressure`.
pub(super) fn of(
    signal: &str,
    si: &str,
    name: &str,
    values: &[f64],
    largest_pressure: f64,
) -> (Guess, Option<String>) {
    if let Some(unit) = unit::of_name(name, si) {
        let more = unit::ambiguous(name, unit).map_or("", |a| a.note);
        let guess = Guess {
            unit: Some(unit).filter(|u| u.factor != 1.0),
            reason: format!("unit by the column's name{more}"),
        };
        return (guess, None);
    }
    let mut guess = by_values(signal, si, values, largest_pressure);
    let text = unit::bracketed(name).filter(|text| !text.is_empty() && !si.is_empty());
    let text = text.map(shown);
    if let Some(text) = &text {
        guess.reason = format!(
            "{text} is no unit that heft knows: check it; {}",
            guess.reason
        );
    }
    // A column of dates has no numbers.
    let has_number = values.iter().any(|x| x.is_finite());
    (guess, text.filter(|_| has_number))
}

fn by_values(signal: &str, si: &str, values: &[f64], largest_pressure: f64) -> Guess {
    let finite: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
    if finite.is_empty() {
        let reason = match signal {
            "t" => "by its name; no number in it (dates are read as they are)",
            _ => "by its name; no number in it: check it",
        };
        return Guess {
            unit: None,
            reason: reason.into(),
        };
    }
    if signal == "t" {
        return time(&finite);
    }
    let all = finite.len();
    let beyond = |limit: f64| beyond(&finite, limit);
    let grade = beyond(STEEPEST.to_degrees());
    if signal == "slope" && grade * 50 > all {
        return Guess {
            unit: unit::find("%"),
            reason: format!(
                "{grade} of {all} values beyond 35, too steep in degrees: a grade in %?"
            ),
        };
    }
    // Values that no machine reaches in SI units: steeper hills, a turn and more for a joint, 3 rad/s of swing,
    // 15 m/s of a loader.
    let (limit, other) = match (signal, si) {
        ("slope" | "pitch" | "roll", _) => (STEEPEST, "deg"),
        (_, "rad") => (core::f64::consts::TAU, "deg"),
        ("swing_velocity", _) if beyond(FASTEST_SWING) * 50 <= all => (3.0, "rpm"),
        ("swing_velocity" | "yaw_rate", _) => (3.0, "deg/s"),
        ("speed", _) => (15.0, "km/h"),
        ("front_wheel_speed" | "rear_wheel_speed", _) => (40.0, "rpm"),
        ("mass", _) => return mass(&finite),
        (_, "Pa") => return sizes::pressure(largest_pressure).into(),
        (_, "N m") => return sizes::torque(sizes::largest(finite.iter())).into(),
        _ => {
            let taken = match si {
                "" => String::new(),
                si => format!("taken as {si}: "),
            };
            return Guess {
                unit: None,
                reason: format!("by its name; {taken}check it"),
            };
        }
    };
    let beyond = beyond(limit);
    if beyond * 50 > all {
        let or_grade = match signal {
            "slope" => " A grade in % has unit = \"%\", scale = 1.0",
            _ => "",
        };
        let reason = format!("{beyond} of {all} values beyond {limit:.2} {si}: {other}?{or_grade}");
        return Guess {
            unit: unit::find(other),
            reason,
        };
    }
    Guess {
        unit: None,
        reason: format!("by its name; {beyond} of {all} values beyond {limit:.2}: {si}?"),
    }
}

/// Number of values beyond a limit. A single number in fewer than half of the rows, of either sign, is a mark of missing samples.
pub(super) fn beyond(values: &[f64], limit: f64) -> usize {
    let mut far = values.iter().map(|x| x.abs()).filter(|x| *x > limit);
    let Some(first) = far.next() else {
        return 0;
    };
    let (mut count, mut is_mark) = (1, true);
    for x in far {
        count += 1;
        is_mark &= x == first;
    }
    match is_mark && 2 * count < values.len() && count > 1 {
        true => 0,
        false => count,
    }
}

/// Step of the rows, as a number: in days it is below this, in seconds above.
const SLOWEST: f64 = 1e-4;

/// Step below which the unit is probably not seconds [s]: few machines are sampled faster.
const FASTEST: f64 = 1e-3;

/// Units of times since 1970, and the numbers of the years 2001 to 2096.
const SINCE_1970: [(&str, Range<f64>); 4] = [
    ("s", 1e9..4e9),
    ("ms", 1e12..4e12),
    ("us", 1e15..4e15),
    ("ns", 1e18..4e18),
];

/// Least step that is not one of recorded rows \[s\]: in milliseconds the same number is plausible.
const SLOW: f64 = 4.0;

/// Least plausible duration of a recording \[s\].
const SHORT: f64 = 10.0;

/// The unit of times by their size and step: a machine is sampled each 0.1 ms to 8 s. In the days of a sheet that is less than 1e-4.
fn time(times: &[f64]) -> Guess {
    let mut steps: Vec<f64> = times
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|d| *d > 0.0)
        .collect();
    steps.sort_by(f64::total_cmp);
    let Some(step) = steps.get(steps.len() / 2) else {
        return Guess {
            unit: None,
            reason: "by its name; it never increases".into(),
        };
    };
    // A counter since switch-on may have such numbers: its rows would be too far apart.
    let is_date = |(name, range): &&(&str, Range<f64>)| {
        let factor = unit::find(name).map_or(1.0, |unit| unit.factor);
        *step * factor < SLOW && times.iter().all(|t| range.contains(t))
    };
    let since_1970 = SINCE_1970.iter().find(is_date);
    let length = *step * times.len() as f64 * 1e-3;
    let name = match *step {
        _ if times.iter().all(|t| TICKS.contains(t)) => "100ns",
        _ if since_1970.is_some() => since_1970.map_or("s", |(name, _)| name),
        s if (1.0..SLOW).contains(&s) && length < SHORT => "s",
        s if s > 1e6 => "ns",
        s if s > 1e3 => "us",
        s if s >= 1.0 => "ms",
        s if s < SLOWEST && is_serial_date(times) => "day",
        _ => "s",
    };
    let other = match name {
        "s" if *step < FASTEST => format!(" in min it would be {} s", rounded(60.0 * step)),
        "ms" if *step < SLOW && since_1970.is_none() => " in s it would be slow".to_owned(),
        "s" if *step >= 1.0 && since_1970.is_none() => " in ms it would be short".to_owned(),
        _ => String::new(),
    };
    let reason = format!("median step {}: {name}?{other}", rounded(*step));
    Guess {
        unit: unit::find(name).filter(|u| u.factor != 1.0),
        reason,
    }
}

/// Ticks of 100 ns since the year 1 or 1601, as Windows counts them: larger than microseconds, smaller than nanoseconds since 1970.
const TICKS: Range<f64> = 1e17..1e18;

/// Whether these are days of 1982 to 2119: since 1900 as in a sheet, or since the year 0 as in MATLAB.
fn is_serial_date(times: &[f64]) -> bool {
    let within = |from: f64| move |day: &f64| (30_000.0..80_000.0).contains(&(day - from));
    times.iter().all(within(0.0)) || times.iter().all(within(693_960.0))
}

fn mass(values: &[f64]) -> Guess {
    let largest = rounded(sizes::largest(values.iter()));
    let unit = unit::find("t").filter(|_| largest < 200.0);
    let word = if unit.is_some() { "t" } else { "kg" };
    Guess {
        unit,
        reason: format!("up to {largest}: {word}?"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_and_the_size_of_times_tell_their_unit() {
        let of = |first: f64, step: f64| {
            let times: Vec<f64> = (0..9).map(|k| first + step * f64::from(k)).collect();
            time(&times).unit.map_or("s", |unit| unit.name)
        };
        for (first, step, unit) in [
            (0.0, 0.01, "s"),
            (1.8e9, 0.01, "s"),
            (1.8e9, 1.0, "s"),
            (1.8e12, 2000.0, "ms"),
            (1.2e9, 10.0, "ms"),
            (1.2e9, 1e4, "us"),
            (2e12, 1e7, "ns"),
            (0.0, 1.0, "s"),
            (0.0, 10.0, "ms"),
            (1.8e12, 10.0, "ms"),
            (1.8e15, 1e4, "us"),
            (1.8e18, 1e7, "ns"),
            (6.39e17, 1e5, "100ns"),
            (1.34e17, 1e5, "100ns"),
            (46_206.5, 1.2e-7, "day"),
            (740_168.5, 1.2e-7, "day"),
            (46_206.5, 1.0 / 86_400.0, "day"),
            (46_206.5, 0.01, "s"),
        ] {
            assert_eq!(of(first, step), unit, "{first} {step}");
        }
        // Rows of 100 Hz, with times in minutes.
        let minutes = time(&[0.0, 0.01 / 60.0, 0.02 / 60.0]).reason;
        assert!(minutes.contains("in min it would be 0.01 s"), "{minutes}");
    }

    #[test]
    fn a_swing_of_a_few_units_is_one_in_turns_a_minute() {
        let of = |largest: f64| {
            let swing: Vec<f64> = (0..100)
                .map(|k| largest * (0.1 * f64::from(k)).sin())
                .collect();
            by_values("swing_velocity", "rad/s", &swing, 0.0)
                .unit
                .map(|unit| unit.name)
        };
        assert_eq!(
            [1.1, 10.8, 32.0].map(of),
            [None, Some("rpm"), Some("deg/s")]
        );
    }

    #[test]
    fn what_stands_for_no_sample_is_no_angle_in_degrees() {
        let unit = |mark: f64, every: u32| {
            let angle = |k: u32| {
                if k.is_multiple_of(every) {
                    mark
                } else {
                    0.8 + 1e-4 * f64::from(k)
                }
            };
            let angles: Vec<f64> = (0..1000).map(angle).collect();
            by_values("boom_angle", "rad", &angles, 0.0)
                .unit
                .map(|unit| unit.name)
        };
        for mark in [-9999.0, 65_535.0, 327.67, 1e30] {
            assert_eq!(unit(mark, 20), None, "{mark}");
        }
        assert_eq!(unit(45.0, 1), Some("deg"));
    }

    #[test]
    fn a_unit_that_is_not_known_is_said() {
        let reason = |name: &str| of("swing_torque", "N m", name, &[1.0], 0.0).0.reason;
        assert!(reason("torque [stone ft]").starts_with("stone ft is no unit that heft knows"));
        assert!(!reason("torque [kNm]").contains("no unit"));
        assert!(!reason("torque []").contains("no unit"));
    }
}

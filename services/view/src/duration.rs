//! Durations as written on a command line: `90s`, `5m`, `2h`, `500ms`.

/// Units and their values in seconds.
const UNITS: &[(&str, f64)] = &[
    ("ms", 1e-3),
    ("s", 1.0),
    ("m", 60.0),
    ("min", 60.0),
    ("h", 3600.0),
    ("d", 86_400.0),
];

/// Longest accepted duration \[s\]: a million days, which means for ever.
const MOST: f64 = 1e11;

/// Parses a duration of 0 or more \[s\]; a bare number is in seconds.
///
/// # Errors
/// It is malformed; the text describes the format.
pub fn seconds(text: &str) -> Result<f64, String> {
    of(text, Some(1.0))
}

/// Parses a duration above 0 \[s\].
///
/// # Errors
/// As for [`seconds`], and for 0.
pub fn positive(text: &str) -> Result<f64, String> {
    match seconds(text)? {
        0.0 => Err("a time above 0".into()),
        time => Ok(time),
    }
}

/// Parses a duration of 0 or more \[s\]. A bare number is in units of `alone` seconds; with `None` a unit is required.
///
/// # Errors
/// It is malformed; the text describes the format.
pub fn of(text: &str, alone: Option<f64>) -> Result<f64, String> {
    let text = text.trim();
    let number = text.trim_end_matches(|c: char| c.is_alphabetic());
    let unit = &text[number.len()..];
    let known = UNITS
        .iter()
        .find(|(name, _)| name.eq_ignore_ascii_case(unit));
    let factor = match unit {
        "" => alone,
        _ => known.map(|(_, factor)| *factor),
    };
    let number = number.trim_end().parse::<f64>().ok();
    let time = number.zip(factor).map(|(number, factor)| number * factor);
    time.filter(|time| (0.0..=MOST).contains(time))
        .ok_or_else(|| wrong(alone))
}

fn wrong(alone: Option<f64>) -> String {
    let named = |alone| UNITS.iter().find(|(_, factor)| Some(*factor) == alone);
    let alone = named(alone).map_or(String::new(), |(unit, _)| {
        format!("; a number alone is in {unit}")
    });
    format!("write a time like 500ms, 90s, 5m, 2h or 7d{alone}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_has_a_unit_or_is_in_seconds() {
        let times = [
            ("5m", 300.0),
            ("5min", 300.0),
            ("90s", 90.0),
            ("90", 90.0),
            ("2h", 7200.0),
            ("1.5 d", 129_600.0),
            ("500ms", 0.5),
            ("1e3", 1000.0),
            (" .25 S ", 0.25),
            ("0", 0.0),
        ];
        for (text, time) in times {
            assert_eq!(seconds(text), Ok(time), "{text}");
        }
        for wrong in [
            "",
            "s",
            "-1",
            "-1s",
            "nan",
            "inf",
            "5 minutes",
            "1h30",
            "1e300h",
            "5µs",
            "é",
        ] {
            let words = seconds(wrong).expect_err(wrong);
            assert!(
                words.contains("5m") && words.contains("alone is in s"),
                "{words}"
            );
        }
        assert!(positive("0s").is_err());
    }

    #[test]
    fn a_number_alone_has_the_unit_of_its_option_or_is_none() {
        assert_eq!(of("30", Some(60.0)), Ok(1800.0));
        assert_eq!(of("30s", Some(60.0)), Ok(30.0));
        assert_eq!(of("90", Some(86_400.0)), Ok(7_776_000.0));
        let words = of("30", None).expect_err("no unit");
        assert!(!words.contains("alone"), "{words}");
    }
}

//! Numbers for people: rounded to their uncertainty, thousands grouped.

/// Separator of groups of three digits; it does not break at the end of a line.
pub const GROUP: char = '\u{a0}';

/// Most decimal places, and most zeros before the point, of a shown number: a double has no more digits.
const PLACES: i32 = 17;

/// `value` with `decimals` places and grouped thousands; negative `decimals` round to tens, hundreds...
pub fn grouped(value: f64, decimals: i32) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value.abs() >= 1e21 || (value != 0.0 && value.abs() < 1e-21) {
        return format!("{value:.3e}").replace('-', "−");
    }
    let decimals = decimals.clamp(-PLACES, PLACES);
    let unit = 10f64.powi(-decimals.min(0));
    let rounded = (value / unit).round() * unit;
    let places = usize::try_from(decimals.max(0)).unwrap_or(0);
    let text = if decimals > 0 {
        format!("{value:.places$}")
    } else {
        format!("{rounded:.0}")
    };
    group(&text)
}

fn group(text: &str) -> String {
    let negative = text.starts_with('-');
    let digits = text.trim_start_matches('-');
    let (whole, fraction) = digits
        .split_once('.')
        .map_or((digits, None), |(w, f)| (w, Some(f)));
    let zero = digits.chars().all(|c| c == '0' || c == '.');
    let mut out = String::new();
    if negative && !zero {
        out.push('−');
    }
    for (i, c) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i).is_multiple_of(3) {
            out.push(GROUP);
        }
        out.push(c);
    }
    if let Some(fraction) = fraction {
        out.push('.');
        out.push_str(fraction);
    }
    out
}

/// Decimal places that show `resolution` with two digits.
pub fn decimals(resolution: f64) -> i32 {
    if !resolution.is_finite() || resolution <= 0.0 {
        return 3;
    }
    let first = resolution.log10().floor() as i32;
    // 0.0996 rounds to 0.10: one place fewer.
    let carried = (resolution / 10f64.powi(first - 1)).round() >= 100.0;
    (1 - first - i32::from(carried)).clamp(-9, 9)
}

/// `value` with `digits` significant digits.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return grouped(value, 0);
    }
    let first = value.abs().log10().floor() as i32;
    grouped(value, digits.saturating_sub(1 + first).min(9))
}

/// Value and standard deviation, both with the places that the standard deviation justifies.
pub fn value_and_std(value: f64, std: f64) -> (String, String) {
    let places = decimals(std);
    (grouped(value, places), grouped(std, places))
}

/// "5 873 ± 61 kg m²".
pub fn with_std(value: f64, std: f64, unit: &str) -> String {
    let (value, std) = value_and_std(value, std);
    if unit.is_empty() {
        format!("{value}{GROUP}±{GROUP}{std}")
    } else {
        format!("{value}{GROUP}±{GROUP}{std}{GROUP}{unit}")
    }
}

/// A number in large print, and its 95 % interval, both with their unit; a share in percent.
pub fn large(value: f64, std: f64, of: &str) -> (String, String) {
    let (factor, name) = if of.is_empty() {
        (100.0, "%".to_owned())
    } else {
        (1.0, unit(of))
    };
    let (value, std) = (factor * value, factor * std);
    let (number, _) = value_and_std(value, std);
    let interval = interval_95(value, std);
    (
        format!("{number}{GROUP}{name}"),
        format!("{interval}{GROUP}{name}"),
    )
}

/// "5 753 to 5 993": the normal 95 % interval of a quantity that is not negative, cut off at zero.
pub fn interval_95(value: f64, std: f64) -> String {
    let places = decimals(std);
    let half = estimation::HALF_WIDTH_95 * std;
    let (low, high) = (value - half, value + half);
    let low = if high > 0.0 { low.max(0.0) } else { low };
    format!("{} to {}", grouped(low, places), grouped(high, places))
}

/// A unit as printed: "kg m^2" becomes "kg m²".
pub fn unit(text: &str) -> String {
    text.replace("^2", "²").replace(' ', "\u{a0}")
}

/// A time in the unit that suits it: "1.2 µs".
pub fn nanoseconds(ns: f64) -> String {
    let (factor, unit) = match ns {
        v if v < 1e3 => (1.0, "ns"),
        v if v < 1e6 => (1e-3, "µs"),
        v if v < 1e9 => (1e-6, "ms"),
        _ => (1e-9, "s"),
    };
    format!("{}{GROUP}{unit}", significant(ns * factor, 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(text: &str) -> String {
        text.replace(GROUP, " ")
    }

    #[test]
    fn a_value_is_rounded_to_its_uncertainty() {
        let shown = |v, s| plain(&with_std(v, s, "kg"));
        assert_eq!(shown(5873.4, 61.2), "5 873 ± 61 kg");
        assert_eq!(shown(5873.4, 612.0), "5 870 ± 610 kg");
        assert_eq!(shown(-0.41234, 0.0031), "−0.4123 ± 0.0031 kg");
        assert_eq!(shown(0.9, 0.0996), "0.90 ± 0.10 kg");
        assert_eq!(shown(0.001, 5.0), "0.0 ± 5.0 kg");
        assert_eq!(shown(1.0, f64::NAN), "1.000 ± – kg");
    }

    #[test]
    fn an_interval_of_what_cannot_be_negative_is_not() {
        assert_eq!(plain(&interval_95(5873.0, 61.2)), "5 753 to 5 993");
        assert_eq!(interval_95(100.0, 100.0), "0 to 300");
        assert_eq!(interval_95(-100.0, 20.0), "−139 to −61");
    }

    #[test]
    fn digits_are_grouped_from_the_point() {
        assert_eq!(plain(&grouped(-1_234_567.891, 1)), "−1 234 567.9");
        assert_eq!(plain(&grouped(999.9, 0)), "1 000");
        assert_eq!(grouped(-0.0004, 2), "0.00");
        assert_eq!(plain(&significant(0.012_345, 3)), "0.0123");
        assert_eq!(plain(&nanoseconds(12_340.0)), "12.3 µs");
    }
}

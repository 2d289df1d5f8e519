//! Units that a signal map may name, and how others write them.

use core::f64::consts::{PI, TAU};

/// A unit: name, the SI unit of the same dimension, and its size in that.
#[derive(Debug, PartialEq)]
pub(crate) struct Unit {
    pub name: &'static str,
    pub si: &'static str,
    pub factor: f64,
    /// Other ways to write it, in small letters without blanks, dots and carets.
    aliases: &'static [&'static str],
}

const fn unit(
    name: &'static str,
    si: &'static str,
    factor: f64,
    aliases: &'static [&'static str],
) -> Unit {
    Unit {
        name,
        si,
        factor,
        aliases,
    }
}

pub(crate) const UNITS: &[Unit] = &[
    unit("s", "s", 1.0, &["sec", "second", "seconds"]),
    unit("ms", "s", 1e-3, &["msec", "millis", "milliseconds"]),
    unit(
        "us",
        "s",
        1e-6,
        &["usec", "µs", "μs", "micros", "microseconds"],
    ),
    unit("ns", "s", 1e-9, &["nsec", "nanos", "nanoseconds"]),
    unit("min", "s", 60.0, &["minutes"]),
    unit("day", "s", 86400.0, &["days"]),
    unit("rad", "rad", 1.0, &["radian", "radians"]),
    unit("mrad", "rad", 1e-3, &[]),
    unit(
        "deg",
        "rad",
        PI / 180.0,
        &["degree", "degrees", "degs", "°", "º"],
    ),
    unit("turn", "rad", TAU, &["rev", "turns"]),
    unit("rad/s", "rad/s", 1.0, &["rad/sec", "rads", "radps", "1/s"]),
    unit(
        "deg/s",
        "rad/s",
        PI / 180.0,
        &["deg/sec", "degree/s", "°/s", "°/sec", "º/s", "dps", "degps"],
    ),
    unit(
        "rpm",
        "rad/s",
        TAU / 60.0,
        &[
            "1/min", "r/min", "rev/min", "u/min", "min-1", "/min", "revs/min",
        ],
    ),
    unit("turn/s", "rad/s", TAU, &["rev/s", "r/s", "rps"]),
    unit("rad/s^2", "rad/s^2", 1.0, &["rad/s2", "rad/s²"]),
    unit("m", "m", 1.0, &["meter", "metre"]),
    unit("mm", "m", 1e-3, &[]),
    unit("cm", "m", 1e-2, &[]),
    unit("km", "m", 1e3, &[]),
    unit("ft", "m", 0.3048, &["feet", "foot"]),
    unit("inch", "m", 0.0254, &["inches"]),
    unit("m/s", "m/s", 1.0, &["m/sec", "mps"]),
    unit("mm/s", "m/s", 1e-3, &["mm/sec"]),
    unit(
        "km/h",
        "m/s",
        1.0 / 3.6,
        &["kph", "kmh", "km/hr", "kmph", "km/hour"],
    ),
    unit("mph", "m/s", 0.44704, &["mi/h"]),
    unit("m/s^2", "m/s^2", 1.0, &["m/s2", "m/s²", "m/s/s", "m/sec2"]),
    unit("g", "m/s^2", 9.80665, &["gs", "g0"]),
    unit("N", "N", 1.0, &["newton"]),
    unit("kN", "N", 1e3, &[]),
    unit("lbf", "N", 4.448_221_615_261, &[]),
    unit("N m", "N m", 1.0, &["nm", "n*m", "n·m", "newtonmeter"]),
    unit("Nm", "N m", 1.0, &[]),
    unit("kN m", "N m", 1e3, &["knm", "kn*m", "kn·m"]),
    unit("kNm", "N m", 1e3, &[]),
    unit("MN m", "N m", 1e6, &["mn*m", "mn·m"]),
    unit("MNm", "N m", 1e6, &[]),
    unit(
        "lbf ft",
        "N m",
        1.355_817_948_331,
        &[
            "lbfft", "ftlbf", "ftlb", "lbft", "ft-lb", "lb-ft", "ft-lbf", "lbf-ft", "lbf*ft",
            "lbf·ft",
        ],
    ),
    unit("kg", "kg", 1.0, &["kilogram"]),
    unit("lb", "kg", 0.453_592_37, &["lbs", "pound", "pounds", "lbm"]),
    unit("t", "kg", 1e3, &["ton", "tons", "tonne", "tonnes"]),
    unit("kg m^2", "kg m^2", 1.0, &["kgm2", "kg*m2", "kgm²", "kg*m²"]),
    unit("N m s/rad", "N m s/rad", 1.0, &["nms/rad", "nms"]),
    unit("Pa", "Pa", 1.0, &["pascal"]),
    unit("kPa", "Pa", 1e3, &[]),
    unit("MPa", "Pa", 1e6, &[]),
    unit("bar", "Pa", 1e5, &["bars"]),
    unit("mbar", "Pa", 1e2, &["hpa"]),
    unit("psi", "Pa", 6_894.757_293_168, &[]),
    unit("V", "V", 1.0, &["volt", "volts"]),
    unit("mV", "V", 1e-3, &[]),
    unit("A", "A", 1.0, &["ampere", "amp", "amps"]),
    unit("mA", "A", 1e-3, &[]),
    unit("%", "", 0.01, &["percent", "pct"]),
    unit("1", "", 1.0, &["-", "ratio"]),
];

/// The unit called `name`.
pub(crate) fn find(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|u| u.name == name)
}

/// The unit that a DBC file or a column's header writes as `text`: by its name, by an alias, or by
/// its name in other capitals (a `G` is no gram, an `NM` no nautical mile, on a machine).
pub(crate) fn guess(text: &str) -> Option<&'static Unit> {
    let text = text.trim();
    let plain = |text: &str| -> String {
        let kept = text.chars().filter(|c| !matches!(c, ' ' | '.' | '^' | '_'));
        kept.flat_map(char::to_lowercase).collect()
    };
    let wanted = plain(text);
    find(text)
        .or_else(|| UNITS.iter().find(|u| u.aliases.contains(&wanted.as_str())))
        .or_else(|| UNITS.iter().find(|u| plain(u.name) == wanted))
}

/// The unit that a name tells of what is measured in `si`: in brackets, or by the words behind it (`boom_deg`, `gyro.z_deg_s`,
/// `BoomAngleDeg`). The degrees of an angular velocity are degrees a second.
pub(crate) fn of_name(name: &str, si: &str) -> Option<&'static Unit> {
    units_of(name).into_iter().find_map(|unit| {
        let a_second = || find(&format!("{}/s", unit.name)).filter(|_| unit.si == "rad");
        Some(unit)
            .filter(|unit| unit.si == si)
            .or_else(|| a_second().filter(|unit| unit.si == si))
    })
}

/// The unit that a name tells, where that is of something else than `si`. A letter alone may mean anything.
pub(crate) fn foreign(name: &str, si: &str) -> Option<&'static str> {
    let tells = |unit: &&Unit| bracketed(name).is_some() || unit.name.len() > 1 || unit.name == "%";
    let unit = units_of(name).into_iter().find(tells)?;
    of_name(name, si).is_none().then_some(unit.name)
}

/// What stands in the last brackets of a name.
fn bracketed(name: &str) -> Option<&str> {
    let (_, text) = name.rsplit_once(['[', '('])?;
    Some(text.trim_end_matches([']', ')']))
}

/// The units that the end of a name may mean, the longest first.
fn units_of(name: &str) -> Vec<&'static Unit> {
    if let Some(text) = bracketed(name) {
        return guess(text).into_iter().collect();
    }
    let words = words(name);
    // A name is more than its unit.
    let lengths = (1..words.len().min(4)).rev();
    let end = |length: usize| {
        let end = words[words.len() - length..].iter().copied();
        let end: Vec<&str> = end.filter(|w| !w.eq_ignore_ascii_case("per")).collect();
        ["", "/"].map(|between| guess(&end.join(between)))
    };
    lengths.flat_map(end).flatten().collect()
}

/// The words of a name: between signs and blanks, and where a capital begins one.
fn words(name: &str) -> Vec<&str> {
    let (mut words, mut begin, mut before) = (Vec::new(), 0, ' ');
    for (at, c) in name.char_indices() {
        let is_sign = matches!(c, '_' | '.' | '-' | ' ' | ':');
        if is_sign || before.is_lowercase() && c.is_uppercase() {
            words.push(&name[begin..at]);
            begin = if is_sign { at + c.len_utf8() } else { at };
        }
        before = c;
    }
    words.push(&name[begin..]);
    words.retain(|word| !word.is_empty());
    words
}

/// The units of a dimension, each once.
pub(crate) fn of(si: &str) -> String {
    let mut all: Vec<&Unit> = Vec::new();
    for unit in UNITS.iter().filter(|unit| unit.si == si) {
        if !all.iter().any(|known| same(known, unit)) {
            all.push(unit);
        }
    }
    let names: Vec<&str> = all.iter().map(|unit| unit.name).collect();
    names.join(", ")
}

/// Whether both are the same unit, perhaps under two names.
pub(crate) fn same(a: &Unit, b: &Unit) -> bool {
    a.si == b.si && a.factor == b.factor
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_others_write_is_understood() {
        for (text, name) in [
            ("km/h", "km/h"),
            ("KPH", "km/h"),
            ("1/min", "rpm"),
            ("RPM", "rpm"),
            ("°", "deg"),
            ("deg/sec", "deg/s"),
            ("m/s²", "m/s^2"),
            ("N.m", "N m"),
            ("NM", "N m"),
            ("ft-lb", "lbf ft"),
            ("lbf·ft", "lbf ft"),
            ("lbs", "lb"),
            ("kN.m", "kN m"),
            ("G", "g"),
            ("MPa", "MPa"),
            ("Bar", "bar"),
            ("%", "%"),
            ("kg m2", "kg m^2"),
        ] {
            assert_eq!(guess(text).map(|u| u.name), Some(name), "{text}");
        }
        for text in ["", "°C", "L/h", "counts", "mPa s"] {
            assert_eq!(guess(text), None, "{text}");
        }
    }

    #[test]
    fn the_end_of_a_name_tells_its_unit() {
        for (name, si, unit) in [
            ("swing.rate_deg", "rad/s", "deg/s"),
            ("SwingRateDegPerSec", "rad/s", "deg/s"),
            ("swing_rate_deg_per_s", "rad/s", "deg/s"),
            ("gyro_z_deg_s", "rad/s", "deg/s"),
            ("omega_rad_s", "rad/s", "rad/s"),
            ("speed_m_s", "m/s", "m/s"),
            ("speed_km_h", "m/s", "km/h"),
            ("BoomAngleDeg", "rad", "deg"),
            ("swing torque [kNm]", "N m", "kNm"),
            ("swing_torque_N_m", "N m", "Nm"),
            ("SwingTorqueKNm", "N m", "kN m"),
            ("wheel_rpm", "rad/s", "rpm"),
            ("mass_t", "kg", "t"),
        ] {
            assert_eq!(of_name(name, si).map(|u| u.name), Some(unit), "{name}");
            assert_eq!(foreign(name, si), None, "{name}");
        }
        for name in ["deg", "speed", "arm_A", "swing_velocity_t", "boom (left)"] {
            assert_eq!(of_name(name, "rad"), None, "{name}");
            assert_eq!(foreign(name, "rad"), None, "{name}");
        }
        assert_eq!(foreign("boom_pos_mm", "rad"), Some("mm"));
        assert_eq!(foreign("slope_pct", "rad"), Some("%"));
        assert_eq!(foreign("swing_moment_bar", "N m"), Some("bar"));
    }

    #[test]
    fn the_page_on_maps_lists_every_unit() {
        let page = include_str!("../../../docs/map.md");
        for unit in UNITS {
            assert!(page.contains(&format!("`{}`", unit.name)), "{}", unit.name);
        }
    }

    #[test]
    fn no_alias_belongs_to_two_units() {
        let all: Vec<_> = UNITS.iter().flat_map(|u| u.aliases).collect();
        for (i, alias) in all.iter().enumerate() {
            assert!(!all[..i].contains(alias), "{alias}");
        }
    }
}

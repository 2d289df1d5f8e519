//! Units that a signal map may name, and how others write them.

use core::f64::consts::{PI, TAU};

/// A unit: name, the SI unit of the same dimension, and its size in that.
#[derive(Debug, PartialEq)]
pub(crate) struct Unit {
    pub name: &'static str,
    pub si: &'static str,
    pub factor: f64,
    /// Other ways to write it, as [`plain`] leaves them.
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
    unit(
        "s",
        "s",
        1.0,
        &[
            "sec", "second", "seconds", "sek", "sekunden", "secondes", "segundos", "秒",
        ],
    ),
    unit("ms", "s", 1e-3, &["msec", "millis", "milliseconds"]),
    unit("us", "s", 1e-6, &["usec", "µs", "micros", "microseconds"]),
    unit("ns", "s", 1e-9, &["nsec", "nanos", "nanoseconds"]),
    unit("100ns", "s", 1e-7, &["tick", "ticks"]),
    unit("min", "s", 60.0, &["minutes"]),
    unit(
        "h",
        "s",
        3600.0,
        &["hr", "hour", "hours", "stunden", "heures", "horas"],
    ),
    unit("day", "s", 86400.0, &["days"]),
    unit("rad", "rad", 1.0, &["radian", "radians", "弧度"]),
    unit("mrad", "rad", 1e-3, &[]),
    unit(
        "deg",
        "rad",
        PI / 180.0,
        &[
            "degree", "degrees", "degs", "°", "grad", "degré", "degrés", "grados", "gradi", "度",
        ],
    ),
    unit("turn", "rad", TAU, &["rev", "turns"]),
    unit("gon", "rad", PI / 200.0, &["gons", "gradian", "gradians"]),
    unit(
        "rad/s",
        "rad/s",
        1.0,
        &["rad/sec", "rads", "radps", "1/s", "rads-1", "s-1", "rad/秒"],
    ),
    unit("mrad/s", "rad/s", 1e-3, &["mrad/sec"]),
    unit(
        "deg/s",
        "rad/s",
        PI / 180.0,
        &[
            "deg/sec",
            "degree/s",
            "degrees/s",
            "°/s",
            "°/sec",
            "dps",
            "degps",
            "grad/s",
            "度/s",
            "度/秒",
        ],
    ),
    unit(
        "rpm",
        "rad/s",
        TAU / 60.0,
        &[
            "1/min",
            "turn/min",
            "turns/min",
            "o/min",
            "ot/min",
            "dev/dak",
            "r/min",
            "rev/min",
            "u/min",
            "min-1",
            "/min",
            "revs/min",
            "tr/min",
            "giri/min",
            "转/分",
            "回転/分",
        ],
    ),
    unit("turn/s", "rad/s", TAU, &["rev/s", "r/s", "rps"]),
    unit("gon/s", "rad/s", PI / 200.0, &["gons/s"]),
    unit("rad/min", "rad/s", 1.0 / 60.0, &[]),
    unit(
        "deg/min",
        "rad/s",
        PI / 180.0 / 60.0,
        &["°/min", "grad/min"],
    ),
    unit("rad/s^2", "rad/s^2", 1.0, &["rads-2"]),
    unit("m", "m", 1.0, &["meter", "metre"]),
    unit("mm", "m", 1e-3, &[]),
    unit("cm", "m", 1e-2, &[]),
    unit("km", "m", 1e3, &[]),
    unit("ft", "m", 0.3048, &["feet", "foot"]),
    unit("inch", "m", 0.0254, &["inches"]),
    unit("m/s", "m/s", 1.0, &["m/sec", "mps", "ms-1"]),
    unit("mm/s", "m/s", 1e-3, &["mm/sec"]),
    unit(
        "km/h",
        "m/s",
        1.0 / 3.6,
        &["kph", "kmh", "km/hr", "kmph", "km/hour"],
    ),
    unit("mph", "m/s", 0.44704, &["mi/h"]),
    unit("m/min", "m/s", 1.0 / 60.0, &[]),
    unit("ft/s", "m/s", 0.3048, &["ft/sec", "fps"]),
    unit("ft/min", "m/s", 0.3048 / 60.0, &["fpm"]),
    unit(
        "knot",
        "m/s",
        1852.0 / 3600.0,
        &["knots", "kn", "kt", "kts"],
    ),
    unit("m/s^2", "m/s^2", 1.0, &["m/s/s", "m/sec2", "ms-2"]),
    unit("ft/s^2", "m/s^2", 0.3048, &["ft/sec2", "ft/s/s"]),
    unit("g", "m/s^2", 9.80665, &["gs", "g0", "g's"]),
    unit("mg", "m/s^2", 9.806_65e-3, &["milli-g"]),
    unit("N", "N", 1.0, &["newton"]),
    unit("kN", "N", 1e3, &[]),
    unit("lbf", "N", 4.448_221_615_261, &[]),
    unit("N m", "N m", 1.0, &["n-m", "newtonmeter"]),
    unit("Nm", "N m", 1.0, &[]),
    unit("kN m", "N m", 1e3, &["kn-m"]),
    unit("kNm", "N m", 1e3, &[]),
    unit("MN m", "N m", 1e6, &["mn-m"]),
    unit("MNm", "N m", 1e6, &[]),
    unit("mN m", "N m", 1e-3, &[]),
    unit("mNm", "N m", 1e-3, &[]),
    unit("N mm", "N m", 1e-3, &["n-mm"]),
    unit("N cm", "N m", 1e-2, &["n-cm"]),
    unit("daN m", "N m", 10.0, &["dan-m"]),
    unit("kgf m", "N m", 9.80665, &["kgf-m", "kgm", "kg-m", "kpm"]),
    unit("tf m", "N m", 9_806.65, &["tf-m"]),
    unit(
        "lbf ft",
        "N m",
        1.355_817_948_331,
        &[
            "ftlbf",
            "ftlb",
            "lbft",
            "ft-lb",
            "lb-ft",
            "ft-lbf",
            "lbf-ft",
            "ftlbs",
            "ft-lbs",
            "lbsft",
            "lbs-ft",
            "footpound",
            "footpounds",
            "foot-pound",
            "foot-pounds",
        ],
    ),
    unit(
        "klbf ft",
        "N m",
        1_355.817_948_331,
        &[
            "kipft", "kip-ft", "ftkip", "ft-kip", "kft-lb", "klb-ft", "klbft",
        ],
    ),
    unit(
        "lbf in",
        "N m",
        0.112_984_829_027_6,
        &[
            "inlbf", "inlb", "lbin", "in-lb", "lb-in", "in-lbf", "lbf-in", "inlbs", "in-lbs",
        ],
    ),
    unit("kg", "kg", 1.0, &["kilogram"]),
    unit("lb", "kg", 0.453_592_37, &["lbs", "pound", "pounds", "lbm"]),
    unit("klb", "kg", 453.592_37, &["klbs", "kip", "kips"]),
    unit(
        "short ton",
        "kg",
        907.184_74,
        &["shorttons", "uston", "ustons"],
    ),
    unit(
        "t",
        "kg",
        1e3,
        &[
            "ton",
            "tons",
            "tonne",
            "tonnes",
            "tonnen",
            "metricton",
            "metrictons",
        ],
    ),
    unit("kg m^2", "kg m^2", 1.0, &["kgm2"]),
    unit("N m s/rad", "N m s/rad", 1.0, &["nms/rad", "nms"]),
    unit("Pa", "Pa", 1.0, &["pascal"]),
    unit("kPa", "Pa", 1e3, &["kn/m2"]),
    unit("MPa", "Pa", 1e6, &["n/mm2"]),
    unit("bar", "Pa", 1e5, &["bars", "barg", "bar(g)"]),
    unit("mbar", "Pa", 1e2, &["hpa"]),
    unit(
        "psi",
        "Pa",
        6_894.757_293_168,
        &["psig", "psi(g)", "lbf/in2", "lb/in2", "lb/squareinch"],
    ),
    unit("ksi", "Pa", 6_894_757.293_168, &[]),
    unit("kgf/cm^2", "Pa", 98_066.5, &["kgf/cm2", "kg/cm2"]),
    unit("V", "V", 1.0, &["volt", "volts"]),
    unit("mV", "V", 1e-3, &[]),
    unit("A", "A", 1.0, &["ampere", "amp", "amps"]),
    unit("mA", "A", 1e-3, &[]),
    unit("%", "", 0.01, &["percent", "pct"]),
    unit("‰", "", 0.001, &["permille", "promille", "mm/m"]),
    unit("1", "", 1.0, &["-", "ratio"]),
];

/// The unit called `name`.
pub(crate) fn find(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|u| u.name == name)
}

/// The unit that a DBC file or a column's header writes as `text`: by its name, by its name in
/// other capitals (a `G` is no gram, an `NM` no nautical mile, on a machine), or by an alias.
pub(crate) fn guess(text: &str) -> Option<&'static Unit> {
    guesses(text).next()
}

/// All that it may be: `kn` is kN in other capitals, or knots.
fn guesses(text: &str) -> impl Iterator<Item = &'static Unit> {
    let all = known(text);
    let all = if all.is_empty() {
        known(&in_symbols(text))
    } else {
        all
    };
    all.into_iter()
}

fn known(text: &str) -> Vec<&'static Unit> {
    let (written, wanted) = (bare(text), plain(text));
    let is_written = |unit: &&Unit| bare(unit.name) == written;
    let is_named = |unit: &&Unit| plain(unit.name) == wanted;
    let is_known = |unit: &&Unit| unit.aliases.contains(&wanted.as_str());
    let mut all: Vec<&Unit> = find(text.trim()).into_iter().collect();
    // An mNm is no MNm.
    all.extend(UNITS.iter().filter(is_written));
    all.extend(UNITS.iter().filter(is_named));
    all.extend(UNITS.iter().filter(is_known));
    all
}

/// The words of units, in English and elsewhere, and their symbols.
const SYMBOLS: &[(&str, &[&str])] = &[
    ("/", &["per"]),
    ("2", &["squared"]),
    (
        "s",
        &[
            "sec", "second", "seconds", "sek", "sekunde", "sekund", "с", "сек", "秒", "초",
        ],
    ),
    (
        "min",
        &["minute", "minuut", "мин", "分", "分钟", "분", "dak", "dk"],
    ),
    (
        "h",
        &["hour", "hours", "hr", "uur", "ч", "小时", "时", "時", "시"],
    ),
    (
        "deg",
        &[
            "degree",
            "degrees",
            "grader",
            "aste",
            "astetta",
            "graus",
            "graden",
            "град",
            "градус",
            "градусы",
            "stopnie",
            "stopni",
            "stupně",
            "stupňů",
            "derece",
            "度",
            "도",
        ],
    ),
    ("rad", &["radian", "radians", "рад", "弧度", "ラジアン"]),
    (
        "rev",
        &[
            "revolution",
            "revolutions",
            "rotations",
            "umdrehungen",
            "umdr",
            "varv",
            "tours",
            "obr",
            "omw",
            "omwentelingen",
            "toeren",
            "omdr",
            "kierr",
            "kierrosta",
            "об",
            "转",
            "圈",
            "回転",
            "회전",
        ],
    ),
    (
        "m",
        &["meter", "meters", "metre", "metres", "м", "米", "メートル"],
    ),
    (
        "mm",
        &["millimeter", "millimeters", "millimetres", "мм", "毫米"],
    ),
    (
        "km",
        &[
            "kilometer",
            "kilometers",
            "kilometre",
            "kilometres",
            "км",
            "公里",
            "千米",
        ],
    ),
    ("ft", &["foot", "feet"]),
    ("mi", &["mile", "miles"]),
    ("N", &["newton", "newtons", "н", "牛", "牛顿"]),
    ("kN", &["kilonewton", "kilonewtons", "кн", "千牛"]),
    ("Nm", &["нм"]),
    ("kNm", &["кнм", "千牛米"]),
    ("kg", &["kilogram", "kilograms", "кг", "公斤", "千克"]),
    ("t", &["т", "吨", "トン", "톤"]),
    ("lb", &["pound", "pounds"]),
    ("Pa", &["па", "帕"]),
    ("kPa", &["кпа", "千帕"]),
    ("MPa", &["мпа", "兆帕"]),
    ("bar", &["бар", "巴"]),
    ("ms", &["мс", "毫秒", "ミリ秒"]),
    ("us", &["мкс", "微秒"]),
];

/// A unit that is written in words (`degrees per second`, `度/秒`), in symbols.
fn in_symbols(text: &str) -> String {
    let word = |c: &char| c.is_alphabetic();
    let mut out = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let end = rest.find(|c: char| c.is_alphabetic() != first.is_alphabetic());
        let (part, more) = rest.split_at(end.unwrap_or(rest.len()));
        let lower = part.to_lowercase();
        let its = |(_, words): &&(&str, &[&str])| words.contains(&lower.as_str());
        let symbol = SYMBOLS.iter().find(its).filter(|_| word(&first));
        out.push_str(symbol.map_or(part, |(symbol, _)| symbol));
        rest = more;
    }
    out
}

/// A unit in small letters.
fn plain(text: &str) -> String {
    bare(text).to_lowercase()
}

/// How the sign of a degree looks in a page, in LaTeX, and where its encoding was taken for another, once or twice.
const DEGREES: [&str; 7] = ["Ã‚Â°", "ã‚â°", "Â°", "â°", "&deg;", "&deg", "$^\\circ$"];
/// What it becomes alone or before a stroke, where it was written in code page 850 or on a Macintosh, or was lost.
const LOST_DEGREE: [char; 3] = ['ø', '¡', '\u{fffd}'];

/// A text whose signs of degrees are what they were.
fn with_degrees(text: &str) -> String {
    let lost = text.trim().strip_prefix(LOST_DEGREE);
    match lost.filter(|rest| rest.is_empty() || rest.starts_with('/')) {
        Some(rest) => format!("°{rest}"),
        None => DEGREES
            .iter()
            .fold(text.to_owned(), |text, sign| text.replace(sign, "°")),
    }
}

/// A unit without blanks, carets, and the dots between its parts.
fn bare(text: &str) -> String {
    let text = with_degrees(text);
    let kept = text.chars().filter(|c| !" .^_*·・･⋅∙•×".contains(*c));
    let one_of = |c| match c {
        '⁻' => '-',
        '¹' => '1',
        '²' => '2',
        'º' | '˚' => '°',
        'μ' => 'µ',
        c => c,
    };
    kept.map(one_of).collect()
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

/// A way to write a unit that others use for another one of the same dimension.
#[derive(Debug)]
pub(crate) struct Ambiguous {
    unit: &'static str,
    /// It stands in the name, in small letters.
    written: &'static str,
    /// And this does not.
    but: Option<&'static str>,
    /// What is said of it in a map.
    pub note: &'static str,
    /// A user must say which one it is.
    pub is_asked: bool,
}

const AMBIGUOUS: [Ambiguous; 2] = [
    // In America the word alone means it.
    Ambiguous {
        unit: "t",
        written: "ton",
        but: Some("tonne"),
        note: "; of 1000 kg: a ton of 2000 lb is unit = \"short ton\"",
        is_asked: false,
    },
    Ambiguous {
        unit: "rad/s",
        written: "1/s",
        but: None,
        note: "; in radians: turns a second are unit = \"turn/s\"",
        is_asked: true,
    },
];

/// What a name, of which `unit` was read, may mean beside it.
pub(crate) fn ambiguous(name: &str, unit: &Unit) -> Option<&'static Ambiguous> {
    let name = name.to_lowercase();
    let is_written = |a: &&Ambiguous| {
        let is_other = a.but.is_some_and(|word| name.contains(word));
        a.unit == unit.name && name.contains(a.written) && !is_other
    };
    AMBIGUOUS.iter().find(is_written)
}

/// The unit that a name tells, where that is of something else than `si`. A letter alone may mean anything.
pub(crate) fn foreign(name: &str, si: &str) -> Option<&'static str> {
    let is_bracketed = !units_in_brackets(name).is_empty();
    let tells = |unit: &&Unit| is_bracketed || unit.name.len() > 1 || unit.name == "%";
    let unit = units_of(name).into_iter().find(tells)?;
    of_name(name, si).is_none().then_some(unit.name)
}

/// Whether what a name tells may be a unit of this dimension.
pub(crate) fn is_of(name: &str, si: &str) -> bool {
    units_of(name).iter().any(|unit| unit.si == si)
}

/// Brackets around units.
pub(crate) const BRACKETS: [(char, char); 7] = [
    ('[', ']'),
    ('(', ')'),
    ('{', '}'),
    ('<', '>'),
    ('［', '］'),
    ('（', '）'),
    ('【', '】'),
];

/// What stands in the last brackets of a name.
pub(crate) fn bracketed(name: &str) -> Option<&str> {
    BRACKETS.iter().find_map(|(open, close)| {
        let (_, text) = name.rsplit_once(*open)?;
        text.split(*close).next()
    })
}

/// The units that the end of a name may mean, the longest first.
fn units_of(name: &str) -> Vec<&'static Unit> {
    let units = units_in_brackets(name);
    if !units.is_empty() {
        return units;
    }
    // What is no unit in brackets stands behind it (`torque, Nm (left)`).
    let words = words(before_brackets(name));
    // A name is more than its unit.
    let lengths = (1..words.len().min(4)).rev();
    lengths
        .flat_map(|length| joined(&words[words.len() - length..]))
        .collect()
}

/// What stands before the first brackets of a name.
pub(crate) fn before_brackets(name: &str) -> &str {
    let open = BRACKETS.map(|(open, _)| open);
    name.split(open).next().unwrap_or(name)
}

/// The units that the brackets of a name may mean.
fn units_in_brackets(name: &str) -> Vec<&'static Unit> {
    bracketed(name).map_or_else(Vec::new, |text| guesses(text).collect())
}

/// The units that words of a name may mean together.
fn joined(words: &[&str]) -> Vec<&'static Unit> {
    let words = words.iter().copied();
    let words: Vec<&str> = words.filter(|w| !w.eq_ignore_ascii_case("per")).collect();
    let ways = ["", "/"].map(|between| words.join(between));
    ways.iter().flat_map(|text| guesses(text)).collect()
}

/// A name without the unit that it tells: `torque [Nm]`, `torque/Nm` and `omega_rad_s` are more than their units.
pub(crate) fn without(name: &str) -> &str {
    let signs = |c: char| is_sign(c) || c.is_whitespace();
    let before = before_brackets(name);
    let words = words(before);
    let lengths = (1..words.len().min(4)).rev();
    let unit = lengths.map(|length| &words[words.len() - length..]);
    let mut unit = unit.filter(|words| !joined(words).is_empty());
    let end = unit.next().map_or(before.len(), |words| {
        words[0].as_ptr() as usize - before.as_ptr() as usize
    });
    before[..end].trim_matches(signs)
}

/// Whether this stands between the words of a name.
fn is_sign(c: char) -> bool {
    matches!(c, '_' | '.' | '-' | ' ' | ':' | '/' | ',' | '|')
}

/// The words of a name: between signs and blanks, and where a capital begins one, of which a `k` may be a part (`TorquekNm`).
pub(crate) fn words(name: &str) -> Vec<&str> {
    let (mut words, mut begin, mut before) = (Vec::new(), 0, ' ');
    for (at, c) in name.char_indices() {
        if is_sign(c) || before.is_lowercase() && c.is_uppercase() {
            let is_kilo = before == 'k' && matches!(c, 'N' | 'P') && at - 1 > begin;
            let end = if is_kilo { at - 1 } else { at };
            words.push(&name[begin..end]);
            begin = if is_sign(c) { at + c.len_utf8() } else { end };
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
    fn degrees_of_old_encodings_are_degrees() {
        for text in ["Â°", "ø", "¡", "&deg;", "\u{fffd}"] {
            assert_eq!(guess(text).map(|u| u.name), Some("deg"), "{text}");
            let a_second = format!("{text}/s");
            assert_eq!(guess(&a_second).map(|u| u.name), Some("deg/s"), "{text}");
        }
        assert_eq!(guess("hours").map(|u| u.name), Some("h"));
    }

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
            ("ft-lbs", "lbf ft"),
            ("N⋅m", "N m"),
            ("kN・m", "kN m"),
            ("kgf·m", "kgf m"),
            ("KN", "kN"),
            ("kts", "knot"),
            ("tr/min", "rpm"),
            ("min⁻¹", "rpm"),
            ("m·s⁻²", "m/s^2"),
            ("Grad/s", "deg/s"),
            ("degrés", "deg"),
            ("kgf/cm²", "kgf/cm^2"),
            ("bar(g)", "bar"),
            ("kN.m", "kN m"),
            ("G", "g"),
            ("MPa", "MPa"),
            ("Bar", "bar"),
            ("%", "%"),
            ("kg m2", "kg m^2"),
            ("lb*ft", "lbf ft"),
            ("foot-pounds", "lbf ft"),
            ("kip-ft", "klbf ft"),
            ("in-lbs", "lbf in"),
            ("kpm", "kgf m"),
            ("tf·m", "tf m"),
            ("N/mm²", "MPa"),
            ("klbs", "klb"),
            ("Short Ton", "short ton"),
            ("US tons", "short ton"),
        ] {
            assert_eq!(guess(text).map(|u| u.name), Some(name), "{text}");
        }
        for (text, name) in [
            ("gon", "gon"),
            ("°/min", "deg/min"),
            ("degrees per minute", "deg/min"),
            ("mNm", "mNm"),
            ("mN·m", "mN m"),
            ("MN·m", "MN m"),
            ("MNM", "MN m"),
            ("N-mm", "N mm"),
            ("degrees per second", "deg/s"),
            ("kilonewton meters", "kN m"),
            ("newton-meters", "N m"),
            ("miles per hour", "mph"),
            ("meters per second squared", "m/s^2"),
            ("pounds per square inch", "psi"),
            ("revolutions per minute", "rpm"),
            ("grader/s", "deg/s"),
            ("varv/min", "rpm"),
            ("астр", ""),
            ("кН·м", "kN m"),
            ("град/с", "deg/s"),
            ("об/мин", "rpm"),
            ("千牛·米", "kN m"),
            ("兆帕", "MPa"),
            ("米/秒²", "m/s^2"),
            ("mg", "mg"),
            ("‰", "‰"),
        ] {
            let found = guess(text).map_or("", |u| u.name);
            assert_eq!(found, name, "{text}");
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
            ("GPS speed [kn]", "m/s", "knot"),
            ("speed_kn", "m/s", "knot"),
            ("pin force [kn]", "N", "kN"),
            ("head press. [bar(g)]", "Pa", "bar"),
            ("Speed [km/h] (GPS)", "m/s", "km/h"),
            ("旋回角速度（度/s）", "rad/s", "deg/s"),
            ("swing torque/kNm", "N m", "kNm"),
            ("Torque / kN m", "N m", "kNm"),
            ("swing_torque{kNm}", "N m", "kNm"),
            ("torque, lb*ft", "N m", "lbf ft"),
            ("SwingTorquekNm", "N m", "kNm"),
            ("HeadPressurekPa", "Pa", "kPa"),
            ("speed, km/h", "m/s", "km/h"),
            ("mass_short_ton", "kg", "short ton"),
            ("swing torque [in-lb]", "N m", "lbf in"),
            ("Torque, kNm (LGR S/N: 1, SEN S/N: 2)", "N m", "kNm"),
        ] {
            assert_eq!(of_name(name, si).map(|u| u.name), Some(unit), "{name}");
            assert_eq!(foreign(name, si), None, "{name}");
        }
        for name in [
            "deg",
            "speed",
            "arm_A",
            "swing_velocity_t",
            "boom (left)",
            "boom A (left)",
        ] {
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

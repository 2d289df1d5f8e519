//! Units for signal maps, and their spellings in foreign files.

use core::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// A unit: name, the SI unit of the same dimension, and its value in that.
#[derive(Debug, PartialEq)]
pub(crate) struct Unit {
    pub name: &'static str,
    pub si: &'static str,
    pub factor: f64,
    /// Other spellings, in small letters, as [`bare`] leaves them, separated by blanks.
    aliases: &'static str,
}

macro_rules! units {
    ($( $name:literal = $factor:expr, $si:literal: $aliases:literal; )*) => {
        pub(crate) const UNITS: &[Unit] = &[
            $( Unit { name: $name, si: $si, factor: $factor, aliases: $aliases } ),*
        ];
    };
}

units! {
    "s" = 1.0, "s": "sec second seconds sek sekunden secondes segundos 秒";
    "ms" = 1e-3, "s": "msec millis milliseconds";
    "us" = 1e-6, "s": "usec µs micros microseconds";
    "ns" = 1e-9, "s": "nsec nanos nanoseconds";
    "100ns" = 1e-7, "s": "tick ticks";
    "min" = 60.0, "s": "minutes";
    "h" = 3600.0, "s": "hr hour hours stunden heures horas";
    "day" = 86400.0, "s": "days";
    "rad" = 1.0, "rad": "radian radians 弧度";
    "mrad" = 1e-3, "rad": "";
    "deg" = PI / 180.0, "rad": "degree degrees degs ° grad degré degrés grados gradi 度";
    "mdeg" = PI / 180.0e3, "rad": "millideg";
    "turn" = TAU, "rad": "rev turns";
    "gon" = PI / 200.0, "rad": "gons gradian gradians";
    "rad/s" = 1.0, "rad/s": "rad/sec rads radps 1/s rads-1 s-1 rad/秒";
    "mrad/s" = 1e-3, "rad/s": "mrad/sec";
    "deg/s" = PI / 180.0, "rad/s": "deg/sec degree/s degrees/s °/s °/sec dps degps grad/s 度/s 度/秒";
    "mdeg/s" = PI / 180.0e3, "rad/s": "mdeg/sec mdps";
    "rpm" = TAU / 60.0, "rad/s": "1/min turn/min turns/min o/min ot/min dev/dak r/min rev/min u/min min-1 \
        /min revs/min tr/min giri/min 转/分 回転/分";
    "turn/s" = TAU, "rad/s": "rev/s r/s rps";
    "gon/s" = PI / 200.0, "rad/s": "gons/s";
    "rad/min" = 1.0 / 60.0, "rad/s": "";
    "deg/min" = PI / 180.0 / 60.0, "rad/s": "°/min grad/min";
    "rad/s^2" = 1.0, "rad/s^2": "rads-2";
    "m" = 1.0, "m": "meter metre";
    "mm" = 1e-3, "m": "";
    "cm" = 1e-2, "m": "";
    "km" = 1e3, "m": "";
    "ft" = 0.3048, "m": "feet foot";
    "inch" = 0.0254, "m": "inches";
    "m/s" = 1.0, "m/s": "m/sec mps ms-1";
    "mm/s" = 1e-3, "m/s": "mm/sec";
    "cm/s" = 1e-2, "m/s": "cm/sec";
    "km/h" = 1.0 / 3.6, "m/s": "kph kmh kmh-1 km/hr kmph km/hour";
    "mph" = 0.44704, "m/s": "mi/h";
    "m/min" = 1.0 / 60.0, "m/s": "";
    "ft/s" = 0.3048, "m/s": "ft/sec fps";
    "inch/s" = 0.0254, "m/s": "in/s in/sec ips";
    "ft/min" = 0.3048 / 60.0, "m/s": "fpm";
    "knot" = 1852.0 / 3600.0, "m/s": "knots kn kt kts";
    "m/s^2" = 1.0, "m/s^2": "m/s/s m/sec2 ms-2";
    "mm/s^2" = 1e-3, "m/s^2": "mm/s/s mm/sec2";
    "cm/s^2" = 1e-2, "m/s^2": "cm/s/s cm/sec2 gal";
    "ft/s^2" = 0.3048, "m/s^2": "ft/sec2 ft/s/s";
    "g" = 9.80665, "m/s^2": "gs g0 g's";
    "mg" = 9.806_65e-3, "m/s^2": "milli-g";
    "N" = 1.0, "N": "newton";
    "kN" = 1e3, "N": "";
    "MN" = 1e6, "N": "";
    "daN" = 10.0, "N": "";
    "kgf" = 9.80665, "N": "kp";
    "tf" = 9_806.65, "N": "";
    "klbf" = 4_448.221_615_261, "N": "";
    "lbf" = 4.448_221_615_261, "N": "";
    "N m" = 1.0, "N m": "n-m newtonmeter";
    "Nm" = 1.0, "N m": "";
    "kN m" = 1e3, "N m": "kn-m";
    "kNm" = 1e3, "N m": "";
    "MN m" = 1e6, "N m": "mn-m";
    "MNm" = 1e6, "N m": "";
    "mN m" = 1e-3, "N m": "";
    "mNm" = 1e-3, "N m": "";
    "N mm" = 1e-3, "N m": "n-mm";
    "N cm" = 1e-2, "N m": "n-cm";
    "daN m" = 10.0, "N m": "dan-m";
    "kgf m" = 9.80665, "N m": "kgf-m kgm kg-m kpm mkp";
    "tf m" = 9_806.65, "N m": "tf-m";
    "lbf ft" = 1.355_817_948_331, "N m": "ftlbf ftlb lbft ft-lb lb-ft ft-lbf lbf-ft ftlbs ft-lbs lbsft lbs-ft \
        footpound footpounds foot-pound foot-pounds";
    "klbf ft" = 1_355.817_948_331, "N m": "kipft kip-ft ftkip ft-kip kft-lb klb-ft klbft";
    "lbf in" = 0.112_984_829_027_6, "N m": "inlbf inlb lbin in-lb lb-in in-lbf lbf-in inlbs in-lbs";
    "kg" = 1.0, "kg": "kilogram";
    "lb" = 0.453_592_37, "kg": "lbs pound pounds lbm";
    "klb" = 453.592_37, "kg": "klbs kip kips";
    "short ton" = 907.184_74, "kg": "shorttons uston ustons";
    "t" = 1e3, "kg": "ton tons tonne tonnes tonnen metricton metrictons";
    "kg m^2" = 1.0, "kg m^2": "kgm2";
    "N m s/rad" = 1.0, "N m s/rad": "nms/rad nms";
    "Pa" = 1.0, "Pa": "pascal";
    "kPa" = 1e3, "Pa": "kn/m2";
    "MPa" = 1e6, "Pa": "n/mm2";
    "N/cm^2" = 1e4, "Pa": "n/cm2";
    "atm" = 101_325.0, "Pa": "";
    "bar" = 1e5, "Pa": "bars barg bar(g) dan/cm2";
    "mbar" = 1e2, "Pa": "hpa";
    "psi" = 6_894.757_293_168, "Pa": "psig psi(g) lbf/in2 lb/in2 lb/squareinch";
    "ksi" = 6_894_757.293_168, "Pa": "";
    "kgf/cm^2" = 98_066.5, "Pa": "kgf/cm2 kg/cm2 kp/cm2";
    "V" = 1.0, "V": "volt volts";
    "mV" = 1e-3, "V": "";
    "A" = 1.0, "A": "ampere amp amps";
    "mA" = 1e-3, "A": "";
    "%" = 0.01, "": "percent pct";
    "‰" = 0.001, "": "permille promille mm/m";
    "1" = 1.0, "": "- ratio";
}

/// The unit called `name`.
pub(crate) fn find(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|u| u.name == name)
}

/// The unit that a DBC file or a column's header writes as `text`: by its name, by its name in
/// other capitals (on a machine a `G` is not a gram, an `NM` not a nautical mile), or by an alias.
pub(crate) fn guess(text: &str) -> Option<&'static Unit> {
    guesses(text).next()
}

/// All units that it may mean: `kn` is kN in other capitals, or knots.
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
    let written = bare(text);
    let wanted = written.to_lowercase();
    let such = |is: &dyn Fn(&Spelling) -> bool| {
        let spellings = SPELLINGS.iter().filter(|spelling| is(spelling));
        spellings.map(|spelling| spelling.unit).collect::<Vec<_>>()
    };
    let mut all: Vec<&Unit> = find(text.trim()).into_iter().collect();
    // An mNm is not an MNm: exact capitals come first.
    all.extend(such(&|spelling| spelling.bare == written));
    all.extend(such(&|spelling| spelling.plain == wanted));
    all.extend(such(&|spelling| spelling.aliases.contains(&&*wanted)));
    all
}

/// The spellings of a unit. Computed once: each name of a table is compared with all of them.
struct Spelling {
    unit: &'static Unit,
    bare: String,
    plain: String,
    aliases: Vec<&'static str>,
}

static SPELLINGS: LazyLock<Vec<Spelling>> = LazyLock::new(|| {
    let spelling = |unit: &'static Unit| Spelling {
        unit,
        bare: bare(unit.name),
        plain: bare(unit.name).to_lowercase(),
        aliases: unit.aliases.split_whitespace().collect(),
    };
    UNITS.iter().map(spelling).collect()
});

/// The symbols of units, and their words in English and other languages, separated by blanks.
const SYMBOLS: &[(&str, &str)] = &[
    ("/", "per"),
    ("2", "squared"),
    ("s", "sec second seconds sek sekunde sekund с сек 秒 초"),
    ("min", "minute minuut мин 分 分钟 분 dak dk"),
    ("h", "hour hours hr uur ч 小时 时 時 시"),
    (
        "deg",
        "degree degrees grader aste astetta graus graden град градус градусы stopnie stopni stupně stupňů derece 度 도",
    ),
    ("rad", "radian radians рад 弧度 ラジアン"),
    (
        "rev",
        "revolution revolutions rotations umdrehungen umdr varv tours obr omw omwentelingen toeren omdr kierr kierrosta об 转 圈 回転 회전",
    ),
    ("m", "meter meters metre metres м 米 メートル"),
    ("mm", "millimeter millimeters millimetres мм 毫米"),
    (
        "km",
        "kilometer kilometers kilometre kilometres км 公里 千米",
    ),
    ("ft", "foot feet"),
    ("mi", "mile miles"),
    ("N", "newton newtons н 牛 牛顿"),
    ("kN", "kilonewton kilonewtons кн 千牛"),
    ("Nm", "нм"),
    ("kNm", "кнм 千牛米"),
    ("kg", "kilogram kilograms кг 公斤 千克"),
    ("t", "т 吨 トン 톤"),
    ("lb", "pound pounds"),
    ("Pa", "па 帕"),
    ("kPa", "кпа 千帕"),
    ("MPa", "мпа 兆帕"),
    ("bar", "бар 巴"),
    ("ms", "мс 毫秒 ミリ秒"),
    ("us", "мкс 微秒"),
];

/// A unit in words (`degrees per second`, `度/秒`), converted to symbols.
fn in_symbols(text: &str) -> String {
    let word = |c: &char| c.is_alphabetic();
    let mut out = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let end = rest.find(|c: char| c.is_alphabetic() != first.is_alphabetic());
        let (part, more) = rest.split_at(end.unwrap_or(rest.len()));
        let lower = part.to_lowercase();
        let its = |(_, words): &&(&str, &str)| words.split(' ').any(|word| word == lower);
        let symbol = SYMBOLS.iter().find(its).filter(|_| word(&first));
        out.push_str(symbol.map_or(part, |(symbol, _)| symbol));
        rest = more;
    }
    out
}

/// Degree signs as HTML, as LaTeX, and after one or two conversions with the wrong encoding.
const DEGREES: [&str; 7] = ["Ã‚Â°", "ã‚â°", "Â°", "â°", "&deg;", "&deg", "$^\\circ$"];
/// Degree signs, alone or before a slash, of code page 850 or a Macintosh, or lost.
const LOST_DEGREE: [char; 3] = ['ø', '¡', '\u{fffd}'];

/// A text with its degree signs restored.
fn with_degrees(text: &str) -> String {
    let lost = text.trim().strip_prefix(LOST_DEGREE);
    match lost.filter(|rest| rest.is_empty() || rest.starts_with('/')) {
        Some(rest) => format!("°{rest}"),
        None => DEGREES
            .iter()
            .fold(text.to_owned(), |text, sign| text.replace(sign, "°")),
    }
}

/// A unit without blanks, carets, and dots between its factors.
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

/// The unit of a quantity in `si` that a name contains: in brackets, or as its last words (`boom_deg`, `gyro.z_deg_s`,
/// `BoomAngleDeg`). Degrees of an angular velocity are degrees per second.
pub(crate) fn of_name(name: &str, si: &str) -> Option<&'static Unit> {
    units_of(name).into_iter().find_map(|unit| {
        let a_second = || find(&format!("{}/s", unit.name)).filter(|_| unit.si == "rad");
        Some(unit)
            .filter(|unit| unit.si == si)
            .or_else(|| a_second().filter(|unit| unit.si == si))
    })
}

/// A spelling of a unit that is also used for another unit of the same dimension.
#[derive(Debug)]
pub(crate) struct Ambiguous {
    unit: &'static str,
    /// The name contains this text, in small letters.
    written: &'static str,
    /// The name does not contain this text.
    but: Option<&'static str>,
    /// Note in a map.
    pub note: &'static str,
    /// The user must choose the unit.
    pub is_asked: bool,
}

const AMBIGUOUS: [Ambiguous; 2] = [
    // In America the word alone means the short ton.
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

/// The other meaning of a name of which `unit` was read.
pub(crate) fn ambiguous(name: &str, unit: &Unit) -> Option<&'static Ambiguous> {
    let name = name.to_lowercase();
    let is_written = |a: &&Ambiguous| {
        let is_other = a.but.is_some_and(|word| name.contains(word));
        a.unit == unit.name && name.contains(a.written) && !is_other
    };
    AMBIGUOUS.iter().find(is_written)
}

/// The unit in a name, if it is of another dimension than `si`. A single letter may have any meaning.
pub(crate) fn foreign(name: &str, si: &str) -> Option<&'static str> {
    let is_bracketed = !units_in_brackets(name).is_empty();
    let tells = |unit: &&Unit| is_bracketed || unit.name.len() > 1 || unit.name == "%";
    let unit = units_of(name).into_iter().find(tells)?;
    of_name(name, si).is_none().then_some(unit.name)
}

/// Whether the unit in a name may be of this dimension.
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

/// The text in the last brackets of a name.
pub(crate) fn bracketed(name: &str) -> Option<&str> {
    BRACKETS.iter().find_map(|(open, close)| {
        let (_, text) = name.rsplit_once(*open)?;
        let text = text.split(*close).next();
        // The place in a list, as in Simulink's `q:1(2)`; a quantity without a unit may be in `[1]`.
        let is_place = |text: &&str| text.parse::<u32>().is_ok() && (*text != "1" || *open == '(');
        text.filter(|text| !is_place(text))
    })
}

/// The units that the end of a name may mean, the longest first.
fn units_of(name: &str) -> Vec<&'static Unit> {
    let units = units_in_brackets(name);
    if !units.is_empty() {
        return units;
    }
    // Text in brackets that is no unit may follow one (`torque, Nm (left)`).
    let words = words(before_brackets(name));
    // A name is longer than its unit.
    let lengths = (1..words.len().min(4)).rev();
    lengths
        .flat_map(|length| joined(&words[words.len() - length..]))
        .collect()
}

/// The text before the first brackets of a name.
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

/// A name without the unit in it: `torque [Nm]`, `torque/Nm` and `omega_rad_s` are longer than their units.
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

/// Whether this character separates the words of a name.
fn is_sign(c: char) -> bool {
    matches!(c, '_' | '.' | '-' | ' ' | ':' | '/' | ',' | '|')
}

/// The words of a name: separated by signs and blanks, and before a capital, with a `k` that may be a part of the unit (`TorquekNm`).
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

/// The units of a dimension, without duplicates.
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
    fn what_sheets_of_hydraulics_and_loggers_write_is_understood() {
        for (text, name) in [
            ("kp/cm²", "kgf/cm^2"),
            ("daN/cm2", "bar"),
            ("kp", "kgf"),
            ("mm/s²", "mm/s^2"),
            ("km·h⁻¹", "km/h"),
            ("in/s", "inch/s"),
            ("mkp", "kgf m"),
            ("N/cm²", "N/cm^2"),
        ] {
            assert_eq!(guess(text).map(|u| u.name), Some(name), "{text}");
        }
    }

    #[test]
    fn the_end_of_a_name_identifies_its_unit() {
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
        let all: Vec<_> = UNITS
            .iter()
            .flat_map(|u| u.aliases.split_whitespace())
            .collect();
        for (i, alias) in all.iter().enumerate() {
            assert!(!all[..i].contains(alias), "{alias}");
        }
    }
}

//! Format of a table: encoding, separator, decimal mark.

/// Separator and decimal mark of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Dialect {
    /// `,`, `;`, `|`, a tab, or [`BLANK`].
    pub separator: u8,
}

/// Characters that end lines for other programs, and their names.
const OTHER_LINE_ENDS: [(char, &str); 7] = [
    ('\u{85}', "NEL (U+0085)"),
    ('\u{2028}', "a line separator (U+2028)"),
    ('\u{2029}', "a paragraph separator (U+2029)"),
    ('\u{b}', "a vertical tab (U+000B)"),
    ('\u{c}', "a form feed (U+000C)"),
    ('\u{1e}', "a record separator (U+001E)"),
    ('\0', "a byte of zero"),
];

/// Remedy for them.
pub(crate) const LINE_ENDS: &str =
    "write the file with the line ends of Unix (LF) or of Windows (CR LF)";

/// Blanks, one or several, separate if no other character does.
pub(super) const BLANK: u8 = b' ';

impl Dialect {
    /// The dialect of a header, or of the line `sep=;` that Excel writes before it. A semicolon, a tab or a bar
    /// outside of quotes means that commas do not separate.
    pub(crate) fn of(line: &[u8]) -> Self {
        if let Some(separator) = separator_line(line) {
            return Self { separator };
        }
        let mut quoted = false;
        let plain = line.iter().filter(|byte| {
            quoted ^= **byte == b'"';
            !quoted
        });
        let plain: Vec<u8> = plain.copied().collect();
        let count = |separator: u8| plain.iter().filter(|b| **b == separator).count();
        // The most frequent one, of equally frequent ones the last; a single one counts without any comma.
        let most = [b',', b'|', b'\t', b';'].into_iter();
        let most = most.max_by_key(|separator| (count(*separator), *separator == b','));
        let blank = Some(BLANK).filter(|blank| plain.trim_ascii().contains(blank));
        Self {
            separator: most.filter(|s| count(*s) > 0).or(blank).unwrap_or(b','),
        }
    }

    /// The number in a cell, NaN for an empty cell or a mark of a missing sample; `None` for text. A comma in it may be the
    /// decimal mark: if commas separate it was in quotes, and [`super::marks`] decides by the whole table.
    pub(crate) fn number(self, cell: &[u8]) -> Option<f64> {
        if cell.is_empty() {
            return Some(f64::NAN);
        }
        // Parses bytes as the standard library parses text: a cell need not be valid text.
        let number = fast_float2::parse(cell).ok();
        let number = number.or_else(|| Self::as_typeset(std::str::from_utf8(cell).ok()?));
        number.or_else(|| is_missing(cell).then_some(f64::NAN))
    }

    /// Name of a character in this cell that ends lines for other programs: a number follows it, so that two lines are one here.
    pub(crate) fn other_line_end(self, cell: &[u8]) -> Option<&'static str> {
        // In Latin-1, U+0085 is an ellipsis of Windows.
        let text = std::str::from_utf8(cell).ok()?;
        let is_within = |(end, _): &&(char, _)| {
            let number = text.rsplit_once(*end).map(|(_, number)| number.trim());
            number.is_some_and(|n| self.number(n.as_bytes()).is_some_and(f64::is_finite))
        };
        OTHER_LINE_ENDS
            .iter()
            .find(is_within)
            .map(|(_, name)| *name)
    }

    /// A number as sheets show it: a decimal comma, a minus sign instead of a hyphen, thousands grouped by thin blanks or
    /// apostrophes, `="1.5"` for a number that a sheet shall not reformat; and as Fortran prints it, `1.5D-3`. A byte order mark
    /// precedes the first number of a file that was joined to another.
    fn as_typeset(text: &str) -> Option<f64> {
        let formula = text.strip_prefix("=\"").and_then(|t| t.strip_suffix('"'));
        let groups = [
            '\u{a0}', '\u{202f}', '\u{2009}', '\'', '\u{2019}', '\u{feff}',
        ];
        let plain = formula.unwrap_or(text).replace(groups, "");
        let plain = with_e(plain.replace('\u{2212}', "-"));
        let number = plain.parse().ok().filter(|_| plain != text);
        number
            .or_else(|| with_decimal_comma(&plain))
            .or_else(|| with_grouping_commas(&plain))
    }
}

fn with_decimal_comma(text: &str) -> Option<f64> {
    let (whole, fraction) = text.rsplit_once(',')?;
    let has_point = whole.contains(',') || fraction.contains('.');
    // A point before the comma groups thousands.
    let whole = whole.replace('.', "");
    (!has_point).then(|| format!("{whole}.{fraction}").parse().ok())?
}

/// `1,234.5`: commas group thousands before a decimal point.
fn with_grouping_commas(text: &str) -> Option<f64> {
    let (whole, fraction) = text.split_once('.')?;
    let mut groups = whole.split(',').skip(1).peekable();
    let are_groups = groups.peek().is_some() && groups.all(|group| group.len() == 3);
    are_groups.then(|| {
        format!("{}.{fraction}", whole.replace(',', ""))
            .parse()
            .ok()
    })?
}

/// A number with Fortran's exponent `D`, converted to `E`. Without a decimal mark it may be hexadecimal.
fn with_e(text: String) -> String {
    match text.find(['d', 'D']) {
        Some(at) if text[..at].contains(['.', ',']) => text.replace(['d', 'D'], "e"),
        _ => text,
    }
}

/// Marks of a missing sample, in any capitals: those that pandas reads, German Excel's `#NV`, the errors of a
/// sheet's formulas, dashes of a logger, the words of a historian for a bad value, the output of C's library on Windows, a
/// database's `\N`.
const MISSING: [&str; 71] = [
    "na",
    "n/a",
    "n.a.",
    "nat",
    "\\n",
    "–",
    "—",
    "#n/a",
    "#na",
    "#nv",
    "<na>",
    "null",
    "none",
    "missing",
    "-",
    "--",
    "---",
    "?",
    "nil",
    "(null)",
    "no data",
    "nodata",
    "bad",
    "invalid",
    "error",
    "err",
    "undefined",
    "#div/0!",
    "#value!",
    "#ref!",
    "#num!",
    "#name?",
    "1.#qnan",
    "-1.#ind",
    "1.#ind",
    "nan(ind)",
    "-nan(ind)",
    "1.#inf",
    // German and French sheets.
    "k.a.",
    "n.v.",
    "nd",
    "n.d.",
    "#n/d",
    "n/d",
    "n/v",
    "*",
    "<null>",
    "[null]",
    "nan()",
    "novalue",
    "no value",
    "not available",
    "sna",
    // Beyond the range of an instrument, and substitutes of a historian.
    "ol",
    "ovl",
    "over",
    "+over",
    "-over",
    "overflow",
    "burnout",
    "over range",
    "under range",
    "out of range",
    "i/o timeout",
    "bad input",
    "comm fail",
    "not connect",
    "pt created",
    "scan off",
    "shutdown",
    "offline",
];

fn is_missing(cell: &[u8]) -> bool {
    let is_word = |word: &&str| cell.eq_ignore_ascii_case(word.as_bytes());
    // The errors of a sheet are words of its language; an instrument fills its digits with a mark.
    let is_error = matches!(cell, [b'#', .., b'!' | b'?']);
    let is_filled = cell.len() > 1 && cell.iter().all(|b| b"-+.*_".contains(b));
    // LibreOffice numbers its errors; C's library appends the bits.
    let begins = |word: &str| {
        let head = cell.get(..word.len());
        head.is_some_and(|head| head.eq_ignore_ascii_case(word.as_bytes()))
    };
    let is_bits = (begins("nan(") || begins("-nan(")) && cell.ends_with(b")");
    let is_numbered = begins("err:") && cell[4..].iter().all(u8::is_ascii_digit);
    MISSING.iter().any(is_word) || is_error || is_filled || is_bits || is_numbered
}

/// The separator in Excel's first line `sep=;`.
pub(crate) fn separator_line(line: &[u8]) -> Option<u8> {
    let (name, said) = line.trim_ascii_start().split_at_checked(4)?;
    if !name.eq_ignore_ascii_case(b"sep=") {
        return None;
    }
    match said.trim_ascii() {
        [separator] => Some(*separator),
        [] if said.starts_with(&[BLANK]) => Some(BLANK),
        [] => Some(b'\t'),
        _ => None,
    }
}

/// The name of a column, without invisible characters: byte order marks, marks of direction, soft hyphens, and zeros around it.
pub(crate) fn name(bytes: &[u8]) -> String {
    let unseen = |c: char| {
        matches!(
            c,
            '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{2060}' | '\u{feff}'
        )
    };
    let fills = |c: char| c == '\0' || c.is_whitespace();
    text(bytes)
        .replace(unseen, "")
        .trim_matches(fills)
        .to_owned()
}

/// A text that is UTF-8, or else Latin-1.
pub(crate) fn text(bytes: &[u8]) -> String {
    let latin = || bytes.iter().map(|b| char::from(*b)).collect();
    std::str::from_utf8(bytes).map_or_else(|_| latin(), str::to_owned)
}

/// Whether a name decoded as Latin-1 has another encoding: no language of Europe has three such letters in sequence.
pub(crate) fn is_garbled(name: &str) -> bool {
    let foreign = |c: &char| ('\u{80}'..='\u{ff}').contains(c);
    let letters: Vec<char> = name.chars().collect();
    letters.windows(3).any(|three| three.iter().all(foreign))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_separator_is_that_of_the_header() {
        for (header, separator) in [
            ("t,speed", b','),
            ("t;speed", b';'),
            ("t\tspeed", b'\t'),
            ("t;\"speed, wheels\";slope", b';'),
            ("\"a;b\",t,speed", b','),
            ("t", b','),
            ("  t   speed  \r\n", BLANK),
            ("\"Time\" \"Speed\"", BLANK),
            ("t, speed", b','),
            ("\"Time [s]\"", b','),
            ("t|speed", b'|'),
            ("t|speed, wheels|slope", b'|'),
            ("sep=;", b';'),
            ("sep=\t", b'\t'),
            ("SEP=\r\n", b'\t'),
            ("sep= \r\n", BLANK),
        ] {
            assert_eq!(
                Dialect::of(header.as_bytes()).separator,
                separator,
                "{header}"
            );
        }
    }

    #[test]
    fn a_comma_within_a_cell_is_a_decimal_mark() {
        let (german, english) = (Dialect { separator: b';' }, Dialect { separator: b',' });
        assert_eq!(german.number(b"1,5"), Some(1.5));
        assert_eq!(german.number(b"-1.234,5e-3"), Some(-1.2345));
        assert_eq!(german.number(b"1.5"), Some(1.5));
        assert_eq!(german.number(b"1,234,5"), None);
        assert_eq!(german.number(b"-1,234,567.5"), Some(-1_234_567.5));
        assert_eq!(german.number(b"1,23.5"), None);
        // In quotes; whether the comma is a decimal mark depends on the other numbers of the table.
        assert_eq!(english.number(b"1,5"), Some(1.5));
        assert_eq!(english.number(b"1,234.5"), Some(1234.5));
        assert_eq!(english.number(b"1,234,567"), None);
    }

    #[test]
    fn a_cell_has_the_number_that_the_standard_library_finds_in_it() {
        let mut cells: Vec<String> = [
            "1",
            "-1.5",
            "+2",
            "1.",
            ".5",
            "-.5e1",
            "1e5",
            "1E-5",
            "1e+400",
            "1e-400",
            "5e-324",
            "-0",
            "inf",
            "-Infinity",
            "+inf",
            "nan",
            "NaN",
            "-nan",
            ".",
            "+",
            "e5",
            "1e",
            "1e+",
            "1_000",
            "0x10",
            "1.5.2",
            "1 2",
            "--1",
            "+-1",
            "1f",
            "infinit",
            "12:30",
            "9007199254740993",
            "0.1000000000000000055511151231257827021181583404541015625",
        ]
        .map(str::to_owned)
        .to_vec();
        let mut bits = 0x9e37_79b9_7f4a_7c15_u64;
        for _ in 0..5000 {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let any = f64::from_bits(bits);
            cells.extend([
                format!("{any:e}"),
                format!("{}", any.fract()),
                format!("{any:.3e}"),
            ]);
        }
        let english = Dialect { separator: b',' };
        for cell in cells {
            let expected: Option<f64> = cell.parse().ok();
            let found = english.number(cell.as_bytes());
            let is_none = |x: Option<f64>| x.is_none_or(f64::is_nan);
            let same = found.map(f64::to_bits) == expected.map(f64::to_bits);
            let both_nan =
                found.is_some() == expected.is_some() && is_none(found) && is_none(expected);
            assert!(same || both_nan, "{cell}: {found:?} {expected:?}");
        }
        assert_eq!(english.number(b"1\xff"), None);
    }

    #[test]
    fn a_number_is_read_as_sheets_show_it() {
        let (german, english) = (Dialect { separator: b';' }, Dialect { separator: b',' });
        assert_eq!(
            english.number("\u{2212}2.5e\u{2212}1".as_bytes()),
            Some(-0.25)
        );
        assert_eq!(english.number("12\u{202f}345.5".as_bytes()), Some(12345.5));
        assert_eq!(german.number("\u{2212}12'345,5".as_bytes()), Some(-12345.5));
        assert_eq!(english.number(b"-1.5D-03"), Some(-0.0015));
        assert_eq!(german.number(b"1,5d2"), Some(150.0));
        assert_eq!(english.number(b"=\"-1.5\""), Some(-1.5));
        assert_eq!(english.number("\u{feff}1.5".as_bytes()), Some(1.5));
        assert_eq!(english.number(b"1D5"), None, "hexadecimal");
        assert_eq!(english.number(b"12 345"), None);
    }

    #[test]
    fn a_word_for_a_missing_sample_is_an_empty_cell() {
        let english = Dialect { separator: b',' };
        for word in [
            "NA",
            "n/a",
            "NULL",
            "None",
            "#N/A",
            "#NV",
            "-",
            "--",
            "#DIV/0!",
            "(null)",
            "No Data",
            "Bad",
            "n.a.",
            "\\N",
            "—",
            "-nan(ind)",
            "1.#INF",
            "#BEZUG!",
            "#NOMBRE?",
            "---.--",
            "****",
            "OVL",
            "I/O Timeout",
            "k.A.",
            "nan(0x8000000000000)",
            "Err:502",
            "+OVER",
            "+++++",
            "BURNOUT",
            "[null]",
        ] {
            let number = english.number(word.as_bytes());
            assert!(number.is_some_and(f64::is_nan), "{word}");
        }
        for text in ["nothing", "#12", "#!x", "false", "."] {
            assert_eq!(english.number(text.as_bytes()), None, "{text}");
        }
    }
}

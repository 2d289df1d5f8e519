//! The lines above the samples of a table: comments, the header, a row of units.

use super::cells::{Cells, Record};
use super::dialect::{self, BLANK, Dialect, separator_line};
use crate::unit;

/// Marks of a comment.
const COMMENT: [&[u8]; 3] = [b"#", b"%", b"//"];

/// Kind of a line of a table, for a reader of one line at a time.
#[derive(Debug, PartialEq)]
pub(crate) enum Line {
    /// Blank, or the line that names the separator.
    Nothing,
    /// A comment; it may be the header of the numbers below it.
    Comment,
    /// The header.
    Header(Dialect),
    /// The first row of samples: the comment above it is the header.
    FirstRow {
        /// The comment without its mark.
        header: Vec<u8>,
        /// Its dialect.
        dialect: Dialect,
    },
    /// Units in a row below the header, a text for each column.
    Units(Vec<String>),
    /// A row of samples.
    Row,
}

/// Classifies the lines of a table, in their order.
///
/// A comment above numbers is the header, as `numpy.savetxt` writes it, if it has as many cells as they.
#[derive(Debug, Default)]
pub(crate) struct Lines {
    separator: Option<u8>,
    /// The last comment, without its mark.
    comment: Option<Vec<u8>>,
    /// The header, until the line below it has come.
    header: Option<(Record, Dialect)>,
    is_below: bool,
}

impl Lines {
    /// Kind of the next line.
    pub(crate) fn take(&mut self, line: &[u8]) -> Line {
        if line.trim_ascii().is_empty() || is_rule(line) {
            return Line::Nothing;
        }
        if self.is_below {
            let header = self.header.take();
            let units = header.and_then(|(header, its)| units(&header, &cells(line, its), its));
            return units.map_or(Line::Row, Line::Units);
        }
        if let Some(said) = separator_line(line) {
            self.separator = Some(said);
            return Line::Nothing;
        }
        if let Some(name) = comment(line) {
            self.comment = Some(name.to_vec());
            return Line::Comment;
        }
        self.is_below = true;
        if let Some(header) = self.comment.take()
            && is_header_of(&header, self.dialect(&header), line)
        {
            let dialect = self.dialect(&header);
            return Line::FirstRow { header, dialect };
        }
        let dialect = self.dialect(line);
        self.header = Some((cells(line, dialect), dialect));
        Line::Header(dialect)
    }

    fn dialect(&self, line: &[u8]) -> Dialect {
        self.separator
            .map_or_else(|| Dialect::of(line), |separator| Dialect { separator })
    }
}

/// Whether a line is a rule drawn by a database around its rows: `+------+------+`.
pub(crate) fn is_rule(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    let dashes = line.iter().filter(|b| **b == b'-').count();
    dashes > 2 && 2 * dashes > line.len() && line.iter().all(|b| b"-+|".contains(b))
}

/// The text of a comment.
pub(crate) fn comment(line: &[u8]) -> Option<&[u8]> {
    let text = line.trim_ascii_start();
    let mark = COMMENT.iter().find(|mark| text.starts_with(mark))?;
    Some(text[mark.len()..].trim_ascii_start())
}

/// Whether a text begins like a table with columns separated by blanks.
pub(crate) fn is_by_blanks(head: &[u8]) -> bool {
    // A header alone may be any words.
    let has_row = lines(head, 0).nth(1).is_some();
    has_row && Front::of(head).is_some_and(|front| front.dialect.separator == BLANK)
}

/// The lines above the samples of a table.
pub(crate) struct Front {
    /// Bytes before the header.
    pub start: usize,
    pub dialect: Dialect,
    /// Units in a separate line, a text for each column.
    pub units: Option<Vec<String>>,
    /// Number of lines below the header that describe the columns: units, kinds of numbers, means or samples.
    pub below: usize,
    /// Names in the row above the header, used for its empty cells.
    pub above: Vec<String>,
    /// Whether each row begins with a name in quotes without a header, as R's `write.table` writes it.
    pub has_row_names: bool,
    /// Names of the columns, where the header is none that a table has.
    pub names: Option<Vec<String>>,
}

impl Front {
    /// Finds them in the beginning of a text; none in an empty one.
    pub(crate) fn of(head: &[u8]) -> Option<Self> {
        let mark: &[u8] = b"\xef\xbb\xbf";
        // Joined files have several.
        let marks = head
            .chunks_exact(mark.len())
            .take_while(|bytes| *bytes == mark);
        let begin = (mark.len() * marks.count()).max(behind_labview(head));
        let (mut kinds, mut after_mark) = (Lines::default(), begin);
        let mut lines = lines(head, begin);
        while let Some((at, line)) = lines.next() {
            let end_of = |text: &[u8]| at + line.len() - text.len();
            match kinds.take(line) {
                Line::Comment => after_mark = comment(line).map_or(at, end_of),
                Line::Header(dialect) => {
                    if let Some(preface) = preface(line, &head[at + line.len()..]) {
                        // The lines above may have another separator.
                        kinds = Lines::default();
                        lines = self::lines(head, at + line.len() + preface);
                        continue;
                    }
                    let start = end_of(line.trim_ascii_start());
                    let around = [&head[begin..at], &head[at + line.len()..]];
                    return Some(Self::around(start, line, dialect, around));
                }
                Line::FirstRow { dialect, .. } => {
                    return Some(Self {
                        start: after_mark,
                        dialect,
                        units: None,
                        below: 0,
                        above: Vec::new(),
                        has_row_names: false,
                        names: None,
                    });
                }
                Line::Nothing | Line::Units(_) | Line::Row => {}
            }
        }
        None
    }

    /// The header `line` that begins at `start`, between these lines above and below it.
    fn around(start: usize, line: &[u8], dialect: Dialect, [over, under]: [&[u8]; 2]) -> Self {
        let header = cells(line, dialect);
        let mut rows = lines(under, 0).map(|(_, row)| row);
        let mut below = rows.next();
        let of_row = |row: &[u8]| units(&header, &cells(row, dialect), dialect);
        let mut units = below.filter(|row| !is_rule(row)).and_then(of_row);
        let mut count = usize::from(units.is_some());
        if units.is_some() {
            below = rows.next();
        }
        while count < MOST_BELOW
            && let Some(row) = below
            && is_words(row, dialect, header.len())
        {
            units = units.or_else(|| several_units(&header, row, dialect));
            count += 1;
            below = rows.next();
        }
        // With blanks as separators the names may contain them.
        let width = header.len();
        let is_of = |width| below.is_none_or(|row| is_row(row, dialect, width));
        let is_within = dialect.separator == BLANK && !is_of(width) && !is_of(width + 1);
        let dialect = match is_within {
            true => Dialect { separator: b',' },
            false => dialect,
        };
        let is_named = |row: &[u8]| {
            row.trim_ascii_start().starts_with(b"\"") && is_row(row, dialect, width + 1)
        };
        let above_units = |(_, line)| several_units(&header, line, dialect);
        Self {
            start,
            dialect,
            units: units.or_else(|| lines(over, 0).filter_map(above_units).last()),
            below: count,
            above: above(over, &header, dialect),
            has_row_names: below.is_some_and(is_named),
            names: None,
        }
    }
}

/// The names in the last line above a header, if it has as many cells: names of groups, and of columns without a group.
fn above(text: &[u8], header: &Record, dialect: Dialect) -> Vec<String> {
    let last = lines(text, 0).last().map(|(_, line)| cells(line, dialect));
    let is_header = |row: &Record| {
        let number = |cell: &[u8]| dialect.number(cell).is_some_and(f64::is_finite);
        row.len() == header.len() && !row.iter().any(number)
    };
    let last = last.filter(is_header);
    last.map_or_else(Vec::new, |row| row.iter().map(dialect::name).collect())
}

/// Units in a line that is not directly below the names: several, since a single one may be a word.
fn several_units(header: &Record, line: &[u8], dialect: Dialect) -> Option<Vec<String>> {
    let mut texts = units(header, &cells(line, dialect), dialect)?;
    for text in &mut texts {
        // The name of the line is no unit.
        if unit::guess(text).is_none() {
            text.clear();
        }
    }
    (texts.iter().filter(|text| !text.is_empty()).count() > 1).then_some(texts)
}

/// Number of lines below a header that may describe its columns.
const MOST_BELOW: usize = 3;

/// Whether a line below a header has words only, which are no samples and no times. An empty cell may be one, and an empty row
/// is a missing sample.
fn is_words(line: &[u8], dialect: Dialect, width: usize) -> bool {
    let row = cells(line, dialect);
    let mut written = row.iter().filter(|cell| !cell.is_empty()).peekable();
    let is_word = |cell: &[u8]| {
        let begins = cell
            .first()
            .is_some_and(|b| b.is_ascii_alphabetic() || b"<[(".contains(b));
        begins && !cell.contains(&b':') && dialect.number(cell).is_none()
    };
    // Separated by blanks it may be a sentence.
    dialect.separator != BLANK
        && row.len() == width
        && written.peek().is_some()
        && written.all(is_word)
}

/// Number of lines in which the header is searched.
pub(crate) const MOST_ABOVE: usize = 100;

/// Offset of the header below `first`, if `first` is none: lines on the logger have fewer cells than the names,
/// which have a row of as many numbers below them.
fn preface(first: &[u8], below: &[u8]) -> Option<usize> {
    let all: Vec<_> = lines(below, 0).take(MOST_ABOVE).collect();
    all.windows(2).enumerate().find_map(|(last, pair)| {
        let dialect = Dialect::of(pair[0].1);
        let width = cells(pair[0].1, dialect).len();
        let number = |cell: &[u8]| dialect.number(cell).is_some_and(f64::is_finite);
        let is_words = |line: &[u8]| {
            let cells = cells(line, dialect);
            cells.len() == width && !cells.iter().any(number)
        };
        let is_row = |line: &[u8]| is_row(line, dialect, width);
        if width < 2 || !is_row(pair[1].1) || !is_words(pair[0].1) {
            return None;
        }
        let is_above = |line: &[u8]| {
            units(&cells(line, dialect), &cells(pair[0].1, dialect), dialect).is_some()
        };
        let is_first = is_words(first) && is_row(all[0].1) || last == 0 && is_above(first);
        if dialect.separator == BLANK {
            let names = last.checked_sub(1).filter(|at| is_above(all[*at].1));
            return (!is_first).then(|| all[names.unwrap_or(last)].0);
        }
        if cells(first, dialect).len() >= width {
            let names = names_below_as_wide(first, &all[..=last], dialect);
            return names.filter(|_| !is_first);
        }
        // Units may follow the names.
        let words = all[..=last]
            .iter()
            .rev()
            .take_while(|(_, line)| is_words(line));
        words.last().map(|(at, _)| *at)
    })
}

/// Place of the names, the last of these lines or the one above its units, if `first` is words with as many cells: padded to the
/// width of the names, or a name with its value above two columns.
fn names_below_as_wide(first: &[u8], all: &[(usize, &[u8])], dialect: Dialect) -> Option<usize> {
    let (last, above) = all.split_last()?;
    let below = cells(last.1, dialect);
    // Any two words may be above each other: units are all units, and `t` is a name.
    let is_unit = |text: &String| text.is_empty() || unit::guess(text).is_some();
    let are_units = |line: &[u8]| {
        units(&cells(line, dialect), &below, dialect).is_some_and(|texts| texts.iter().all(is_unit))
    };
    // A logger may describe its columns further below their units.
    let over_units = all
        .windows(2)
        .find(|two| several_units(&cells(two[0].1, dialect), two[1].1, dialect).is_some());
    if let Some([names, _]) = over_units {
        // Kinds of numbers below the names are repeated; so are names below groups, which have gaps.
        let [of_first, of_names] = [first, names.1].map(|line| cells(line, dialect));
        let are_kinds =
            repeats(&of_names) && !repeats(&of_first) && !is_padded(&of_first, &of_names);
        return (!are_kinds).then_some(names.0);
    }
    let names = above
        .last()
        .filter(|line| are_units(line.1))
        .unwrap_or(last);
    let (of_first, of_names) = (cells(first, dialect), cells(names.1, dialect));
    // A group is written once, or above each of its columns. Where the names below repeat too, each is one of its group.
    let pairs_repeat = || {
        let pairs = of_first.iter().zip(of_names.iter());
        let mut pairs: Vec<_> = pairs.filter(|(_, name)| !name.is_empty()).collect();
        pairs.sort_unstable();
        pairs.windows(2).any(|two| two[0] == two[1])
    };
    let repeats_alone =
        repeats(&of_first) && (!repeats(&of_names) || !are_units(last.1) && !pairs_repeat());
    let is_name = |cell: &[u8]| cell.first().is_some_and(u8::is_ascii_alphabetic);
    let is_pair = of_names.len() == 2 && !above.is_empty() && of_names.iter().all(is_name);
    (is_padded(&of_first, &of_names) || repeats_alone || is_pair).then_some(names.0)
}

/// Whether a line has an empty cell above a name.
fn is_padded(first: &Record, names: &Record) -> bool {
    let mut pairs = first.iter().zip(names.iter());
    pairs.any(|(first, name)| first.is_empty() && !name.is_empty())
}

/// Whether a text occurs in two cells.
fn repeats(cells: &Record) -> bool {
    let mut all: Vec<_> = cells.iter().filter(|cell| !cell.is_empty()).collect();
    all.sort_unstable();
    all.windows(2).any(|two| two[0] == two[1])
}

/// Whether a line may be a row of this width. Sentences have blanks and numbers too.
fn is_row(line: &[u8], dialect: Dialect, width: usize) -> bool {
    let row = cells(line, dialect);
    let number = |cell: &[u8]| dialect.number(cell);
    let enough = match dialect.separator {
        BLANK => row.iter().skip(1).all(|cell| number(cell).is_some()),
        _ => row
            .iter()
            .any(|cell| number(cell).is_some_and(f64::is_finite)),
    };
    row.len() == width && enough
}

/// Where the names of the columns begin in a file of LabVIEW (.lvm): behind the last line that ends a header; else 0.
fn behind_labview(head: &[u8]) -> usize {
    let ends = lines(head, 0).filter(|(_, line)| line.starts_with(b"***End_of_Header***"));
    ends.last().map_or(0, |(at, line)| at + line.len())
}

/// The lines of a text that are not blank, each with its offset.
pub(super) fn lines(text: &[u8], begin: usize) -> impl Iterator<Item = (usize, &[u8])> {
    let mut at = begin;
    let lines = text
        .get(begin..)
        .unwrap_or_default()
        .split_inclusive(|b| *b == b'\n');
    lines.filter_map(move |line| {
        let start = at;
        at += line.len();
        (!line.trim_ascii().is_empty()).then_some((start, line))
    })
}

pub(super) fn cells(line: &[u8], dialect: Dialect) -> Record {
    Cells::new(dialect).split(line).clone()
}

/// Whether a comment names the columns of the row below it. That row has only numbers, or words too if the comment has no number.
fn is_header_of(comment: &[u8], dialect: Dialect, below: &[u8]) -> bool {
    let (names, row) = (cells(comment, dialect), cells(below, dialect));
    let is_number = |cell: &[u8]| dialect.number(cell).is_some_and(f64::is_finite);
    let are_numbers = row.iter().all(|cell| dialect.number(cell).is_some());
    let is_row = row.iter().any(is_number) && !names.iter().any(is_number);
    names.len() > 1 && names.len() == row.len() && (are_numbers || is_row)
}

/// Units of the columns, if the row below the header has some and no number.
fn units(header: &Record, below: &Record, dialect: Dialect) -> Option<Vec<String>> {
    let texts: Vec<String> = below
        .iter()
        .map(|cell| dialect::text(cell).trim().to_owned())
        .collect();
    let plain = |text: &String| {
        let text = text.trim_matches(['[', ']', '(', ')']).trim();
        // A dash means no unit.
        text.trim_matches('-').to_owned()
    };
    let has_number = below
        .iter()
        .any(|cell| !cell.is_empty() && dialect.number(cell).is_some_and(f64::is_finite));
    let texts: Vec<String> = texts.iter().map(plain).collect();
    let known = texts
        .iter()
        .filter(|text| unit::guess(text).is_some())
        .count();
    let written = texts.iter().filter(|text| !text.is_empty()).count();
    // Separated by blanks, words may be units by chance: all of them must be units.
    let enough = match dialect.separator {
        BLANK => known == written,
        _ => 2 * known >= written,
    };
    (below.len() == header.len() && !has_number && known > 0 && enough).then_some(texts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> (String, u8, Option<Vec<String>>) {
        let front = Front::of(text.as_bytes()).expect("a front");
        let header = text[front.start..].lines().next().unwrap_or_default();
        (header.to_owned(), front.dialect.separator, front.units)
    }

    #[test]
    fn comments_and_blank_lines_stand_above_the_header() {
        let plain = ("t;speed".to_owned(), b';', None);
        for front in [
            "",
            "\n\n",
            "# logger v3\n# machine 14 t\n",
            "% x, y\n\n",
            "\u{feff}",
            "\u{feff}\u{feff}",
            "sep=;\r\n",
            "// a\n",
        ] {
            assert_eq!(of(&format!("{front}t;speed\n0;1\n")), plain, "{front:?}");
        }
        assert_eq!(of("# t,speed\n0,1\n"), ("t,speed".to_owned(), b',', None));
        assert_eq!(of("# a, comment\nt,speed\n0,1\n").0, "t,speed");
        assert_eq!(of("%time,frame,x\n0,base,1\n").0, "time,frame,x");
        assert!(Front::of(b"\n \n# only words\n").is_none());
    }

    #[test]
    fn blanks_separate_where_every_row_has_as_many_cells_as_the_header() {
        for (text, header, separator) in [
            ("t speed slope\n0 1 2\n", "t speed slope", BLANK),
            ("  t   speed\n0.00 -1.5\n", "t   speed", BLANK),
            ("t speed\ns m/s\n0 1\n", "t speed", BLANK),
            ("t speed\n", "t speed", BLANK),
            ("# t speed\n0.0e+00 1.0e+00\n", "t speed", BLANK),
            // Names with blanks, and a date with one.
            (
                "Time [s]  Speed [m/s]\n0  1\n",
                "Time [s]  Speed [m/s]",
                b',',
            ),
            ("t speed\n2026-11-26 01:02:03 1\n", "t speed", b','),
            // Lines on the logger contain blanks too.
            (
                "Logger 2.1\nMachine: EX-22\nt speed\n0 0\n",
                "t speed",
                BLANK,
            ),
            (
                "Made on day 3\nLogger two\n\nt speed\n0 0\n",
                "t speed",
                BLANK,
            ),
            ("Made on day 3\nt,speed\n0,0\n", "t,speed", b','),
            ("t speed\n0 0\nt speed\n0 1\n", "t speed", BLANK),
            // R's row names.
            ("\"t\" \"speed\"\n\"1\" 0 1\n", "\"t\" \"speed\"", BLANK),
            ("t speed\n1 0 1\n", "t speed", BLANK),
        ] {
            let (found, its, _) = of(text);
            assert_eq!((found.as_str(), its), (header, separator), "{text}");
        }
    }

    #[test]
    fn words_of_a_logger_stand_above_the_header() {
        for front in [
            "Device;ABC\nSerial;12\n\n",
            "Logger v3\n",
            "Date: 1,5\nA,B\n",
        ] {
            let (header, separator, units) =
                of(&format!("{front}t;speed;x\ns;m/s;\n0;1;2\n1;1;2\n"));
            assert_eq!((header.as_str(), separator), ("t;speed;x", b';'), "{front}");
            assert!(units.is_some(), "{front}");
        }
        for (front, rest) in [
            ("Site;North\nDate;2026-11-21\n", "t;speed\n0;1\n1;1\n"),
            ("Site;North\nDate;2026-11-21\n", "t;speed\n[s];[m/s]\n0;1\n"),
            ("Serial;12\nSite;North\n\n", "t;speed\n0;1\n"),
            // Padded as in sheets, and groups above names.
            ("Site;North;;\nBy;K. Ito;;\n;;;\n", "t;speed;x;y\n0;1;2;3\n"),
            ("Logger;;;\n", "t;speed;x;y\ns;m/s;-;-\n0;1;2;3\n"),
            (";Drive;;Cabin\n", "t;speed;x;y\n0;1;2;3\n"),
            (
                "A;B;C;D;E\n",
                "t;speed;x;y\ns;m/s;RN;m\n;;Avg;Smp\n0;1;2;3\n",
            ),
            ("By;K. Ito\nSite;North\n", "t;speed\n0;1\n"),
        ] {
            let (header, ..) = of(&format!("{front}{rest}"));
            assert_eq!(Some(header.as_str()), rest.lines().next(), "{front}");
        }
        // Columns without a group have their names in the upper row only.
        for groups in ["t;Drive;;Cabin", "t;Drive;Drive;Cabin", "t;Drive;;"] {
            let text = format!("{groups}\n;speed;slope;x\n0;1;2;3\n");
            assert_eq!(of(&text).0, ";speed;slope;x", "{groups}");
            let front = Front::of(text.as_bytes()).expect("a front");
            assert_eq!(front.above[..2], ["t", "Drive"], "{groups}");
        }
        for header in [
            "t;speed\n2026-11-26;-\n2026-11-26;-\n2026-11-26;1.5\n",
            "t;speed;\n0;1;\n1;1;\n",
            ";t;speed\n0;0;1\n1;1;1\n",
            "t;speed\ns;m/s\n-;-\n0;1\n",
        ] {
            assert_eq!(Some(of(header).0.as_str()), header.lines().next());
        }
        // A header with a missing name is still a header.
        assert_eq!(of("t,speed\n0,1,2\n1,1,2\n").0, "t,speed");
        assert_eq!(of("t,speed\ns,m/s\n0,1\n").0, "t,speed");
    }

    #[test]
    fn lines_of_words_below_the_names_are_no_samples() {
        let front = |below: &str| {
            let text = format!("t,swing,boom,note\n{below}0,1,2,3\n");
            let front = Front::of(text.as_bytes()).expect("a front");
            (front.below, front.units)
        };
        let units = Some(["s", "rpm", "deg", ""].map(str::to_owned).to_vec());
        for below in [
            "s,rpm,deg,\n,Smp,Avg,\n",
            "double,double,double,string\ns,rpm,deg,\n",
            "s,rpm,deg,-\nAbs. min,,,\n",
        ] {
            assert_eq!(front(below), (2, units.clone()), "{below}");
        }
        assert_eq!(front("float64,float64,float64,object\n"), (1, None));
        for sample in ["NaN,,,\n", ",,,\n", "0,x,,\n", "Mon 10:00:00,,,\n", "a,b\n"] {
            assert_eq!(front(sample).0, 0, "{sample}");
        }
    }

    #[test]
    fn the_rules_of_a_database_are_no_rows() {
        let rule = "+-----+-------+\n";
        let (header, separator, _) = of(&format!("{rule}| t   | speed |\n{rule}| 0 | 1 |\n"));
        assert_eq!((header.as_str(), separator), ("| t   | speed |", b'|'));
        for sample in ["-,-,-", "--", "-1|-2|-3", "---|---|1"] {
            assert!(!is_rule(sample.as_bytes()), "{sample}");
        }
    }

    #[test]
    fn units_may_stand_among_the_words_above_the_names() {
        let names = "X\tswing\tboom\tnote\n";
        let front =
            |line: &str| Front::of(format!("{line}Date\tx\t\t\n{names}0\t1\t2\t\n").as_bytes());
        let of = |line: &str| front(line).and_then(|front| front.units);
        let found = ["", "rpm", "deg", ""].map(str::to_owned).to_vec();
        assert_eq!(of("Logger\t2\nUnits\trpm\tdeg\t\n"), Some(found));
        assert_eq!(of("Logger\t2\nKind\tm\t\t\n"), None, "one word");
    }

    #[test]
    fn a_row_of_units_is_distinguished_from_a_row_of_samples() {
        let units = |row: &str| of(&format!("t,swing,boom,note\n{row}\n0,1,2,3\n")).2;
        let found = ["s", "rpm", "deg", ""].map(str::to_owned).to_vec();
        assert_eq!(units("s,rpm,deg,"), Some(found.clone()));
        assert_eq!(units("[s],[rpm],[deg],"), Some(found.clone()));
        assert_eq!(units("s,rpm,deg,-"), Some(found));
        for row in ["0,1,2,3", ",,,", "NaN,,,", "s,1,2,3", "a,b,c,d", "s,rpm"] {
            assert_eq!(units(row), None, "{row}");
        }
    }
}

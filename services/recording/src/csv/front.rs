//! What stands above the samples of a table: comments, the header, a row of units.

use ::csv::ByteRecord;

use super::cells::Cells;
use super::dialect::{self, Dialect, separator_line};
use crate::unit;

/// Marks of a line that is a comment.
const COMMENT: [&[u8]; 3] = [b"#", b"%", b"//"];

/// The front of a table.
pub(super) struct Front {
    /// Bytes before the header.
    pub start: usize,
    pub dialect: Dialect,
    /// Units in a row of their own below the header, a text for each column.
    pub units: Option<Vec<String>>,
}

impl Front {
    /// That of a text which begins like this; nothing where there is nothing in it.
    ///
    /// A line of comment above numbers is the header, as `numpy.savetxt` writes it, where it has as many cells as they.
    pub(super) fn of(head: &[u8]) -> Option<Self> {
        let mark: &[u8] = b"\xef\xbb\xbf";
        let begin = if head.starts_with(mark) {
            mark.len()
        } else {
            0
        };
        let mut lines = lines(head, begin).peekable();
        let (mut separator, mut comment) = (None, None);
        while let Some((at, line)) = lines.next() {
            let text = line.trim_ascii_start();
            if let Some(said) = separator_line(line) {
                separator = Some(said);
                continue;
            }
            let start = at + (line.len() - text.len());
            if let Some(mark) = COMMENT.iter().find(|mark| text.starts_with(mark)) {
                let name = text[mark.len()..].trim_ascii_start();
                comment = Some((at + line.len() - name.len(), name));
                continue;
            }
            let of = |line: &[u8]| {
                separator.map_or_else(|| Dialect::of(line), |separator| Dialect { separator })
            };
            let its = of(text);
            if let Some((start, name)) =
                comment.filter(|(_, name)| is_header_of(name, of(name), text))
            {
                return Some(Self {
                    start,
                    dialect: of(name),
                    units: None,
                });
            }
            let next = lines.peek().map(|(_, line)| *line);
            let units = next.and_then(|next| units(&cells(text, its), &cells(next, its), its));
            return Some(Self {
                start,
                dialect: its,
                units,
            });
        }
        None
    }
}

/// The lines of a text that are not blank, each with where it begins.
fn lines(text: &[u8], begin: usize) -> impl Iterator<Item = (usize, &[u8])> {
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

fn cells(line: &[u8], dialect: Dialect) -> ByteRecord {
    Cells::new(dialect).split(line).clone()
}

/// Whether a comment names the columns of the numbers below it.
fn is_header_of(comment: &[u8], dialect: Dialect, below: &[u8]) -> bool {
    let (names, numbers) = (cells(comment, dialect), cells(below, dialect));
    let are_numbers = numbers.iter().all(|cell| dialect.number(cell).is_some());
    names.len() > 1 && names.len() == numbers.len() && are_numbers
}

/// Units of the columns, where the row below the header holds some and no number.
fn units(header: &ByteRecord, below: &ByteRecord, dialect: Dialect) -> Option<Vec<String>> {
    let texts: Vec<String> = below
        .iter()
        .map(|cell| dialect::text(cell).trim().to_owned())
        .collect();
    let plain = |text: &String| text.trim_matches(['[', ']', '(', ')']).trim().to_owned();
    let has_number = below
        .iter()
        .any(|cell| !cell.is_empty() && dialect.number(cell).is_some_and(f64::is_finite));
    let texts: Vec<String> = texts.iter().map(plain).collect();
    let known = texts
        .iter()
        .filter(|text| unit::guess(text).is_some())
        .count();
    let written = texts.iter().filter(|text| !text.is_empty()).count();
    (below.len() == header.len() && !has_number && known > 0 && 2 * known >= written)
        .then_some(texts)
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
            "sep=;\r\n",
            "// a\n",
        ] {
            assert_eq!(of(&format!("{front}t;speed\n0;1\n")), plain, "{front:?}");
        }
        assert_eq!(of("# t,speed\n0,1\n"), ("t,speed".to_owned(), b',', None));
        assert_eq!(of("# a, comment\nt,speed\n0,1\n").0, "t,speed");
        assert!(Front::of(b"\n \n# only words\n").is_none());
    }

    #[test]
    fn a_row_of_units_is_told_from_a_row_of_samples() {
        let units = |row: &str| of(&format!("t,swing,boom,note\n{row}\n0,1,2,3\n")).2;
        let found = ["s", "rpm", "deg", ""].map(str::to_owned).to_vec();
        assert_eq!(units("s,rpm,deg,"), Some(found.clone()));
        assert_eq!(units("[s],[rpm],[deg],"), Some(found));
        for row in ["0,1,2,3", ",,,", "NaN,,,", "s,1,2,3", "a,b,c,d", "s,rpm"] {
            assert_eq!(units(row), None, "{row}");
        }
    }
}

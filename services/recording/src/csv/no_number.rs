//! A cell that contains text instead of a number: what it may be, and the remedy.

use super::absent::SHOWN;
use super::cells::Record;
use super::dialect::{self, Dialect};
use crate::Error;
use crate::{time, unit};

/// Remedy for a file with zeros: a loss of power leaves blocks of them.
pub(crate) const ZEROS: &str = "it holds bytes of zero, as after a loss of power: write it without them (tr -d '\\000' < FILE > NEW), and delete torn rows";

/// A cell that contains text instead of a number.
#[derive(Debug)]
pub(crate) struct NoNumber {
    pub text: String,
    pub column: String,
    /// Whether it is in the column of the time.
    pub is_time: bool,
    /// Whether the text is the name of a column: the header is repeated here.
    pub is_header: bool,
    /// Whether its line consists of words, other than those of the header.
    pub is_of_words: bool,
    /// Whether it is the last one of its line.
    pub is_last: bool,
}

impl NoNumber {
    /// The text in a cell of this column.
    pub(super) fn of(cell: &[u8], column: &str, header: &[String], is_time: bool) -> Self {
        let mut text: Vec<char> = dialect::text(cell).chars().collect();
        // A block of zeros is shown as one.
        text.dedup_by(|b, a| (*b, *a) == ('\0', '\0'));
        let text: String = text.into_iter().collect();
        let name = text.trim_start_matches('\u{feff}');
        Self {
            is_header: header.iter().any(|column| column == name),
            is_of_words: false,
            is_last: false,
            text: text.chars().take(SHOWN).collect(),
            column: column.to_owned(),
            is_time,
        }
    }

    /// The same at this place of a line: its other cells show whether another table begins there.
    pub(super) fn within(
        mut self,
        record: &Record,
        at: usize,
        header: &[String],
        dialect: Dialect,
    ) -> Self {
        self.is_last = at + 1 == record.len();
        let written = || record.iter().filter(|cell| !cell.is_empty());
        let are_words = written().all(|cell| dialect.number(cell).is_none());
        let are_same = record.iter().map(dialect::name).eq(header.iter().cloned());
        self.is_of_words = are_words && !are_same && written().count() > 1;
        self
    }

    /// As an error.
    pub(crate) fn at(self, line: usize, file: &str) -> Error {
        let is_ambiguous = self.is_time && time::is_ambiguous(&self.text);
        let remedy = match () {
            () if is_ambiguous => "write the year first, as in 2026-11-21 16:00:00.25",
            () if self.is_header && self.is_of_words => {
                "the header stands here once more, of other columns or in another order: make a file of each recording"
            }
            () if self.text.chars().any(is_foreign_digit) => {
                "write the numbers in the digits 0 to 9, of ASCII"
            }
            () if self.is_of_words => {
                "its line has words alone: where another table begins there, make a file of each; else delete the line"
            }
            () if self.is_header => {
                "the header stands here once more: make a file of each recording, or delete the line"
            }
            () if self.text.contains('\0') => ZEROS,
            () if self.is_time && self.text.chars().all(char::is_alphabetic) => {
                "delete the line if it is none of the recording (a sum, a second row of names); else write seconds, or dates like 2026-11-21 16:00:00.25 (or 21.11.2026 16:00:00.25)"
            }
            () if self.is_time && has_zone_name(&self.text) => {
                "write the zone as a number, +01:00, or leave it out"
            }
            () if self.is_time && (!self.text.contains(',') || self.text.contains(':')) => {
                "write seconds, or dates like 2026-11-21 16:00:00.25 (or 21.11.2026 16:00:00.25)"
            }
            () if has_unit(&self.text) => {
                "write the number alone; its unit stands once, in a row below the names, or in a signal map (unit = ...)"
            }
            () if self.text.contains(',') || is_in_groups(&self.text) => {
                "write it with a decimal point and without marks between thousands"
            }
            () => {
                "write a number, or leave the cell empty where the sample is missing; delete the line if it is no sample"
            }
        };
        let what = match () {
            () if is_ambiguous => "may begin with its day or with its month",
            () if self.is_time && self.text.contains(':') => "is no time",
            () => "is no number",
        };
        Error::new(
            format!("\"{}\" {what}", self.text),
            format!("{file}:{line}, column {}", self.column),
            remedy,
        )
    }
}

/// Whether this is a digit of another script, or a wide one: `１`, `١`.
fn is_foreign_digit(c: char) -> bool {
    matches!(c, '\u{660}'..='\u{669}' | '\u{6f0}'..='\u{6f9}' | '\u{966}'..='\u{96f}' | '\u{ff10}'..='\u{ff19}')
}

/// Whether a unit follows the number, as in `12.5 kN`.
fn has_unit(text: &str) -> bool {
    let number = text.trim_end_matches(|c: char| !c.is_ascii_digit());
    number.replace(',', ".").parse::<f64>().is_ok() && unit::guess(&text[number.len()..]).is_some()
}

/// Whether blanks part the digits, as in `12 500.0`.
fn is_in_groups(text: &str) -> bool {
    let mut groups = text.trim_start_matches(['-', '+']).split(' ');
    let is_number = |group: &str| {
        group.starts_with(|c: char| c.is_ascii_digit()) && group.parse::<f64>().is_ok()
    };
    text.contains(' ') && groups.all(is_number)
}

/// Whether a time ends with the name of its zone, such as CET.
fn has_zone_name(text: &str) -> bool {
    let Some((time, zone)) = text.trim_end().rsplit_once(' ') else {
        return false;
    };
    let is_name = zone.len() > 2 && zone.chars().all(|c| c.is_ascii_uppercase());
    is_name && time.starts_with(|c: char| c.is_ascii_digit()) && time.contains(':')
}

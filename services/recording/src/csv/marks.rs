//! Detects thousands separators that could be taken for decimal marks: `12.345` in a table that also has `0,5`.

/// Point and comma.
const MARKS: [u8; 2] = [b'.', b','];

/// Use of points and commas in the numbers of a column.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Marks {
    /// Before three digits and after one to three: a thousands separator or a decimal mark.
    either: [bool; 2],
    /// Certainly a decimal mark.
    decimal: [bool; 2],
    /// Numbers of the first kind, numbers below a thousand without a mark, and whether any other had none.
    groups: u32,
    small: u32,
    has_large: bool,
}

/// Fewest numbers of each kind for a verdict: of numbers with three decimals one in ten ends with a zero, which some programs omit.
const ENOUGH: u32 = 50;

impl Marks {
    /// Takes a number.
    pub(super) fn see(&mut self, cell: &[u8]) {
        let Some(at) = memchr::memrchr2(MARKS[0], MARKS[1], cell) else {
            let digits = cell.strip_prefix(b"-").unwrap_or(cell);
            self.has_large |= digits.len() > 3;
            self.small += u32::from(digits != b"0");
            return;
        };
        let (whole, below) = (&cell[..at], &cell[at + 1..]);
        let whole = whole.strip_prefix(b"-").unwrap_or(whole);
        let is_digits = |text: &[u8]| text.iter().all(u8::is_ascii_digit);
        let is_either = matches!(whole, [b'1'..=b'9', rest @ ..] if rest.len() < 3 && is_digits(rest))
            && below.len() == 3
            && is_digits(below);
        let mark = usize::from(cell[at] == MARKS[1]);
        self.groups += u32::from(is_either);
        self.either[mark] |= is_either;
        self.decimal[mark] |= !is_either;
    }

    /// Whether no number of a thousand or more lacks a mark, and none below has one.
    fn is_grouped(&self) -> bool {
        self.groups > ENOUGH && self.small > ENOUGH && !self.has_large
    }
}

/// The first column with ambiguous numbers, and their mark. The mark may separate thousands if the table
/// has the other mark for decimals, or if only numbers above a thousand have it. Commas in quotes in a table separated by commas are
/// decimal marks only if some of them certainly are, and no number has a point.
pub(super) fn unclear(columns: &[Marks], separator: u8) -> Option<(usize, char)> {
    let has = |mark: usize| columns.iter().any(|column| column.decimal[mark]);
    (0..MARKS.len()).find_map(|mark| {
        let is_other_decimal = has(1 - mark);
        let may_group = |column: &Marks| column.either[mark] && !column.decimal[mark];
        let tells =
            |column: &&Marks| is_other_decimal || separator != MARKS[1] && column.is_grouped();
        let is_quoted = |column: &Marks| {
            MARKS[mark] == separator && (column.either[mark] || column.decimal[mark])
        };
        let is_unclear = |column: &Marks| match is_quoted(column) {
            true => is_other_decimal || !has(mark),
            false => may_group(column) && tells(&column),
        };
        let at = columns.iter().position(is_unclear)?;
        Some((at, char::from(MARKS[mark])))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ambiguity in columns of these cells.
    fn unclear_of(columns: &[&[&str]], separator: u8) -> Option<(usize, char)> {
        let marks = columns.iter().map(|cells| {
            let mut marks = Marks::default();
            cells.iter().for_each(|cell| marks.see(cell.as_bytes()));
            marks
        });
        unclear(&marks.collect::<Vec<_>>(), separator)
    }

    #[test]
    fn thousands_are_doubted_where_nothing_below_them_has_a_mark() {
        let of = |text: fn(i32) -> String| {
            let mut marks = Marks::default();
            (0..200).for_each(|i| marks.see(text(i).as_bytes()));
            unclear(&[marks], b';')
        };
        let grouped = |i: i32| match 13 * i {
            x if x < 1000 => x.to_string(),
            x => format!("{}.{:03}", x / 1000, x % 1000),
        };
        assert_eq!(of(grouped), Some((0, '.')));
        assert_eq!(of(|i| (f64::from(13 * i) / 1000.0).to_string()), None);
        assert_eq!(of(|i| format!("{:.3}", f64::from(i) / 10.0)), None);
    }

    #[test]
    fn thousands_are_doubted_where_the_other_mark_is_that_of_decimals() {
        let of = |columns: &[&[&str]]| unclear_of(columns, b';');
        assert_eq!(of(&[&["0,5"], &["987", "-12.345"]]), Some((1, '.')));
        assert_eq!(of(&[&["12.345", "9.876,5"]]), Some((0, '.')));
        assert_eq!(of(&[&["1,234"], &["0.5"]]), Some((0, ',')));
        for columns in [
            &[&["0,5"][..], &["12,345"]][..],
            &[&["0.5"], &["12.345"]],
            &[&["0,5"], &["12.345", "0.345"]],
            &[&["0,5"], &["12.345", "1.5"]],
            &[&["0,5"], &["1.234.567,5"]],
            &[&["5"], &["12.345"]],
        ] {
            assert_eq!(of(columns), None, "{columns:?}");
        }
    }

    #[test]
    fn commas_in_quotes_are_decimal_marks_where_the_table_shows_it() {
        let of = |columns: &[&[&str]]| unclear_of(columns, b',');
        for columns in [
            &[&["0,5"][..], &["12,345"]][..],
            &[&["0"], &["1,25", "7"]],
            &[&["0.5"], &["12.345"]],
        ] {
            assert_eq!(of(columns), None, "{columns:?}");
        }
        // Thousands, two numbers in one cell.
        assert_eq!(of(&[&["1"], &["12,345"]]), Some((1, ',')));
        assert_eq!(of(&[&["0.5"], &["1,5"]]), Some((1, ',')));
    }
}

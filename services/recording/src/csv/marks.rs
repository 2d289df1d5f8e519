//! Marks between thousands that pass for decimal marks: `12.345` in a table that has `0,5` too.

/// Point and comma.
const MARKS: [u8; 2] = [b'.', b','];

/// What points and commas were in the numbers of a column.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Marks {
    /// Before three digits and behind one to three: between thousands, or a decimal mark.
    either: [bool; 2],
    /// Nothing but a decimal mark.
    decimal: [bool; 2],
}

impl Marks {
    /// Looks at a number.
    pub(super) fn see(&mut self, cell: &[u8]) {
        let Some(at) = memchr::memrchr2(MARKS[0], MARKS[1], cell) else {
            return;
        };
        let (whole, below) = (&cell[..at], &cell[at + 1..]);
        let whole = whole.strip_prefix(b"-").unwrap_or(whole);
        let is_digits = |text: &[u8]| text.iter().all(u8::is_ascii_digit);
        let is_either = matches!(whole, [b'1'..=b'9', rest @ ..] if rest.len() < 3 && is_digits(rest))
            && below.len() == 3
            && is_digits(below);
        let mark = usize::from(cell[at] == MARKS[1]);
        self.either[mark] |= is_either;
        self.decimal[mark] |= !is_either;
    }
}

/// The first column whose numbers cannot be told, with the mark in them: its marks may stand between thousands, and the table
/// has the other mark for decimals.
pub(super) fn unclear(columns: &[Marks]) -> Option<(usize, char)> {
    (0..MARKS.len()).find_map(|mark| {
        let is_other_decimal = columns.iter().any(|column| column.decimal[1 - mark]);
        let may_group = |column: &Marks| column.either[mark] && !column.decimal[mark];
        let at = columns
            .iter()
            .position(may_group)
            .filter(|_| is_other_decimal)?;
        Some((at, char::from(MARKS[mark])))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_doubted_where_the_other_mark_is_that_of_decimals() {
        let of = |columns: &[&[&str]]| {
            let marks = columns.iter().map(|cells| {
                let mut marks = Marks::default();
                cells.iter().for_each(|cell| marks.see(cell.as_bytes()));
                marks
            });
            unclear(&marks.collect::<Vec<_>>())
        };
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
}

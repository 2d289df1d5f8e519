//! Tables as text.

use std::fmt;

/// A table: the first column left-aligned, all others right-aligned.
#[derive(Clone, Debug)]
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with its header.
    pub fn new(header: &[&str]) -> Self {
        Self {
            rows: vec![header.iter().map(|cell| (*cell).to_owned()).collect()],
        }
    }

    /// A table whose header is one text, its cells separated by semicolons: `mode; mean; std`.
    pub fn headed(header: &str) -> Self {
        Self::new(&header.split(';').map(str::trim).collect::<Vec<_>>())
    }

    /// Adds a row. A line end in a cell, as names of files have, is written as `\n`.
    pub fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        let one_line = |cell: S| cell.into().replace('\n', "\\n");
        self.rows.push(cells.into_iter().map(one_line).collect());
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |i: usize| {
            let cells = self.rows.iter().filter_map(|row| row.get(i));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for (number, row) in self.rows.iter().enumerate() {
            let cells = row
                .iter()
                .zip(&widths)
                .enumerate()
                .map(|(i, (cell, &width))| match i {
                    0 => format!("{cell:<width$}"),
                    _ => format!("{cell:>width$}"),
                });
            let line = cells.collect::<Vec<_>>().join("  ");
            writeln!(f, "  {}", line.trim_end())?;
            if number == 0 {
                let ruler: Vec<String> = widths.iter().map(|&width| "-".repeat(width)).collect();
                writeln!(f, "  {}", ruler.join("  "))?;
            }
        }
        Ok(())
    }
}

/// A number with the given decimals and a sign.
pub fn signed(value: f64, decimals: usize) -> String {
    format!("{value:+.decimals$}")
}

/// A number with the given decimals.
pub fn plain(value: f64, decimals: usize) -> String {
    format!("{value:.decimals$}")
}

/// Result of a target: "pass" or "FAIL".
pub fn verdict(met: bool) -> String {
    if met { "pass" } else { "FAIL" }.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let mut table = Table::new(&["case", "mean"]);
        table.row(["1", "-0.25"]);
        table.row(["a\nb", "10"]);
        assert_eq!(
            table.to_string(),
            "  case   mean\n  ----  -----\n  1     -0.25\n  a\\nb     10\n"
        );
    }
}

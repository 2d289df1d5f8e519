//! A table as tests read it: rows of cells, by the names of their columns.

use std::path::Path;

/// A table without quotes, comments or units: those that heft writes, and golden ones.
pub struct Table {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// A row of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<'a> {
    names: &'a [String],
    cells: &'a [String],
}

fn cells(line: &str) -> Vec<String> {
    line.split(',').map(str::to_owned).collect()
}

impl Table {
    pub fn read(file: impl AsRef<Path>) -> Self {
        let text = std::fs::read_to_string(file).expect("a table");
        let mut lines = text.lines().map(cells);
        let names = lines.next().expect("a header");
        let rows: Vec<_> = lines.collect();
        for row in &rows {
            assert_eq!(row.len(), names.len(), "a cell for each column: {row:?}");
        }
        Self { names, rows }
    }

    pub fn names(&self) -> &[String] {
        &self.names
    }

    pub fn rows(&self) -> impl ExactSizeIterator<Item = Row<'_>> + DoubleEndedIterator {
        let names = &self.names;
        self.rows.iter().map(|cells| Row { names, cells })
    }
}

impl<'a> Row<'a> {
    /// The cell of a column that the table has.
    pub fn cell(&self, name: &str) -> &'a str {
        self.find(name)
            .unwrap_or_else(|| panic!("no column {name} in {:?}", self.names))
    }

    /// The number of a column that the table has.
    pub fn number(&self, name: &str) -> f64 {
        let cell = self.cell(name);
        cell.parse()
            .unwrap_or_else(|_| panic!("{name}: {cell:?} is no number"))
    }

    /// The number of a column that the table may lack, or whose cell may be empty.
    pub fn measured(&self, name: &str) -> Option<f64> {
        self.find(name)?.parse().ok()
    }

    fn find(&self, name: &str) -> Option<&'a str> {
        let place = self.names.iter().position(|found| found == name)?;
        Some(&self.cells[place])
    }
}

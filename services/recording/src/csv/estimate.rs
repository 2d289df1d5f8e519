use std::fmt::Write as _;
use std::marker::PhantomData;
use std::path::Path;

use messages::{Message, Value};
use sheet::Quantity;

use crate::Error;
use crate::output::{Output, first_line};

/// A column of the output.
#[derive(Debug, Clone, Copy)]
pub enum Column {
    /// A field, empty unless `estimated` has all of these bits.
    Value(&'static str, u32),
    /// A bit of `flags`, 0 or 1.
    Flag(&'static str, u32),
}

impl Column {
    pub(crate) fn name(self) -> &'static str {
        let (Self::Value(name, _) | Self::Flag(name, _)) = self;
        name
    }

    /// Index of its field, if it is one.
    pub(crate) fn index<E: Estimate>(self) -> Option<usize> {
        match self {
            Self::Value(name, _) => E::index(name),
            Self::Flag(..) => None,
        }
    }

    pub(crate) fn unit<E: Estimate>(self) -> &'static str {
        self.index::<E>().map_or("", |i| E::FIELDS[i].unit)
    }
}

/// Number of columns of quantities and flags.
pub(crate) const fn count(quantities: &[Quantity], flags: &[sheet::Flag]) -> usize {
    let (mut count, mut i) = (0, 0);
    while i < quantities.len() {
        if !matches!(quantities[i].column, sheet::Column::Never) {
            count += 1 + quantities[i].std.is_some() as usize;
        }
        i += 1;
    }
    i = 0;
    while i < flags.len() {
        count += flags[i].column as usize;
        i += 1;
    }
    count
}

/// The `N` columns: quantities, each followed by its standard deviation, flags, then quantities of later versions.
pub(crate) const fn columns<const N: usize>(
    quantities: &[Quantity],
    flags: &[sheet::Flag],
) -> [Column; N] {
    let columns = [Column::Flag("", 0); N];
    let (mut columns, mut at) = values(columns, 0, quantities, sheet::Column::Always);
    let mut i = 0;
    while i < flags.len() {
        if flags[i].column {
            columns[at] = Column::Flag(flags[i].entry.name, flags[i].entry.number);
            at += 1;
        }
        i += 1;
    }
    let (columns, at) = values(columns, at, quantities, sheet::Column::Last);
    assert!(at == N, "N is the number of columns");
    columns
}

/// Puts the quantities of one group after the first `at` columns.
const fn values<const N: usize>(
    mut columns: [Column; N],
    mut at: usize,
    quantities: &[Quantity],
    place: sheet::Column,
) -> ([Column; N], usize) {
    let mut i = 0;
    while i < quantities.len() {
        let q = &quantities[i];
        if q.column as u8 == place as u8 {
            columns[at] = Column::Value(q.name, q.estimated);
            at += 1;
            if let Some(std) = q.std {
                columns[at] = Column::Value(std, q.estimated);
                at += 1;
            }
        }
        i += 1;
    }
    (columns, at)
}

/// An [`Estimate`] of a machine from its sheet.
macro_rules! estimate_of {
    ($machine:ident, $bits:ident, $methods:ident, $reasons:ident) => {
        const REFUSED: u32 = messages::$bits::REFUSED;
        const METHODS: &'static [&'static str] = messages::$methods;
        const REASONS: &'static [(&'static str, &'static str)] = messages::$reasons;
        const COLUMNS: &'static [$crate::csv::Column] = &{
            use sheet::$machine::{FLAGS, QUANTITIES};
            use $crate::csv::{columns, count};
            columns::<{ count(QUANTITIES, FLAGS) }>(QUANTITIES, FLAGS)
        };

        fn codes(&self) -> $crate::csv::Codes {
            $crate::csv::Codes {
                flags: self.flags,
                estimated: self.estimated,
                method: self.method,
                reason: self.reason,
            }
        }
    };
}
pub(crate) use estimate_of;

/// Codes of an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Codes {
    /// Its flags.
    pub flags: u32,
    /// Bits of the estimated quantities.
    pub estimated: u32,
    /// Index of the method.
    pub method: u32,
    /// Code of the reason.
    pub reason: u32,
}

/// An estimate that can be written as a row.
pub trait Estimate: Message {
    /// Its columns after the time, the same for every method; method and reason come last.
    const COLUMNS: &'static [Column];
    /// Bit of `flags` that marks a refused row.
    const REFUSED: u32;
    /// Names of the methods.
    const METHODS: &'static [&'static str];
    /// Names and texts of the reasons by their code.
    const REASONS: &'static [(&'static str, &'static str)];
    /// Its codes.
    fn codes(&self) -> Codes;
    /// Whether its row was refused.
    fn is_refused(&self) -> bool {
        self.codes().flags & Self::REFUSED != 0
    }
    /// Names of its method and of its reason; "" for an unknown one.
    fn names(&self) -> [&'static str; 2] {
        let Codes { method, reason, .. } = self.codes();
        let reason = Self::REASONS.get(reason as usize);
        [
            Self::METHODS.get(method as usize).copied().unwrap_or(""),
            reason.map_or("", |(name, _)| *name),
        ]
    }
}

/// A cell of an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell {
    /// A number; NaN where the method does not estimate the quantity.
    Number(f64),
    /// A flag.
    Flag(bool),
    /// A word.
    Word(&'static str),
}

/// Splits estimates into the cells of their columns.
#[derive(Debug)]
pub struct Values<E: Estimate> {
    /// Columns with the field of each.
    columns: Vec<(Column, Option<usize>)>,
    estimates: PhantomData<E>,
}

impl<E: Estimate> Default for Values<E> {
    fn default() -> Self {
        let columns = E::COLUMNS.iter();
        Self {
            columns: columns.map(|c| (*c, c.index::<E>())).collect(),
            estimates: PhantomData,
        }
    }
}

impl<E: Estimate> Values<E> {
    /// The cells between time and method.
    pub fn of(&self, estimate: &E) -> impl Iterator<Item = Cell> {
        let Codes {
            flags, estimated, ..
        } = estimate.codes();
        self.columns
            .iter()
            .map(move |(column, index)| match *column {
                Column::Flag(_, bit) => Cell::Flag(flags & bit != 0),
                Column::Value(_, bits) if estimated & bits != bits => Cell::Number(f64::NAN),
                Column::Value(..) => match index.and_then(|i| estimate.get(i)) {
                    Some(Value::F64(x)) => Cell::Number(x),
                    _ => Cell::Number(f64::NAN),
                },
            })
    }
}

/// Estimates as rows of text.
#[derive(Debug)]
pub struct EstimateRows<E: Estimate>(Values<E>);

impl<E: Estimate> Default for EstimateRows<E> {
    fn default() -> Self {
        Self(Values::default())
    }
}

impl<E: Estimate> EstimateRows<E> {
    /// Names of the columns, without the end of the line.
    pub fn header(&self) -> String {
        let mut row = String::from("t");
        for column in E::COLUMNS {
            let _ = write!(row, ",{}", column.name());
        }
        row + ",method,reason"
    }

    /// Appends the row of an estimate, without the end of the line; returns false and appends nothing for a refused one.
    pub fn put(&self, estimate: &E, row: &mut String) -> bool {
        if estimate.is_refused() {
            return false;
        }
        put_number(row, estimate.stamp().time);
        let names = estimate.names().map(Cell::Word);
        for cell in self.0.of(estimate).chain(names) {
            row.push(',');
            match cell {
                Cell::Number(x) => put_number(row, x),
                Cell::Flag(x) => row.push(if x { '1' } else { '0' }),
                Cell::Word(x) => row.push_str(x),
            }
        }
        true
    }
}

/// Writes estimates as CSV, one row per accepted sample. The file appears under its name only when
/// it is complete.
pub struct EstimateWriter<E: Estimate> {
    out: Output,
    rows: EstimateRows<E>,
    row: String,
    written: usize,
}

impl<E: Estimate> EstimateWriter<E> {
    /// Begins a file of estimates.
    ///
    /// # Errors
    /// The file cannot be created.
    pub fn create(path: &Path) -> Result<Self, Error> {
        let rows = EstimateRows::default();
        Ok(Self {
            out: Output::create("write the estimates", path, &[], is_estimates)?,
            row: rows.header() + "\n",
            rows,
            written: 0,
        })
    }

    /// Adds an estimate; a refused row is left out.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&mut self, estimate: &E) -> Result<(), Error> {
        if !self.rows.put(estimate, &mut self.row) {
            return Ok(());
        }
        self.row.push('\n');
        self.written += 1;
        self.put_row()
    }

    /// Completes the file, gives it its name and returns its number of rows.
    ///
    /// # Errors
    /// The file cannot be written; it is then removed.
    pub fn finish(mut self) -> Result<usize, Error> {
        self.put_row()?;
        self.out.finish()?;
        Ok(self.written)
    }

    fn put_row(&mut self) -> Result<(), Error> {
        let written = self.out.put(self.row.as_bytes());
        self.row.clear();
        written
    }
}

/// Recognizes estimates of heft by the first bytes of a file.
pub fn is_estimates(head: &[u8]) -> bool {
    let named = |line: &str| line.split(',').any(|column| column == "method");
    first_line(head).is_some_and(|line| line.starts_with("t,") && named(line))
}

/// The shortest text that reads back to the same number; empty for NaN and infinities.
pub(crate) fn put_number(out: &mut String, x: f64) {
    if x == 0.0 || (1e-5..1e16).contains(&x.abs()) {
        // A tenth of the time of the standard library's, which would be two fifths of that of `heft estimate`.
        let mut buffer = zmij::Buffer::new();
        let text = buffer.format_finite(x);
        out.push_str(text.strip_suffix(".0").unwrap_or(text));
    } else if x.is_finite() {
        let _ = write!(out, "{x:e}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_written_as_shortly_as_by_the_standard_library_and_reads_back() {
        let mut bits = 0x9e37_79b9_7f4a_7c15_u64;
        let mut numbers = vec![
            0.0,
            -0.0,
            1.0,
            -2.5,
            1e-5,
            9.999e-6,
            1e15,
            1e16,
            0.1 + 0.2,
            5e-324,
        ];
        for k in 0..20_000 {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let any = f64::from_bits(bits);
            numbers.extend([any, (any.fract() * 1e3).trunc() / 1e3, f64::from(k) * 0.01]);
        }
        for x in numbers {
            let plain = x == 0.0 || (1e-5..1e16).contains(&x.abs());
            let expected = match x {
                _ if !x.is_finite() => String::new(),
                _ if plain => format!("{x}"),
                _ => format!("{x:e}"),
            };
            let mut text = String::new();
            put_number(&mut text, x);
            // Of two shortest texts that are equally near each library has its own choice.
            assert_eq!(text.len(), expected.len(), "{text} {expected}");
            assert!(!x.is_finite() || text.parse() == Ok(x), "{text} {expected}");
        }
    }
}

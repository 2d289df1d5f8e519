//! Estimates as columns and as cells.

use crate::csv::{Cell, Codes, Column, Estimate, EstimateValues};

/// One column of estimates.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers; NaN where the method does not estimate the quantity.
    Numbers(Vec<f64>),
    /// Flags.
    Flags(Vec<bool>),
    /// Words, as indices into the list.
    Words(Vec<u8>, Vec<&'static str>),
}

/// A column: name, SI unit, values.
pub type NamedColumn = (&'static str, &'static str, Values);

/// Estimates in columns, as `heft estimate` writes them, without the rows that were refused.
#[derive(Debug)]
pub struct Table<E: Estimate> {
    times: Vec<f64>,
    cells: EstimateValues<E>,
    columns: Vec<Values>,
    methods: Vec<u8>,
    reasons: Vec<u8>,
    rows: u32,
    /// Indices of the refused rows.
    refused: Vec<u32>,
}

impl<E: Estimate> Table<E> {
    /// An empty table with capacity for this number of rows.
    pub fn with_capacity(rows: usize) -> Self {
        let column = |c: &Column| match c {
            Column::Flag(..) => Values::Flags(Vec::with_capacity(rows)),
            Column::Value(..) => Values::Numbers(Vec::with_capacity(rows)),
        };
        Self {
            times: Vec::with_capacity(rows),
            cells: EstimateValues::default(),
            columns: E::COLUMNS.iter().map(column).collect(),
            methods: Vec::with_capacity(rows),
            reasons: Vec::with_capacity(rows),
            rows: 0,
            refused: Vec::new(),
        }
    }

    /// Adds a row; a refused one is only counted as such.
    pub fn push(&mut self, estimate: &E) {
        self.rows += 1;
        if estimate.is_refused() {
            self.refused.push(self.rows - 1);
            return;
        }
        self.times.push(estimate.stamp().time);
        for (column, cell) in self.columns.iter_mut().zip(self.cells.of(estimate)) {
            match (column, cell) {
                (Values::Flags(column), Cell::Flag(x)) => column.push(x),
                (Values::Numbers(column), Cell::Number(x)) => column.push(x),
                _ => {}
            }
        }
        let Codes { method, reason, .. } = estimate.codes();
        self.methods.push(u8::try_from(method).unwrap_or(u8::MAX));
        self.reasons.push(u8::try_from(reason).unwrap_or(u8::MAX));
    }

    /// Indices of the refused rows.
    pub fn refused(&self) -> &[u32] {
        &self.refused
    }

    /// The columns.
    pub fn finish(self) -> Vec<NamedColumn> {
        let mut columns = vec![("t", "s", Values::Numbers(self.times))];
        let named = E::COLUMNS.iter().zip(self.columns);
        columns.extend(named.map(|(c, values)| (c.name(), c.unit::<E>(), values)));
        columns.push((
            "method",
            "",
            Values::Words(self.methods, E::METHODS.to_vec()),
        ));
        let names = E::REASONS.iter().map(|(name, _)| *name);
        columns.push(("reason", "", Values::Words(self.reasons, names.collect())));
        columns
    }
}

/// Name, unit and kind of every column of an estimate: time, quantities, flags, whether
/// the row was refused, method and reason.
pub fn header<E: Estimate>() -> Vec<(&'static str, &'static str, Kind)> {
    let column = |c: &Column| {
        let kind = match c {
            Column::Flag(..) => Kind::Flag,
            Column::Value(..) => Kind::Number,
        };
        (c.name(), c.unit::<E>(), kind)
    };
    let mut all = vec![("t", "s", Kind::Number)];
    all.extend(E::COLUMNS.iter().map(column));
    all.extend([("refused", "", Kind::Flag), ("method", "", Kind::Method)]);
    all.push(("reason", "", Kind::Reason));
    all
}

/// Type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Numbers.
    Number,
    /// Flags.
    Flag,
    /// Names of methods.
    Method,
    /// Names of reasons.
    Reason,
}

/// Splits estimates into the cells of [`header`].
#[derive(Debug)]
pub struct Cells<E: Estimate>(EstimateValues<E>);

impl<E: Estimate> Default for Cells<E> {
    fn default() -> Self {
        Self(EstimateValues::default())
    }
}

impl<E: Estimate> Cells<E> {
    /// Calls `put` with the cells of an estimate in the order of [`header`].
    pub fn of(&self, estimate: &E, put: &mut dyn FnMut(Cell)) {
        put(Cell::Number(estimate.stamp().time));
        self.0.of(estimate).for_each(&mut *put);
        put(Cell::Flag(estimate.is_refused()));
        estimate
            .names()
            .into_iter()
            .for_each(|n| put(Cell::Word(n)));
    }
}

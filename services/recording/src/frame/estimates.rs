//! Estimates as columns, and as cells.

use std::marker::PhantomData;

use messages::Value;

use crate::csv::{Codes, Column, Estimate};

/// One column of estimates.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers; NaN where the method does not estimate the quantity.
    Numbers(Vec<f64>),
    /// Flags.
    Flags(Vec<bool>),
    /// Words by their code, which is their place in the list.
    Words(Vec<u8>, Vec<&'static str>),
}

/// A column: name, SI unit, values.
pub type NamedColumn = (&'static str, &'static str, Values);

/// Estimates in columns, as `heft estimate` writes them, without the rows that were refused.
#[derive(Debug)]
pub struct Table<E: Estimate> {
    times: Vec<f64>,
    columns: Vec<(Column, Option<usize>, Values)>,
    methods: Vec<u8>,
    reasons: Vec<u8>,
    rows: u32,
    /// Places of the rows that were refused.
    refused: Vec<u32>,
    estimates: PhantomData<E>,
}

impl<E: Estimate> Table<E> {
    /// An empty table with room for so many rows.
    pub fn with_capacity(rows: usize) -> Self {
        let column = |c: &Column| {
            let values = match c {
                Column::Flag(..) => Values::Flags(Vec::with_capacity(rows)),
                Column::Value(..) => Values::Numbers(Vec::with_capacity(rows)),
            };
            (*c, c.index::<E>(), values)
        };
        Self {
            times: Vec::with_capacity(rows),
            columns: E::COLUMNS.iter().map(column).collect(),
            methods: Vec::with_capacity(rows),
            reasons: Vec::with_capacity(rows),
            rows: 0,
            refused: Vec::new(),
            estimates: PhantomData,
        }
    }

    /// Adds a row; one that was refused is noted as such.
    pub fn push(&mut self, estimate: &E) {
        let Codes {
            flags,
            estimated,
            method,
            reason,
        } = estimate.codes();
        self.rows += 1;
        if flags & E::REFUSED != 0 {
            self.refused.push(self.rows - 1);
            return;
        }
        self.times.push(estimate.stamp().time);
        for (column, index, cells) in &mut self.columns {
            match (cells, *column) {
                (Values::Flags(cells), Column::Flag(_, bit)) => cells.push(flags & bit != 0),
                (Values::Numbers(cells), Column::Value(_, bits)) => {
                    cells.push(number(estimate, *index, estimated & bits == bits));
                }
                _ => {}
            }
        }
        self.methods.push(u8::try_from(method).unwrap_or(u8::MAX));
        self.reasons.push(u8::try_from(reason).unwrap_or(u8::MAX));
    }

    /// Places of the rows that were refused.
    pub fn refused(&self) -> &[u32] {
        &self.refused
    }

    /// The columns.
    pub fn finish(self) -> Vec<NamedColumn> {
        let mut columns = vec![("t", "s", Values::Numbers(self.times))];
        for (column, _, values) in self.columns {
            columns.push((column.name(), column.unit::<E>(), values));
        }
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

/// A field of an estimate; NaN where it is not estimated.
fn number<E: Estimate>(estimate: &E, index: Option<usize>, is_estimated: bool) -> f64 {
    match index.and_then(|i| estimate.get(i)) {
        Some(Value::F64(x)) if is_estimated => x,
        _ => f64::NAN,
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

/// Name, unit and meaning of every column that an estimate of this kind can have: time, quantities, flags, whether
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

/// What a column holds.
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

/// Takes estimates apart into the cells of [`header`].
#[derive(Debug)]
pub struct Cells<E: Estimate> {
    columns: Vec<(Column, Option<usize>)>,
    estimates: PhantomData<E>,
}

impl<E: Estimate> Default for Cells<E> {
    fn default() -> Self {
        let columns = E::COLUMNS.iter();
        Self {
            columns: columns.map(|c| (*c, c.index::<E>())).collect(),
            estimates: PhantomData,
        }
    }
}

impl<E: Estimate> Cells<E> {
    /// Calls `put` with the cells of an estimate in the order of [`header`].
    pub fn of(&self, estimate: &E, put: &mut dyn FnMut(Cell)) {
        let Codes {
            flags, estimated, ..
        } = estimate.codes();
        put(Cell::Number(estimate.stamp().time));
        for (column, index) in &self.columns {
            put(match *column {
                Column::Flag(_, bit) => Cell::Flag(flags & bit != 0),
                Column::Value(_, bits) => {
                    Cell::Number(number(estimate, *index, estimated & bits == bits))
                }
            });
        }
        put(Cell::Flag(flags & E::REFUSED != 0));
        estimate
            .names()
            .into_iter()
            .for_each(|n| put(Cell::Word(n)));
    }
}

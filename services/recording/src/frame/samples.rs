//! Samples from columns, or from values in the order of columns.

use messages::Machine;

use crate::Error;
use crate::map::hint;
use crate::signal::{self, Builder, Row, Sensors, Signal};

/// The samples of a machine from columns with the names of its CSV, in order. Columns of other names are
/// ignored. A value that is not finite is a missing sample.
///
/// # Errors
/// A required column is missing, or the columns differ in length.
pub fn rows<'a, S: Sensors>(
    columns: &'a [(&str, Vec<f64>)],
) -> Result<impl Iterator<Item = Row<S>> + 'a, Error> {
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    check_required::<S>(&names)?;
    let length = columns.first().map_or(0, |(_, values)| values.len());
    if let Some((name, values)) = columns.iter().find(|(_, v)| v.len() != length) {
        let what = format!("column {name} has {} values, not {length}", values.len());
        return Err(Error::new(what, TABLE, "give columns of the same length"));
    }
    let signals = signal::signals::<S>();
    let known: Vec<(&Signal, &[f64])> = signals
        .iter()
        .filter_map(|signal| {
            let column = columns.iter().find(|(name, _)| *name == signal.name)?;
            Some((signal, column.1.as_slice()))
        })
        .collect();
    let mut builder = Builder::<S>::new(known.iter().map(|(signal, _)| *signal));
    let values: Vec<&[f64]> = known.into_iter().map(|(_, values)| values).collect();
    let mut row = vec![0.0; values.len()];
    let mut at = 0;
    Ok(std::iter::from_fn(move || {
        loop {
            if let Some(next) = builder.next() {
                return Some(next);
            }
            if at == length {
                builder.finish();
                return builder.next();
            }
            for (value, values) in row.iter_mut().zip(&values) {
                *value = values[at];
            }
            builder.push(&row, 0);
            at += 1;
        }
    }))
}

const TABLE: &str = "the table";

/// The names of a required signal of which there is none.
fn missing<S: Sensors>(names: &[&str]) -> Option<&'static [&'static str]> {
    let time: &[&str] = &["t"];
    let mut groups = [time].into_iter().chain(S::REQUIRED.iter().copied());
    groups.find(|group| !group.iter().any(|name| names.contains(name)))
}

/// Fails if a signal that the machine requires is missing.
fn check_required<S: Sensors>(names: &[&str]) -> Result<(), Error> {
    missing::<S>(names).map_or(Ok(()), |group| {
        let what = format!("there is no column {} ({})", group.join(" or "), S::MACHINE);
        let remedy = format!("rename a column; the table has {}", names.join(", "));
        Err(Error::new(what, TABLE, remedy))
    })
}

/// Makes samples one by one; every named signal counts as present, even if it has no values at first.
#[derive(Debug)]
pub struct Feed<S: Sensors> {
    builder: Builder<S>,
}

impl<S: Sensors> Feed<S> {
    /// For rows with the values of these signals, in this order, including the time.
    ///
    /// # Errors
    /// A signal is unknown or named twice, or a required one is missing.
    pub fn new(names: &[&str]) -> Result<Self, Error> {
        let all = signal::signals::<S>();
        let known = |name: &str| all.iter().find(|s| s.name == name);
        for (i, name) in names.iter().enumerate() {
            if known(name).is_none() {
                let known = all.iter().map(|s| s.name.as_str());
                // What a sensor gives, and not a simulator.
                let known = known.filter(|name| *name != "t" && !name.starts_with("true_"));
                let what = format!("the {} has no signal {name}", S::MACHINE);
                let remedy = hint(name, known, "the signals are");
                return Err(Error::new(what, "the signals", remedy));
            }
            if names[..i].contains(name) {
                let what = format!("{name} is named twice");
                return Err(Error::new(what, "the signals", "name each signal once"));
            }
        }
        if let Some(group) = missing::<S>(names) {
            let needed = group.join(" or ");
            let what = format!("the {} needs {needed}", S::MACHINE);
            let remedy = format!(
                "name {needed} among the signals; without that sensor nothing is estimated"
            );
            return Err(Error::new(what, "the signals", remedy));
        }
        let signals = names.iter().filter_map(|name| known(name));
        Ok(Self {
            builder: Builder::with_all(signals),
        })
    }

    /// The next sample; a value that is not finite is missing.
    pub fn sample(&mut self, values: &[f64]) -> S {
        self.builder.push(values, 0);
        self.builder
            .next()
            .map_or_else(S::default, |(sample, _)| sample)
    }

    /// Number of samples made.
    pub fn count(&self) -> u64 {
        self.builder.count()
    }

    /// Continues to count from this number.
    pub fn go_on_from(&mut self, count: u64) {
        self.builder.go_on_from(count);
    }
}

/// Names of the possible columns of a machine's samples.
pub fn signals_of(machine: Machine) -> Vec<String> {
    signal::signals_of(machine)
        .into_iter()
        .map(|s| s.name)
        .collect()
}

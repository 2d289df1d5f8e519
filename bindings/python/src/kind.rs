//! Operations on a machine, independent of its types.

use std::path::Path;

use config::Description;
use messages::{Envelope, ExcavatorSensors, Message};
use pyo3::PyResult;
use recording::csv::Estimate;
use recording::frame::{self, Cell, Cells, Feed, NamedColumn, Table};
use recording::{Lacks, Map, Sensors};
use steps::chain::{chain, last_answer, method};

use crate::hints::Hints;
use crate::refused;

/// Result of an estimation.
pub struct Estimates {
    pub columns: Vec<NamedColumn>,
    /// Indices of the refused rows.
    pub refused: Vec<u32>,
    pub rows: usize,
    /// Missing and damaged parts of the file.
    pub lacks: Lacks,
    /// Warnings on the data.
    pub hints: Vec<String>,
}

/// A machine.
pub trait Kind: Sync {
    fn header(&self) -> Vec<(&'static str, &'static str, frame::Kind)>;
    fn reasons(&self) -> &'static [(&'static str, &'static str)];
    fn of_columns(
        &self,
        description: &Description,
        method: Option<&str>,
        columns: &[(&str, Vec<f64>)],
        length: usize,
    ) -> PyResult<Estimates>;
    fn of_file(
        &self,
        description: &Description,
        method: Option<&str>,
        path: &Path,
        map: Option<&Map>,
    ) -> PyResult<Estimates>;
    fn feed(&self, signals: &[&str]) -> PyResult<Box<dyn AnyFeed>>;
}

/// Converts numbers to samples, and estimates to cells.
pub trait AnyFeed: Send {
    /// Refuses signals that the method cannot use.
    fn check(&self, description: &Description, method: &str) -> PyResult<()>;
    fn sample(&mut self, values: &[f64]) -> Envelope;
    fn count(&self) -> u64;
    fn go_on_from(&mut self, count: u64);
    fn cells(&self, estimate: &Envelope, put: &mut dyn FnMut(Cell));
}

struct Of<S, E>(std::marker::PhantomData<fn() -> (S, E)>);

struct FeedOf<S: Sensors, E: Estimate> {
    feed: Feed<S>,
    names: Vec<String>,
    cells: Cells<E>,
}

macro_rules! kinds {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// The machine of a description.
        pub fn kind(description: &Description) -> &'static dyn Kind {
            match description.machine() {
                $( messages::Machine::$machine =>
                    &Of::<messages::$sensors, messages::$estimate>(std::marker::PhantomData), )*
            }
        }
    };
}

messages::machines!(kinds);

/// Refuses samples that the method cannot use.
fn check<S: Message>(description: &Description, method: &str, first: &S) -> PyResult<()> {
    match description {
        Description::Excavator(d) => match ExcavatorSensors::inside(&first.envelope()) {
            Some(first) => steps::excavator::check_columns(d, method, first).map_err(refused),
            None => Ok(()),
        },
        Description::Loader(_) => Ok(()),
    }
}

/// Passes the rows through the stages one by one, as `heft estimate` does.
fn run<S: Message, T, E: Estimate>(
    description: &Description,
    (asked, map): (Option<&str>, Option<&Map>),
    rows: impl Iterator<Item = (S, T)>,
    room: usize,
) -> PyResult<Estimates> {
    let method = method(description.machine(), asked);
    let mut chain = chain(description, method).map_err(refused)?;
    let mut table = Table::<E>::with_capacity(room);
    let mut hints = Hints::new(description, map);
    let mut count = 0;
    for (sample, _) in rows {
        if count == 0 {
            check(description, method, &sample)?;
        }
        count += 1;
        let sample = sample.envelope();
        hints.add(&sample);
        if let Some(estimate) = last_answer(&mut chain, sample).as_ref().and_then(E::inside) {
            table.push(estimate);
        }
    }
    let refused = table.refused().to_vec();
    let (columns, lacks) = (table.finish(), Lacks::default());
    let hints = hints.words();
    Ok(Estimates {
        columns,
        refused,
        rows: count,
        lacks,
        hints,
    })
}

/// Warnings on signals without which nothing is estimated, and whose columns hold no value.
fn silent<S: Sensors>(columns: &[(&str, Vec<f64>)], length: usize) -> Vec<String> {
    let has_value = |name: &&str| {
        let column = columns.iter().find(|(other, _)| other == name);
        column.is_some_and(|(_, values)| values.iter().any(|x| x.is_finite()))
    };
    let silent = S::REQUIRED
        .iter()
        .filter(|group| length > 0 && !group.iter().any(has_value));
    let words = |group: &&[&str]| {
        let names = group.join(" or ");
        format!(
            "{names} holds no value in any row, and nothing is estimated without; check the sensor and its recording"
        )
    };
    silent.map(words).collect()
}

impl<S: Sensors, E: Estimate> Kind for Of<S, E> {
    fn header(&self) -> Vec<(&'static str, &'static str, frame::Kind)> {
        frame::header::<E>()
    }

    fn reasons(&self) -> &'static [(&'static str, &'static str)] {
        E::REASONS
    }

    fn of_columns(
        &self,
        description: &Description,
        method: Option<&str>,
        columns: &[(&str, Vec<f64>)],
        length: usize,
    ) -> PyResult<Estimates> {
        let rows = frame::rows::<S>(columns).map_err(refused)?;
        let mut found = run::<_, _, E>(description, (method, None), rows, length)?;
        for hint in found.hints.iter_mut().filter(|h| h.contains("signal map")) {
            hint.push_str("\n  here: a frame has no signal map; convert its column so");
        }
        found.hints.extend(silent::<S>(columns, length));
        Ok(found)
    }

    fn of_file(
        &self,
        description: &Description,
        method: Option<&str>,
        path: &Path,
        map: Option<&Map>,
    ) -> PyResult<Estimates> {
        let samples = recording::open::<S>(path, map).map_err(refused)?;
        let found = run::<_, _, E>(description, (method, map), samples.rows().map_err(refused)?, 0)?;
        samples.check().map_err(refused)?;
        let lacks = samples.lacks();
        let hints = found.hints.into_iter().chain(lacks.empty.clone());
        Ok(Estimates {
            hints: hints.collect(),
            lacks,
            ..found
        })
    }

    fn feed(&self, signals: &[&str]) -> PyResult<Box<dyn AnyFeed>> {
        Ok(Box::new(FeedOf::<S, E> {
            feed: Feed::new(signals).map_err(refused)?,
            names: signals.iter().map(|&name| name.to_owned()).collect(),
            cells: Cells::default(),
        }))
    }
}

impl<S: Sensors, E: Estimate> AnyFeed for FeedOf<S, E> {
    fn check(&self, description: &Description, method: &str) -> PyResult<()> {
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let mut feed = Feed::<S>::new(&names).map_err(refused)?;
        check(description, method, &feed.sample(&vec![0.0; names.len()]))
    }

    fn sample(&mut self, values: &[f64]) -> Envelope {
        self.feed.sample(values).envelope()
    }

    fn count(&self) -> u64 {
        self.feed.count()
    }

    fn go_on_from(&mut self, count: u64) {
        self.feed.go_on_from(count);
    }

    fn cells(&self, estimate: &Envelope, put: &mut dyn FnMut(Cell)) {
        if let Some(estimate) = E::inside(estimate) {
            self.cells.of(estimate, put);
        }
    }
}

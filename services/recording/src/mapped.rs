//! Rows of samples from values that arrive one by one, each with its time: a signal map applied to a bus or to topics.

use crate::Error;
use crate::map::{Conversion, Entry, Map, Rows as When, Term, hint};
use crate::sampling::{RowTime, Rows, Series};
use crate::signal::{self, Builder, Row, Sensors, Signal};

/// Origin of a term of a signal.
#[derive(Debug)]
pub(crate) enum Source {
    /// A constant.
    Constant(f64),
    /// A series of values, and their conversion.
    Series(Series, Conversion),
}

/// A signal of the map, and its terms.
#[derive(Debug)]
struct Line {
    entry: Entry,
    terms: Vec<Part>,
}

#[derive(Debug)]
enum Part {
    Constant(f64),
    /// Index of the series.
    Series(usize, Conversion),
}

/// The signals of a map, combined into rows.
#[derive(Debug)]
pub(crate) struct MappedRows<S: Sensors> {
    lines: Vec<Line>,
    series: Vec<Series>,
    rows: Rows,
    /// The series whose values make rows: that of the master's first term.
    master: Option<usize>,
    builder: Builder<S>,
    values: Vec<f64>,
}

impl<S: Sensors> MappedRows<S> {
    /// For these entries, with rows at the times of `when`; `origin` names the kind of origin. `source` gives the origin of each term:
    /// series are numbered in the order of these calls.
    pub(crate) fn new<'a>(
        map: &Map,
        entries: &'a [Entry],
        (when, origin): (&When, &str),
        mut source: impl FnMut(&'a Entry, &'a Term, &Signal) -> Result<Source, Error>,
    ) -> Result<Self, Error> {
        let signals = signal::signals::<S>();
        let (mut lines, mut series) = (Vec::new(), Vec::new());
        for entry in entries.iter().filter(|e| !e.is_nowhere()) {
            let signal = map.signal(entry, &signals)?;
            let mut terms = Vec::new();
            for term in &entry.terms {
                terms.push(match source(entry, term, signal)? {
                    Source::Constant(value) => Part::Constant(value),
                    Source::Series(values, conversion) => {
                        series.push(values);
                        Part::Series(series.len() - 1, conversion)
                    }
                });
            }
            let entry = entry.clone();
            lines.push(Line { entry, terms });
        }
        let (rate, master) = match when {
            When::Rate(rate) => (Some(*rate), None),
            When::Master(name) => (None, Some(master(name, &lines, map, origin)?)),
        };
        let used = lines
            .iter()
            .filter_map(|l| signals.iter().find(|s| s.name == l.entry.signal));
        Ok(Self {
            builder: Builder::with_all(signals.iter().take(1).chain(used)),
            lines,
            series,
            rows: Rows::new(rate),
            master,
            values: Vec::new(),
        })
    }

    /// The first value gets the time `ns` instead of 0.
    pub(crate) fn begin_at(&mut self, ns: i64) {
        self.rows.begin_at(ns);
    }

    /// The clock is at `time`: rows that are complete are built. `absolute` converts a time to the clock of the values.
    pub(crate) fn pass(&mut self, time: i64, absolute: impl Fn(i64) -> u64) {
        self.rows.pass(time);
        self.build(false, absolute);
    }

    /// Takes a value of a series that arrives at `time`.
    pub(crate) fn push(&mut self, series: usize, time: i64, value: f64) {
        self.series[series].push(time, value);
        if self.master == Some(series) {
            self.rows.add(self.series[series].measured(time));
        }
    }

    /// All values of `time`, at least one, have arrived.
    pub(crate) fn hear(&mut self, time: i64, absolute: impl Fn(i64) -> u64) {
        self.rows.hear(time);
        self.build(false, absolute);
    }

    /// No value will come any more: the waiting rows are complete.
    pub(crate) fn finish(&mut self, absolute: impl Fn(i64) -> u64) {
        self.build(true, absolute);
        self.builder.finish();
    }

    /// The next row, if one is complete.
    pub(crate) fn row(&mut self) -> Option<Row<S>> {
        self.builder.next()
    }

    fn build(&mut self, at_end: bool, absolute: impl Fn(i64) -> u64) {
        while let Some(RowTime { ns, seconds }) = self.rows.next(&mut self.series, at_end) {
            let series = &self.series;
            self.values.clear();
            self.values.push(seconds);
            self.values.extend(self.lines.iter().map(|line| {
                line.entry.combine(line.terms.iter().map(|term| match term {
                    Part::Constant(value) => *value,
                    Part::Series(at, conversion) => conversion.apply(series[*at].at(ns)),
                }))
            }));
            self.builder.push(&self.values, absolute(ns));
        }
    }
}

/// The series whose values make rows.
fn master(name: &str, lines: &[Line], map: &Map, origin: &str) -> Result<usize, Error> {
    let line = lines.iter().find(|l| l.entry.signal == name);
    let mut series = line.iter().flat_map(|l| &l.terms).filter_map(|s| match s {
        Part::Series(at, _) => Some(*at),
        Part::Constant(_) => None,
    });
    series.next().ok_or_else(|| {
        let comes = |l: &&Line| l.terms.iter().any(|t| matches!(t, Part::Series(..)));
        let names = lines.iter().filter(comes).map(|l| l.entry.signal.as_str());
        Error::new(
            format!("the master {name} is no signal of the map that comes from {origin}"),
            map.file(),
            hint(name, names, "its signals are"),
        )
    })
}

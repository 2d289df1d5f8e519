//! Rows of samples of values that come one by one, each at its time: what a signal map makes of a bus, and of topics.

use crate::Error;
use crate::map::{Conversion, Entry, Map, Rows as When, Term, hint};
use crate::sampling::{RowTime, Rows, Series};
use crate::signal::{self, Builder, Row, Sensors, Signal};

/// Where a term of a signal comes from.
#[derive(Debug)]
pub(crate) enum Source {
    /// It is always this.
    Constant(f64),
    /// Values that come, and what is made of each.
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
    /// Which series.
    Series(usize, Conversion),
}

/// The signals of a map, made into rows.
#[derive(Debug)]
pub(crate) struct MappedRows<S: Sensors> {
    lines: Vec<Line>,
    series: Vec<Series>,
    rows: Rows,
    /// The series that makes rows: that of the master's first term.
    master: Option<usize>,
    builder: Builder<S>,
    values: Vec<f64>,
}

impl<S: Sensors> MappedRows<S> {
    /// For these entries, with a row when `when` says; `origin` names what values come from. `source` says it of each term: series
    /// are numbered in the order in which they are asked for.
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

    /// It is `time`: what was complete before becomes rows. `absolute` is a time on the clock of the values.
    pub(crate) fn pass(&mut self, time: i64, absolute: impl Fn(i64) -> u64) {
        self.rows.pass(time);
        self.build(false, absolute);
    }

    /// A value of a series comes at `time`.
    pub(crate) fn push(&mut self, series: usize, time: i64, value: f64) {
        self.series[series].push(time, value);
        if self.master == Some(series) {
            self.rows.add(self.series[series].measured(time));
        }
    }

    /// All that comes at `time`, at least one value, is here.
    pub(crate) fn hear(&mut self, time: i64, absolute: impl Fn(i64) -> u64) {
        self.rows.hear(time);
        self.build(false, absolute);
    }

    /// Nothing will come any more: the rows that wait are complete.
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

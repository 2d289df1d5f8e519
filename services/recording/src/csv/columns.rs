//! Assignment of a table's columns to signals, and conversion of its cells to rows.

use std::collections::VecDeque;

use messages::fnv32;

use super::absent::absent;
use super::cells::Record;
use super::dialect::{self, BLANK, Dialect};
use super::front::{comment, is_rule};
use super::marks::{self, Marks};
use super::no_number::{NoNumber, ZEROS};
use super::several::Several;
use crate::counter::Counter;
use crate::map::{Conversion, Entry, Map, Origin, Timing, are_absent, hint};
use crate::sampling::{Rows, Series};
use crate::signal::{self, Builder, Row, Sensors};
use crate::time::{self, Dates};
use crate::{Error, Finding};

/// Age limit of a value that is held or interpolated, where the map has none [s].
const HOLD: f64 = 1.0;

/// Converts the cells of a table to rows.
#[derive(Debug)]
pub(crate) struct Columns<S: Sensors> {
    header: Vec<String>,
    numbers: Numbers,
    lines: Vec<Line>,
    builder: Builder<S>,
    values: Vec<f64>,
    rows: u64,
    sampler: Option<Sampler>,
    /// The column that names the machine of each row, as in a table of many machines, and its first name.
    machine: Option<usize>,
    named: Vec<u8>,
}

/// Column of a map that exists in every table: the number of the row, from 0.
const ROW: &str = "row";

/// Last column of LabVIEW's tables, which a row without a remark leaves out.
const REMARKS: &str = "Comment";

/// Column of the names in a table of many machines.
const MACHINE: &str = "machine";

/// A signal and its terms.
#[derive(Debug)]
struct Line {
    /// Name of the signal.
    signal: String,
    /// The map's entry; none for a column named as the signal.
    entry: Option<Entry>,
    is_time: bool,
    /// It is a switch, which tables write as words too.
    is_switch: bool,
    /// It is an identifier, as a number or a word.
    is_label: bool,
    parts: Vec<Part>,
    /// It is a sensor's, without a value up to now.
    is_silent: bool,
}

/// Reads the cells of all rows as numbers.
#[derive(Debug)]
struct Numbers {
    dialect: Dialect,
    /// Decimal marks, by column.
    marks: Vec<Marks>,
    dates: Dates,
    counter: Counter,
}

impl Numbers {
    /// The number in a cell of column `at` for this signal: converted, but for identifiers and dates. None for any other text.
    fn of(&mut self, cell: &[u8], at: usize, conversion: &Conversion, line: &Line) -> Option<f64> {
        let number = self.dialect.number(cell);
        if let Some(x) = number.filter(|_| !(line.is_time && time::is_compact(cell))) {
            self.marks[at].see(cell);
            let is_counter = line.is_time && line.parts.len() == 1;
            let x = if is_counter { self.counter.count(x) } else { x };
            return Some(conversion.apply(x));
        }
        if number.is_none()
            && line.is_switch
            && let Some(state) = switched(cell)
        {
            return Some(conversion.apply(state));
        }
        if number.is_none() && line.is_label && !cell.contains(&0) {
            return Some(labelled(cell));
        }
        let text = std::str::from_utf8(cell).ok().filter(|_| line.is_time)?;
        self.dates.seconds(text.trim_start_matches('\u{feff}'))
    }
}

/// A term of a signal.
#[derive(Debug)]
enum Part {
    Constant(f64),
    /// The number of the row, from 0.
    Row(Conversion),
    Cell {
        at: usize,
        conversion: Conversion,
    },
}

/// Whether a signal is read from column `at`.
fn is_used(lines: &[Line], at: usize) -> bool {
    let mut parts = lines.iter().flat_map(|line| &line.parts);
    parts.any(|part| matches!(part, Part::Cell { at: its, .. } if *its == at))
}

/// The character at the end of a text of DOS, Ctrl-Z.
const END_OF_DOS: &[u8] = b"\x1a";

/// The last line of an export of TwinCAT Scope.
const END_OF_EXPORT: &[u8] = b"EOF";
impl<S: Sensors> Columns<S> {
    /// Finds the origin of each signal of the table or the map.
    pub(crate) fn choose(
        header: Vec<String>,
        dialect: Dialect,
        map: Option<&Map>,
        file: &str,
    ) -> Result<Self, Error> {
        let entries = map.map_or(&[][..], |m| &m.columns);
        let signals = signal::signals::<S>();
        if let Some(map) = map {
            map.check(entries, &signals)?;
        }
        let (mut lines, mut used, mut timings) = (Vec::new(), Vec::new(), Vec::new());
        for signal in &signals {
            let is_time = signal.name == "t";
            let entry = entries.iter().find(|e| e.signal == signal.name);
            let parts = match (entry, map) {
                (Some(entry), Some(map)) if !entry.is_nowhere() => {
                    parts(entry, map, &header, file)?
                }
                (Some(entry), Some(map)) if is_time => {
                    return Err(Error::new(
                        "the map says that there is no time: t is \"none\"",
                        map.place(entry),
                        "name the column of the time: t = \"...\"",
                    ));
                }
                (Some(_), _) => continue,
                (None, _) => {
                    let Some(at) = header.iter().position(|h| *h == signal.name) else {
                        continue;
                    };
                    let conversion = Conversion::NONE;
                    vec![Part::Cell { at, conversion }]
                }
            };
            let own = entry.iter().flat_map(|e| e.terms.iter().map(|t| t.timing));
            // Delayed and interpolated cells are converted before.
            let turn = entry.map_or(f64::INFINITY, |e| e.turn(&Conversion::NONE, signal));
            let own = own.chain([Timing::default()]).take(parts.len());
            timings.extend(own.map(|timing| (timing, turn)));
            used.push(signal);
            lines.push(Line {
                signal: signal.name.clone(),
                entry: entry.cloned(),
                is_time,
                is_switch: signal.is_switch(),
                is_label: signal.name == LABEL,
                parts,
                is_silent: signal.is_measured(),
            });
        }
        require::<S>(entries, &used, &header, file)?;
        let machine = header.iter().position(|name| name == MACHINE);
        let is_timed = timings.iter().any(|(t, _)| *t != Timing::default());
        Ok(Self {
            machine: machine.filter(|at| !is_used(&lines, *at)),
            named: Vec::new(),
            numbers: Numbers {
                dialect,
                marks: vec![Marks::default(); header.len()],
                dates: Dates::default(),
                counter: Counter::default(),
            },
            header,
            builder: Builder::new(used),
            values: vec![0.0; lines.len()],
            rows: 0,
            lines,
            sampler: is_timed.then(|| Sampler::new(&timings)),
        })
    }

    /// Looks for a column that is no signal and names the machine of each row.
    pub(super) fn several(&self) -> Several {
        let unused = (0..self.header.len()).filter(|at| !is_used(&self.lines, *at));
        Several::of(unused, self.lines.len())
    }

    /// Time and signals of the row that was taken last.
    pub(super) fn taken(&self) -> (f64, &[f64]) {
        let time = self.lines.iter().position(|line| line.is_time);
        (time.map_or(f64::NAN, |at| self.values[at]), &self.values)
    }

    /// Messages on sensors whose columns have no value in any row.
    pub(crate) fn empty(&self) -> impl Iterator<Item = String> + '_ {
        let silent = self.lines.iter().filter(|line| line.is_silent);
        silent.map(|line| format!("{} in any row; it counts as absent", self.no_value(line)))
    }

    /// Checks that each required group of signals had a value, and that the decimal marks of all numbers are unambiguous.
    ///
    /// # Errors
    /// A group had none in any row, or the marks are ambiguous.
    pub(crate) fn check_values(&self, file: &str) -> Result<(), Error> {
        if let Some((at, mark)) =
            marks::unclear(&self.numbers.marks, self.numbers.dialect.separator)
        {
            let column = &self.header[at];
            return Err(Error::new(
                format!(
                    "column {column} has numbers like 12{mark}345, where others have another decimal mark, or none"
                ),
                file,
                "write all numbers with one decimal mark, and without marks between thousands",
            ));
        }
        for group in S::REQUIRED {
            let of_group = |line: &&Line| group.contains(&line.signal.as_str());
            let mut its = self.lines.iter().filter(of_group);
            let Some(first) = its.clone().next() else {
                continue;
            };
            if its.all(|line| line.is_silent) {
                return Err(Error::new(
                    format!("{} in any row ({})", self.no_value(first), S::MACHINE),
                    file,
                    "check the sensor and its recording, or name another column in a signal map (--map)",
                ));
            }
        }
        Ok(())
    }

    fn no_value(&self, line: &Line) -> String {
        let cells = line.parts.iter().filter_map(|part| match part {
            Part::Cell { at, .. } => self.header.get(*at),
            Part::Constant(_) | Part::Row(_) => None,
        });
        let columns: Vec<&str> = cells.map(String::as_str).collect();
        let signal = &line.signal;
        match columns[..] {
            [one] if one == signal => format!("column {one} holds no value"),
            [one] => format!("column {one} ({signal}) holds no value"),
            _ => format!("columns {} ({signal}) hold no value", columns.join(", ")),
        }
    }

    /// Names of the columns.
    pub(crate) fn header(&self) -> &[String] {
        &self.header
    }

    /// Whether a line is no row: empty cells, as sheets fill their ends, the rule of a database, the end of a file of DOS, or a comment.
    pub(crate) fn is_no_row(&self, record: &Record) -> bool {
        let is_first_empty = record.get(0).is_some_and(<[u8]>::is_empty);
        is_first_empty && record.iter().all(<[u8]>::is_empty)
            || record.len() == 1
                && record.get(0).is_some_and(|cell| {
                    is_rule(cell) || [END_OF_DOS, END_OF_EXPORT].contains(&cell)
                })
            || self.is_comment(record)
    }

    /// Whether a line is a block of zeros.
    pub(crate) fn is_hole(record: &Record) -> bool {
        let mut bytes = record.iter().flatten().peekable();
        bytes.peek().is_some() && bytes.all(|b| *b == 0)
    }

    /// Whether a line is a comment: another number of cells than the header, or no number.
    fn is_comment(&self, record: &Record) -> bool {
        let is_number = |cell: &[u8]| {
            self.numbers
                .dialect
                .number(cell)
                .is_some_and(f64::is_finite)
        };
        let is_marked = record.get(0).is_some_and(|cell| comment(cell).is_some());
        is_marked && (record.len() != self.header.len() || !record.iter().any(is_number))
    }

    /// Whether a row has too few cells for the columns up to the last named one.
    pub(crate) fn is_short(&self, record: &Record) -> bool {
        let may_lack = |name: &&String| name.is_empty() || *name == REMARKS;
        let unnamed = self.header.iter().rev().take_while(may_lack);
        record.len() < self.header.len() - unnamed.count()
    }

    /// How much there is of a row that was cut off; none if it was not, or if a quote that is never closed took the lines below it.
    pub(crate) fn cut(&self, record: &Record) -> Option<String> {
        let (cells, width) = (record.len(), self.header.len());
        (self.is_short(record) && !record.has_line_end())
            .then(|| format!("{cells} of {width} cells"))
    }

    /// Why a row does not fit the table. A row that was cut off must not be taken for one with missing samples.
    pub(crate) fn misfit(&mut self, record: &Record) -> Option<Finding> {
        let (cells, width) = (record.len(), self.header.len());
        let has_value = |at| record.get(at).is_some_and(|cell| !cell.is_empty());
        let has_more = (width..cells).any(has_value);
        let dialect = self.numbers.dialect;
        if let Some(what) = hidden_rows(record, width, dialect) {
            return Some(Finding::new(what, CLOSE));
        }
        if !has_more && !self.is_short(record) {
            return self.another_machine(record);
        }
        let separator = char::from(dialect.separator).escape_default();
        let s = if cells == 1 { "" } else { "s" };
        let what =
            format!("the row has {cells} cell{s}, the header {width}, separated by '{separator}'");
        let mut ends = record.iter();
        if let Some(end) = ends.find_map(|cell| dialect.other_line_end(cell)) {
            let what = format!("{what}: it goes on behind {end}, which ends no line here");
            return Some(Finding::new(what, dialect::LINE_ENDS));
        }
        let remedy = match (record.iter().any(|cell| cell.contains(&0)), dialect) {
            (true, _) => ZEROS,
            (_, Dialect { separator: b',' }) if has_more => {
                "complete or delete the row, and name every column; where commas are decimal marks, separate the columns by ;"
            }
            (_, Dialect { separator: BLANK }) if !has_more => {
                "complete or delete the row; where blanks separate, a missing sample is NaN"
            }
            _ if record.has_line_end() => CLOSE,
            _ if has_more && cells == width + 1 => {
                "name every column, that of the rows' names too (in R: col.names = NA), or delete the row"
            }
            _ => "complete the row, or delete it",
        };
        Some(Finding::new(what, remedy))
    }

    /// Why a row belongs to another machine than those before it.
    fn another_machine(&mut self, record: &Record) -> Option<Finding> {
        let name = record.get(self.machine?).filter(|name| !name.is_empty())?;
        if self.named.is_empty() {
            self.named = name.to_vec();
        }
        (name != self.named).then(|| {
            let [other, first] = [name, &self.named].map(dialect::text);
            Finding::new(
                format!("the row is of machine {other}, and those before it are of {first}"),
                "heft serve takes a table of many machines; here give the rows of one, or rename the column if it names something else",
            )
        })
    }

    /// Takes the cells of a row.
    pub(crate) fn take(&mut self, record: &Record) -> Result<(), NoNumber> {
        let mut sampled = 0;
        for (line, value) in self.lines.iter_mut().zip(&mut self.values) {
            let mut sum = None;
            for part in &line.parts {
                let x = match part {
                    Part::Constant(value) => *value,
                    Part::Row(conversion) => conversion.apply(self.rows as f64),
                    Part::Cell { at, conversion } => {
                        let cell = record.get(*at).unwrap_or_default();
                        let number = self.numbers.of(cell, *at, conversion, line);
                        number.ok_or_else(|| {
                            NoNumber::of(cell, &self.header[*at], &self.header, line.is_time)
                                .within(record, *at, &self.header, self.numbers.dialect)
                        })?
                    }
                };
                if let Some(sampler) = &mut self.sampler {
                    sampler.values[sampled] = x;
                    sampled += 1;
                }
                sum = Some(sum.map_or(x, |sum: f64| sum + x));
            }
            let sum = sum.unwrap_or(f64::NAN);
            *value = line.entry.as_ref().map_or(sum, |e| e.conversion.apply(sum));
            line.is_silent &= !value.is_finite();
        }
        self.rows += 1;
        match &mut self.sampler {
            None => self.builder.push(&self.values, 0),
            Some(sampler) => {
                let time = self.lines.iter().position(|l| l.is_time);
                sampler.take(time.map_or(f64::NAN, |at| self.values[at]));
                self.build(false);
            }
        }
        Ok(())
    }

    /// No row will come any more.
    pub(crate) fn finish(&mut self) {
        self.build(true);
        self.builder.finish();
    }

    /// The next row, if one is complete.
    pub(crate) fn row(&mut self) -> Option<Row<S>> {
        self.builder.next()
    }

    fn build(&mut self, at_end: bool) {
        let Some(sampler) = &mut self.sampler else {
            return;
        };
        while let Some((ns, time)) = sampler.next(at_end) {
            let mut series = sampler.series.iter();
            for (line, value) in self.lines.iter().zip(&mut self.values) {
                let parts = series.by_ref().take(line.parts.len());
                let parts = parts.map(|s| s.at(ns));
                *value = match &line.entry {
                    _ if line.is_time => {
                        parts.for_each(drop);
                        time
                    }
                    Some(entry) => entry.combine(parts),
                    None => parts.sum(),
                };
            }
            self.builder.push(&self.values, 0);
        }
    }
}

/// Remedy for a quote that is not closed.
pub(super) const CLOSE: &str = "close the quote that opens in this row, or delete it";

/// What to say of rows of a table of this width that are within a cell of one record: a quote above them is not closed.
pub(super) fn hidden_rows(record: &Record, width: usize, dialect: Dialect) -> Option<String> {
    if !record.has_line_end() {
        return None;
    }
    let within = record
        .iter()
        .flat_map(|cell| cell.split(|b| *b == b'\n').skip(1));
    let is_row = |line: &&[u8]| {
        let mut cells = line.split(|b| *b == dialect.separator);
        let first = cells.next().unwrap_or_default();
        first.trim_ascii().first().is_some_and(u8::is_ascii_digit) && 1 + cells.count() >= width
    };
    let count = within.filter(is_row).count();
    (count > 0 && width > 1)
        .then(|| format!("a quote takes {count} of the rows below it into one cell"))
}

/// The columns of a table whose map gives their times of measurement.
#[derive(Debug)]
struct Sampler {
    series: Vec<Series>,
    /// The terms of the current row.
    values: Vec<f64>,
    rows: Rows,
    start: Option<f64>,
    times: VecDeque<f64>,
}

impl Sampler {
    fn new(timings: &[(Timing, f64)]) -> Self {
        let series = timings
            .iter()
            .map(|(timing, turn)| match *timing == Timing::default() {
                // Without a timing in the map a cell is valid in its row only.
                true => Series::new(timing, 0.0, *turn),
                false => Series::new(timing, HOLD, *turn),
            });
        Self {
            series: series.collect(),
            values: vec![0.0; timings.len()],
            rows: Rows::of_table(),
            start: None,
            times: VecDeque::new(),
        }
    }

    /// Takes the terms of the row at `time`; an empty cell is no value.
    fn take(&mut self, time: f64) {
        if !time.is_finite() {
            return;
        }
        let ns = ((time - *self.start.get_or_insert(time)) * 1e9).round() as i64;
        for (series, value) in self.series.iter_mut().zip(&self.values) {
            if value.is_finite() {
                series.push(ns, *value);
            }
        }
        self.rows.pass(ns);
        if self.rows.add(ns) {
            self.times.push_back(time);
        }
    }

    fn next(&mut self, at_end: bool) -> Option<(i64, f64)> {
        let row = self.rows.next(&mut self.series, at_end)?;
        Some((row.ns, self.times.pop_front()?))
    }
}

/// Words for on and off, of programs and sheets in several languages.
const SWITCHED: [&[&str]; 2] = [
    &[
        "false", "off", "no", "falsch", "aus", "nein", "faux", "non", "falso",
    ],
    &[
        "true",
        "on",
        "yes",
        "wahr",
        "ein",
        "an",
        "ja",
        "vrai",
        "oui",
        "verdadero",
        "vero",
    ],
];

/// 1 for on, 0 for off.
fn switched(cell: &[u8]) -> Option<f64> {
    let is_word = |word: &&str| cell.eq_ignore_ascii_case(word.as_bytes());
    let state = SWITCHED
        .iter()
        .position(|words| words.iter().any(is_word))?;
    Some(state as f64)
}

/// The identifier of which only a change counts: trucks have plates.
const LABEL: &str = "truck";

/// A word as a number, the same in every file, larger than any counted number and smaller than the limit of
/// measurements: FNV-1a, 28 bits of it.
fn labelled(cell: &[u8]) -> f64 {
    f64::from((fnv32(cell) >> 4) + (1 << 29))
}

/// What a truck is called, as the number that a table has for it: a number stays what it is, a mark of a missing one is NaN.
#[must_use]
pub fn label(text: &str) -> f64 {
    let cell = text.trim().as_bytes();
    let number = Dialect { separator: b',' }.number(cell);
    number.unwrap_or_else(|| labelled(cell))
}

fn parts(entry: &Entry, map: &Map, header: &[String], file: &str) -> Result<Vec<Part>, Error> {
    let part = |term: &crate::map::Term| match &term.origin {
        Origin::Constant(value) => Ok(Part::Constant(term.conversion.apply(*value))),
        Origin::Column(name) if name == ROW && !header.contains(name) => {
            Ok(Part::Row(term.conversion))
        }
        Origin::Column(name) => {
            let at = header.iter().position(|h| h == name).ok_or_else(|| {
                Error::new(
                    format!(
                        "the map wants column {name} for {}, but {file} has none",
                        entry.signal
                    ),
                    map.place(entry),
                    hint(name, header.iter().map(String::as_str), "its columns are"),
                )
            })?;
            Ok(Part::Cell {
                at,
                conversion: term.conversion,
            })
        }
        Origin::Can(_) | Origin::Topic(_) | Origin::Nowhere => Ok(Part::Constant(f64::NAN)),
    };
    entry.terms.iter().map(part).collect()
}

fn require<S: Sensors>(
    entries: &[Entry],
    used: &[&signal::Signal],
    header: &[String],
    file: &str,
) -> Result<(), Error> {
    let time: &[&str] = &["t"];
    for group in [time].iter().chain(S::REQUIRED) {
        let is_used = group
            .iter()
            .any(|name| used.iter().any(|s| s.name == *name));
        if !is_used && (*group == time || !are_absent(entries, group)) {
            return Err(absent(group, S::MACHINE.name(), header, file));
        }
    }
    Ok(())
}

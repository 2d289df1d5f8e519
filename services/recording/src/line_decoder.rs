//! Samples out of lines as they come: candump's, or the rows of a table.

use std::sync::Arc;

use crate::Error;
use crate::can::{self, Decoder, LeftOut, Line, parse};
use crate::csv::{self, Cells, Columns, Dialect, Front};
use crate::kind;
use crate::map::Map;
use crate::packed::GZIP;
use crate::signal::{Row, Sensors};

/// Longest line; what is longer is none of ours.
pub const MAX_LINE: usize = 1 << 16;
/// Remarks about lines that say nothing, until they are only counted.
const MOST_REMARKS: u64 = 5;

/// Makes rows of lines. Which kind they are is given by the map (`[can]`) and the first line.
#[derive(Debug)]
pub struct LineDecoder<S: Sensors> {
    /// Its name in what is said of lines.
    input: Arc<str>,
    map: Option<Map>,
    kind: Kind<S>,
    /// What the lines of a table are.
    lines: csv::Lines,
    /// What stood where the header was looked for, and what it lacks as one.
    above: Option<(Vec<u8>, Error)>,
    count: u64,
    /// Rows of a table, and lines that say nothing.
    rows: u64,
    refused: u64,
    left_out: LeftOut,
    remarks: Vec<String>,
    /// Frames, and those whose lines tell no time.
    frames: u64,
    untimed: u64,
    /// Time of the last frame and when it came [ns].
    last: Option<(i64, i64)>,
}

#[derive(Debug)]
enum Kind<S: Sensors> {
    Frames(Box<Decoder<S>>),
    /// A table whose header has not come.
    Headless,
    Table(Box<Columns<S>>, Box<Cells>),
}

impl<S: Sensors> LineDecoder<S> {
    /// Lines of candump if the map has a `[can]` table, rows of a table otherwise.
    ///
    /// # Errors
    /// The map names what its DBC files do not have.
    pub fn new(map: Option<Map>) -> Result<Self, Error> {
        let kind = match &map {
            Some(map) if map.has_can() => Kind::Frames(Box::new(Decoder::new(map)?)),
            _ => Kind::Headless,
        };
        Ok(Self {
            input: INPUT.into(),
            map,
            kind,
            lines: csv::Lines::default(),
            above: None,
            count: 0,
            rows: 0,
            refused: 0,
            left_out: LeftOut::default(),
            frames: 0,
            untimed: 0,
            remarks: Vec::new(),
            last: None,
        })
    }

    /// The lines are of this input instead of standard input.
    #[must_use]
    pub fn of(self, input: Arc<str>) -> Self {
        Self { input, ..self }
    }

    /// So many lines of the input went elsewhere or were taken: the next one is counted behind them.
    pub fn skip_to(&mut self, line: u64) {
        self.count = line;
    }

    /// Takes a line that came at `now_ns`. A line that says nothing is left out and reported.
    ///
    /// # Errors
    /// The header of a table lacks a column, and none of the next lines is one that does not; see [`Self::check_header`].
    pub fn take(&mut self, line: &[u8], now_ns: i64) -> Result<(), Error> {
        self.count += 1;
        let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
        if line.trim_ascii().is_empty() {
            return Ok(());
        }
        match &mut self.kind {
            Kind::Frames(decoder) => {
                let text = can::text(line);
                let mut said = parse(&text);
                if let Some(Line::Frame { frame, timed }) = &mut said {
                    self.frames += 1;
                    if !std::mem::replace(timed, true) {
                        self.untimed += 1;
                        frame.time_ns = now_ns;
                    }
                    self.last = Some((frame.time_ns, now_ns));
                    decoder.take(frame);
                }
                self.left_out.count(said.as_ref(), self.count, &text);
                match said {
                    Some(Line::Frame { .. } | Line::Nothing) => {}
                    Some(Line::Dropped(frames)) => self.remark(&format!(
                        "{frames} frames were lost before line {} (DROPCOUNT of candump)",
                        self.count
                    )),
                    None => self.refuse("is no frame"),
                }
            }
            Kind::Headless | Kind::Table(..) => self.take_line(line)?,
        }
        Ok(())
    }

    /// Takes a line of a table.
    fn take_line(&mut self, line: &[u8]) -> Result<(), Error> {
        if let Some((above, error)) = self.above.take() {
            return self.look_below(above, error, line);
        }
        match self.lines.take(line) {
            csv::Line::Nothing | csv::Line::Comment => {}
            csv::Line::Header(dialect) => {
                check_text(line, &self.input)?;
                if let Err(error) = self.begin(line, dialect, &[]) {
                    self.above = Some((whole(line), error));
                }
            }
            csv::Line::FirstRow { header, dialect } => {
                self.begin(&header, dialect, &[])?;
                self.take_row(line);
            }
            csv::Line::Units(units) => {
                if let Kind::Table(columns, _) = &self.kind {
                    let place = || format!("{}:{}", self.input, self.count);
                    csv::check_units::<S>(columns.header(), &units, self.map.as_ref(), place)?;
                }
            }
            csv::Line::Row => self.take_row(line),
        }
        Ok(())
    }

    /// The header lacks a column: as in a file it may stand below, where words of a logger or groups of names are above it.
    fn look_below(&mut self, mut above: Vec<u8>, error: Error, line: &[u8]) -> Result<(), Error> {
        above.extend(whole(line));
        let front = Front::of(&above).filter(|front| front.start > 0);
        if let Some(Front {
            start,
            dialect,
            above: groups,
            ..
        }) = front
        {
            let mut lines = above[start..].split_inclusive(|b| *b == b'\n');
            let header = lines.next().unwrap_or_default();
            if self.begin(header, dialect, &groups).is_ok() {
                self.lines = csv::Lines::default();
                self.lines.take(header);
                return lines.try_for_each(|line| self.take_line(line));
            }
        }
        if above.split(|b| *b == b'\n').count() > csv::MOST_ABOVE {
            return Err(error);
        }
        self.above = Some((above, error));
        Ok(())
    }

    /// Whether the header, if one came, has all columns that are needed.
    ///
    /// # Errors
    /// It lacks one.
    pub fn check_header(&self) -> Result<(), Error> {
        let lack = self.above.as_ref().map(|(_, error)| error.clone());
        lack.map_or(Ok(()), Err)
    }

    /// Begins a table with this header, whose names are told by those of the groups above.
    fn begin(&mut self, line: &[u8], dialect: Dialect, groups: &[String]) -> Result<(), Error> {
        let (cells, header) = head(line, groups, dialect, &self.input)?;
        let columns = Columns::choose(header, dialect, self.map.as_ref(), &self.input)?;
        self.kind = Kind::Table(Box::new(columns), Box::new(cells));
        Ok(())
    }

    fn take_row(&mut self, line: &[u8]) {
        self.rows += 1;
        if let Kind::Table(columns, cells) = &mut self.kind {
            let record = cells.split(line);
            if columns.is_no_row(record) {
                self.rows -= 1;
            } else if let Some((what, remedy)) = columns.misfit(record) {
                self.refuse(&format!("is no row of the table: {what}; {remedy}"));
            } else if let Err(cell) = columns.take(record) {
                let column = cell.column.clone();
                let Error { what, remedy, .. } = cell.at(self.count as usize, &self.input);
                self.refuse(&format!(
                    "is no row of the table: column {column}: {what}; {remedy}"
                ));
            }
        }
    }

    /// Nothing came until `now_ns`: silence makes rows of frames too.
    pub fn pass(&mut self, now_ns: i64) {
        if let (Kind::Frames(decoder), Some((time, came))) = (&mut self.kind, self.last) {
            decoder.pass(time.saturating_add(now_ns.saturating_sub(came)));
        }
    }

    /// There will be no more lines.
    pub fn finish(&mut self) {
        if self.refused > MOST_REMARKS {
            let (refused, input) = (self.refused, &self.input);
            self.remarks.push(format!(
                "{refused} lines of {input} were left out, the first {MOST_REMARKS} are named above"
            ));
        }
        match &mut self.kind {
            Kind::Frames(decoder) => decoder.finish(),
            Kind::Table(columns, _) => columns.finish(),
            Kind::Headless => {}
        }
    }

    /// Words on columns of a table that held no value in any row.
    pub fn empty(&self) -> Vec<String> {
        match &self.kind {
            Kind::Table(columns, _) => columns.empty().collect(),
            Kind::Frames(_) | Kind::Headless => Vec::new(),
        }
    }

    /// The next row, if one is complete. When it was measured on the host's clock is not known.
    pub fn row(&mut self) -> Option<Row<S>> {
        let (mut sensors, truth) = match &mut self.kind {
            Kind::Frames(decoder) => decoder.row(),
            Kind::Table(columns, _) => columns.row(),
            Kind::Headless => None,
        }?;
        sensors.stamp_mut().measured_ns = 0;
        Some((sensors, truth))
    }

    /// The first frame gets the time `seconds` instead of 0; a table tells its own times.
    pub fn begin_at(&mut self, seconds: f64) {
        if let Kind::Frames(decoder) = &mut self.kind {
            decoder.begin_at(seconds);
        }
    }

    /// Lines that said nothing and were left out.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// What was strange so far, a line each; taken once.
    pub fn take_remarks(&mut self) -> Vec<String> {
        if let Kind::Frames(decoder) = &mut self.kind {
            self.remarks.extend(decoder.take_remarks());
        }
        std::mem::take(&mut self.remarks)
    }

    /// Whether what came is what it should be: most lines said something, and frames came at different times.
    ///
    /// # Errors
    /// It is not.
    pub fn judge(&self) -> Result<(), Error> {
        self.check_header()?;
        if let Kind::Frames(decoder) = &self.kind {
            self.left_out.judge(&self.input)?;
            let checked = match self.last {
                Some(_) => decoder.check_times(&self.input),
                None => Ok(()),
            };
            return checked.map_err(|error| match 2 * self.untimed > self.frames {
                true => Error::new(
                    "the lines tell no times, and most came together",
                    error.place,
                    "record with candump -L, or with candump -ta",
                ),
                false => error,
            });
        }
        if 2 * self.refused <= self.rows {
            return match &self.kind {
                Kind::Table(columns, _) if self.rows > 0 => columns.check_values(&self.input),
                _ => Ok(()),
            };
        }
        let (refused, rows) = (self.refused, self.rows);
        Err(Error::new(
            format!("{refused} of {rows} lines are no rows of the table"),
            &*self.input,
            "each row has a number or nothing in each column of the header",
        ))
    }

    fn refuse(&mut self, why: &str) {
        self.refused += 1;
        if self.refused <= MOST_REMARKS {
            let (line, input) = (self.count, &self.input);
            self.remarks
                .push(format!("line {line} of {input} {why}; left out"));
        }
    }

    fn remark(&mut self, text: &str) {
        if self.remarks.len() < MOST_REMARKS as usize {
            self.remarks.push(format!("{}: {text}", self.input));
        }
    }
}

/// A line with its end.
fn whole(line: &[u8]) -> Vec<u8> {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    [line, b"\n"].concat()
}

/// Whether a line may be one of a table.
fn check_text(line: &[u8], input: &str) -> Result<(), Error> {
    if line.starts_with(&GZIP) {
        return Err(Error::new(
            "the input is packed by gzip",
            input,
            "unpack it on its way: zcat FILE | heft ...",
        ));
    }
    if matches!(parse(&can::text(line)), Some(Line::Frame { .. })) {
        return Err(kind::no_map(input));
    }
    if kind::is_no_text(line) && !line.contains(&0) {
        return Err(kind::no_text(input));
    }
    Ok(())
}

/// The cells of a header, and the names in it, told by those of `groups` above.
fn head(
    line: &[u8],
    groups: &[String],
    dialect: Dialect,
    input: &str,
) -> Result<(Cells, Vec<String>), Error> {
    check_text(line, input)?;
    let mut cells = Cells::new(dialect);
    let header = csv::header(cells.split(line), groups, dialect, input, || {
        input.to_owned()
    })?;
    Ok((cells, header))
}

/// A column of text in the rows of a table, such as the name of the machine that each row is of.
#[derive(Debug)]
pub struct NameColumn {
    name: &'static str,
    input: Arc<str>,
    lines: csv::Lines,
    /// What a decoder of the rows is to be given before them.
    above: Vec<Vec<u8>>,
    found: Option<Found>,
}

/// The header, and the column in it.
#[derive(Debug)]
struct Found {
    dialect: Dialect,
    cells: Cells,
    names: Vec<String>,
    at: usize,
}

/// What a line of such a table is.
#[derive(Debug, PartialEq)]
pub enum NamedLine {
    /// It stands above the rows: see [`NameColumn::above`].
    Above,
    /// A row, and what it says in the column; nothing where it says nothing.
    Row(Option<String>),
    /// A header once more, of files that were joined, and whether it is that of the rows before.
    Header(bool),
}

impl NameColumn {
    /// The column of this name in an input.
    pub fn new(name: &'static str, input: Arc<str>) -> Self {
        Self {
            name,
            input,
            lines: csv::Lines::default(),
            above: Vec::new(),
            found: None,
        }
    }

    /// What stood above the rows: a line that tells the separator, a comment that may be the header, the header, units.
    pub fn above(&self) -> &[Vec<u8>] {
        &self.above
    }

    /// Whether the header has come.
    pub fn is_found(&self) -> bool {
        self.found.is_some()
    }

    /// Takes the next line.
    ///
    /// # Errors
    /// The header has no such column.
    pub fn take(&mut self, line: &[u8]) -> Result<NamedLine, Error> {
        let text = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
        match self.lines.take(text) {
            csv::Line::Row => return Ok(self.of(text)),
            csv::Line::FirstRow { header, dialect } => {
                self.find(&header, dialect)?;
                return Ok(self.of(text));
            }
            csv::Line::Header(dialect) => self.find(text, dialect)?,
            // Only the last comment can be the header: they may be without end.
            csv::Line::Comment => self.above.retain(|line| csv::comment(line).is_none()),
            csv::Line::Nothing if text.trim_ascii().is_empty() || self.is_found() => {
                return Ok(NamedLine::Above);
            }
            csv::Line::Nothing | csv::Line::Units(_) => {}
        }
        self.above.push(text.to_vec());
        Ok(NamedLine::Above)
    }

    fn find(&mut self, header: &[u8], dialect: Dialect) -> Result<(), Error> {
        let (cells, names) = head(header, &[], dialect, &self.input)?;
        let at = names.iter().position(|n| n == self.name).ok_or_else(|| {
            let what = format!("there is no column {}", self.name);
            let remedy = match names.len() {
                1 => format!(
                    "delete what stands above the header; the first line is {}",
                    csv::listed(&names)
                ),
                _ => format!("add it; the table has {}", csv::listed(&names)),
            };
            Error::new(what, format!("{}:1", self.input), remedy)
        })?;
        self.found = Some(Found {
            dialect,
            cells,
            names,
            at,
        });
        Ok(())
    }

    fn of(&mut self, line: &[u8]) -> NamedLine {
        let Some(found) = &mut self.found else {
            return NamedLine::Row(None);
        };
        let record = found.cells.split(line);
        let is_name = |cell: &[u8]| cell == self.name.as_bytes();
        let is_word = |cell: &[u8]| found.dialect.number(cell).is_none();
        if record.get(found.at).is_some_and(is_name)
            || record.iter().any(is_name) && record.iter().all(is_word)
        {
            let is_same = record.iter().map(csv::name).eq(found.names.iter().cloned());
            return NamedLine::Header(is_same);
        }
        let text = record.get(found.at).map(String::from_utf8_lossy);
        // A quote that is left open, or a line end inside of one, is half a name.
        let is_whole = |text: &str| !text.chars().any(|c| c.is_control() || c == '"');
        let text = text.filter(|text| is_whole(text) && !text.is_empty());
        NamedLine::Row(text.map(|text| text.into_owned()))
    }
}

/// The usual input.
const INPUT: &str = "standard input";

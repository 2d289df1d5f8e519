//! Decodes lines into samples as they arrive: lines of candump, or the rows of a table.

use std::sync::Arc;

use crate::can::{self, Decoder, LeftOut, Line, parse};
use crate::csv::{self, Cells, Columns, Dialect, Front};
use crate::kind;
use crate::map::Map;
use crate::packed::GZIP;
use crate::signal::{Row, Sensors};
use crate::{Error, Finding};

/// Longest accepted line \[bytes\].
pub const MAX_LINE: usize = 1 << 16;
/// Number of remarks on lines that were left out; further ones are only counted.
const MOST_REMARKS: u64 = 5;

/// Converts lines to rows. Their kind is given by the map (`[can]`) and the first line.
#[derive(Debug)]
pub struct LineDecoder<S: Sensors> {
    /// Its name in remarks and errors.
    input: Arc<str>,
    map: Option<Map>,
    kind: Kind<S>,
    /// Classifies the lines of a table.
    lines: csv::Lines,
    /// Lines read in search of the header, and the error of the first one.
    above: Option<(Vec<u8>, Error)>,
    count: u64,
    /// Rows of a table, and lines that were left out.
    rows: u64,
    refused: u64,
    left_out: LeftOut,
    remarks: Vec<String>,
    /// Frames, and frames without a time.
    frames: u64,
    untimed: u64,
    /// Time of the last frame and time of its arrival [ns].
    last: Option<(i64, i64)>,
}

#[derive(Debug)]
enum Kind<S: Sensors> {
    Frames(Box<Decoder<S>>),
    /// A table before its header.
    Headless,
    Table(Box<Columns<S>>, Box<Cells>),
}

impl<S: Sensors> LineDecoder<S> {
    /// Lines of candump if the map has a `[can]` table, rows of a table otherwise.
    ///
    /// # Errors
    /// The map names signals that its DBC files do not have.
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

    /// Names the input, instead of standard input.
    #[must_use]
    pub fn of(self, input: Arc<str>) -> Self {
        Self { input, ..self }
    }

    /// Sets the number of lines that were taken elsewhere, for the line numbers of the next ones.
    pub fn skip_to(&mut self, line: u64) {
        self.count = line;
    }

    /// Takes a line that arrived at `now_ns`. A line without data is left out and reported.
    ///
    /// # Errors
    /// The header of a table lacks a column, and so do the next lines; see [`Self::check_header`].
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

    /// The header lacks a column: the real one may be below lines of a logger or names of groups, as in a file.
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

    /// Checks that the header, if there is one, has all required columns.
    ///
    /// # Errors
    /// It lacks one.
    pub fn check_header(&self) -> Result<(), Error> {
        let lack = self.above.as_ref().map(|(_, error)| error.clone());
        lack.map_or(Ok(()), Err)
    }

    /// Begins a table with this header, whose names are completed by those of the groups above.
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
            } else if let Some(Finding { what, remedy }) = columns.misfit(record) {
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

    /// Completes rows of frames up to `now_ns` without a line: rows continue during silence.
    pub fn pass(&mut self, now_ns: i64) {
        if let (Kind::Frames(decoder), Some((time, came))) = (&mut self.kind, self.last) {
            decoder.pass(time.saturating_add(now_ns.saturating_sub(came)));
        }
    }

    /// Completes the pending rows after the last line.
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

    /// Messages on columns of a table without a value in any row.
    pub fn empty(&self) -> Vec<String> {
        match &self.kind {
            Kind::Table(columns, _) => columns.empty().collect(),
            Kind::Frames(_) | Kind::Headless => Vec::new(),
        }
    }

    /// The next row, if one is complete. Its time on the host's clock is unknown.
    pub fn row(&mut self) -> Option<Row<S>> {
        let (mut sensors, truth) = match &mut self.kind {
            Kind::Frames(decoder) => decoder.row(),
            Kind::Table(columns, _) => columns.row(),
            Kind::Headless => None,
        }?;
        sensors.stamp_mut().measured_ns = 0;
        Some((sensors, truth))
    }

    /// Sets the time of the first frame to `seconds` instead of 0; a table has its own times.
    pub fn begin_at(&mut self, seconds: f64) {
        if let Kind::Frames(decoder) = &mut self.kind {
            decoder.begin_at(seconds);
        }
    }

    /// Number of lines that were left out.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Remarks since the last call, one line each.
    pub fn take_remarks(&mut self) -> Vec<String> {
        if let Kind::Frames(decoder) = &mut self.kind {
            self.remarks.extend(decoder.take_remarks());
        }
        std::mem::take(&mut self.remarks)
    }

    /// Checks that most lines had data, and that frames had different times.
    ///
    /// # Errors
    /// They did not.
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

/// Checks that a line is text.
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

/// The cells of a header, and its names, completed by those of `groups` above.
fn head(
    line: &[u8],
    groups: &[String],
    dialect: Dialect,
    input: &str,
) -> Result<(Cells, Vec<String>), Error> {
    check_text(line, input)?;
    let mut cells = Cells::new(dialect);
    let header = csv::header(cells.split(line), groups, dialect, || input.to_owned())?;
    Ok((cells, header))
}

/// A column of text in the rows of a table, such as the name of each row's machine.
#[derive(Debug)]
pub struct NameColumn {
    name: &'static str,
    input: Arc<str>,
    lines: csv::Lines,
    /// Lines that a decoder of the rows needs before them.
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

/// Kind of a line of such a table.
#[derive(Debug, PartialEq)]
pub enum NamedLine {
    /// It is above the rows: see [`NameColumn::above`].
    Above,
    /// A row, and its text in the column; none if the cell is empty.
    Row(Option<String>),
    /// A repeated header of joined files, and whether it equals that of the rows before.
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

    /// The lines above the rows: the line of the separator, a comment that may be the header, the header, units.
    pub fn above(&self) -> &[Vec<u8>] {
        &self.above
    }

    /// Whether the header has been found.
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
            // Only the last comment can be the header: an endless number of comments must not be stored.
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
        // An open quote, or a line end within quotes, means an incomplete name.
        let is_whole = |text: &str| !text.chars().any(|c| c.is_control() || c == '"');
        let text = text.filter(|text| is_whole(text) && !text.is_empty());
        NamedLine::Row(text.map(|text| text.into_owned()))
    }
}

/// The usual input.
const INPUT: &str = "standard input";

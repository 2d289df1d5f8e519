//! Samples out of lines as they come: candump's, or the rows of a table.

use crate::Error;
use crate::can::{Decoder, Line, parse};
use crate::csv::{Cells, Columns, Dialect, names, separator_line};
use crate::map::Map;
use crate::signal::{Row, Sensors};

/// Longest line; what is longer is none of ours.
pub const MAX_LINE: usize = 1 << 16;
/// Remarks about lines that say nothing, until they are only counted.
const MOST_REMARKS: u64 = 5;

/// Makes rows of lines. Which kind they are is given by the map (`[can]`) and the first line.
#[derive(Debug)]
pub struct LineDecoder<S: Sensors> {
    map: Option<Map>,
    kind: Kind<S>,
    count: u64,
    refused: u64,
    remarks: Vec<String>,
    /// Time of the last frame and when it came [ns].
    last: Option<(i64, i64)>,
}

#[derive(Debug)]
enum Kind<S: Sensors> {
    Frames(Box<Decoder<S>>),
    /// A table whose header has not come; the separator, if a line said it.
    Headless(Option<u8>),
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
            _ => Kind::Headless(None),
        };
        Ok(Self {
            map,
            kind,
            count: 0,
            refused: 0,
            remarks: Vec::new(),
            last: None,
        })
    }

    /// Takes a line that came at `now_ns`. A line that says nothing is left out and reported.
    ///
    /// # Errors
    /// The header of a table lacks a column.
    pub fn take(&mut self, line: &[u8], now_ns: i64) -> Result<(), Error> {
        self.count += 1;
        let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
        if line.trim_ascii().is_empty() {
            return Ok(());
        }
        match &mut self.kind {
            Kind::Frames(decoder) => {
                let text = String::from_utf8_lossy(line);
                match parse(&text) {
                    Some(Line::Frame { mut frame, timed }) => {
                        if !timed {
                            frame.time_ns = now_ns;
                        }
                        self.last = Some((frame.time_ns, now_ns));
                        decoder.take(&frame);
                    }
                    Some(Line::Nothing) => {}
                    None => self.refuse("is no frame"),
                }
            }
            Kind::Headless(separator) => {
                if let Some(said) = separator_line(line) {
                    *separator = Some(said);
                    return Ok(());
                }
                let dialect = match *separator {
                    Some(separator) => Dialect { separator },
                    None => Dialect::of(line),
                };
                let mut cells = Cells::new(dialect);
                let header = names(cells.split(line), INPUT)?;
                let columns = Columns::choose(header, dialect, self.map.as_ref(), INPUT)?;
                self.kind = Kind::Table(Box::new(columns), Box::new(cells));
            }
            Kind::Table(columns, cells) => {
                let record = cells.split(line);
                let is_whole = record.len() == columns.width();
                if !is_whole || columns.take(record).is_err() {
                    self.refuse("is no row of the table");
                }
            }
        }
        Ok(())
    }

    /// Nothing came until `now_ns`: silence makes rows of frames too.
    pub fn pass(&mut self, now_ns: i64) {
        if let (Kind::Frames(decoder), Some((time, came))) = (&mut self.kind, self.last) {
            decoder.pass(time.saturating_add(now_ns.saturating_sub(came)));
        }
    }

    /// There will be no more lines.
    pub fn finish(&mut self) {
        match &mut self.kind {
            Kind::Frames(decoder) => decoder.finish(),
            Kind::Table(columns, _) => columns.finish(),
            Kind::Headless(_) => {}
        }
    }

    /// The next row, if one is complete. When it was measured on the host's clock is not known.
    pub fn row(&mut self) -> Option<Row<S>> {
        let (mut sensors, truth) = match &mut self.kind {
            Kind::Frames(decoder) => decoder.row(),
            Kind::Table(columns, _) => columns.row(),
            Kind::Headless(_) => None,
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

    /// What was strange so far, a line each; taken once.
    pub fn take_remarks(&mut self) -> Vec<String> {
        if let Kind::Frames(decoder) = &mut self.kind {
            self.remarks.extend(decoder.take_remarks());
        }
        std::mem::take(&mut self.remarks)
    }

    fn refuse(&mut self, why: &str) {
        self.refused += 1;
        if self.refused <= MOST_REMARKS {
            self.remarks
                .push(format!("line {} of {INPUT} {why}; left out", self.count));
        }
    }
}

/// A column of text in the rows of a table, such as the name of the machine that each row is of.
#[derive(Debug)]
pub struct NameColumn {
    cells: Cells,
    at: usize,
}

impl NameColumn {
    /// The column of this name; `said` is the line before the header, if that tells the separator.
    ///
    /// # Errors
    /// The header has no such column.
    pub fn find(header: &[u8], said: Option<&[u8]>, name: &str) -> Result<Self, Error> {
        let header = header.strip_prefix(b"\xef\xbb\xbf").unwrap_or(header);
        let dialect = Dialect::of(said.unwrap_or(header));
        let mut cells = Cells::new(dialect);
        let names = names(cells.split(header), INPUT)?;
        let at = names.iter().position(|n| n == name).ok_or_else(|| {
            let what = format!("there is no column {name}");
            let remedy = format!("add it; the table has {}", names.join(", "));
            Error::new(what, format!("{INPUT}:1"), remedy)
        })?;
        Ok(Self { cells, at })
    }

    /// Whether a line tells the separator and is no header.
    #[must_use]
    pub fn is_separator(line: &[u8]) -> bool {
        separator_line(line).is_some()
    }

    /// What a row says there; nothing where it says nothing.
    #[must_use]
    pub fn of(&mut self, line: &[u8]) -> Option<String> {
        let record = self.cells.split(line);
        let text = String::from_utf8_lossy(record.get(self.at)?).into_owned();
        // A quote that is left open, or a line end inside of one, is half a name.
        let is_whole = !text.chars().any(|c| c.is_control() || c == '"');
        (is_whole && !text.is_empty()).then_some(text)
    }
}

/// The name of the input in errors.
const INPUT: &str = "standard input";

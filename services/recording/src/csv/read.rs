use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::absent::{absent, listed};
use super::cells::{Records, TooLong};
use super::columns::{CLOSE, Columns, hidden_rows};
use super::dialect::Dialect;
use super::exported;
use super::front::Front;
use super::header::{check_units, header};
use super::no_number::{NoNumber, ZEROS};
use super::several::By;
use crate::kind;
use crate::map::Map;
use crate::packed;
use crate::signal::{Row, Sensors};
use crate::unit;
use crate::{Error, Finding};

/// Reads axle weights on level and tilted ground: `pitch` [rad, nose up positive], `front_load`
/// and `rear_load` \[N\]; a row of units below the header may state others.
///
/// # Errors
/// The file cannot be read, lacks a column, has one in a unit of another dimension, or a cell holds no finite number.
pub fn read_weighings(path: impl AsRef<Path>) -> Result<Vec<[f64; 3]>, Error> {
    const NAMES: [(&str, &str); 3] = [("pitch", "rad"), ("front_load", "N"), ("rear_load", "N")];
    let table = Table::open(path.as_ref())?;
    let (mut records, header) = table.records()?;
    let (mut at, mut factors) = ([0; 3], [1.0; 3]);
    for ((at, factor), (name, si)) in at.iter_mut().zip(&mut factors).zip(NAMES) {
        let found = header.iter().position(|h| h == name);
        // Weighings have no signal map.
        *at = found.ok_or_else(|| Error {
            remedy: format!("add or rename it; the file has {}", listed(&header)),
            ..absent(&[name], "weighing", &header, &table.file)
        })?;
        *factor = table.factor(*at, name, si)?;
    }
    let mut rows = Vec::new();
    while table.advance(&mut records)? {
        let record = records.record();
        if let Some(what) = hidden_rows(record, header.len(), table.dialect) {
            let place = format!("{}:{}", table.file, table.line(records.start()));
            return Err(Error::new(what, place, CLOSE));
        }
        let mut row = [0.0; 3];
        for ((value, at), factor) in row.iter_mut().zip(at).zip(factors) {
            let cell = record.get(at).unwrap_or_default();
            *value = table
                .dialect
                .number(cell)
                .map(|x| x * factor)
                .filter(|x| x.is_finite())
                .ok_or_else(|| {
                    let line = table.line(records.start());
                    let error =
                        NoNumber::of(cell, &header[at], &header, false).at(line, &table.file);
                    // No number of a weighing may be missing.
                    let remedy = "write a number, or delete the row";
                    Error::new(error.what, error.place, remedy)
                })?;
        }
        rows.push(row);
    }
    Ok(rows)
}

/// A file and its format.
struct Table {
    path: PathBuf,
    file: String,
    dialect: Dialect,
    is_packed: bool,
    /// Whether the bytes of the text are those of the file.
    is_plain: bool,
    /// Bytes before the header: a byte order mark, lines of comment, and Excel's line that names the separator.
    preface: usize,
    /// Units in a separate line, a text for each column.
    units: Option<Vec<String>>,
    /// Lines below the header that are no samples.
    below: usize,
    /// Names in the row above, for empty ones in the header.
    above: Vec<String>,
    /// Whether each row has a name without a column in the header.
    has_row_names: bool,
    /// Names of the columns, where the header is none that a table has.
    names: Option<Vec<String>>,
}

/// The lines below the header.
type Lines = Records<BufReader<Box<dyn Read>>>;

/// Number of bytes in which the header must be.
const HEAD: u64 = 1 << 18;

impl Table {
    fn open(path: &Path) -> Result<Self, Error> {
        let failed = |e| Error::system("read the data", path, &e);
        let mut head = Vec::new();
        let mut content = packed::open(path).map_err(failed)?;
        match content.by_ref().take(HEAD).read_to_end(&mut head) {
            // A compressed file that was cut off within these bytes may still contain the header.
            Err(e) if e.kind() != io::ErrorKind::UnexpectedEof => return Err(failed(e)),
            _ => {}
        }
        let file = path.display().to_string();
        let packed = [
            (&packed::GZIP[..], "the file is packed twice"),
            (kind::MCAP, "this is a packed recording"),
        ];
        for (magic, what) in packed {
            if content.is_packed && head.starts_with(magic) {
                return Err(Error::new(what, file, "unpack it: gunzip FILE"));
            }
        }
        if let Some((_, remedy)) = kind::of_tar(&head) {
            return Err(Error::new("this is a packed tar archive", file, remedy));
        }
        let exported = exported::front(&head).transpose();
        let exported = exported.map_err(|refusal| refusal.at(&file))?;
        let Some(front) = exported.or_else(|| Front::of(&head)) else {
            let what = if head.trim_ascii().is_empty() {
                "the file is empty"
            } else {
                "the file does not begin with a table: no line of its beginning is a header"
            };
            let remedy = "give a CSV file with a header and a row per sample";
            return Err(Error::new(what, file, remedy));
        };
        Ok(Self {
            path: path.to_owned(),
            dialect: front.dialect,
            file,
            preface: front.start,
            units: front.units,
            below: front.below,
            above: front.above,
            has_row_names: front.has_row_names,
            names: front.names,
            is_packed: content.is_packed,
            is_plain: content.is_plain,
        })
    }

    /// One of a column's unit in SI; a column without a unit is in SI.
    fn factor(&self, at: usize, name: &str, si: &str) -> Result<f64, Error> {
        let text = self.units.as_ref().and_then(|units| units.get(at));
        let Some(text) = text.filter(|text| !text.is_empty()) else {
            return Ok(1.0);
        };
        let found = unit::guess(text).filter(|unit| unit.si == si);
        found.map(|unit| unit.factor).ok_or_else(|| {
            let scales = if si == "N" {
                "; kg times 9.81 is N"
            } else {
                ""
            };
            Error::new(
                format!("column {name} is in {text}, and {si} is expected"),
                format!("{}:{}", self.file, self.line(0) + 1),
                format!("give it in one of {}{scales}", unit::of(si)),
            )
        })
    }

    /// The content from byte `start`.
    fn content(&self, start: usize) -> Result<Box<dyn Read>, Error> {
        let failed = |e| Error::system("read the data", &self.path, &e);
        let mut content = packed::open(&self.path).map_err(failed)?;
        let before = &mut content.by_ref().take(start as u64);
        std::io::copy(before, &mut std::io::sink()).map_err(failed)?;
        Ok(Box::new(content))
    }

    /// The records after the last line above the samples, and the header.
    fn records(&self) -> Result<(Lines, Vec<String>), Error> {
        let content = BufReader::with_capacity(1 << 16, self.content(self.preface)?);
        let mut records = Records::new(content, self.dialect);
        self.advance(&mut records)?;
        let place = || format!("{}:{}", self.file, self.line(0));
        let mut header = match &self.names {
            Some(names) => names.clone(),
            None => header(records.record(), &self.above, self.dialect, place)?,
        };
        if self.has_row_names {
            header.insert(0, String::new());
        }
        for _ in 0..self.below {
            self.advance(&mut records)?;
        }
        Ok((records, header))
    }

    fn advance(&self, records: &mut Lines) -> Result<bool, Error> {
        let more = records.advance();
        more.map_err(|e| self.failed(&e, records.start()))
    }

    /// The error of a row that cannot be read.
    fn failed(&self, error: &io::Error, start: u64) -> Error {
        match error.get_ref() {
            Some(e) if e.is::<TooLong>() => Error::new(
                e.to_string(),
                format!("{}:{}", self.file, self.line(start)),
                "close the quote that opens in it, if one does; else leave out columns that are no signals",
            ),
            _ => Error::system("read the data", &self.path, error),
        }
    }

    /// The error of a compressed file whose content differs from what was compressed: it explains a row that is no row.
    fn damage(&self) -> Option<Error> {
        let mut content = self.content(0).ok().filter(|_| self.is_packed)?;
        let error = io::copy(&mut content, &mut io::sink()).err()?;
        let is_damaged = error.kind() != io::ErrorKind::UnexpectedEof;
        is_damaged.then(|| Error::system("read the data", &self.path, &error))
    }

    /// Whether this error means that a compressed file ends early.
    fn is_cut(&self, error: &io::Error) -> bool {
        self.is_packed && error.kind() == io::ErrorKind::UnexpectedEof
    }

    /// Whether the last row has a line end.
    fn is_closed(&self) -> Result<bool, Error> {
        let failed = |e| Error::system("read the data", &self.path, &e);
        let last = if self.is_plain {
            last_byte(&self.path).map_err(failed)?
        } else {
            // The end of the text is reached only by reading all of it.
            let bytes = BufReader::new(self.content(0)?).bytes();
            bytes.last().transpose().map_err(failed)?
        };
        Ok(last == Some(b'\n'))
    }

    /// Line of the record that begins at this byte, counted from 1, empty lines included.
    fn line(&self, start: u64) -> usize {
        let start = self.preface + start as usize;
        let content = self
            .content(0)
            .into_iter()
            .flat_map(|c| BufReader::new(c).bytes());
        let bytes = content.map_while(Result::ok).enumerate();
        let before = bytes.take_while(|(at, b)| *at < start || b.is_ascii_whitespace());
        before.filter(|(_, b)| *b == b'\n').count() + 1
    }
}

fn last_byte(path: &Path) -> io::Result<Option<u8>> {
    let mut file = File::open(path)?;
    if file.seek(SeekFrom::End(0))? == 0 {
        return Ok(None);
    }
    let mut last = [0];
    file.seek(SeekFrom::End(-1))?;
    file.read_exact(&mut last)?;
    Ok(Some(last[0]))
}

/// The rows of a table, one after the other.
pub(crate) struct TableRows<S: Sensors> {
    table: Table,
    records: Lines,
    columns: Columns<S>,
    count: u64,
    has_ended: bool,
    /// Place of a last row that was cut off.
    cut_off: Option<String>,
}

impl<S: Sensors> TableRows<S> {
    /// Opens a table, to be read with the map.
    pub(crate) fn open(path: &Path, map: Option<&Map>) -> Result<Self, Error> {
        let table = Table::open(path)?;
        let (records, header) = table.records()?;
        if let Some(units) = &table.units {
            let place = || format!("{}:{}", table.file, table.line(0) + 1);
            check_units::<S>(&header, units, map, place)?;
        }
        Ok(Self {
            columns: Columns::choose(header, table.dialect, map, &table.file)?,
            table,
            records,
            count: 0,
            has_ended: false,
            cut_off: None,
        })
    }

    /// Bytes read.
    pub(crate) fn read(&self) -> u64 {
        self.records.end()
    }

    /// Message on a last row that was cut off, after all rows were read.
    pub(crate) fn cut_off(&self) -> Option<&str> {
        self.cut_off.as_deref()
    }

    /// Messages on columns without a value, after all rows were read.
    pub(crate) fn empty(&self) -> Vec<String> {
        self.columns.empty().collect()
    }

    /// The next row; none at the end.
    pub(crate) fn row(&mut self) -> Result<Option<Row<S>>, Error> {
        loop {
            if let Some(row) = self.columns.row() {
                return Ok(Some(row));
            }
            if self.has_ended {
                return Ok(None);
            }
            if let Err(error) = self.take() {
                return Err(self.table.damage().unwrap_or(error));
            }
        }
    }

    /// Takes a line, or the end.
    fn take(&mut self) -> Result<(), Error> {
        let table = &self.table;
        let more = match self.records.advance() {
            Ok(more) => more,
            Err(e) if self.count > 0 && table.is_cut(&e) => {
                self.cut_off = Some(format!(
                    "{}: the packed file was cut off; the rows before the cut were read",
                    table.file
                ));
                return self.end();
            }
            Err(e) => return Err(table.failed(&e, self.records.start())),
        };
        let table = &self.table;
        if more {
            let (record, start) = (self.records.record(), self.records.start());
            if self.columns.is_no_row(record) {
                return Ok(());
            }
            if Columns::<S>::is_hole(record) {
                return self.end_in_zeros();
            }
            if let Some(misfit) = self.columns.misfit(record) {
                let error = misfit.at(format!("{}:{}", table.file, table.line(start)));
                return match self.columns.cut(record) {
                    Some(cut) => self.end_early(&cut, error),
                    None => Err(error),
                };
            }
            let Err(cell) = self.columns.take(record) else {
                self.count += 1;
                return Ok(());
            };
            let cut = format!("\"{}\" in column {}", cell.text, cell.column);
            let (is_last, error) = (cell.is_last, cell.at(table.line(start), &table.file));
            return match is_last && !table.is_closed()? {
                true => self.end_early(&cut, error),
                false => Err(error),
            };
        }
        if self.count == 0 {
            let remedy = "give a file with a row per sample below the header";
            let file = table.file.clone();
            return Err(Error::new(
                "the file has a header but no rows",
                file,
                remedy,
            ));
        }
        self.end()
    }

    fn end(&mut self) -> Result<(), Error> {
        self.has_ended = true;
        self.columns.finish();
        self.columns.check_values(&self.table.file)
    }

    /// A block of zeros was met: the end of a file that was reserved and not written. Above rows it is an error.
    fn end_in_zeros(&mut self) -> Result<(), Error> {
        let (table, start) = (&self.table, self.records.start());
        let mut is_end = self.count > 0;
        while is_end && table.advance(&mut self.records)? {
            let record = self.records.record();
            is_end = Columns::<S>::is_hole(record) || self.columns.is_no_row(record);
        }
        let place = format!("{}:{}", table.file, table.line(start));
        if !is_end {
            return Err(Error::new(
                "bytes of zero stand instead of rows",
                place,
                ZEROS,
            ));
        }
        self.cut_off = Some(format!(
            "{place}: the file ends in bytes of zero: its end was reserved, and not written or lost"
        ));
        self.end()
    }

    /// A last row was cut off while it was written, as the words `cut` say: it is left out. If it is not the last one, or the only
    /// one, it is an error.
    fn end_early(&mut self, cut: &str, error: Error) -> Result<(), Error> {
        let (table, start) = (&self.table, self.records.start());
        if self.count == 0 {
            return Err(error);
        }
        while table.advance(&mut self.records)? {
            if !self.columns.is_no_row(self.records.record()) {
                return Err(error);
            }
        }
        let line = table.line(start);
        self.cut_off = Some(format!(
            "{}:{line}: the last row was cut off ({cut}); it is left out",
            table.file
        ));
        self.end()
    }
}

/// Reads the samples of a machine from a table; a map renames and converts its columns.
///
/// # Errors
/// The file cannot be read, lacks a column, or has a cell that is no number; the error says where.
pub fn read<S: Sensors>(path: impl AsRef<Path>, map: Option<&Map>) -> Result<Vec<Row<S>>, Error> {
    let mut rows = TableRows::<S>::open(path.as_ref(), map)?;
    std::iter::from_fn(|| rows.row().transpose()).collect()
}

/// The column by which the rows of a table are of several machines or recordings, if its first `most` rows show one.
pub(crate) fn several<S: Sensors>(
    path: &Path,
    map: Option<&Map>,
    (by, most): (By, usize),
) -> Option<Finding> {
    let mut rows = TableRows::<S>::open(path, map).ok()?;
    let mut several = rows.columns.several();
    let mut taken = 0;
    while several.is_open() && taken < most && rows.records.advance().ok()? {
        let record = rows.records.record();
        if rows.columns.is_no_row(record) || rows.columns.is_short(record) {
            continue;
        }
        if rows.columns.take(record).is_ok() {
            let (time, values) = rows.columns.taken();
            several.take(record, time, values);
            // Rows are built as they come.
            while rows.columns.row().is_some() {}
            taken += 1;
        }
    }
    several.found(rows.columns.header(), by)
}

/// Columns of a table that are no signal, each with the most similar name of an absent signal; none if the table
/// cannot be read.
pub fn misspelt<S: Sensors>(path: &Path) -> Vec<(String, String)> {
    let header = Table::open(path).and_then(|table| Ok(table.records()?.1));
    let header = header.unwrap_or_default();
    let signals = crate::signal::signals::<S>();
    let known: Vec<&str> = signals.iter().map(|s| s.name.as_str()).collect();
    let is_absent = |name: &&str| !header.iter().any(|h| h == name);
    let absent: Vec<&str> = known.iter().copied().filter(is_absent).collect();
    let near = |column: &String| config::nearest(column, absent.iter().copied()).map(str::to_owned);
    let foreign = header.iter().filter(|h| !known.contains(&h.as_str()));
    foreign
        .filter_map(|h| Some((h.clone(), near(h)?)))
        .collect()
}

/// The first rows of a table.
pub(crate) struct Look {
    /// Names of the columns.
    pub header: Vec<String>,
    /// Units in a row below the header, empty texts if there are none.
    pub units: Vec<String>,
    /// Numbers by column; NaN where a cell holds none.
    pub columns: Vec<Vec<f64>>,
    /// Whether each cell of a column is a whole number, or a time of day or date without a part of a second.
    pub is_whole_second: Vec<bool>,
    /// Names in the row above the header, if there is one.
    pub above: Vec<String>,
}

/// Header and the numbers of the first `most` rows.
pub(crate) fn look(path: &Path, most: usize) -> Result<Look, Error> {
    let table = Table::open(path)?;
    let (mut records, header) = table.records()?;
    if header.len() < 2 {
        return Err(absent(&["t"], "any machine", &header, &table.file));
    }
    let mut columns = vec![Vec::new(); header.len()];
    let mut is_whole_second = vec![true; header.len()];
    for row in 0..most {
        match records.advance() {
            Ok(true) => {}
            Ok(false) => break,
            // The rows before the cut suffice for the units.
            Err(e) if row > 0 && table.is_cut(&e) => break,
            Err(e) => return Err(Error::system("read the data", path, &e)),
        }
        let record = records.record();
        for (at, column) in columns.iter_mut().enumerate() {
            let cell = record.get(at).unwrap_or_default();
            is_whole_second[at] &= is_of_whole_seconds(cell);
            column.push(table.dialect.number(cell).unwrap_or(f64::NAN));
        }
    }
    let units = table
        .units
        .unwrap_or_else(|| vec![String::new(); header.len()]);
    Ok(Look {
        header,
        units,
        columns,
        is_whole_second,
        above: table.above,
    })
}

/// Whether a time has no fraction of a second: no decimal mark after its last colon.
fn is_of_whole_seconds(cell: &[u8]) -> bool {
    let seconds = cell.rsplit(|b| *b == b':').next().unwrap_or_default();
    !seconds.iter().any(|b| b".,eE".contains(b))
}

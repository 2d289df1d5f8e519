use std::io::Read;
use std::path::Path;

use ::csv::{ByteRecord, Reader, ReaderBuilder, Trim};
use messages::{ExcavatorSensors, ExcavatorTruth, LoaderSensors, LoaderTruth};

use super::columns::{Columns, NoNumber, absent};
use super::dialect::{self, Dialect};
use crate::Error;
use crate::map::Map;
use crate::signal::{Excavator, Loader, Machine, Row};

/// Reads the samples of an excavator. Columns are those of heft, in SI units, or what the map
/// makes of others; `true_*` columns become the truth. An empty cell and a number that is not
/// finite are missing samples. Rows with a wrong time are passed on: the estimator refuses them.
///
/// # Errors
/// The file cannot be read, lacks a column, or has text for a number; the error names line and column.
pub fn read_excavator(
    path: impl AsRef<Path>,
    map: Option<&Map>,
) -> Result<Vec<(ExcavatorSensors, ExcavatorTruth)>, Error> {
    read::<Excavator>(path.as_ref(), map)
}

/// Reads the samples of a wheel loader, as [`read_excavator`] does.
///
/// # Errors
/// As [`read_excavator`].
pub fn read_loader(
    path: impl AsRef<Path>,
    map: Option<&Map>,
) -> Result<Vec<(LoaderSensors, LoaderTruth)>, Error> {
    read::<Loader>(path.as_ref(), map)
}

/// Reads axle weights on level and tilted ground: `pitch` [rad, nose up positive], `front_load`
/// and `rear_load` [N].
///
/// # Errors
/// The file cannot be read, lacks a column, or a cell holds no finite number.
pub fn read_weighings(path: impl AsRef<Path>) -> Result<Vec<[f64; 3]>, Error> {
    const NAMES: [&str; 3] = ["pitch", "front_load", "rear_load"];
    let table = Table::open(path.as_ref())?;
    let (mut reader, header) = table.reader()?;
    let mut at = [0; 3];
    for (at, name) in at.iter_mut().zip(NAMES) {
        let found = header.iter().position(|h| h == name);
        *at = found.ok_or_else(|| absent(&[name], "weighing", &header, &table.file))?;
    }
    let mut rows = Vec::new();
    let mut record = ByteRecord::new();
    while reader
        .read_byte_record(&mut record)
        .map_err(|e| broken(&e, &table.file))?
    {
        let mut row = [0.0; 3];
        for (value, at) in row.iter_mut().zip(at) {
            let cell = record.get(at).unwrap_or_default();
            *value = table
                .dialect
                .number(cell)
                .filter(|x| x.is_finite())
                .ok_or_else(|| no_number(cell, &header[at], table.line(&record), &table.file))?;
        }
        rows.push(row);
    }
    Ok(rows)
}

/// The bytes of a file.
struct Table {
    bytes: Vec<u8>,
    file: String,
    dialect: Dialect,
    /// Bytes before the header: Excel's line that names the separator.
    preface: usize,
}

impl Table {
    fn open(path: &Path) -> Result<Self, Error> {
        let bytes = std::fs::read(path).map_err(|e| Error::system("read the data", path, &e))?;
        let bytes = dialect::utf8(bytes);
        let file = path.display().to_string();
        if bytes.trim_ascii().is_empty() {
            let remedy = "give a CSV file with a header and a row per sample";
            return Err(Error::new("the file is empty", file, remedy));
        }
        let blank = bytes.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let line = bytes[blank..].split(|b| *b == b'\n').next();
        let line = line.unwrap_or_default();
        let preface = match dialect::separator_line(line) {
            Some(_) => (blank + line.len() + 1).min(bytes.len()),
            None => 0,
        };
        Ok(Self {
            dialect: Dialect::of(line),
            bytes,
            file,
            preface,
        })
    }

    /// A reader behind the header, and the header.
    fn reader(&self) -> Result<(Reader<&[u8]>, Vec<String>), Error> {
        let mut builder = ReaderBuilder::new();
        let mut reader = builder
            .delimiter(self.dialect.separator)
            .trim(Trim::All)
            .flexible(true)
            .from_reader(&self.bytes[self.preface..]);
        let header = header(&mut reader, &self.file)?;
        Ok((reader, header))
    }

    /// Line of a record, counted from 1; empty lines before it are counted too.
    fn line(&self, record: &ByteRecord) -> usize {
        let start = self.preface + record.position().map_or(0, |p| p.byte() as usize);
        let rest = self.bytes.get(start..).unwrap_or_default();
        let blank = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let before = self.bytes.get(..start + blank).unwrap_or(&self.bytes);
        before.iter().filter(|b| **b == b'\n').count() + 1
    }
}

pub(crate) fn read<M: Machine>(path: &Path, map: Option<&Map>) -> Result<Vec<Row<M>>, Error> {
    let table = Table::open(path)?;
    let (mut reader, header) = table.reader()?;
    let mut columns = Columns::<M>::choose(header, table.dialect, map, &table.file)?;
    let mut record = ByteRecord::new();
    let mut count = 0;
    while reader
        .read_byte_record(&mut record)
        .map_err(|e| broken(&e, &table.file))?
    {
        check_width(
            &record,
            columns.width(),
            || table.line(&record),
            &table.file,
        )?;
        columns.take(&record).map_err(|NoNumber { text, column }| {
            no_number(text.as_bytes(), &column, table.line(&record), &table.file)
        })?;
        count += 1;
    }
    if count == 0 {
        let remedy = "give a file with a row per sample below the header";
        return Err(Error::new(
            "the file has a header but no rows",
            table.file,
            remedy,
        ));
    }
    columns.finish();
    Ok(std::iter::from_fn(|| columns.row()).collect())
}

/// Header and numbers of the first `most` rows, by column; NaN where a cell holds none.
pub(crate) fn numbers(path: &Path, most: usize) -> Result<(Vec<String>, Vec<Vec<f64>>), Error> {
    let table = Table::open(path)?;
    let (mut reader, header) = table.reader()?;
    let mut columns = vec![Vec::new(); header.len()];
    let mut record = ByteRecord::new();
    for _ in 0..most {
        if !reader
            .read_byte_record(&mut record)
            .map_err(|e| broken(&e, &table.file))?
        {
            break;
        }
        for (at, column) in columns.iter_mut().enumerate() {
            let number = table.dialect.number(record.get(at).unwrap_or_default());
            column.push(number.unwrap_or(f64::NAN));
        }
    }
    Ok((header, columns))
}

fn header<R: Read>(reader: &mut Reader<R>, file: &str) -> Result<Vec<String>, Error> {
    let bytes = reader.byte_headers().map_err(|e| broken(&e, file))?;
    names(bytes, file)
}

/// The names in a header: UTF-8, or else Latin-1; none twice.
pub(crate) fn names(header: &ByteRecord, file: &str) -> Result<Vec<String>, Error> {
    let names: Vec<String> = header
        .iter()
        .map(|name| dialect::text(name).trim().to_owned())
        .collect();
    for (i, name) in names.iter().enumerate() {
        if !name.is_empty() && names[..i].contains(name) {
            return Err(Error::new(
                format!("two columns are called {name}"),
                format!("{file}:1, column {}", i + 1),
                "rename one of them",
            ));
        }
    }
    Ok(names)
}

/// A row that was cut off must not pass for one with missing samples.
fn check_width(
    record: &ByteRecord,
    width: usize,
    line: impl Fn() -> usize,
    file: &str,
) -> Result<(), Error> {
    let surplus_is_empty = record.iter().skip(width).all(<[u8]>::is_empty);
    if record.len() < width || !surplus_is_empty {
        return Err(Error::new(
            format!("the row has {} cells, the header {width}", record.len()),
            format!("{file}:{}", line()),
            "complete the row, or delete it",
        ));
    }
    Ok(())
}

fn no_number(cell: &[u8], column: &str, line: usize, file: &str) -> Error {
    Error::new(
        format!("\"{}\" is no number", String::from_utf8_lossy(cell)),
        format!("{file}:{line}, column {column}"),
        "write a number, or leave the cell empty where the sample is missing",
    )
}

fn broken(error: &::csv::Error, file: &str) -> Error {
    let line = error.position().map_or(1, ::csv::Position::line);
    Error::new(
        format!("this is no CSV: {error}"),
        format!("{file}:{line}"),
        "give a CSV file with a header, separated by commas",
    )
}

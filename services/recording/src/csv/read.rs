use std::io::Read;
use std::path::Path;

use ::csv::{ByteRecord, Reader, ReaderBuilder, Trim};
use messages::{ExcavatorSensors, ExcavatorTruth, LoaderSensors, LoaderTruth};

use crate::Error;
use crate::map::{Conversion, Map, Origin, hint};
use crate::signal::{self, Builder, Excavator, Loader, Machine, Row, Signal};

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
            *value = number(cell).filter(|x| x.is_finite()).ok_or_else(|| {
                no_number(
                    cell,
                    &header[at],
                    line_of(&record, table.text()),
                    &table.file,
                )
            })?;
        }
        rows.push(row);
    }
    Ok(rows)
}

/// The bytes of a file.
struct Table {
    bytes: Vec<u8>,
    file: String,
}

impl Table {
    fn open(path: &Path) -> Result<Self, Error> {
        let bytes = std::fs::read(path).map_err(|e| Error::system("read the data", path, &e))?;
        let table = Self {
            bytes,
            file: path.display().to_string(),
        };
        if table.text().trim_ascii().is_empty() {
            let remedy = "give a CSV file with a header and a row per sample";
            return Err(Error::new("the file is empty", table.file, remedy));
        }
        Ok(table)
    }

    /// Without the byte order mark.
    fn text(&self) -> &[u8] {
        self.bytes
            .strip_prefix(b"\xef\xbb\xbf")
            .unwrap_or(&self.bytes)
    }

    /// A reader behind the header, and the header.
    fn reader(&self) -> Result<(Reader<&[u8]>, Vec<String>), Error> {
        let mut builder = ReaderBuilder::new();
        let mut reader = builder
            .trim(Trim::All)
            .flexible(true)
            .from_reader(self.text());
        let header = header(&mut reader, &self.file)?;
        Ok((reader, header))
    }
}

pub(crate) fn read<M: Machine>(path: &Path, map: Option<&Map>) -> Result<Vec<Row<M>>, Error> {
    let table = Table::open(path)?;
    let (reader, header) = table.reader()?;
    let signals = signal::signals::<M>();
    let columns = choose(&header, &signals, map, &table.file)?;
    require::<M>(&columns, &header, &table.file)?;
    rows::<M>(reader, table.text(), &columns, &header, &table.file)
}

fn header<R: Read>(reader: &mut Reader<R>, file: &str) -> Result<Vec<String>, Error> {
    let bytes = reader.byte_headers().map_err(|e| broken(&e, file))?;
    let names: Vec<String> = bytes
        .iter()
        .map(|name| String::from_utf8_lossy(name).trim().to_owned())
        .collect();
    if let [only] = names.as_slice()
        && let Some(separator) = [';', '\t'].into_iter().find(|c| only.contains(*c))
    {
        return Err(Error::new(
            format!("columns are separated by {separator:?}"),
            format!("{file}:1"),
            "separate columns by commas and write decimals with a point",
        ));
    }
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

/// Where a signal's values come from in this file.
enum From {
    Cell(usize, Conversion),
    Constant(f64),
}

type Column<'a> = (&'a Signal, From);

/// For each signal that the file or the map has, where it comes from.
fn choose<'a>(
    header: &[String],
    signals: &'a [Signal],
    map: Option<&Map>,
    file: &str,
) -> Result<Vec<Column<'a>>, Error> {
    let entries = map.map_or(&[][..], |m| &m.columns);
    if let Some(map) = map {
        map.check(entries, signals)?;
    }
    let mut columns = Vec::new();
    for signal in signals {
        let entry = entries.iter().find(|e| e.signal == signal.name);
        let from = match (entry.map(|e| (&e.origin, e.conversion)), map, entry) {
            (Some((Origin::Column(name), conversion)), Some(map), Some(entry)) => {
                let at = header.iter().position(|h| h == name).ok_or_else(|| {
                    Error::new(
                        format!(
                            "the map wants column {name} for {}, but {file} has none",
                            signal.name
                        ),
                        map.place(entry),
                        hint(name, header.iter().map(String::as_str), "its columns are"),
                    )
                })?;
                Some(From::Cell(at, conversion))
            }
            (Some((Origin::Constant(value), _)), ..) => Some(From::Constant(*value)),
            (Some(_), ..) => None,
            (None, ..) => {
                let at = header.iter().position(|h| *h == signal.name);
                at.map(|at| From::Cell(at, Conversion::NONE))
            }
        };
        columns.extend(from.map(|from| (signal, from)));
    }
    Ok(columns)
}

fn require<M: Machine>(columns: &[Column], header: &[String], file: &str) -> Result<(), Error> {
    let time: &[&str] = &["t"];
    for group in [time].iter().chain(M::REQUIRED) {
        if group
            .iter()
            .any(|name| columns.iter().any(|(s, _)| s.name == *name))
        {
            continue;
        }
        return Err(absent(group, M::NAME, header, file));
    }
    Ok(())
}

/// None of these columns is there.
fn absent(names: &[&str], of: &str, header: &[String], file: &str) -> Error {
    let similar = config::nearest(names[0], header.iter().map(String::as_str));
    let remedy = match similar {
        Some(name) => format!("rename column {name}, or name it in a signal map (--map)"),
        None => format!(
            "add the column, or name another in a signal map (--map); the file has {}",
            header.join(", ")
        ),
    };
    let what = format!("there is no column {} ({of})", names.join(" or "));
    Error::new(what, format!("{file}:1"), remedy)
}

fn rows<M: Machine>(
    mut reader: Reader<&[u8]>,
    text: &[u8],
    columns: &[Column],
    header: &[String],
    file: &str,
) -> Result<Vec<Row<M>>, Error> {
    let mut builder = Builder::<M>::new(columns.iter().map(|(signal, _)| *signal));
    let mut record = ByteRecord::new();
    let mut values = vec![0.0; columns.len()];
    let mut count = 0;
    while reader
        .read_byte_record(&mut record)
        .map_err(|e| broken(&e, file))?
    {
        let line = || line_of(&record, text);
        check_width(&record, header.len(), line, file)?;
        for (value, (_, from)) in values.iter_mut().zip(columns) {
            *value = match from {
                From::Constant(value) => *value,
                From::Cell(at, conversion) => {
                    let cell = record.get(*at).unwrap_or_default();
                    conversion.apply(
                        number(cell).ok_or_else(|| no_number(cell, &header[*at], line(), file))?,
                    )
                }
            };
        }
        builder.push(&values);
        count += 1;
    }
    if count == 0 {
        let remedy = "give a file with a row per sample below the header";
        return Err(Error::new(
            "the file has a header but no rows",
            file,
            remedy,
        ));
    }
    Ok(builder.finish())
}

/// Line of a record, counted from 1; empty lines before it are counted too.
fn line_of(record: &ByteRecord, text: &[u8]) -> usize {
    let start = record.position().map_or(0, |p| p.byte() as usize);
    let rest = text.get(start..).unwrap_or_default();
    let blank = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
    let before = text.get(..start + blank).unwrap_or(text);
    before.iter().filter(|b| **b == b'\n').count() + 1
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

/// The number in a cell, NaN where it is empty; `None` where it is text.
fn number(cell: &[u8]) -> Option<f64> {
    if cell.is_empty() {
        return Some(f64::NAN);
    }
    std::str::from_utf8(cell).ok()?.parse().ok()
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

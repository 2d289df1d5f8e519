//! The header of a table: the names of its columns, and their units.

use std::collections::HashSet;

use super::cells::Record;
use super::dialect::{self, Dialect};
use crate::Error;
use crate::map::Map;
use crate::signal::Sensors;
use crate::suggest::names::fitting;
use crate::unit;

/// The names in the header of a table, which numbers are not.
pub(crate) fn header(
    record: &Record,
    dialect: Dialect,
    file: &str,
    place: impl Fn() -> String,
) -> Result<Vec<String>, Error> {
    let header = names(record, file)?;
    // Of a program, and of text in two bytes a character, half is zeros; one of them in quotes is a strange name.
    let zeros = record.iter().flatten().filter(|b| **b == 0).count();
    let length: usize = record.iter().map(<[u8]>::len).sum();
    if 10 * zeros > length {
        return Err(Error::new(
            "this is no table: it holds bytes that are no text",
            place(),
            "give a table in UTF-8 (iconv -f UTF-16 -t UTF-8 converts others), a CAN log (.log) or an MCAP file (.mcap)",
        ));
    }
    let is_number = |cell: &[u8]| dialect.number(cell).is_some_and(f64::is_finite);
    if record.iter().all(is_number) {
        return Err(Error::new(
            "the table has no header: its first line holds numbers",
            place(),
            "write a line with the names of the columns above them",
        ));
    }
    Ok(header)
}

/// Takes the names of the row above where the header has none.
pub(crate) fn fill(header: &mut [String], above: &[String]) {
    for (at, above) in above.iter().enumerate() {
        if header[at].is_empty() && !header.contains(above) {
            header[at].clone_from(above);
        }
    }
}

/// What has a signal's own name and no line in the map is taken in SI: its unit, where one stands below it, must be that.
pub(crate) fn check_units<S: Sensors>(
    header: &[String],
    units: &[String],
    map: Option<&Map>,
    place: impl Fn() -> String,
) -> Result<(), Error> {
    let signals = crate::signal::signals::<S>();
    for (name, text) in header.iter().zip(units) {
        let is_mapped = map.is_some_and(|map| map.columns.iter().any(|e| e.signal == *name));
        let signal = signals.iter().find(|s| s.name == *name && !is_mapped);
        let (Some(signal), Some(unit)) = (signal, unit::guess(text)) else {
            continue;
        };
        if unit.si != signal.unit || unit.factor != 1.0 {
            return Err(Error::new(
                format!(
                    "column {name} is in {}, and {} is expected",
                    unit.name, signal.unit
                ),
                place(),
                "let `heft map` write a signal map, which converts it, and give that with --map",
            ));
        }
    }
    Ok(())
}

/// The names in a header: UTF-8, or else Latin-1; none twice.
fn names(header: &Record, file: &str) -> Result<Vec<String>, Error> {
    let names: Vec<String> = header.iter().map(dialect::name).collect();
    let mut seen = HashSet::new();
    for (i, name) in names.iter().enumerate() {
        if !name.is_empty() && !seen.insert(name) {
            let remedy = match fitting("t", &[name], &[]) {
                Some(_) => {
                    "if each has the times of its own columns, write all signals at one rate; else rename one of them"
                }
                None => "rename one of them",
            };
            return Err(Error::new(
                format!("two columns are called {name}"),
                format!("{file}:1, column {}", i + 1),
                remedy,
            ));
        }
    }
    Ok(names)
}

//! The header of a table: the names of its columns, and their units.

use std::collections::{HashMap, HashSet};

use super::cells::Record;
use super::dialect::{self, Dialect};
use crate::Error;
use crate::map::Map;
use crate::signal::Sensors;
use crate::suggest::names::fitting;
use crate::unit;

/// The names in the header of a table, which must not be numbers, completed by the names `above` them.
pub(crate) fn header(
    record: &Record,
    above: &[String],
    dialect: Dialect,
    place: impl Fn() -> String,
) -> Result<Vec<String>, Error> {
    if let Some(end) = record.iter().find_map(|cell| dialect.other_line_end(cell)) {
        return Err(Error::new(
            format!("the line of the names goes on behind {end}, which ends no line here"),
            place(),
            dialect::LINE_ENDS,
        ));
    }
    let header = unambiguous(record.iter().map(dialect::name).collect(), above);
    // Much of a program, or of UTF-16 text, is control characters; a single one in quotes is an unusual name.
    let is_strange = |b: &&u8| b.is_ascii_control() && !b.is_ascii_whitespace();
    let strange = record.iter().flatten().filter(is_strange);
    let length: usize = record.iter().map(<[u8]>::len).sum();
    if 10 * strange.count() > length {
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
    check_names(&header, &place())?;
    Ok(header)
}

/// Unambiguous names: an empty name is replaced by the one in the row above. A repeated name is prefixed by that of its group, which is
/// above the first of its columns.
fn unambiguous(names: Vec<String>, above: &[String]) -> Vec<String> {
    let mut counts: HashMap<&str, usize> = HashMap::new();
    for name in &names {
        *counts.entry(name).or_default() += 1;
    }
    let mut group = "";
    let above = above.iter().map(String::as_str);
    let named = names.iter().zip(above.chain(std::iter::repeat("")));
    let named = named.map(|(name, above)| {
        group = if above.is_empty() { group } else { above };
        let is_twice = counts[name.as_str()] > 1;
        match (name.as_str(), group) {
            ("", _) if !counts.contains_key(above) => above.to_owned(),
            (name, group) if is_twice && !name.is_empty() && !group.is_empty() => {
                format!("{group} {name}")
            }
            (name, _) => name.to_owned(),
        }
    });
    named.collect()
}

/// A column with the name of a signal that is not in the map is read in SI units. Its unit below the header, if any, must be the same.
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

/// Refuses repeated names.
fn check_names(names: &[String], place: &str) -> Result<(), Error> {
    let mut seen = HashSet::new();
    for (i, name) in names.iter().enumerate() {
        if !name.is_empty() && !seen.insert(name) {
            let remedy = match fitting("t", &[name.as_str()], &[]) {
                Some(_) => {
                    "if each has the times of its own columns, write all signals at one rate; else rename one of them"
                }
                None => {
                    "rename one of them; several rows of names of pandas become one by frame.columns = frame.columns.map(\"_\".join)"
                }
            };
            return Err(Error::new(
                format!("two columns are called {name}"),
                format!("{place}, column {}", i + 1),
                remedy,
            ));
        }
    }
    Ok(())
}

//! Headers without the wanted columns: of which other kind the table is, or what its columns are called.

use super::dialect;
use crate::Error;

/// The kind of a table that cannot be read with this header, if recognized.
pub(crate) fn misread(header: &[String], file: &str) -> Option<Error> {
    let lower: Vec<String> = header.iter().map(|name| name.to_lowercase()).collect();
    let is_in = |name: &String, names: &str| names.split(", ").any(|known| known == name);
    let is_one_of = |names| lower.iter().any(|name| is_in(name, names));
    let (what, remedy) = if is_one_of(FRAMES[0]) && is_one_of(FRAMES[1]) {
        (
            "this is a table of CAN frames",
            "save it as a log of candump (SavvyCAN and python-can's can_logconvert do), and give that with its DBC file in a signal map",
        )
    } else if is_one_of(LONG[0]) && is_one_of(LONG[1]) {
        (
            "this table has a row for each value, and heft reads one with a column for each signal",
            "turn it: in pandas table.pivot(index=TIME, columns=NAME, values=VALUE).to_csv(\"wide.csv\")",
        )
    } else if header.iter().any(|name| dialect::is_garbled(name)) {
        (
            "the names of the columns are in another encoding than UTF-8",
            "convert it: iconv -f GB18030 -t UTF-8 FILE > NEW (Chinese), or -f CP932 (Japanese), -f CP949 (Korean), -f CP1251 (Russian)",
        )
    } else {
        return None;
    };
    Some(Error::new(what, format!("{file}:1"), remedy))
}

/// Foreign names of the columns of a frame's identifier and its data.
const FRAMES: [&str; 2] = [
    "id, can id, canid, can_id, id (hex), identifier, arbitration_id, arb id",
    "data, data (hex), dlc, len, length, d0, d1, db0, data0, b1, byte0",
];

/// Foreign names of the columns of a signal's name and its value, in tables with a signal per row.
const LONG: [&str; 2] = [
    "signal, signalname, signal_name, signal name, name, variable, varname, channel, sensor, parameter, tag, \
     tagname, metric, _field, kanal, topic, series",
    "value, _value, varvalue, val, wert, valeur, valor, reading",
];

/// Number of characters of a cell, and of names of a header, that are shown.
pub(super) const SHOWN: usize = 40;

/// The names of a header.
pub(crate) fn listed(header: &[String]) -> String {
    let first = &header[..header.len().min(SHOWN)];
    let names = first.iter().map(|name| name.chars().take(SHOWN).collect());
    let more = match header.len() - first.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    names.collect::<Vec<String>>().join(", ") + &more
}

/// The error that none of these columns exists.
pub(crate) fn absent(names: &[&str], of: &str, header: &[String], file: &str) -> Error {
    if let Some(error) = misread(header, file) {
        return error;
    }
    let named = header.iter().filter(|name| !name.is_empty());
    let similar = config::nearest(names[0], named.map(String::as_str));
    let remedy = match similar {
        _ if header.len() < 2 => format!(
            "separate the columns by , ; | or tabs (by blanks only where names and cells have none), and delete what stands above their names, or mark it by #; the first line is {}",
            header.concat().chars().take(2 * SHOWN).collect::<String>()
        ),
        Some(name) => format!("rename column {name}, or name it in a signal map (--map)"),
        None => format!(
            "add the column, or name another in a signal map (--map; `heft map FILE` writes a first one{}); the file has {}",
            match names {
                ["t"] => ", and t = { column = \"row\", scale = 0.01 } there counts the rows of a table of 100 Hz".to_owned(),
                [one] => format!(", and {one} = \"none\" there says that the machine has no such sensor"),
                _ => String::new(),
            },
            listed(header)
        ),
    };
    let what = format!("there is no column {} ({of})", names.join(" or "));
    Error::new(what, format!("{file}:1"), remedy)
}

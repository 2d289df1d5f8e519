//! Exports of programs that describe their columns in a block of lines above the rows, each line with its name in the first cell.
//!
//! TwinCAT Scope writes the names, units and sample times of its channels so, and a column of times before each channel or before
//! those of one sample time. ControlDesk is named: its files have several such blocks.

use super::cells::Record;
use super::dialect::{self, Dialect};
use super::front::{Front, cells, lines};
use crate::Finding;

/// First cells of the lines that describe the channels of TwinCAT Scope.
const NAMES: &[u8] = b"Name";
const BEGIN: &[u8] = b"Starttime of export";
const COMMENTS: &[u8] = b"SymbolComment";
const STEPS: &[u8] = b"SampleTime[ms]";
const UNITS: &[u8] = b"Unit";

/// First cell of the rows of a recorder of ControlDesk.
const VALUES: &[u8] = b"trace_values";

/// Times above this are ticks of Windows, of 100 ns since 1601, and none in milliseconds: some 30 000 years.
const TICKS: f64 = 1e15;

/// The lines above the rows of such an export; none of other tables.
pub(super) fn front(head: &[u8]) -> Option<Result<Front, Finding>> {
    let begins = |line: &[u8], word: &[u8]| {
        let line = line.trim_ascii_start();
        line.strip_prefix(b"\"").unwrap_or(line).starts_with(word)
    };
    if lines(head, 0).any(|(_, line)| begins(line, VALUES)) {
        return Some(Err(Finding::new(
            "this is a recording of ControlDesk (dSPACE), with its names and values in blocks",
            "export it as MDF (.mf4) and convert that: pip install asammdf; or write a table of the block: its trace_names as the header, the rows from trace_values on below",
        )));
    }
    let has_begin = lines(head, 0).take(8).any(|(_, line)| begins(line, BEGIN));
    if !has_begin {
        return None;
    }
    let all: Vec<(usize, &[u8])> = lines(head, 0).collect();
    let names = all
        .windows(2)
        .position(|two| begins(two[0].1, NAMES) && begins(two[1].1, COMMENTS))?;
    let dialect = Dialect::of(all[names].1);
    let block = all[names..].iter().map(|(_, line)| cells(line, dialect));
    let block = block.take_while(|row| dialect.number(row.get(0).unwrap_or_default()).is_none());
    let block: Vec<Record> = block.collect();
    let row = all.get(names + block.len());
    let row = row.map(|(_, line)| cells(line, dialect));
    Some(
        scope(&block, row.as_ref(), dialect).map(|(names_of, units)| Front {
            start: all[names].0,
            dialect,
            units: Some(units),
            below: block.len() - 1,
            above: Vec::new(),
            has_row_names: false,
            names: Some(names_of),
        }),
    )
}

/// The names and units of the columns of TwinCAT Scope, by the lines that describe its channels and the first row.
fn scope(
    block: &[Record],
    row: Option<&Record>,
    dialect: Dialect,
) -> Result<(Vec<String>, Vec<String>), Finding> {
    let named = |name: &[u8]| block.iter().find(|row| row.get(0) == Some(name));
    let channels = block[0].iter();
    let is_time: Vec<bool> = channels.map(|cell| cell == NAMES).collect();
    let mut steps = named(STEPS)
        .into_iter()
        .flat_map(Record::iter)
        .filter_map(|cell| dialect.number(cell))
        .filter(|step| step.is_finite());
    let first = steps.next();
    if let Some(other) = steps.find(|step| Some(*step) != first) {
        return Err(Finding::new(
            format!(
                "the channels of this export of TwinCAT Scope have several sample times, {} and {other} ms among them: a row is of several times",
                first.unwrap_or_default()
            ),
            "export channels of one sample time; or make a table of one rate (pip install pytcs)",
        ));
    }
    let ticks = row
        .and_then(|row| dialect.number(row.get(0)?))
        .is_some_and(|time| time > TICKS);
    let unit_of_time = if ticks { "100ns" } else { "ms" };
    let names = block[0].iter().zip(&is_time).enumerate();
    let names = names.map(|(at, (cell, is_time))| match (is_time, at) {
        // All channels have the same times.
        (true, 0) => "Time".to_owned(),
        (true, _) => String::new(),
        (false, _) => dialect::name(cell),
    });
    let unit = |at: usize| {
        let text = named(UNITS).and_then(|row| row.get(at)).unwrap_or_default();
        let text = dialect::text(text);
        // `deg (Angle)`, or `(None)`.
        text.split('(').next().unwrap_or_default().trim().to_owned()
    };
    let units = is_time.iter().enumerate();
    let units = units.map(|(at, is_time)| match (is_time, at) {
        (true, 0) => unit_of_time.to_owned(),
        (true, _) => String::new(),
        (false, at) => unit(at),
    });
    Ok((names.collect(), units.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An export with these sample times, separator and first times.
    fn export(steps: [&str; 2], separator: &str, times: [&str; 2]) -> String {
        let line = |cells: &[&str]| cells.join(separator) + "\r\n";
        let of = |name, values: [&str; 2]| line(&[name, values[0], name, values[1]]);
        let mut text = line(&["Name", "Scope Project"]);
        text += &line(&[
            "Starttime of export",
            "133238090039920000",
            "Montag, 20. März 2023",
        ]);
        text += "\r\n\r\n";
        text += &of("Name", ["SwingVelocity", "SwingTorque"]);
        text += &of("SymbolComment", ["", ""]);
        text += &of("SampleTime[ms]", steps);
        text += &of("BitMask", ["0xff", "0xff"]);
        text += &of("Unit", ["deg/s (Rate)", "(None)"]);
        text += "\r\n";
        for time in times {
            text += &line(&[time, "0.5", time, "2"]);
        }
        text + "EOF\r\n"
    }

    #[test]
    fn the_channels_of_twincat_are_columns_with_one_time() {
        for (separator, times, unit) in [
            ("\t", ["0", "10"], "ms"),
            (";", ["0", "10"], "ms"),
            (",", ["133238090039920000", "133238090040020000"], "100ns"),
        ] {
            let text = export(["10", "10"], separator, times);
            let front = front(text.as_bytes()).expect("an export");
            let front = front.unwrap_or_else(|refusal| panic!("{refusal}"));
            let names = ["Time", "SwingVelocity", "", "SwingTorque"].map(str::to_owned);
            assert_eq!(front.names, Some(names.to_vec()), "{separator:?}");
            let units = [unit, "deg/s", "", ""].map(str::to_owned);
            assert_eq!(front.units, Some(units.to_vec()), "{separator:?}");
            let dir = tempfile::tempdir().expect("a folder");
            let (file, map) = (dir.path().join("x.csv"), dir.path().join("x.toml"));
            std::fs::write(&file, text).expect("writable");
            let said = crate::suggest(&file, &[], Some(messages::Machine::Excavator));
            std::fs::write(&map, said.expect("a map").text).expect("writable");
            let map = crate::Map::read(&map).expect("a map");
            let rows = crate::csv::read::<messages::ExcavatorSensors>(&file, Some(&map));
            let rows = rows.expect("rows");
            let [first, last] = [rows[0].0, rows[1].0];
            assert_eq!(rows.len(), 2);
            assert_eq!(first.swing_velocity, 0.5_f64.to_radians());
            assert!((last.stamp.time - first.stamp.time - 0.01).abs() < 1e-6);
        }
    }

    #[test]
    fn an_export_whose_rows_are_of_several_times_is_refused_by_its_name() {
        let text = export(["10", "2"], "\t", ["0", "10"]);
        let Finding { what, .. } = front(text.as_bytes())
            .expect("an export")
            .err()
            .expect("several times");
        assert!(what.contains("several sample times, 10 and 2 ms"), "{what}");
        let text = "trace_names,time,vel\nunit,s,rad/s\ntrace_values,0,1\n,0.01,1\n";
        let Finding { what, .. } = front(text.as_bytes())
            .expect("an export")
            .err()
            .expect("blocks");
        assert!(what.contains("ControlDesk"), "{what}");
        assert!(front(b"Name,Starttime\n0,1\n").is_none());
    }
}

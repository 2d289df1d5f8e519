//! Proposes a signal map for a file: columns and CAN signals are assigned by name, unit and range, each
//! line with its reason. Guesses are marked as such; missing signals are left to be filled in.

mod absolute;
mod guessed_unit;
mod languages;
mod log;
pub(crate) mod names;
pub(crate) mod ports;
mod sides;
mod sizes;
pub(crate) mod suggestion;
pub(crate) mod table;

use std::cmp::Reverse;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use messages::Machine;

use crate::reader::Reader;
use crate::signal::{self, Sensors};
use crate::topics::list;
use crate::{Error, Kind, Quoted, foreign, parts, steers};
pub use guessed_unit::STEEPEST;
use names::wanted;
pub use sizes::LARGEST_PRESSURES;
pub use suggestion::Suggestion;

/// A first map for the table, CAN log or foreign MCAP file `path`; a log needs its DBC files. Without
/// a machine, the one whose signals fit best.
///
/// # Errors
/// A file cannot be read, or is neither a table nor a log; or its names do not identify the machine.
pub fn suggest(
    path: &Path,
    dbc: &[PathBuf],
    machine: Option<Machine>,
) -> Result<Suggestion, Error> {
    if path.is_dir() && parts::recordings(path).is_empty() {
        return Err(of_folder(path));
    }
    let kind = Kind::of(path)?;
    if let Some(dbc) = dbc.first().filter(|_| kind != Kind::Log) {
        if kind == Kind::Table {
            // A table of frames has an error of its own.
            guess(Machine::ALL[0], path, &Foreign::Table)?;
        }
        return Err(Error::new(
            "a DBC file describes a CAN log, and this is none",
            path.display().to_string(),
            format!("leave out --dbc {}, or give the log", dbc.display()),
        ));
    }
    let file = match kind {
        Kind::Table => Foreign::Table,
        Kind::Log => Foreign::Log(dbc),
        Kind::Recording => {
            let reader = list::open(path)?;
            for lack in reader.lacks().all() {
                tracing::warn!("{lack}");
            }
            if reader.metadata().contains_key("heft.version") {
                return Err(Error::new(
                    "this is a recording of heft, which needs no signal map",
                    path.display().to_string(),
                    "give it as it is: heft estimate, loads, report, replay",
                ));
            }
            Foreign::Topics(Box::new(reader))
        }
    };
    let machines = machine.map_or(Machine::ALL.to_vec(), |machine| vec![machine]);
    let guesses = machines
        .into_iter()
        .map(|machine| guess(machine, path, &file));
    let mut guesses = guesses.collect::<Result<Vec<_>, _>>()?;
    guesses.sort_by_key(|guess| Reverse(guess.found));
    if let [first, second, ..] = &guesses[..]
        && first.found == second.found
    {
        let machines = Machine::ALL.map(|m| format!("--machine {m}")).join(" or ");
        return Err(Error::new(
            "the names in this file do not tell which machine it is of",
            path.display().to_string(),
            format!("give {machines}; the map lists what the file holds, to fill in by hand"),
        ));
    }
    Ok(guesses.swap_remove(0))
}

/// The error for a folder of tables or logs: a map belongs to one of them.
fn of_folder(path: &Path) -> Error {
    let files = path.read_dir().into_iter().flatten().flatten();
    let files = files.map(|entry| entry.path());
    let files = files.filter(|file| !file.is_dir() && Kind::by_name(file).is_some());
    let remedy = match files.min() {
        Some(first) => format!(
            "give one of its files: heft map {}",
            Quoted(first.display())
        ),
        None => match foreign(path) {
            Some(error) => return error,
            None => "give a table (.csv), a CAN log (.log) or an MCAP file".to_owned(),
        },
    };
    Error::new(
        "a map is of one file, and this is a folder",
        path.display().to_string(),
        remedy,
    )
}

/// Kind of a file that heft did not write.
enum Foreign<'a> {
    Table,
    /// A CAN log with its DBC files.
    Log(&'a [PathBuf]),
    Topics(Box<Reader>),
}

macro_rules! guesses {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// A map for a machine.
        fn guess(machine: Machine, path: &Path, file: &Foreign) -> Result<Suggestion, Error> {
            match (machine, file) {
                $( (Machine::$machine, Foreign::Table) => table::suggest::<messages::$sensors>(path),
                (Machine::$machine, Foreign::Log(dbc)) => log::suggest::<messages::$sensors>(path, dbc),
                (Machine::$machine, Foreign::Topics(reader)) => Ok(list::map::<messages::$sensors>(path, reader)), )*
            }
        }
    };
}

messages::machines!(guesses);

/// A text within a comment: characters that could end the comment, or are not allowed in one, are replaced.
fn shown(text: &str) -> String {
    text.replace(steers, "\u{fffd}")
}

/// The first lines of a map: purpose and use.
fn opening<S: Sensors>(path: &Path) -> String {
    let (file, machine) = (shown(&path.display().to_string()), S::MACHINE);
    format!(
        "# A first signal map of {file} for the {machine}, guessed: read every line.\n# Then: heft estimate {} --machine {machine} --map THIS_FILE -o out.csv\n",
        Quoted(&file)
    )
}

/// The missing signals: lines to be filled in for the required ones, with the text of `blank` after each name, and the rest by name.
fn lacking<S: Sensors>(
    found: &[String],
    missing: &[&[&str]],
    mut blank: impl FnMut(&str) -> String,
) -> String {
    let mut out = String::new();
    for group in missing {
        let one = if group.len() > 1 {
            "one of these is "
        } else {
            ""
        };
        for signal in *group {
            let _ = writeln!(
                out,
                "# {signal} = {}  # {one}needed, and nothing fits by its name",
                blank(signal)
            );
        }
    }
    let is_required = |signal: &str| S::REQUIRED.iter().any(|group| group.contains(&signal));
    let more = wanted::<S>().into_iter();
    let more = more.filter(|s| s != "t" && !found.contains(s) && !is_required(s));
    let more = more.map(|s| match unit_of::<S>(&s) {
        "" => s,
        unit => format!("{s} [{unit}]"),
    });
    let more: Vec<String> = more.collect();
    if !more.is_empty() {
        let more = more.join(", ");
        let _ = writeln!(
            out,
            "# Nothing fits these by its name, and each that is measured helps: {more}"
        );
    }
    out
}

/// Unit of a signal.
fn unit_of<S: Sensors>(name: &str) -> &'static str {
    let signals = signal::signals::<S>();
    signals
        .iter()
        .find(|s| s.name == name)
        .map_or("", |s| s.unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_and_the_contents_of_a_bag_are_named_with_the_file_to_give() {
        let dir = tempfile::tempdir().expect("a folder");
        let said = |path: &Path| {
            suggest(path, &[], None)
                .err()
                .map_or(String::new(), |e| e.to_string())
        };
        assert!(said(dir.path()).contains("give a table (.csv)"));
        let table = dir.path().join("day.csv");
        std::fs::write(&table, "t,speed\n0,1\n").expect("writable");
        assert!(said(dir.path()).contains(&format!("heft map {}", table.display())));
        let bag = dir.path().join("metadata.yaml");
        std::fs::write(&bag, "rosbag2_bagfile_information:\n  version: 5\n").expect("writable");
        std::fs::remove_file(&table).expect("removable");
        let of_bag = said(dir.path());
        assert!(
            of_bag.contains("contents of a bag of ROS 2") && of_bag.contains("rosbags-convert"),
            "{of_bag}"
        );
        assert!(
            said(&bag).contains(".mcap file beside it"),
            "{}",
            said(&bag)
        );
    }

    #[test]
    fn names_of_groups_above_those_of_columns_count_where_these_do_not_tell() {
        let dir = tempfile::tempdir().expect("a folder");
        let file = dir.path().join("x.csv");
        let groups = "Time,Swing,,Front,,\n[s],Rate [deg/s],Torque [kNm],Boom [deg],Arm [deg],Bucket [deg]\n";
        let text = format!("{groups}0,1,2,3,4,5\n1,1,2,3,4,5\n");
        std::fs::write(&file, text).expect("writable");
        let said = suggest(&file, &[], Some(Machine::Excavator)).expect("a table");
        assert!(said.missing.is_empty(), "{}", said.text);
        let line = "swing_velocity = { column = \"Rate [deg/s]\", unit = \"deg/s\" }";
        assert!(said.text.contains(line), "{}", said.text);
        assert!(said.text.contains("t = \"[s]\""), "{}", said.text);
    }

    #[test]
    fn names_that_repeat_below_groups_are_distinguished_by_them_in_the_map_and_in_the_rows() {
        let dir = tempfile::tempdir().expect("a folder");
        let file = dir.path().join("x.csv");
        let names = ";Swing;;Front;;;Boom cylinder;;Arm cylinder;\n\
                     Time;Speed;Torque;Boom;Arm;Bucket;Head;Rod;Head;Rod\n\
                     [s];[deg/s];[kNm];[deg];[deg];[deg];[bar];[bar];[bar];[bar]\n";
        let rows = "0;1;2;3;4;5;60;7;8;9\n1;1;2;3;4;5;60;7;8;9\n";
        std::fs::write(&file, format!("{names}{rows}")).expect("writable");
        let said = suggest(&file, &[], Some(Machine::Excavator)).expect("a table");
        assert!(said.missing.is_empty(), "{}", said.text);
        let line = "arm_head_pressure = { column = \"Arm cylinder Head\", unit = \"bar\" }";
        assert!(said.text.contains(line), "{}", said.text);
        let map = dir.path().join("x.toml");
        std::fs::write(&map, said.text).expect("writable");
        let map = crate::Map::read(&map).expect("a map");
        let rows = crate::csv::read::<messages::ExcavatorSensors>(&file, Some(&map));
        let first = rows.expect("rows")[0].0;
        assert_eq!(
            [first.boom_head_pressure, first.arm_head_pressure],
            [60e5, 8e5]
        );
    }

    #[test]
    fn what_no_name_fits_is_offered_by_its_unit_and_a_motor_by_its_ports() {
        let dir = tempfile::tempdir().expect("a folder");
        let file = dir.path().join("x.csv");
        let names =
            "t,Rotation moteur [rpm] max,Channel 3 [deg/s],Swing motor A [bar],Swing motor B [bar]";
        std::fs::write(&file, format!("{names}\n0,1,2,3,4\n1,1,2,3,4\n")).expect("writable");
        let text = suggest(&file, &[], Some(Machine::Excavator))
            .expect("a table")
            .text;
        let line = "# swing_velocity = { column = \"Channel 3 [deg/s]\", unit = \"deg/s\" }  # one of these is needed";
        assert!(text.contains(line), "{text}");
        let line = "# swing_torque = { terms = [{ column = \"Swing motor A [bar]\", unit = \"bar\" }, \
                    { column = \"Swing motor B [bar]\", unit = \"bar\", sign = -1 }], scale = SCALE }";
        assert!(text.contains(line), "{text}");
    }

    #[test]
    fn a_column_in_a_unit_of_the_signal_comes_before_one_whose_name_alone_fits() {
        let dir = tempfile::tempdir().expect("a folder");
        let file = dir.path().join("x.csv");
        let map = |names: &str| {
            std::fs::write(&file, format!("t,{names}\n0,1,2\n")).expect("writable");
            let found = suggest(&file, &[], Some(Machine::Loader)).expect("a table");
            found.text
        };
        let text = map("Antriebsmoment VA [kNm],Raddrehzahl vorne [1/min]");
        for line in [
            "front_torque = { column = \"Antriebsmoment VA [kNm]\", unit = \"kNm\" }",
            "\nfront_wheel_speed = { column = \"Raddrehzahl vorne [1/min]\", unit = \"rpm\" }",
        ] {
            assert!(text.contains(line), "{text}");
        }
        let text = map("Channel 3 [kNm],Channel 4 [kNm]");
        for line in [
            "# front_torque = { column = \"Channel 3 [kNm]\"",
            "# rear_torque = { column = \"Channel 4 [kNm]\"",
        ] {
            assert!(text.contains(line), "{text}");
        }
    }

    #[test]
    fn pressures_without_a_unit_have_the_one_of_their_largest() {
        let dir = tempfile::tempdir().expect("a folder");
        let file = dir.path().join("x.csv");
        let map = |units: &str, largest: f64| {
            let head = "t,swing rate,swing torque,boom,boom head,boom rod,arm rod";
            let row = |t: i32| format!("{t},0.1,9500,0.5,{largest},{},{}\n", largest / 9.0, 0.0);
            let rows: String = (0..200).map(row).collect();
            std::fs::write(&file, format!("{head}\n{units}{rows}")).expect("writable");
            let found = suggest(&file, &[], Some(Machine::Excavator)).expect("a table");
            crate::Map::parse(&found.text, "m.toml").expect("a map");
            found.text
        };
        for (largest, unit) in [
            (210.0, "bar"),
            (21.0, "MPa"),
            (3046.0, "psi"),
            (21e3, "kPa"),
        ] {
            for name in ["boom_head", "boom_rod", "arm_rod"] {
                let column = name.replace('_', " ");
                let line =
                    format!("{name}_pressure = {{ column = \"{column}\", unit = \"{unit}\" }}");
                let text = map("", largest);
                assert!(text.contains(&line), "{line}: {text}");
            }
        }
        assert!(map("", 21e6).contains("boom_head_pressure = \"boom head\""));
        let told = map("s,rad/s,Nm,rad,psi,psi,psi\n", 210.0);
        let line = "boom_head_pressure = { column = \"boom head\", unit = \"psi\" }";
        assert!(told.contains(line), "{told}");
    }

    #[test]
    fn small_angles_without_a_unit_have_that_of_the_large_ones() {
        let dir = tempfile::tempdir().expect("a folder");
        let file = dir.path().join("x.csv");
        let map = |boom: f64, head: &str| {
            let row = |t: i32| format!("{t},0.1,{boom},0.5,0.01\n");
            let rows: String = (0..200).map(row).collect();
            std::fs::write(&file, format!("t,swing rate,boom,pitch,{head}\n{rows}"))
                .expect("writable");
            suggest(&file, &[], Some(Machine::Excavator))
                .expect("a table")
                .text
        };
        let text = map(35.0, "roll");
        for line in [
            "pitch = { column = \"pitch\", unit = \"deg\" }",
            "roll = { column = \"roll\", unit = \"deg\" }",
        ] {
            assert!(text.contains(line), "{line}: {text}");
        }
        let text = map(0.6, "roll");
        assert!(text.contains("\npitch = \"pitch\""), "{text}");
        let text = map(35.0, "roll [rad]");
        assert!(text.contains("\nroll = \"roll [rad]\""), "{text}");
    }

    #[test]
    fn a_link_that_is_missing_and_a_column_of_another_unit_are_reported() {
        let dir = tempfile::tempdir().expect("a folder");
        let of = |header: &str| {
            let file = dir.path().join("x.csv");
            std::fs::write(&file, format!("{header}\n0,1,2,3\n")).expect("writable");
            suggest(&file, &[], Some(Machine::Excavator)).expect("a table")
        };
        let said = of("t,swing_rate,boom,Swing torque [%]");
        assert_eq!(said.links, ["arm_angle", "bucket_angle"]);
        assert_eq!(
            said.of_others,
            ["swing_torque (\"Swing torque [%]\", in %)"]
        );
        assert!(of("t,swing_rate,x,y").links.is_empty());
    }

    #[test]
    fn names_of_any_kind_make_a_map_that_is_read() {
        let dir = tempfile::tempdir().expect("a folder");
        let file = dir.path().join("x.csv");
        let names = ["slope \"\\\n\0\u{7f}[rad]", "b\r\nrate = 1"];
        let header = names.map(|n| format!("\"{}\"", n.replace('"', "\"\"")));
        let text = format!("t,{}\n0,1,2\n", header.join(","));
        std::fs::write(&file, text).expect("writable");
        let text = suggest(&file, &[], Some(Machine::Loader))
            .expect("a table")
            .text;
        let map = crate::Map::parse(&text, "m.toml").expect("a map");
        let slope = map.columns.iter().find(|e| e.signal == "slope");
        let origin = slope.map(|e| &e.terms[0].origin);
        let expected = crate::map::Origin::Column(names[0].into());
        assert_eq!(origin, Some(&expected), "{text}");
        assert!(!map.has_can(), "{text}");
    }

    #[test]
    fn names_that_speak_tell_the_machine_and_opaque_ones_do_not() {
        let dir = tempfile::tempdir().expect("a folder");
        let file = dir.path().join("x.csv");
        let of = |header: &str| {
            std::fs::write(&file, format!("{header}\n0,1,2\n")).expect("writable");
            suggest(&file, &[], None).map(|suggestion| suggestion.text)
        };
        for opaque in ["ch1,ch2,ch3", "t,ch2,ch3", "Time [s],A,B", "t,truck,x"] {
            let error = of(opaque).expect_err("no machine").to_string();
            assert!(error.contains("do not tell which machine"), "{error}");
            assert!(error.contains("--machine excavator or"), "{error}");
        }
        for (speaking, machine) in [("t,swing_rate,x", "excavator"), ("t,speed,x", "loader")] {
            let text = of(speaking).expect("a machine");
            assert!(text.contains(&format!("for the {machine},")), "{text}");
        }
    }

    #[test]
    fn what_is_no_unit_is_reported_with_its_column_and_a_ton_with_its_size() {
        let dir = tempfile::tempdir().expect("a folder");
        let of = |header: &str| {
            let file = dir.path().join("x.csv");
            std::fs::write(&file, format!("{header}\n0,1,2\n")).expect("writable");
            suggest(&file, &[], Some(Machine::Loader)).expect("a table")
        };
        let said = of("t [s],speed [furlong/h],mass [ton]");
        assert_eq!(said.unknown, ["furlong/h (column \"speed [furlong/h]\")"]);
        assert!(said.text.contains("2000 lb is unit = \"short ton\""));
        assert!(of("t,speed [mph],mass [tonne]").unknown.is_empty());
        let said = of("t,front_wheel_speed [1/s],rear_wheel_speed [rad/s]");
        assert_eq!(
            said.of_second,
            ["front_wheel_speed (column \"front_wheel_speed [1/s]\")"]
        );
    }

    #[test]
    fn what_nothing_fits_is_named_and_asked_for_only_where_the_machine_needs_it() {
        let dir = tempfile::tempdir().expect("a folder");
        let of = |header: &str, machine| {
            let file = dir.path().join("x.csv");
            std::fs::write(&file, format!("{header}\n0,1,2\n")).expect("writable");
            suggest(&file, &[], Some(machine)).expect("a table")
        };
        let Suggestion { text, missing, .. } = of("t,swing_rate,p_motor", Machine::Excavator);
        assert!(missing.is_empty(), "{missing:?}");
        assert!(!text.contains("swing_angle"), "the rate will do: {text}");
        assert!(
            text.contains("helps: swing_torque [N m], boom_angle [rad]"),
            "{text}"
        );
        let Suggestion { text, missing, .. } = of("x,y,z", Machine::Excavator);
        assert_eq!(missing, [&["t"][..], &["swing_velocity", "swing_angle"]]);
        for signal in ["swing_velocity", "swing_angle"] {
            let line = format!("# {signal} = \"...\"  # one of these is needed");
            assert!(text.contains(&line), "{text}");
        }
        let Suggestion { text, missing, .. } = of("t,speed,slope", Machine::Loader);
        assert!(missing.contains(&&["front_torque"][..]), "{missing:?}");
        assert!(
            text.contains("# front_torque = \"...\"  # needed"),
            "{text}"
        );
        assert!(!text.contains("# slope"), "{text}");
    }
}

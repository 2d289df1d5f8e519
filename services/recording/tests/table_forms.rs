//! Tables in the forms of independent programs are read correctly.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use messages::{ExcavatorSensors, LoaderSensors, loader_bits};
use recording::{Error, LineDecoder, Map, csv};

const HEADER: &str = "t,swing_velocity,swing_torque";

fn rows() -> Vec<String> {
    (0..400)
        .map(|i| {
            format!(
                "{},{},{}",
                0.01 * f64::from(i),
                0.001 * f64::from(i),
                10 * i
            )
        })
        .collect()
}

fn written(folder: &Path, name: &str, content: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, content).expect("written");
    path
}

fn read(path: &Path) -> Result<Vec<f64>, Error> {
    let samples = recording::load::<ExcavatorSensors>(path, None)?;
    Ok(samples.iter().map(|(s, _)| s.swing_torque).collect())
}

fn packed(text: impl AsRef<[u8]>) -> Vec<u8> {
    let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    out.write_all(text.as_ref()).expect("memory");
    out.finish().expect("memory")
}

#[test]
fn a_table_gives_the_same_rows_packed_with_comments_and_with_units() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = rows().join("\n");
    let plain = format!("{HEADER}\n{rows}\n");
    let expected = read(&written(folder.path(), "a.csv", plain.as_bytes())).expect("rows");
    assert_eq!(expected.len(), 400);
    let tabs = plain.replace(',', "\t");
    let numpy = format!("# {plain}");
    let units = format!("# by a logger\n{HEADER}\ns,rad/s,N m\n{rows}\n");
    for (name, content) in [
        ("a.csv.gz", packed(&plain)),
        (
            "two.gz",
            [packed(&plain[..100]), packed(&plain[100..])].concat(),
        ),
        ("a.tsv", tabs.into_bytes()),
        ("export", plain.clone().into_bytes()),
        ("numpy.txt", numpy.into_bytes()),
        ("units.dat", units.into_bytes()),
    ] {
        let found = read(&written(folder.path(), name, &content));
        assert_eq!(found.as_ref().ok(), Some(&expected), "{name}: {found:?}");
    }
}

/// The torques of a table that is read line by line, as from standard input and live sources.
fn lines(text: &str) -> Result<Vec<f64>, Error> {
    let mut decoder = LineDecoder::<ExcavatorSensors>::new(None)?;
    let mut found = Vec::new();
    for line in text.split_inclusive('\n') {
        decoder.take(line.as_bytes(), 0)?;
        found.extend(std::iter::from_fn(|| decoder.row()).map(|(s, _)| s.swing_torque));
    }
    decoder.check_header()?;
    assert!(decoder.take_remarks().is_empty(), "no line is left out");
    decoder.finish();
    found.extend(std::iter::from_fn(|| decoder.row()).map(|(s, _)| s.swing_torque));
    Ok(found)
}

#[test]
fn lines_that_come_one_by_one_are_read_as_a_file_of_them_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = rows().join("\n");
    let plain = format!("{HEADER}\n{rows}\n");
    for text in [
        plain.clone(),
        format!("\u{feff}# machine 14 t\n\n// by a logger, v3\n{plain}"),
        format!("sep=;\n{}", plain.replace(',', ";")),
        format!("# a, b\n# {plain}"),
        format!("% {HEADER}\n{HEADER}\n\n[s],[rad/s],[N m]\n{rows}\n"),
    ] {
        let expected = read(&written(folder.path(), "a.csv", text.as_bytes())).expect("a file");
        assert_eq!(expected.len(), 400);
        assert_eq!(lines(&text), Ok(expected), "{}", &text[..60]);
    }
    for (text, what) in [
        (format!("{HEADER}\ns,deg/s,N m\n"), "is in deg/s"),
        ("0,1,2\n".into(), "has no header"),
    ] {
        let error = lines(&text).expect_err(what);
        assert!(error.what.contains(what), "{error}");
        assert!(error.place.starts_with("standard input"), "{error}");
    }
    let mut decoder = LineDecoder::<ExcavatorSensors>::new(None).expect("a decoder");
    let error = decoder.take(&packed(&plain), 0).expect_err("packed");
    assert!(error.remedy.contains("zcat"), "{error}");
}

#[test]
fn words_and_groups_above_the_names_are_no_header_as_they_come() {
    let table = format!("{HEADER}\n{}\n", rows().join("\n"));
    let expected = lines(&table).expect("rows");
    let units = table.replacen('\n', "\ns,rad/s,N m\n", 1);
    for above in ["Logger;12\nSite;North\n\n", "Made on day 3\n", "x,Swing,\n"] {
        for table in [&table, &units] {
            let found = lines(&format!("{above}{table}")).expect("rows");
            assert_eq!(found, expected, "{above}");
        }
    }
    for wrong in ["t,speed\n0,1\n".to_owned(), "t,speed\n".repeat(200)] {
        let error = lines(&wrong).expect_err("no signal");
        assert!(error.what.contains("no column swing_velocity"), "{error}");
    }
}

#[test]
fn a_unit_below_a_name_that_is_not_si_is_refused_and_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = format!("{HEADER}\ns,deg/s,N m\n0,1,2\n");
    let error = read(&written(folder.path(), "a.csv", text.as_bytes())).expect_err("degrees");
    assert!(error.what.contains("swing_velocity is in deg/s"), "{error}");
    assert!(error.place.ends_with(":2"), "{error}");
    assert!(error.remedy.contains("heft map"), "{error}");
}

#[test]
fn what_is_no_table_is_named_as_what_it_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let plain = format!("{HEADER}\n{}\n", rows().join("\n"));
    let mut tar = b"data.csv".to_vec();
    tar.resize(257, 0);
    tar.extend(b"ustar\0");
    tar.extend(plain.bytes());
    // A changed byte makes rows that are none.
    let mut torn = packed(&plain);
    let middle = torn.len() / 2;
    torn[middle] ^= 0xff;
    for (content, what, remedy) in [
        (b"t\0\x01\x02;\0\xff\n1;2\n".to_vec(), "no text", ".csv"),
        (b"\x28\xb5\x2f\xfdxx".to_vec(), "packed by zstd", "zstd -d"),
        (b"BZh91AY".to_vec(), "packed by bzip2", "bunzip2"),
        (
            b"time;Signal;Value\n0;swing_velocity;0.1\n".to_vec(),
            "a row for each value",
            "pivot",
        ),
        // Time and swing speed in the encoding GB18030.
        (
            b"\xca\xb1\xbc\xe4,\xbb\xd8\xd7\xaa\xcb\xd9\xb6\xc8\n0,1\n".to_vec(),
            "another encoding",
            "iconv -f GB18030",
        ),
        (b"\xfd7zXZ\0".to_vec(), "packed by xz", "unxz"),
        (tar.clone(), "a tar archive", "tar -xf"),
        (packed(&tar), "a packed tar archive", "tar -xf"),
        (b"CDF\x01\0\0".to_vec(), "a netCDF file", "Python"),
        (torn, "corrupt", "get the file anew"),
        (
            format!("# {}\n{plain}", "x".repeat(400_000)).into_bytes(),
            "does not begin with a table",
            "header",
        ),
        (
            [packed(&plain), b"more than that follows".to_vec()].concat(),
            "invalid gzip header",
            "get the file anew",
        ),
    ] {
        let error = read(&written(folder.path(), "a.csv", &content)).expect_err(what);
        assert!(error.what.contains(what), "{error}");
        assert!(error.remedy.contains(remedy), "{error}");
    }
}

#[test]
fn a_packed_table_that_was_cut_gives_the_rows_before_the_cut_and_reports_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = packed(format!("{HEADER}\n{}\n", rows().join("\n")));
    let path = written(folder.path(), "cut.csv.gz", &whole[..whole.len() / 2]);
    let samples = recording::open::<ExcavatorSensors>(&path, None).expect("a table");
    let count = samples.rows().expect("rows").count();
    samples.check().expect("no error");
    assert!((10..400).contains(&count), "{count}");
    let said = samples.lacks().cut_off.unwrap_or_default();
    assert!(said.contains("cut off"), "{said}");
    let map = recording::suggest(&path, &[], None).expect("a map").text;
    assert!(map.contains("swing_velocity = "), "{map}");
}

#[test]
fn numbers_without_names_and_words_of_missing_samples() {
    let folder = tempfile::tempdir().expect("a folder");
    let error = read(&written(folder.path(), "a.csv", b"0,1,2\n1,2,3\n")).expect_err("no header");
    assert!(error.what.contains("no header"), "{error}");
    let text = format!("{HEADER}\n0,1,NA\n0.01, \"1\" ,n/a\n0.02,1,5\n");
    let path = written(folder.path(), "b.csv", text.as_bytes());
    let rows = csv::read::<ExcavatorSensors>(&path, None).expect("rows");
    assert_eq!(rows.len(), 3);
}

/// Map and times of the rows of a table whose column `when` is the time.
fn timed(when: &str, times: &[&str]) -> (String, Vec<f64>) {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = times.iter().map(|time| format!("{time};0,1\n"));
    let table = format!("{when};Swing rate\n{}", rows.collect::<String>());
    let path = written(folder.path(), "a.csv", table.as_bytes());
    let machine = Some(messages::Machine::Excavator);
    let text = recording::suggest(&path, &[], machine).expect("a map").text;
    let map = recording::Map::parse(&text, "a.toml").expect("a map");
    let samples = recording::load::<ExcavatorSensors>(&path, Some(&map)).expect("rows");
    (text, samples.iter().map(|(s, _)| s.stamp.time).collect())
}

#[test]
fn serial_dates_of_a_sheet_and_times_of_day_are_times() {
    let (map, days) = timed(
        "Date",
        &["46110,5", "46110,50000023148", "46110,50000046296"],
    );
    assert!(map.contains("unit = \"day\""), "{map}");
    for (day, seconds) in days.iter().zip([0.0, 0.02, 0.04]) {
        assert!((day - days[0] - seconds).abs() < 1e-4, "{days:?}");
    }
    let (_, clock) = timed("Time", &["11:59:59.99 AM", "12:00:00.01 PM"]);
    assert!((clock[1] - clock[0] - 0.02).abs() < 1e-9, "{clock:?}");
}

/// What a table of these lines lacks, or the error that refuses it.
fn lacks(lines: &str, map: Option<&str>) -> Result<recording::Lacks, Error> {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("day.csv");
    std::fs::write(&path, lines).expect("writable");
    let map = map.map(|text| Map::parse(text, "map.toml").expect("a map"));
    let samples = recording::open::<ExcavatorSensors>(&path, map.as_ref())?;
    samples.rows()?.for_each(drop);
    samples.check()?;
    Ok(samples.lacks())
}

#[test]
fn a_column_without_a_value_is_named_and_refused_where_nothing_else_measures_the_motion() {
    let error = lacks("t,swing_velocity,swing_torque\n0,,1\n1,,2\n", None).expect_err("empty");
    assert!(
        error
            .what
            .contains("column swing_velocity holds no value in any row"),
        "{error}"
    );
    let said = lacks("t,swing_velocity,swing_torque\n0,1,\n1,2,NaN\n", None).expect("rows");
    assert_eq!(
        said.empty,
        ["column swing_torque holds no value in any row; it counts as absent"]
    );
    let map = "[columns]\nt = \"t\"\nswing_velocity = \"w\"\nswing_torque = \"trq\"\n";
    let said = lacks("t,w,trq,swing_angle\n0,1,,\n1,2,,0\n", Some(map)).expect("rows");
    assert_eq!(said.empty.len(), 1, "{said:?}");
    assert!(
        said.empty[0].starts_with("column trq (swing_torque)"),
        "{said:?}"
    );
}

#[test]
fn a_column_in_a_unit_of_something_else_is_no_signal() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("day.csv");
    std::fs::write(&path, "t,Swing speed [mph],Torque [kNm]\n0,1,2\n1,1,2\n").expect("writable");
    let machine = Some(messages::Machine::Excavator);
    let map = recording::suggest(&path, &[], machine).expect("a map");
    assert!(
        map.text.contains(
            "# swing_velocity = \"Swing speed [mph]\"  # its unit is mph, which is none of rad/s"
        ),
        "{}",
        map.text
    );
    assert_eq!(map.missing, [["swing_velocity", "swing_angle"]]);
    // A DBC file does not apply to a table, and is not ignored silently.
    let error = recording::suggest(&path, &["x.dbc".into()], machine).expect_err("no log");
    assert!(error.remedy.contains("leave out --dbc x.dbc"), "{error}");
}

#[test]
fn frames_that_a_dbc_file_does_not_fit_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let dbc = "BO_ 256 Swing: 8 X\n SG_ rate : 0|16@1- (0.001,0) [0|0] \"rad/s\" X\n";
    let dbc = written(folder.path(), "x.dbc", dbc.as_bytes());
    let of = |name: &str, text: &str| {
        let path = written(folder.path(), name, text.as_bytes());
        recording::suggest(&path, std::slice::from_ref(&dbc), None).expect_err("no map")
    };
    let table = "Time,Channel,ID,Flags,DLC,Data\n0.01,0,256,,2,01 02\n";
    assert!(of("a.csv", table).what.contains("a table of CAN frames"));
    let error = of("a.log", "(1.000000) can0 00000100#E803\n");
    assert!(error.remedy.ends_with("the log has 00000100"), "{error}");
}

#[test]
fn ticks_of_a_register_that_was_full_are_times() {
    let folder = tempfile::tempdir().expect("a folder");
    let ticks = ["65506", "65516", "65526", "0", "10", "20"];
    let rows: Vec<String> = ticks.iter().map(|tick| format!("{tick},1")).collect();
    let text = format!("ms,swing_velocity\n{}\n", rows.join("\n"));
    let path = written(folder.path(), "ticks.csv", text.as_bytes());
    let map = "[columns]\nt = { column = \"ms\", unit = \"ms\" }\n";
    let map = recording::Map::parse(map, "m.toml").expect("a map");
    let rows = csv::read::<ExcavatorSensors>(&path, Some(&map)).expect("rows");
    let times: Vec<f64> = rows.iter().map(|(sample, _)| sample.stamp.time).collect();
    assert_eq!(times, [65.506, 65.516, 65.526, 65.536, 65.546, 65.556]);
}

#[test]
fn names_of_rows_as_r_writes_them_are_no_column_or_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let table = |header: &str, separator: &str, quote: &str| {
        let named = |(i, row): (usize, &String)| format!("{quote}{}{quote},{row}\n", i + 1);
        let rows: String = rows().iter().enumerate().map(named).collect();
        let text = format!("{header}\n{rows}").replace(',', separator);
        read(&written(folder.path(), "r.txt", text.as_bytes()))
    };
    let quoted = "\"t\",\"swing_velocity\",\"swing_torque\"";
    for separator in [" ", "\t", ",", ";"] {
        let found = table(quoted, separator, "\"");
        let torques = found.as_ref().map(|torques| (torques.len(), torques[3]));
        assert_eq!(torques.ok(), Some((400, 30.0)), "{separator:?}: {found:?}");
        // A number without quotes may belong to a column without a name.
        let error = table(HEADER, separator, "").expect_err("a name is missing");
        let error = error.to_string();
        assert!(
            error.contains("the row has 4 cells, the header 3"),
            "{error}"
        );
        assert!(error.contains("name every column"), "{error}");
    }
}

#[test]
fn a_table_of_two_machines_is_no_recording_of_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let of = |second: &str| {
        let named = |(i, row): (usize, String)| {
            let name = if i % 2 == 0 { "EX1" } else { second };
            format!("{name},{row}\n")
        };
        let rows: String = rows().into_iter().enumerate().map(named).collect();
        let text = format!("machine,{HEADER}\n{rows}");
        read(&written(folder.path(), "two.csv", text.as_bytes()))
    };
    assert_eq!(of("EX1").expect("one machine").len(), 400);
    let mut decoder = LineDecoder::<ExcavatorSensors>::new(None).expect("a decoder");
    for line in [
        "machine,t,swing_velocity",
        "EX1,0,0",
        "EX2,0.01,0",
        "EX1,0.02,0",
    ] {
        decoder.take(line.as_bytes(), 0).expect("a line");
    }
    let remarks = decoder.take_remarks();
    assert!(
        remarks.len() == 1 && remarks[0].contains("of machine EX2"),
        "{remarks:?}"
    );
    let error = of("EX2").expect_err("two machines").to_string();
    assert!(error.contains("two.csv:3"), "{error}");
    assert!(
        error.contains("machine EX2") && error.contains("heft serve"),
        "{error}"
    );
}

#[test]
fn two_machines_in_turn_are_named_whatever_the_column_is_called() {
    let folder = tempfile::tempdir().expect("a folder");
    let of = |other: f64, name: &str| {
        let row = |i: u32| {
            let (time, is_second) = (0.005 * f64::from(i), i % 2 == 1);
            let level = if is_second { other } else { 0.0 };
            let name = if is_second { name } else { "EX1" };
            format!("{time},{},{},{name}\n", level + 0.001 * time, level + time)
        };
        let text = format!("{HEADER},Asset\n{}", (0..800).map(row).collect::<String>());
        read(&written(folder.path(), "two.csv", text.as_bytes()))
    };
    let error = of(0.5, "EX2").expect_err("two machines").to_string();
    assert!(
        error.contains("by the column Asset: EX1, EX2") && error.contains("heft serve"),
        "{error}"
    );
    assert_eq!(of(0.5, "EX1").map(|rows| rows.len()).ok(), Some(800));
    assert_eq!(of(0.0, "EX2").map(|rows| rows.len()).ok(), Some(800));
}

#[test]
fn what_nobody_sees_and_rows_of_nothing_change_no_table() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = rows();
    let (first, second) = rows.split_at(200);
    let (first, second) = (first.join("\n"), second.join("\n"));
    let plain = format!("{HEADER}\n{first}\n{second}\n");
    let expected = read(&written(folder.path(), "a.csv", plain.as_bytes())).expect("rows");
    let bar = "+---------+----------+---------+";
    for (name, content) in [
        (
            "joined.csv",
            format!("\u{feff}{HEADER}\n{first}\n\u{feff}{second}\n"),
        ),
        (
            "unseen.csv",
            format!("\u{200b}t,swing_\u{ad}velocity,\u{200f}swing_torque\n{first}\n{second}\n"),
        ),
        ("filled.csv", format!("{plain}{}", ",,\n".repeat(500))),
        (
            "first.csv",
            format!("{HEADER}\n{}{first}\n{second}\n", ",,\n".repeat(50)),
        ),
        (
            "kinds.csv",
            format!("{HEADER}\ndouble,double,double\n{first}\n{second}\n"),
        ),
        (
            "toa5.csv",
            format!("{HEADER}\ns,rad/s,N m\n,Smp,Smp\n{first}\n{second}\n"),
        ),
        (
            "database.csv",
            format!("{bar}\n{HEADER}\n{bar}\n{first}\n{second}\n{bar}\n").replace(',', "|"),
        ),
    ] {
        let found = read(&written(folder.path(), name, content.as_bytes()));
        let found = found.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(found, expected, "{name}");
    }
}

#[test]
fn a_switch_may_be_a_word_and_nothing_else_may() {
    let folder = tempfile::tempdir().expect("a folder");
    let table = |brakes: [&str; 3], map: Option<&str>| {
        let row = |(k, brake): (usize, &str)| format!("{k},0.5,1,1,10,10,0,{brake}\n");
        let rows: String = brakes.into_iter().enumerate().map(row).collect();
        let head =
            "t,speed,front_wheel_speed,rear_wheel_speed,front_torque,rear_torque,slope,brake\n";
        let path = written(folder.path(), "a.csv", format!("{head}{rows}").as_bytes());
        let map = map.map(|text| Map::parse(text, "map.toml").expect("a map"));
        let rows = recording::load::<LoaderSensors>(path, map.as_ref())?;
        let is_on = |(s, _): &(LoaderSensors, _)| s.valid & loader_bits::BRAKE != 0;
        Ok::<_, Error>(rows.iter().map(is_on).collect::<Vec<_>>())
    };
    for brakes in [
        ["0", "1", "0"],
        ["False", "True", "FALSE"],
        ["off", "ON", "Off"],
        ["aus", "ein", "nein"],
        ["non", "oui", ""],
    ] {
        let said = table(brakes, None).expect("rows");
        assert_eq!(said, [false, true, false], "{brakes:?}");
    }
    let map = "[columns]\nbrake = \"brake\"\n";
    let said = table(["no", "yes", "no"], Some(map)).expect("rows");
    assert_eq!(said, [false, true, false]);
    assert!(table(["0", "half", "0"], None).is_err());
    // A word is not a measurement.
    let torque = format!("{HEADER}\n0,0,true\n");
    assert!(read(&written(folder.path(), "b.csv", torque.as_bytes())).is_err());
}

#[test]
fn a_truck_may_be_a_word_each_with_a_number_of_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = "0,0,0,TRK-12\n1,0,0,TRK-12\n2,0,0,TRK-7\n3,0,0,\n4,0,0,12\n5,0,0,TRK-12\n";
    let text = format!("{HEADER},truck\n{rows}");
    let path = written(folder.path(), "a.csv", text.as_bytes());
    let samples = recording::load::<ExcavatorSensors>(path, None).expect("rows");
    let trucks: Vec<f64> = samples.iter().map(|(s, _)| s.truck).collect();
    let [first, again, second, none, number, back] = trucks[..] else {
        panic!("{trucks:?}");
    };
    assert!(first == again && first == back);
    assert!(second != first && number == 12.0);
    assert_eq!(first, 636594109.0);
    // Frames in Python have the same numbers.
    let labels = ["TRK-12", " TRK-7", "12", "k.A.", ""].map(recording::csv::label);
    assert_eq!(labels[..3], [first, second, number]);
    assert!(labels[3].is_nan() && labels[4].is_nan());
    assert!(
        [first, second]
            .iter()
            .all(|truck| (1e8..1e9).contains(truck))
    );
    assert!(!none.is_finite() || samples[3].0.valid != samples[2].0.valid);
}

#[test]
fn milliseconds_beside_whole_seconds_are_a_part_of_the_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let machine = Some(messages::Machine::Excavator);
    let map = |names: &str, time: fn(usize) -> String| {
        let row = |k: usize| format!("{},{},0.1,1\n", time(k), k % 100 * 10);
        let rows: String = (0..250).map(row).collect();
        let text = format!("{names},swing_velocity,swing_torque\n{rows}");
        let path = written(folder.path(), "a.csv", text.as_bytes());
        let text = recording::suggest(&path, &[], machine).expect("a map").text;
        let map = Map::parse(&text, "map.toml").expect("what heft writes");
        let rows = csv::read::<ExcavatorSensors>(path, Some(&map)).expect("rows");
        let times = rows.iter().map(|(s, _)| s.stamp.time);
        (text, times.collect::<Vec<_>>())
    };
    let date: fn(usize) -> String = |k| format!("2026-11-28 10:00:{:02}", k / 100);
    let unix: fn(usize) -> String = |k| format!("{}", 1_795_334_511 + k / 100);
    for (names, time) in [
        ("timestamp,millisecond", date),
        ("Time,Time [ms]", date),
        ("timestamp,Msec", unix),
    ] {
        let (text, times) = map(names, time);
        assert!(text.contains("t = { terms = "), "{names}: {text}");
        let step = times[249] - times[248];
        assert!((step - 0.01).abs() < 1e-6, "{names}: {step}");
    }
    // If the time has parts of a second, the column of milliseconds is not added.
    let whole: fn(usize) -> String = |k| format!("2026-11-28 10:00:{:05.2}", k as f64 / 100.0);
    let (text, _) = map("timestamp,millisecond", whole);
    assert!(!text.contains("t = { terms"), "{text}");
}

#[test]
fn a_blank_at_which_no_line_may_break_is_a_blank() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = "t,swing velocity,boom head pressure,boom rod pressure".replace(' ', "\u{a0}");
    let text = format!("{names}\n0,0.1,8e6,1e6\n1,0.1,8e6,1e6\n");
    let path = written(folder.path(), "a.csv", text.as_bytes());
    let machine = Some(messages::Machine::Excavator);
    let text = recording::suggest(&path, &[], machine).expect("a map").text;
    let line = "\nboom_head_pressure = \"boom\u{a0}head\u{a0}pressure\"";
    assert!(text.contains(line), "{text}");
}

#[test]
fn rows_within_a_quote_that_is_not_closed_are_no_remark() {
    let folder = tempfile::tempdir().expect("a folder");
    let of = |remark: &str| {
        let mut rows = rows().join(",\n") + ",\n";
        let at = rows.find(",2000,\n").expect("row 200") + ",2000,".len();
        rows.insert_str(at, remark);
        let text = format!("{HEADER},remark\n{rows}");
        read(&written(folder.path(), "a.csv", text.as_bytes()))
    };
    for remark in ["\"two\nlines\"", "\"1 of\n2, or 3\"", "5\" pipe"] {
        assert_eq!(of(remark).expect("rows").len(), 400, "{remark}");
    }
    let error = of("\"open").expect_err("half of the rows").to_string();
    assert!(
        error.contains("a quote takes 199 of the rows below"),
        "{error}"
    );
    assert!(error.contains("a.csv:202"), "{error}");
}

#[test]
fn a_measurement_file_of_labview_is_read_below_its_headers() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = rows().join("\n").replace(',', "\t");
    let text = format!(
        "LabVIEW Measurement\t\nSeparator\tTab\nDate\t2026/11/20\n***End_of_Header***\t\nChannels\t2\n\
         Date\t2026/11/20\t2026/11/20\nTime\t10:00:00\t10:00:00\nX0\t0.0\t0.0\nDelta_X\t0.01\t0.01\n\
         ***End_of_Header***\nt\tswing_velocity\tswing_torque\tComment\n{rows}\n"
    );
    let read = read(&written(folder.path(), "a.lvm", text.as_bytes())).expect("rows");
    assert_eq!((read.len(), read[399]), (400, 3990.0));
}

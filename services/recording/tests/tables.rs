//! CSV in and out, and the messages for faulty files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use messages::channels::EXCAVATOR_SENSORS;
use messages::{
    ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth, LoaderEstimate, LoaderSensors,
    excavator_bits as e, loader_bits as l,
};
use recording::csv::{EstimateWriter, export, misspelt, read, read_weighings};
use recording::{Error, Map, Metadata, Reader, Writer, load, open};

/// A file with this text in a folder of its own.
fn file(text: impl AsRef<[u8]>) -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().expect("a folder for temporary files");
    let path = dir.path().join("data.csv");
    std::fs::write(&path, text).expect("writable");
    (dir, path)
}

fn excavator(text: &str) -> Result<Vec<ExcavatorSensors>, Error> {
    let (_dir, path) = file(text);
    read::<ExcavatorSensors>(path, None).map(|rows| rows.into_iter().map(|(s, _)| s).collect())
}

fn golden(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden")).join(name)
}

#[test]
fn a_table_becomes_samples_with_their_bits_and_the_truth() {
    let rows =
        read::<ExcavatorSensors>(golden("excavator_input_base_case2.csv"), None).expect("a table");
    assert_eq!(rows.len(), 481);
    let (sensors, truth) = rows[2];
    assert_eq!((sensors.stamp.sequence, sensors.stamp.time), (2, 5.02));
    assert_eq!(
        (sensors.swing_velocity, sensors.boom_angle),
        (-0.00206532, 0.93508)
    );
    let all = 0b11_1101; // all but the swing angle
    assert_eq!((sensors.valid, sensors.columns), (all, all));
    assert_eq!(
        (truth.inertia, truth.payload, truth.known),
        (5584.36, 288.0, 0b111_1111)
    );
}

#[test]
fn the_loaders_table_has_its_optional_columns_as_bits() {
    let rows = read::<LoaderSensors>(golden("loader_input_S4_tierB.csv"), None).expect("a table");
    let (sensors, truth) = rows[0];
    assert_eq!((sensors.mass, truth.cg_ratio), (4770.5, 0.414194));
    assert_eq!(sensors.columns & l::MASS, l::MASS);
    assert_eq!(sensors.columns & (l::SPADE_FORCE_X | l::BOOM_MOVING), 0);
    let rows =
        read::<LoaderSensors>(golden("loader_input_S6_60s_tierA.csv"), None).expect("a table");
    assert_eq!(rows[0].0.columns & l::BOOM_MOVING, l::BOOM_MOVING);
    assert_eq!(
        rows[0].0.valid & l::BOOM_MOVING,
        0,
        "it does not move there"
    );
}

#[test]
fn empty_cells_and_numbers_that_are_not_finite_are_missing() {
    let rows = excavator("t,swing_velocity,swing_torque\n0,,1\n1,nan,2\n2,-inf,\n3,0.5,3\n")
        .expect("a table");
    let valid: Vec<u32> = rows.iter().map(|r| r.valid).collect();
    let (velocity, torque) = (e::SWING_VELOCITY, e::SWING_TORQUE);
    assert_eq!(valid, [torque, torque, 0, velocity | torque]);
    assert_eq!(rows[0].swing_velocity, 0.0, "and 0 in the message");
}

#[test]
fn rows_with_a_wrong_time_are_passed_on() {
    let rows = excavator("t,swing_velocity\n0,1\n,2\n0,3\n-5,4\n1,5\n").expect("a table");
    assert_eq!(rows.len(), 5);
    assert!(rows[1].stamp.time.is_nan());
    assert_eq!(
        rows.iter().map(|r| r.stamp.sequence).collect::<Vec<_>>(),
        [0, 1, 2, 3, 4]
    );
}

#[test]
fn an_optional_column_without_a_value_in_the_first_second_is_not_there() {
    let late = excavator("t,swing_velocity,swing_torque\n0,1,\n1.5,1,7\n").expect("a table");
    assert_eq!(late[0].columns, e::SWING_VELOCITY);
    let early = excavator("t,swing_velocity,swing_torque\n0,1,\n0.5,1,7\n").expect("a table");
    assert_eq!(early[0].columns, e::SWING_VELOCITY | e::SWING_TORQUE);
}

#[test]
fn line_ends_marks_quotes_spaces_and_surplus_columns_do_no_harm() {
    let text = "\u{feff}comment, t ,\"swing_velocity\"\r\n\"a, b\", 0.5 ,\"1e-3\"\r\nx,0.6,2\r\n";
    let rows = excavator(text).expect("a table");
    assert_eq!((rows[0].stamp.time, rows[0].swing_velocity), (0.5, 1e-3));
    assert_eq!(rows[1].swing_velocity, 2.0);
}

#[test]
fn a_missing_column_is_named_with_the_nearest_one() {
    let error = excavator("t,swing_velocty\n0,1\n").expect_err("no velocity");
    assert_eq!(
        error.what,
        "there is no column swing_velocity or swing_angle (excavator)"
    );
    assert!(
        error.remedy.starts_with("rename column swing_velocty"),
        "{error}"
    );
    assert!(error.place.ends_with("data.csv:1"));
    assert!(excavator("swing_velocity\n1\n").is_err(), "no time");
    let (_dir, path) = file("t,speed\n0,1\n");
    let error = read::<LoaderSensors>(path, None).expect_err("no wheels");
    assert_eq!(error.what, "there is no column front_wheel_speed (loader)");
}

#[test]
fn text_in_a_number_is_reported_with_line_and_column() {
    let error = excavator("t,swing_velocity\n0,1\n\n1,fast\n").expect_err("text");
    assert_eq!(error.what, "\"fast\" is no number");
    assert!(
        error.place.ends_with("data.csv:4, column swing_velocity"),
        "{error}"
    );
    assert_eq!(error.to_string().lines().count(), 3);
}

#[test]
fn a_table_is_read_as_excel_writes_it() {
    let plain = excavator("t,swing_velocity,swing_torque\n0,0.5,\n0.01,-1.5,2000\n").expect("rows");
    let german = "t;swing_velocity;swing_torque\r\n0,00;0,5;\r\n0,01;\"-1,5\";2.000,0\r\n";
    let tabs = german.replace(';', "\t");
    let dates = german
        .replace("0,00;", "2026-11-21 16:00:00,00;")
        .replace("0,01;", "2026-11-21 16:00:00,01;");
    for text in [german, &tabs, &format!("sep=;\r\n{german}"), &dates] {
        assert_eq!(excavator(text).expect(text), plain, "{text}");
    }
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("data.csv");
    let text = format!("\u{feff}{german}");
    let wide = text.encode_utf16().flat_map(u16::to_le_bytes);
    std::fs::write(&path, wide.collect::<Vec<u8>>()).expect("writable");
    let rows = read::<ExcavatorSensors>(&path, None).expect("rows");
    assert_eq!(rows.into_iter().map(|(s, _)| s).collect::<Vec<_>>(), plain);
    let error = excavator("sep=;\nt;swing_velocity\n0;x\n").expect_err("text");
    assert!(
        error.place.ends_with("data.csv:3, column swing_velocity"),
        "{error}"
    );
}

/// Takes seconds; a comparison of each column with each other took minutes.
#[test]
fn a_table_may_have_a_hundred_thousand_columns() {
    let others = 100_000;
    let names: String = (0..others).map(|i| format!(",c{i}")).collect();
    let cells = ",1".repeat(others);
    let text = format!("t,swing_velocity,swing_torq{names}\n0,.5,0{cells}\n");
    let begun = std::time::Instant::now();
    let (_dir, path) = file(&text);
    let rows = read::<ExcavatorSensors>(&path, None).expect("a table");
    assert_eq!(rows[0].0.swing_velocity, 0.5);
    assert_eq!(
        misspelt::<ExcavatorSensors>(&path),
        [("swing_torq".into(), "swing_torque".into())]
    );
    assert!(begun.elapsed().as_secs() < 30, "{:?}", begun.elapsed());
}

#[test]
fn a_number_with_its_unit_or_with_marks_gets_a_message_with_its_own() {
    for (cell, remedy) in [
        ("12.5 kN", "its unit stands once"),
        ("12,5%", "its unit stands once"),
        ("12 500.0", "without marks between thousands"),
        ("12,50.0", "without marks between thousands"),
        ("fast", "leave the cell empty"),
        ("9 lives", "leave the cell empty"),
    ] {
        let error = excavator(&format!("t;swing_velocity\n0.01;1.5\n0.02;{cell}\n"));
        let error = error.expect_err(cell);
        assert_eq!(error.what, format!("\"{cell}\" is no number"));
        assert!(error.remedy.contains(remedy), "{error}");
        assert!(!error.remedy.contains("separate the columns"), "{error}");
    }
}

#[test]
fn files_without_samples_are_refused() {
    for (text, what) in [
        ("", "the file is empty"),
        (" \n\n", "the file is empty"),
        ("t,swing_velocity\n", "the file has a header but no rows"),
        ("t,t,swing_velocity\n0,0,1\n", "two columns are called t"),
        (
            "0,0,1\n0.01,0,1\n",
            "the table has no header: its first line holds numbers",
        ),
        (
            "t,swing_velocity\n0,1\n1\n2,3\n",
            "the row has 1 cell, the header 2, separated by ','",
        ),
        (
            "t,swing_velocity\n0,1,5\n",
            "the row has 3 cells, the header 2, separated by ','",
        ),
    ] {
        assert_eq!(excavator(text).expect_err(what).what, what);
    }
    assert!(read::<ExcavatorSensors>("/nowhere/data.csv", None).is_err());
    assert!(read::<ExcavatorSensors>("/", None).is_err());
    let (_dir, path) = file([0, 159, 146, 150, 10, 1, 2, 3]);
    assert!(
        read::<ExcavatorSensors>(path, None).is_err(),
        "no text at all"
    );
}

#[test]
fn line_ends_of_other_programs_and_blocks_of_zeros_are_named() {
    let row = |k: u32| format!("{k},0.5{}", "0".repeat(30));
    let rows: Vec<String> = (0..5).map(row).collect();
    let table = format!("t,swing_velocity\n{}\n", rows.join("\n"));
    let zeros = "\0".repeat(200_000);
    let read = |text: &str| {
        let (_dir, path) = file(text.as_bytes());
        let samples = open::<ExcavatorSensors>(&path, None)?;
        let rows = samples.rows()?.count();
        samples.check()?;
        Ok::<_, Error>((rows, samples.lacks().cut_off.unwrap_or_default()))
    };
    for (end, name) in [
        ("\u{85}", "NEL (U+0085)"),
        ("\u{2028}", "a line separator (U+2028)"),
        ("\u{2029}", "(U+2029)"),
        ("\u{b}", "a vertical tab"),
        ("\u{1e}", "a record separator"),
        ("\0", "a byte of zero"),
    ] {
        let all = table.replace('\n', end);
        let first = table.replacen('\n', end, 1);
        let one = table.replacen("\n2", &format!("{end}2"), 1);
        for (text, line) in [(all, ":1"), (first, ":1"), (one, ":3")] {
            let error = read(&text).expect_err(name);
            assert!(error.what.contains(name), "{error}");
            assert!(error.place.ends_with(line), "{text:?}: {error}");
            assert!(error.remedy.contains("(LF)"), "{error}");
        }
    }
    for padded in [
        format!("{table}\0"),
        format!("{table}{zeros}"),
        format!("{table}{zeros}\n{zeros}\n\n"),
    ] {
        let (count, said) = read(&padded).expect("rows");
        assert_eq!(count, 5);
        assert!(said.contains("data.csv:7: the file ends in bytes of zero"));
    }
    for (text, what, place) in [
        (zeros.clone(), "instead of data", "data.csv"),
        (format!("{zeros}{table}"), "instead of data", "data.csv"),
        (format!("\0\0\0\0{table}"), "bytes that are no text", ":1"),
        (
            table.replace('\n', "\0\0\0\n"),
            "among the text",
            "data.csv",
        ),
        (
            format!("t,swing_velocity\n{zeros}"),
            "instead of rows",
            ":2",
        ),
        (format!("{table}{zeros}\n{table}"), "instead of rows", ":7"),
        (format!("{table}{zeros}9,0.5\n"), "instead of rows", ":7"),
        (
            format!("{table}\0\09,0.5\n"),
            "is no number",
            ":7, column t",
        ),
    ] {
        let error = read(&text).expect_err(what);
        assert!(error.what.contains(what), "{error}");
        assert!(error.place.ends_with(place), "{error}");
    }
}

#[test]
fn a_row_longer_than_any_is_named_with_its_line() {
    let wide = format!("t,swing_velocity\n0,1\n1,1{}\n", ",0".repeat(3_000_000));
    let error = excavator(&wide).expect_err("too long");
    assert!(error.what.contains("a row is longer than 4 MB"), "{error}");
    assert!(error.place.ends_with(":3"), "{error}");
    assert!(error.remedy.contains("leave out columns"), "{error}");
}

#[test]
fn a_last_row_that_was_cut_off_is_left_out_and_named() {
    let read = |text: &[u8]| {
        let (_dir, path) = file(text);
        let samples = open::<ExcavatorSensors>(&path, None)?;
        let rows = samples.rows()?.count();
        samples.check()?;
        Ok::<_, Error>((rows, samples.lacks().cut_off))
    };
    let whole = "t,swing_velocity\n0,1\n1,2\n";
    assert_eq!(read(whole.as_bytes()).expect("rows"), (2, None));
    assert_eq!(read(whole.trim_end().as_bytes()).expect("rows"), (2, None));
    // The end of a text of DOS.
    let of_dos = format!("{whole}\u{1a}");
    assert_eq!(read(of_dos.as_bytes()).expect("rows"), (2, None));
    let wide = |text: &str| -> Vec<u8> {
        let text = format!("\u{feff}{text}");
        text.encode_utf16().flat_map(u16::to_le_bytes).collect()
    };
    let cut = format!("{whole}2");
    for text in [cut.clone().into_bytes(), wide(&cut)] {
        let (rows, said) = read(&text).expect("rows");
        assert_eq!(rows, 2);
        assert!(said.is_some_and(|s| s.contains("data.csv:4: the last row was cut off")));
    }
    // An editor, or the next start of the logger, may have written a line end behind it; empty lines and a comment are no rows.
    for (table, cut) in [
        ("t,swing_velocity,x\n0,1,2\n1,2,3\n", "2,"),
        ("t;swing_velocity;x\r\n0;1;2\r\n1;2;3\r\n", "2;\"1\r\n"),
        ("t\tswing_velocity\tx\n0\t1\t2\n1\t2\t3\n", "2\n\n# end\n"),
        ("t swing_velocity x\n0 1 2\n1 2 3\n", "2 1\n"),
        ("t,swing_velocity,x\n0,1,2\n1,2,3\n", "2,\"1"),
        ("t,swing_velocity,x\n0,1,2\n1,2,3\n", "2,\0\0\0"),
    ] {
        let (rows, said) = read(format!("{table}{cut}").as_bytes()).expect(cut);
        assert_eq!(rows, 2, "{cut}");
        let said = said.unwrap_or_default();
        let words = ["data.csv:4: the last row was cut off (", " of 3 cells)"];
        assert!(words.iter().all(|w| said.contains(w)), "{cut}: {said}");
    }
    // The last number of a whole row is cut off: an exponent, half of a minus sign.
    for cut in [&b"2,6.1e"[..], b"2,6.1e+", b"2,\xe2\x88"] {
        let (rows, said) = read(&[whole.as_bytes(), cut].concat()).expect("rows");
        assert_eq!(rows, 2);
        assert!(said.is_some_and(|s| s.contains("cut off (\"")), "{cut:?}");
    }
    for text in [
        "t,swing_velocity\n0,1\n1\n2,3",
        "t,swing_velocity\n0",
        "t,swing_velocity\n0,1\n1,6.1e\n",
        "t,swing_velocity\n0,1\nx,1",
        // The quote takes the rest of the table.
        "t,swing_velocity\n0,1\n\"1,1\n2,1\n3,1\n",
    ] {
        assert!(read(text.as_bytes()).is_err(), "{text}");
    }
}

fn estimate(n: u32) -> ExcavatorEstimate {
    let mut estimate = ExcavatorEstimate {
        inertia: 5000.1 + f64::from(n),
        inertia_std: 1e-7,
        velocity: 1.0 / 3.0,
        flags: e::EXCITED | e::TRUSTED,
        estimated: e::INERTIA,
        method: 3,
        ..Default::default()
    };
    estimate.stamp.time = 0.1 + f64::from(n);
    estimate
}

#[test]
fn estimates_have_the_columns_of_the_contract() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("out.csv");
    let mut writer = EstimateWriter::<ExcavatorEstimate>::create(&path).expect("a file");
    writer.write(&estimate(0)).expect("room");
    writer
        .write(&ExcavatorEstimate {
            flags: e::REFUSED,
            ..estimate(1)
        })
        .expect("room");
    writer
        .write(&ExcavatorEstimate {
            inertia: f64::NAN,
            ..estimate(2)
        })
        .expect("room");
    assert!(!path.exists(), "not before it is complete");
    assert_eq!(writer.finish(), Ok(2));
    let text = std::fs::read_to_string(&path).expect("readable");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[0],
        "t,inertia,inertia_std,damping,damping_std,torque,torque_std,payload,payload_std,velocity,\
         acceleration,excited,consistent,fresh,converged,identifiable,held,changing,reset,trusted,friction,friction_std,offset,\
         offset_std,method,reason"
    );
    assert_eq!(
        lines[1],
        "0.1,5000.1,1e-7,,,,,,,0.3333333333333333,,1,0,0,0,0,0,0,0,1,,,,,posture-torque,"
    );
    assert!(lines[2].starts_with("2.1,,1e-7,"), "{}", lines[2]);
    assert_eq!(lines.len(), 3);
    assert_eq!(std::fs::read_dir(dir.path()).expect("readable").count(), 1);
}

#[test]
fn columns_are_the_same_whatever_the_first_row_estimates() {
    let row = ExcavatorEstimate {
        friction: 20.0,
        offset: 7.0,
        estimated: e::FRICTION | e::OFFSET,
        ..estimate(0)
    };
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("out.csv");
    let mut writer = EstimateWriter::<ExcavatorEstimate>::create(&path).expect("a file");
    writer.write(&estimate(0)).expect("room");
    writer.write(&row).expect("room");
    writer.finish().expect("room");
    let text = std::fs::read_to_string(&path).expect("readable");
    assert!(text.contains(",trusted,friction,friction_std,offset,offset_std,method,reason\n"));
    assert!(text.contains(",1,,,,,posture-torque,\n"), "{text}");
    assert!(text.ends_with(",1,20,0,7,0,posture-torque,\n"), "{text}");

    let mut table = recording::frame::Table::<ExcavatorEstimate>::with_capacity(2);
    table.push(&estimate(0));
    table.push(&row);
    let columns = table.finish();
    let offset = columns.iter().find(|(name, ..)| *name == "offset");
    let Some((.., recording::frame::Values::Numbers(offset))) = offset else {
        panic!("no offset");
    };
    assert!(offset[0].is_nan() && offset[1] == 7.0, "{offset:?}");
}

#[test]
fn the_loaders_estimates_have_the_columns_of_the_contract() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("out.csv");
    let mut writer = EstimateWriter::<LoaderEstimate>::create(&path).expect("a file");
    let row = LoaderEstimate {
        cg_ratio: 0.45,
        estimated: l::STATE,
        ..Default::default()
    };
    writer.write(&row).expect("room");
    writer.finish().expect("room");
    let text = std::fs::read_to_string(&path).expect("readable");
    assert_eq!(
        text,
        "t,speed,front_wheel_speed,rear_wheel_speed,slip_stiffness,slip_stiffness_std,cg_height,\
         cg_height_std,cg_ratio,cg_ratio_std,cg_distance,spade_force_x,spade_force_x_std,slope_bias,\
         front_radius_scale,rear_radius_scale,nis,excited_ratio,excited_height,consistent,fresh,\
         converged_ratio,converged_height,frozen,reset,trusted_ratio,trusted_height,trusted_payload,payload,\
         payload_std,method,reason\n\
         0,0,0,0,0,0,0,0,0.45,0,0,,,,,,0,0,0,0,0,0,0,0,0,0,0,0,,,full,\n"
    );
}

#[test]
fn an_unfinished_output_leaves_nothing_behind_and_an_unwritable_one_is_an_error() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("out.csv");
    let mut writer = EstimateWriter::<ExcavatorEstimate>::create(&path).expect("a file");
    writer.write(&estimate(0)).expect("room");
    drop(writer);
    assert_eq!(std::fs::read_dir(dir.path()).expect("readable").count(), 0);
    assert!(
        EstimateWriter::<ExcavatorEstimate>::create(dir.path()).is_err(),
        "a folder"
    );
    if Path::new("/dev/full").exists() {
        let mut full =
            EstimateWriter::<ExcavatorEstimate>::create("/dev/full".as_ref()).expect("a device");
        let written = (0..10_000).try_for_each(|n| full.write(&estimate(n)));
        assert!(
            written
                .and_then(|()| full.finish())
                .is_err_and(|e| e.remedy.contains("make room"))
        );
    }
}

#[test]
fn numbers_read_back_to_the_last_bit() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("out.csv");
    let values = [
        0.1 + 0.2,
        1e-300,
        -1.5e22,
        f64::MIN_POSITIVE,
        123_456_789.123_456_79,
        -0.0,
    ];
    let mut writer = EstimateWriter::<ExcavatorEstimate>::create(&path).expect("a file");
    for value in values {
        writer
            .write(&ExcavatorEstimate {
                velocity: value,
                ..estimate(0)
            })
            .expect("room");
    }
    writer.finish().expect("room");
    let text = std::fs::read_to_string(&path).expect("readable");
    for (line, value) in text.lines().skip(1).zip(values) {
        let cell = line.split(',').nth(9).expect("the velocity");
        assert_eq!(
            cell.parse::<f64>().map(f64::to_bits),
            Ok(value.to_bits()),
            "{cell}"
        );
    }
}

#[test]
fn a_recording_exports_to_tables_and_loads_as_samples() {
    let dir = tempfile::tempdir().expect("a folder");
    let run = dir.path().join("run.mcap");
    let rows =
        read::<ExcavatorSensors>(golden("excavator_input_base_case2.csv"), None).expect("a table");
    let mut writer = Writer::create(&run, &Metadata::new()).expect("a file");
    for (sensors, truth) in &rows {
        writer.write(&EXCAVATOR_SENSORS, sensors).expect("room");
        writer
            .write(&messages::channels::EXCAVATOR_TRUTH, truth)
            .expect("room");
    }
    writer.finish().expect("room");
    assert_eq!(load::<ExcavatorSensors>(&run, None).as_ref(), Ok(&rows));
    let reader = Reader::open(&run).expect("a recording");
    let files = export(&reader, dir.path().join("tables")).expect("room");
    let again = read::<ExcavatorSensors>(&files[0], None).expect("an exported table is an input");
    assert!(files[0].ends_with("excavator_sensors.csv"));
    let values = |row: &(ExcavatorSensors, ExcavatorTruth)| {
        let (s, _) = row;
        (
            s.stamp.time.to_bits(),
            s.swing_torque.to_bits(),
            s.valid,
            s.columns,
        )
    };
    assert!(
        rows.iter().map(values).eq(again.iter().map(values)),
        "missing samples stay missing"
    );
    assert!(load::<messages::LoaderSensors>(&run, None).is_err_and(|e| e.what.contains("loader")));
}

#[test]
fn an_exported_verdict_has_a_column_for_each_flag_and_words_for_codes() {
    let dir = tempfile::tempdir().expect("a folder");
    let run = dir.path().join("run.mcap");
    let mut writer = Writer::create(&run, &Metadata::new()).expect("a file");
    let estimate = messages::LoaderEstimate {
        flags: messages::loader_bits::TRUSTED_PAYLOAD | messages::SIMULATED,
        reason: 16,
        method: 4,
        ..Default::default()
    };
    let channel = &messages::channels::LOADER_CG_UKF;
    writer.write(channel, &estimate).expect("room");
    writer.finish().expect("room");
    let reader = Reader::open(&run).expect("a recording");
    let files = export(&reader, dir.path().join("tables")).expect("room");
    let text = std::fs::read_to_string(&files[0]).expect("a table");
    let mut lines = text.lines().map(|line| line.split(','));
    let (names, cells) = (lines.next().expect("names"), lines.next().expect("a row"));
    let row: BTreeMap<&str, &str> = names.zip(cells).collect();
    let bits = estimate.flags.to_string();
    for (name, wanted) in [
        ("trusted_payload", "1"),
        ("trusted_ratio", "0"),
        ("refused", "0"),
        ("refused_now", "0"),
        ("simulated", "1"),
        ("reason", "load"),
        ("method", "full-ekf"),
        ("flags", &bits),
    ] {
        assert_eq!(row.get(name), Some(&wanted), "{name}");
    }
}

#[test]
fn the_kind_of_file_is_recognized_from_its_content_and_its_ending() {
    let (_dir, path) = file("t,swing_velocity\n0,1\n");
    assert!(load::<ExcavatorSensors>(&path, None).is_ok());
    let other = path.with_extension("xlsx");
    std::fs::rename(&path, &other).expect("renamed");
    assert!(
        load::<ExcavatorSensors>(&other, None).is_ok(),
        "a table all the same"
    );
    std::fs::write(&other, b"PK\x03\x04 and so on").expect("writable");
    let error = load::<ExcavatorSensors>(&other, None).expect_err("a spreadsheet");
    assert!(error.remedy.contains("save the sheet as CSV"), "{error}");
    let log = path.with_extension("log");
    std::fs::write(&log, "(0.0) can0 123#00\n").expect("writable");
    assert!(
        load::<ExcavatorSensors>(&log, None)
            .is_err_and(|e| e.what == "a CAN log needs a signal map")
    );
    let map = Map::parse("[columns]\nt = \"time\"\n", "m.toml").expect("a map");
    let recording = path.with_extension("mcap");
    std::fs::write(&recording, b"\x89MCAP0\r\n").expect("writable");
    assert!(
        load::<ExcavatorSensors>(&recording, Some(&map))
            .is_err_and(|e| e.remedy.starts_with("leave out --map"))
    );
}

#[test]
fn weighings_are_read_and_refused_like_other_tables() {
    let (_dir, path) = file("pitch, rear_load, front_load\n0,1,2\n0.2,3,4\n");
    assert_eq!(
        read_weighings(&path),
        Ok(vec![[0.0, 2.0, 1.0], [0.2, 4.0, 3.0]])
    );
    let (_dir, path) = file("pitch,rear_load,front_load\n0,1,\n");
    let error = read_weighings(&path).expect_err("a weight is missing");
    assert!(
        error.place.ends_with("data.csv:2, column front_load"),
        "{error}"
    );
    assert!(!error.remedy.contains("leave the cell empty"), "{error}");
    let (_dir, path) = file("pitch,rear,front_load\n0,1,2\n");
    assert!(read_weighings(&path).is_err_and(|e| e.what.contains("rear_load")));
    let (_dir, path) = file("pitch,rear_load,front_load,by\n0,1,2,\"me\n0.2,3,4,\n");
    assert!(read_weighings(&path).is_err_and(|e| e.what.contains("takes 1 of the rows below")));
}

#[test]
fn weighings_are_converted_by_their_row_of_units_and_a_mass_is_no_weight() {
    let (_dir, path) = file("pitch,front_load,rear_load\nmrad,kN,N\n500,1,2\n");
    assert_eq!(read_weighings(&path), Ok(vec![[0.5, 1000.0, 2.0]]));
    let (_dir, path) = file("pitch,front_load,rear_load\nrad,kg,kg\n0,1,2\n");
    let error = read_weighings(&path).expect_err("a mass");
    assert_eq!(error.what, "column front_load is in kg, and N is expected");
    assert!(error.place.ends_with("data.csv:2"), "{error}");
    assert!(
        error
            .remedy
            .contains("N, kN, MN, daN, kgf, tf, klbf, lbf; kg times 9.81 is N"),
        "{error}"
    );
}

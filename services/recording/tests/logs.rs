//! CAN logs that differ from what the map expects.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use messages::ExcavatorSensors;
use recording::{Error, Lacks, LineDecoder, Map, load};

const DBC: &str = "BO_ 100 Swing: 8 X\n SG_ rate : 0|16@1- (0.001,0) [0|0] \"rad/s\" X\n";

/// The error of a map with this DBC file, or this master.
fn refused(dbc: &[u8], master: &str) -> Error {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("run.log");
    std::fs::write(&path, "(0.0) can0 064#E803\n").expect("writable");
    std::fs::write(dir.path().join("swing.dbc"), dbc).expect("writable");
    let text = format!(
        "[can]\ndbc = \"swing.dbc\"\nmaster = \"{master}\"\n[can.signals]\n\
         swing_velocity = {{ message = \"Swing\", signal = \"rate\" }}\nboom_angle = {{ constant = 0.5 }}\n"
    );
    let map = Map::parse(&text, dir.path().join("map.toml")).expect("a map");
    load::<ExcavatorSensors>(&path, Some(&map)).expect_err("no rows")
}

#[test]
fn a_file_without_messages_and_a_master_that_is_constant_are_named() {
    let wide: Vec<u8> = DBC.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for dbc in [b"".as_slice(), b"\0\0", &wide] {
        let error = refused(dbc, "swing_velocity");
        assert!(error.what.contains("no message in the DBC file"), "{error}");
    }
    let error = refused(DBC.as_bytes(), "boom_angle");
    assert_eq!(error.remedy, "its signals are swing_velocity");
}

/// The swing velocities of a log of this name, read by an entry with these keys.
fn velocities(name: &str, keys: &str, content: &[u8]) -> Result<Vec<f64>, Error> {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join(name);
    std::fs::write(&path, content).expect("writable");
    std::fs::write(dir.path().join("swing.dbc"), DBC).expect("writable");
    let text = format!(
        "[can]\ndbc = \"swing.dbc\"\nmaster = \"swing_velocity\"\n[can.signals]\n\
         swing_velocity = {{ message = \"Swing\", signal = \"rate\"{keys} }}\n"
    );
    let map = Map::parse(&text, dir.path().join("map.toml"))?;
    let rows = load::<ExcavatorSensors>(&path, Some(&map))?;
    Ok(rows.iter().map(|(s, _)| s.swing_velocity).collect())
}

#[test]
fn of_two_buses_that_carry_the_same_message_the_first_counts() {
    let log =
        b"(0.0) can0 064#E803\n(0.1) can1 064#0000\n(0.2) can0 064#E803\n(0.3) can1 064#0000\n";
    assert_eq!(velocities("run.log", "", log), Ok(vec![1.0, 1.0]));
    let second = ", interface = \"can1\"";
    assert_eq!(velocities("run.log", second, log), Ok(vec![0.0, 0.0]));
    // An interface that was silent for long leaves the signal to another one.
    let log = b"(0.0) can0 064#E803\n(6.0) can1 064#D007\n";
    let found = velocities("run.log", "", log).expect("rows");
    assert!(found.contains(&2.0), "{found:?}");
}

#[test]
fn a_packed_log_is_read_up_to_where_it_was_cut() {
    let log: Vec<String> = (0..5000)
        .map(|k| {
            format!(
                "({:.2}) can0 064#{:04X}\n",
                0.01 * f64::from(k),
                k * 7919 % 65536
            )
        })
        .collect();
    let whole = velocities("run.log", "", log.concat().as_bytes()).expect("rows");
    assert_eq!(whole.len(), 5000);
    let mut packed = GzEncoder::new(Vec::new(), Compression::default());
    packed.write_all(log.concat().as_bytes()).expect("packed");
    let packed = packed.finish().expect("packed");
    let read = |bytes: &[u8]| velocities("run.log.gz", "", bytes);
    assert_eq!(read(&packed), Ok(whole.clone()));
    let cut = read(&packed[..packed.len() / 2]).expect("what is whole");
    assert!(
        cut.len() > 1000 && whole.starts_with(&cut[..cut.len() - 1]),
        "{}",
        cut.len()
    );
}

#[test]
fn a_log_without_frames_and_one_whose_times_are_no_times_are_named() {
    for content in [
        "",
        "\n\n",
        "(0.0) can0 064#R8\n",
        "(0.0) can0 20000004#0004\n",
        "noise",
    ] {
        let error = velocities("run.log", "", content.as_bytes()).expect_err(content);
        assert!(error.what.contains("there is no frame"), "{error}");
    }
    // Differences of times, as candump -td writes them; and a log that is read backwards.
    let log = |time: fn(u32) -> f64| -> String {
        let line = |k| format!("({:.3}) can0 064#E803\n", time(k));
        (0..1000).map(line).collect()
    };
    for time in [
        |k| if k % 2 == 0 { 0.001 } else { 0.009 },
        |k| {
            if k == 0 {
                0.02
            } else {
                0.01 + 1e-3 * f64::from(k % 7)
            }
        },
        |k| 100.0 - 0.01 * f64::from(k),
    ] {
        let error = velocities("run.log", "", log(time).as_bytes()).expect_err("no times");
        assert!(error.what.contains("earlier than one before"), "{error}");
    }
    // A clock that is set back once, and frames of two buses with small delays, are accepted.
    let log = log(|k| {
        let late = if k % 3 == 0 { 0.015 } else { 0.0 };
        let set = if k < 500 { 10.0 } else { 6.0 };
        set + 0.01 * f64::from(k) - late
    });
    assert!(velocities("run.log", "", log.as_bytes()).is_ok());
}

/// A log of swings at 100 Hz; `other` gives the text before a line.
fn swings(rows: u32, other: impl Fn(u32) -> &'static str) -> String {
    let line = |k| format!("{}({:.2}) can0 064#E803\n", other(k), 0.01 * f64::from(k));
    (0..rows).map(line).collect()
}

/// The number of rows of a log, and what it lacks.
fn lacks(log: &str) -> Result<(usize, Lacks), Error> {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("run.log");
    std::fs::write(&path, log).expect("writable");
    let samples = recording::open::<ExcavatorSensors>(&path, Some(&map(&dir)))?;
    let rows = samples.rows()?.count();
    samples.check()?;
    Ok((rows, samples.lacks()))
}

fn map(dir: &tempfile::TempDir) -> Map {
    std::fs::write(dir.path().join("swing.dbc"), DBC).expect("writable");
    let text = "[can]\ndbc = \"swing.dbc\"\nmaster = \"swing_velocity\"\n[can.signals]\n\
                swing_velocity = { message = \"Swing\", signal = \"rate\" }\n";
    Map::parse(text, dir.path().join("map.toml")).expect("a map")
}

#[test]
fn lines_that_are_no_frames_are_left_out_counted_and_the_first_is_named() {
    let torn = |k| match k {
        40 => "(0.4) can0 06\n",
        70 => "DROPCOUNT: dropped 12 CAN frames on 'can0' socket (total drops 40)\n",
        80 => "064#E803\n",
        90 => "\tprotocol-violation{{error-on-tx}{}}\n",
        _ => "",
    };
    let (rows, lacks) = lacks(&swings(100, torn)).expect("rows");
    assert_eq!(rows, 100);
    let said = lacks.left_out.expect("words");
    assert!(
        said.contains("run.log:41, the first of them: 2 lines are no frames"),
        "{said}"
    );
    assert!(said.contains("\"(0.4) can0 06\""), "{said}");
    assert!(
        said.contains("12 frames were lost while it was recorded"),
        "{said}"
    );
}

#[test]
fn a_last_line_that_was_cut_off_is_named() {
    let (rows, lacks) = lacks(&(swings(50, |_| "") + "(0.50) can0 06")).expect("rows");
    assert_eq!((rows, lacks.left_out), (50, None));
    let said = lacks.cut_off.expect("words");
    assert!(
        said.contains("run.log:51: the last line was cut off"),
        "{said}"
    );
}

#[test]
fn what_is_mostly_no_log_is_refused() {
    let prose = "once upon a time\nthere was a bus\n(0.0) can0 064#E803\n";
    let error = lacks(prose).expect_err("no log");
    assert!(
        error.what.starts_with("2 of 3 lines are no frames"),
        "{error}"
    );
    assert!(error.place.ends_with("run.log:1"), "{error}");
    // A long line is judged before its end.
    let long = "once upon a time\n".repeat(100_000);
    let error = lacks(&long).expect_err("no log");
    assert!(error.what.starts_with("100 of 100 lines"), "{error}");
    let untimed = "can0 064 [2] E8 03\n".repeat(1000);
    let error = lacks(&untimed).expect_err("no times");
    assert_eq!(error.what, "the log has no times");
}

#[test]
fn a_log_whose_frames_carry_one_time_is_refused_on_a_disk_and_as_it_comes() {
    let one = "(1700000000.000000) can0 064#E803\n".repeat(300);
    let error = lacks(&one).expect_err("no times");
    assert!(
        error.what.contains("all 300 frames carry one time"),
        "{error}"
    );
    let dir = tempfile::tempdir().expect("a folder");
    let mut decoder = LineDecoder::<ExcavatorSensors>::new(Some(map(&dir))).expect("a decoder");
    for line in one.lines() {
        decoder.take(line.as_bytes(), 0).expect("a line");
    }
    decoder.finish();
    let error = decoder.judge().expect_err("no times");
    assert!(
        error.what.contains("all 300 frames carry one time"),
        "{error}"
    );
}

#[test]
fn lines_without_times_that_come_together_are_refused() {
    let dir = tempfile::tempdir().expect("a folder");
    let judged = |each: i64| {
        let mut decoder = LineDecoder::<ExcavatorSensors>::new(Some(map(&dir))).expect("a decoder");
        for k in 0..300 {
            decoder.take(b"can0 064#E803", each * k).expect("a line");
        }
        decoder.finish();
        decoder.judge()
    };
    assert_eq!(judged(10_000_000), Ok(()));
    let error = judged(0).expect_err("no times");
    assert!(error.what.starts_with("the lines tell no times"), "{error}");
}

#[test]
fn of_lines_that_come_each_one_that_is_left_out_is_counted() {
    let dir = tempfile::tempdir().expect("a folder");
    let mut decoder = LineDecoder::<ExcavatorSensors>::new(Some(map(&dir))).expect("a decoder");
    let log = swings(100, |k| if k % 10 == 0 { "torn\n" } else { "" });
    for line in log.lines() {
        decoder.take(line.as_bytes(), 0).expect("a line");
    }
    decoder.finish();
    assert_eq!((decoder.refused(), decoder.judge()), (10, Ok(())));
    let remarks = decoder.take_remarks();
    assert!(
        remarks
            .iter()
            .any(|r| r.contains("10 lines of standard input")),
        "{remarks:?}"
    );
}

#[test]
fn a_log_whose_times_are_too_coarse_for_its_values_is_refused() {
    // Whole seconds; and the differences of a regular bus, as candump -td writes them.
    for time in [|k| f64::from(k / 100), |k| if k == 0 { 0.0 } else { 0.01 }] {
        let line = |k| format!("({:.6}) can0 064#E803\n", time(k));
        let error = lacks(&(0..1000).map(line).collect::<String>()).expect_err("no times");
        assert!(
            error
                .what
                .ends_with("values carry the time of the one before them"),
            "{error}"
        );
    }
    // Two frames of one time now and then are a bus with a slow clock.
    let line = |k: u32| {
        format!(
            "({:.2}) can0 064#E803\n",
            0.01 * f64::from(k - u32::from(k % 3 == 1))
        )
    };
    assert!(lacks(&(0..999).map(line).collect::<String>()).is_ok());
}

#[test]
fn times_in_milliseconds_are_read_where_they_are_dates_and_named_where_not() {
    let log = |time: &dyn Fn(u64) -> String| -> String {
        (0..200)
            .map(|k| format!("({}) can0 064#E803\n", time(10 * k)))
            .collect()
    };
    let since_1970 = log(&|ms| format!("{}.000", 1_700_000_000_000 + ms));
    let found = velocities("run.log", "", since_1970.as_bytes()).expect("rows");
    assert_eq!(found.len(), 200);
    let since_start = log(&|ms| format!("{ms}.000"));
    let error = velocities("run.log", "", since_start.as_bytes()).expect_err("milliseconds");
    assert!(
        error.what.contains("the times seem to be in milliseconds"),
        "{error}"
    );
    assert!(error.remedy.contains("divide the times by 1000"), "{error}");
    let seconds = log(&|ms| format!("{}.{:03}", ms / 1000, ms % 1000));
    assert_eq!(
        velocities("run.log", "", seconds.as_bytes()).map(|all| all.len()),
        Ok(200)
    );
}

#[test]
fn what_python_can_prints_is_no_log_and_a_line_of_one_is_shown() {
    let printed =
        "Timestamp: 1700000000.000000    ID:      064    S Rx    DL:  2    e8 03\n".repeat(3);
    let error = velocities("run.log", "", printed.as_bytes()).expect_err("no log");
    assert!(error.remedy.contains("can_logger -f"), "{error}");
    let error = velocities("run.log", "", b"(1.0 s) can0 064#E803\n").expect_err("no log");
    assert!(
        error.remedy.contains("a line is (1700000000.000000) can0"),
        "{error}"
    );
}

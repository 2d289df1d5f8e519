//! CAN logs that were recorded otherwise than thought.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use messages::ExcavatorSensors;
use recording::{Error, Map, load};

const DBC: &str = "BO_ 100 Swing: 8 X\n SG_ rate : 0|16@1- (0.001,0) [0|0] \"rad/s\" X\n";

/// What is wrong with a map whose DBC file is this, or whose master is that.
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
    // One that was silent for long has left the signal to another.
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
    // Differences of times, as candump -td writes them; and a log that is read from its end.
    let log = |time: fn(u32) -> f64| -> String {
        let line = |k| format!("({:.3}) can0 064#E803\n", time(k));
        (0..1000).map(line).collect()
    };
    for time in [
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
    // A clock that is set back once, and frames of two buses that come a little late, are nothing of the kind.
    let log = log(|k| {
        let late = if k % 3 == 0 { 0.015 } else { 0.0 };
        let set = if k < 500 { 10.0 } else { 6.0 };
        set + 0.01 * f64::from(k) - late
    });
    assert!(velocities("run.log", "", log.as_bytes()).is_ok());
}

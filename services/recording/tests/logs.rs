//! CAN logs that were recorded otherwise than thought.

use messages::ExcavatorSensors;
use recording::{Error, Map, load};

const DBC: &str = "BO_ 100 Swing: 8 X\n SG_ rate : 0|16@1- (0.001,0) [0|0] \"rad/s\" X\n";

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

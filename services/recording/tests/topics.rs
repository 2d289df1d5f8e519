//! MCAP files of other programs, made by their own libraries (`tests/others/make.py`): numbers by topic and field.

use std::path::{Path, PathBuf};

use messages::{ExcavatorSensors, Machine};
use recording::{Map, load, recover, suggest};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/others")
        .join(name)
}

fn rows(name: &str, map: &str) -> Result<Vec<ExcavatorSensors>, recording::Error> {
    let map = Map::parse(map, "map.toml")?;
    let rows = load::<ExcavatorSensors>(file(name), Some(&map))?;
    Ok(rows.into_iter().map(|(sensors, _)| sensors).collect())
}

/// The rows must be those of `make.py`: velocity 0.5 sin t, torque 1000 cos t, 100 a second for 4 s.
fn assert_is_the_swing(rows: &[ExcavatorSensors], single: bool) {
    // At a rate there is no row at the end itself: more values could come at that time.
    assert!((399..=400).contains(&rows.len()), "{}", rows.len());
    let near = if single { 1e-6 } else { 1e-9 };
    for (i, row) in rows.iter().enumerate() {
        let t = i as f64 / 100.0;
        assert!((row.stamp.time - t).abs() < 1e-9, "{i}: {}", row.stamp.time);
        assert!((row.swing_velocity - 0.5 * t.sin()).abs() < near, "{row:?}");
        assert!(
            (row.swing_torque - 1000.0 * t.cos()).abs() < 1e-6,
            "{row:?}"
        );
    }
}

const ROS: &str = r#"
[topics]
master = "swing_velocity"
[topics.signals]
swing_velocity = { topic = "/joint_states", field = "velocity", name = "swing_joint" }
swing_torque = { topic = "/swing/pressure", field = "fluid_pressure", unit = "Pa", scale = 0.01 }
"#;

#[test]
fn ros_2_with_zstd_is_read_by_joint_and_by_field() {
    assert_is_the_swing(&rows("ros2.zstd.mcap", ROS).expect("readable"), false);
}

#[test]
fn the_time_of_a_header_is_that_of_the_measurement() {
    let header = ROS.replace("[topics]\n", "[topics]\ntime = \"header\"\n");
    let rows = rows("ros2.zstd.mcap", &header).expect("readable");
    assert_is_the_swing(&rows, false);
    assert_eq!(rows[0].stamp.measured_ns, 1_700_000_000_000_000_000);
    let log = self::rows("ros2.zstd.mcap", ROS).expect("readable");
    assert_eq!(log[0].stamp.measured_ns, 1_700_000_000_020_000_000);
}

#[test]
fn json_with_lz4_is_read_in_its_units() {
    let map = r#"
[topics]
master = "swing_velocity"
[topics.signals]
swing_velocity = { topic = "/drive", field = "swing.rate_deg", unit = "deg/s" }
swing_torque = { topic = "/drive", field = "swing.torques[1]" }
"#;
    assert_is_the_swing(&rows("json.lz4.mcap", map).expect("readable"), false);
}

#[test]
fn protobuf_outside_of_chunks_is_read_by_its_descriptors() {
    let map = r#"
[topics]
rate = 100
[topics.signals]
swing_velocity = { topic = "/drive", field = "rate" }
swing_torque = { topic = "/drive", field = "torque.z" }
"#;
    assert_is_the_swing(&rows("protobuf.plain.mcap", map).expect("readable"), true);
}

#[test]
fn what_is_not_there_is_named_with_what_is() {
    let reported = |from: &str, to: &str| {
        let error = rows("ros2.zstd.mcap", &ROS.replace(from, to)).expect_err(to);
        error.to_string()
    };
    let topic = reported("/joint_states", "/joint_state");
    assert!(
        topic.contains("/joint_states") && topic.contains("map.toml:5"),
        "{topic}"
    );
    let joint = reported("swing_joint", "arm_joint");
    assert!(
        joint.contains("its places are boom, swing_joint"),
        "{joint}"
    );
    let drive = "[topics]\nrate = 100\ntime = \"header\"\n[topics.signals]\nswing_velocity = { topic = \"/drive\", field = \"swing.rate_deg\" }\n";
    let header = self::rows("json.lz4.mcap", drive)
        .expect_err("no header")
        .to_string();
    assert!(header.contains("leave out time"), "{header}");
    let field = reported("fluid_pressure", "fluid_presure");
    assert!(field.contains("did you mean fluid_pressure?"), "{field}");
    assert!(reported("field = \"velocity\"", "field = \"velo..city\"").contains("no path"));
    let none = rows("ros2.zstd.mcap", "[columns]\nt = \"x\"\n").expect_err("no topics");
    assert!(none.to_string().contains("[topics.signals]"), "{none}");
    let without = load::<ExcavatorSensors>(file("ros2.zstd.mcap"), None).expect_err("no map");
    assert!(without.to_string().contains("heft map"), "{without}");
}

#[test]
fn the_first_map_lists_topics_numbers_and_joints() {
    let first = suggest(&file("ros2.zstd.mcap"), &[], Some(Machine::Excavator)).expect("readable");
    assert!(first.missing.is_empty(), "{first:?}");
    let text = first.text;
    for line in [
        "# /joint_states  sensor_msgs/msg/JointState, cdr  400 messages",
        "#     velocity[1] = 0",
        "#     names of places: boom, swing_joint",
        "#     fluid_pressure = 100000",
        "swing_velocity = { topic = \"/joint_states\", field = \"velocity\", name = \"swing_joint\" }  # by its name: check it; [rad/s]; other units by unit = ...",
        // Its speed exists, its angle does not.
        "# boom_angle = { topic = \"/...\", field = \"...\" }  # [rad]; other units by unit = ...",
    ] {
        assert!(text.contains(line), "{line} in\n{text}");
    }
}

#[test]
fn a_cut_file_gives_what_is_whole_and_recovers_that() {
    let folder = tempfile::tempdir().expect("a folder");
    let bytes = std::fs::read(file("ros2.zstd.mcap")).expect("there");
    let cut = folder.path().join("cut.mcap");
    std::fs::write(&cut, &bytes[..bytes.len() / 2]).expect("writable");
    let map = Map::parse(ROS, "map.toml").expect("a map");
    let rows = load::<ExcavatorSensors>(&cut, Some(&map)).expect("readable");
    assert!((50..400).contains(&rows.len()), "{}", rows.len());
    let out = folder.path().join("mended.mcap");
    let recovered = recover(&cut, Some(&out)).expect("recoverable");
    assert!(recovered.messages > 100, "{recovered}");
    let again = load::<ExcavatorSensors>(&out, Some(&map)).expect("readable");
    assert_eq!(again.len(), rows.len());
}

#[test]
fn no_byte_of_a_foreign_file_makes_a_panic() {
    let folder = tempfile::tempdir().expect("a folder");
    let damaged = folder.path().join("damaged.mcap");
    let map = Map::parse(ROS, "map.toml").expect("a map");
    let bytes = std::fs::read(file("ros2.zstd.mcap")).expect("there");
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    for _ in 0..60 {
        let mut bytes = bytes.clone();
        for _ in 0..4 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let at = (seed >> 33) as usize % bytes.len();
            bytes[at] ^= (seed >> 8) as u8 | 1;
        }
        std::fs::write(&damaged, &bytes).expect("writable");
        // All values that are read are finite.
        for (row, _) in load::<ExcavatorSensors>(&damaged, Some(&map)).unwrap_or_default() {
            assert!(row.swing_velocity.is_finite() && row.swing_torque.is_finite());
        }
    }
}

#[test]
fn messages_of_one_time_are_refused() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("bag.mcap");
    let write = |time: fn(u64) -> u64| {
        let file = std::fs::File::create(&path).expect("writable");
        let mut writer = mcap::Writer::new(std::io::BufWriter::new(file)).expect("a writer");
        let none = std::collections::BTreeMap::new();
        let schema = writer
            .add_schema("D", "jsonschema", b"{}")
            .expect("a schema");
        let id = writer
            .add_channel(schema, "/d", "json", &none)
            .expect("a channel");
        for k in 0..300 {
            let header = mcap::records::MessageHeader {
                channel_id: id,
                sequence: 0,
                log_time: time(k),
                publish_time: time(k),
            };
            writer
                .write_to_known_channel(&header, b"{\"w\": 1.0}")
                .expect("written");
        }
        writer.finish().expect("whole");
    };
    let text = "[topics]\nrate = 100\n[topics.signals]\nswing_velocity = { topic = \"/d\", field = \"w\" }\n";
    let map = Map::parse(text, "map.toml").expect("a map");
    let read = || load::<ExcavatorSensors>(&path, Some(&map));
    for time in [|_| 0, |k| k / 100 * 1_000_000_000] {
        write(time);
        let error = read().expect_err("no times");
        assert!(
            error
                .what
                .ends_with("values carry the time of the one before them"),
            "{error}"
        );
    }
    // Microseconds where MCAP has nanoseconds.
    write(|k| k * 10_000);
    let error = read().expect_err("three milliseconds");
    assert!(error.what.ends_with("their times are not in ns"), "{error}");
    write(|k| k * 10_000_000);
    assert_eq!(read().expect("rows").len(), 299);
    let whole = std::fs::read(&path).expect("read");
    std::fs::write(&path, &whole[..60]).expect("cut");
    let error = read().expect_err("no topic");
    assert!(error.place.contains("it was cut off"), "{error}");
}

/// Writes fifty messages of one topic, at 100 Hz; `message`: the JSON by the number.
fn write_json(path: &std::path::Path, topic: &str, message: impl Fn(u64) -> String) {
    let mut writer = mcap::Writer::new(std::fs::File::create(path).expect("a file")).expect("new");
    let channel = writer.add_channel(0, topic, "json", &Default::default());
    let channel = channel.expect("a channel");
    for k in 0..50_u64 {
        let header = mcap::records::MessageHeader {
            channel_id: channel,
            sequence: k as u32,
            log_time: 10_000_000 * k,
            publish_time: 10_000_000 * k,
        };
        let written = writer.write_to_known_channel(&header, message(k).as_bytes());
        written.expect("written");
    }
    writer.finish().expect("written");
}

#[test]
fn a_map_names_what_is_silent_in_the_first_message_and_names_that_are_no_paths() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("own.mcap");
    write_json(&path, "/own", |k| {
        let rate = if k == 0 { "NaN" } else { "2.0" };
        format!("{{\"swing rate [deg/s]\": {rate}, \"torque_kNm\": 1.5}}")
    });
    let first = suggest(&path, &[], Some(Machine::Excavator)).expect("readable");
    let map = Map::parse(&first.text, "map.toml").expect("a map");
    let rows = load::<ExcavatorSensors>(&path, Some(&map)).expect("readable");
    let (sensors, _) = rows.last().expect("rows");
    assert!((sensors.swing_velocity - 2.0_f64.to_radians()).abs() < 1e-12);
    assert!((sensors.swing_torque - 1500.0).abs() < 1e-9);
}

#[test]
fn a_file_without_topics_is_named_as_such() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("empty.mcap");
    let mut writer = mcap::Writer::new(std::fs::File::create(&path).expect("a file")).expect("new");
    writer.finish().expect("whole");
    let map = Map::parse(ROS, "map.toml").expect("a map");
    let read = load::<ExcavatorSensors>(&path, Some(&map)).expect_err("no topics");
    let first = suggest(&path, &[], Some(Machine::Excavator)).expect_err("no topics");
    for error in [read.to_string(), first.to_string()] {
        assert!(error.contains("the file has no topics"), "{error}");
    }
}

#[test]
fn the_orientation_of_an_imu_gives_angles_and_its_numbers_are_taken_for_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("imu.mcap");
    // The boom points 0.6 rad up: a negative pitch of ROS.
    let (y, w) = (-0.3_f64).sin_cos();
    write_json(&path, "/imu/boom", |_| {
        format!(
            r#"{{"orientation": {{"x": 0, "y": {y}, "z": 0, "w": {w}}}, "orientation_covariance": [1], "rate": {{"z": 0.2}}}}"#
        )
    });
    let first = suggest(&path, &[], Some(Machine::Excavator)).expect("readable");
    assert!(
        first.text.contains("#     orientation.angle_y = -0."),
        "{}",
        first.text
    );
    let named = first.text.lines().filter(|line| !line.starts_with('#'));
    let named = named.filter(|line| line.contains("orientation")).count();
    assert!(
        named == 0 && !first.text.contains("covariance"),
        "{}",
        first.text
    );
    let map = "[topics]\nrate = 100\n[topics.signals]\n\
        swing_velocity = { topic = \"/imu/boom\", field = \"rate.z\" }\n\
        boom_angle = { topic = \"/imu/boom\", field = \"orientation.angle_y\", sign = -1 }\n";
    let map = Map::parse(map, "map.toml").expect("a map");
    let rows = load::<ExcavatorSensors>(&path, Some(&map)).expect("readable");
    let (sensors, _) = rows.last().expect("rows");
    assert!((sensors.boom_angle - 0.6).abs() < 1e-12, "{sensors:?}");
}

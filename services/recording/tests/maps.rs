//! Signal maps: foreign names and units, and the messages for names that do not fit.

#[path = "../../../tests/common/theirs.rs"]
mod theirs;

use std::path::Path;

use messages::{ExcavatorSensors, LoaderSensors, excavator_bits as e};
use recording::csv::read;
use recording::{Error, Map, load};

fn map(text: &str) -> Result<Map, Error> {
    Map::parse(text, "map.toml")
}

/// Reads a table through a map.
fn through(text: &str, table: &str) -> Result<Vec<ExcavatorSensors>, Error> {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("data.csv");
    std::fs::write(&path, table).expect("writable");
    let rows = read::<ExcavatorSensors>(path, Some(&map(text)?))?;
    Ok(rows.into_iter().map(|(s, _)| s).collect())
}

#[test]
fn columns_are_renamed_scaled_turned_and_shifted() {
    let text = r#"[columns]
t = { column = "ms", unit = "ms" }
swing_velocity = { column = "n", unit = "rpm", sign = -1 }
swing_torque = { column = "dp", unit = "bar", scale = 2e-3 }
boom_angle = { column = "boom", unit = "deg", offset = 0.5 }
arm_angle = { constant = -90.0, unit = "deg" }
bucket_angle = "none"
"#;
    let rows = through(text, "ms,n,dp,boom,bucket_angle\n500,60,100,90,1\n").expect("rows");
    let row = rows[0];
    assert_eq!(row.stamp.time, 0.5);
    assert_eq!(row.swing_velocity, -core::f64::consts::TAU);
    assert_eq!(row.swing_torque, 20_000.0); // 100 bar = 1e7 Pa, times 2e-3 N m/Pa
    assert_eq!(row.boom_angle, core::f64::consts::FRAC_PI_2 + 0.5);
    assert_eq!(row.arm_angle, -core::f64::consts::FRAC_PI_2);
    assert_eq!(row.columns & e::BUCKET_ANGLE, 0);
}

#[test]
fn a_column_of_hefts_own_name_needs_no_entry() {
    let rows = through(
        "[columns]\nswing_velocity = \"w\"\n",
        "t,w,swing_torque\n0,1,2\n",
    );
    let row = rows.expect("rows")[0];
    assert_eq!((row.swing_velocity, row.swing_torque), (1.0, 2.0));
}

#[test]
fn names_that_do_not_fit_are_reported_with_the_nearest_ones() {
    let table = "t,swing_deg\n0,1\n";
    let error =
        through("[columns]\n\nswing_angle = \"swing_dge\"\n", table).expect_err("no such column");
    assert_eq!(error.place, "map.toml:3");
    assert_eq!(error.remedy, "did you mean swing_deg?");
    let error =
        through("[columns]\nswing_angel = \"swing_deg\"\n", table).expect_err("no such signal");
    assert_eq!(
        (error.place.as_str(), error.remedy.as_str()),
        ("map.toml:2", "did you mean swing_angle?")
    );
    let error =
        through("[columns]\nspeed = \"swing_deg\"\n", table).expect_err("of the other machine");
    assert!(error.remedy.contains("swing_velocity"), "{error}");
}

#[test]
fn a_unit_of_another_dimension_needs_a_scale() {
    let text = "[columns]\nswing_angle = { column = \"x\", unit = \"mm\" }\n";
    let error = through(text, "t,x\n0,1\n").expect_err("a length is no angle");
    assert_eq!(error.what, "swing_angle is measured in rad, not in mm");
    assert!(
        error.remedy.contains("rad, mrad, deg, mdeg, turn"),
        "{error}"
    );
    // A constant has a unit too.
    let text = "[columns]\nswing_velocity = { constant = 1.0, unit = \"kg\" }\n";
    let error = through(text, "t\n0\n").expect_err("a mass is no velocity");
    assert!(
        error.remedy.contains("rad/s, deg/s, mdeg/s, rpm"),
        "{error}"
    );
    let text = "[columns]\nswing_angle = { column = \"x\", unit = \"mm\", scale = 2.0 }\n";
    assert_eq!(
        through(text, "t,x\n0,500\n").expect("rows")[0].swing_angle,
        1.0
    );
}

#[test]
fn a_map_that_says_nonsense_is_refused_with_its_line() {
    for (text, line, what) in [
        ("", 1, "the map is empty"),
        ("[columns\n", 1, ""),
        ("\n[colums]\nt = \"x\"\n", 2, "a map has no table [colums]"),
        (
            "[columns]\nt = 5\n",
            2,
            "t does not say where it comes from",
        ),
        (
            "[columns]\nt = { colum = \"x\" }\n",
            2,
            "a map has no key colum there",
        ),
        (
            "[columns]\nt = { column = \"x\", unit = \"kmh\" }\n",
            2,
            "unknown unit kmh",
        ),
        (
            "[columns]\nt = { column = \"x\", sign = 2 }\n",
            2,
            "sign is 2",
        ),
        (
            "[columns]\nt = { column = \"x\", scale = \"2\" }\n",
            2,
            "scale is no number",
        ),
        (
            "[columns]\nt = { column = \"x\", scale = 0 }\n",
            2,
            "scale is 0",
        ),
        (
            "[columns]\nt = { column = \"x\", constant = 1 }\n",
            2,
            "column and constant both say",
        ),
        (
            "[columns]\nt = { message = \"x\", signal = \"y\" }\n",
            2,
            "message is of the table [can.signals]",
        ),
        ("[can]\nmaster = \"t\"\n", 1, "[can] names no DBC file"),
        ("[can]\ndbc = \"x.dbc\"\nrate = 1e300\n", 3, "rate is 1"),
        (
            "[columns]\nt = { column = \"x\", delay = -1 }\n",
            2,
            "delay is -1",
        ),
        (
            "[can]\ndbc = \"x.dbc\"\n",
            1,
            "[can] does not say when there is a row",
        ),
        (
            "[can]\ndbc = \"x.dbc\"\nrate = 10\nmaster = \"t\"\n",
            1,
            "[can] says twice when there is a row",
        ),
        (
            "[can]\ndbc = \"x.dbc\"\nrate = 10\n",
            1,
            "[can] names no signals",
        ),
    ] {
        let error = map(text).expect_err(text);
        assert!(error.what.contains(what), "{error}");
        assert_eq!(error.place, format!("map.toml:{line}"), "{error}");
    }
    assert!(Map::read(Path::new("/nowhere/map.toml")).is_err());
}

const DBC: &str = "BO_ 100 Swing: 8 X\n SG_ rate : 0|16@1- (0.001,0) [0|0] \"rad/s\" X\n\
                   BO_ 101 Torque: 8 X\n SG_ torque : 7|16@0- (1,0) [0|0] \"\" X\n";

/// Reads a CAN log through a map whose lines follow `[can]`.
fn log(can: &str, signals: &str, frames: &str) -> Result<Vec<ExcavatorSensors>, Error> {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("run.log");
    std::fs::write(&path, frames).expect("writable");
    std::fs::write(dir.path().join("swing.dbc"), DBC).expect("writable");
    let text = format!("[can]\ndbc = \"swing.dbc\"\n{can}\n[can.signals]\n{signals}");
    let map = Map::parse(&text, dir.path().join("map.toml"))?;
    Ok(load::<ExcavatorSensors>(&path, Some(&map))?
        .into_iter()
        .map(|(s, _)| s)
        .collect())
}

const SIGNALS: &str = "swing_velocity = { message = \"Swing\", signal = \"rate\" }\n\
                       swing_torque = { message = \"Torque\", signal = \"torque\", unit = \"kN m\", sign = -1 }\n";
const FRAMES: &str =
    "(100.0) can0 065#0002\n(100.1) can0 064#E803\n(100.2) can0 064#D007\n(100.9) can0 064#0CFE\n";

#[test]
fn a_log_has_a_row_for_each_frame_of_the_master_and_holds_the_others() {
    let rows = log("master = \"swing_velocity\"\nhold = 0.5", SIGNALS, FRAMES).expect("rows");
    let times: Vec<f64> = rows
        .iter()
        .map(|r| (r.stamp.time * 1e9).round() / 1e9)
        .collect();
    assert_eq!(times, [0.1, 0.2, 0.9]);
    assert_eq!(
        rows.iter().map(|r| r.swing_velocity).collect::<Vec<_>>(),
        [1.0, 2.0, -0.5]
    );
    assert_eq!(rows[1].swing_torque, -2000.0);
    assert_eq!(
        rows[2].valid,
        e::SWING_VELOCITY,
        "a torque of 0.9 s ago is missing"
    );
}

#[test]
fn a_log_can_be_read_at_a_rate() {
    let rows = log("rate = 4", SIGNALS, FRAMES).expect("rows");
    assert_eq!(
        rows.iter().map(|r| r.stamp.time).collect::<Vec<_>>(),
        [0.0, 0.25, 0.5, 0.75]
    );
    assert_eq!(rows[0].valid, e::SWING_TORQUE);
    assert_eq!(rows[1].swing_velocity, 2.0);
}

#[test]
fn can_names_that_do_not_fit_are_reported_with_the_nearest_ones() {
    let can = "master = \"swing_velocity\"";
    let of = |message: &str, signal: &str| {
        let signals =
            format!("swing_velocity = {{ message = \"{message}\", signal = \"{signal}\" }}\n");
        log(can, &signals, FRAMES).expect_err("a wrong name").remedy
    };
    assert_eq!(of("Swin", "rate"), "did you mean Swing?");
    assert_eq!(of("Swing", "rat"), "did you mean rate?");
    let silent = log(can, SIGNALS, "(1.0) can0 064#E803\n").expect_err("no torque ever");
    assert!(
        silent.what.ends_with("has no value of swing_torque"),
        "{silent}"
    );
    let text = log(can, SIGNALS, "(1.0) can0 064#E803\nhello\nworld\n").expect_err("no frame");
    assert!(text.place.ends_with("run.log:2"), "{text}");
    assert!(
        log(can, "swing_torque = { constant = 1.0 }\n", FRAMES).is_err(),
        "no velocity"
    );
}

/// Reads a log with the DBC's own units, through a map of one signal.
fn speed(dbc_unit: &str, entry: &str) -> Result<f64, Error> {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("run.log");
    std::fs::write(&path, "(0.0) can0 064#2400\n(0.1) can0 064#2400\n").expect("writable");
    let dbc = format!("BO_ 100 S: 8 X\n SG_ v : 0|16@1- (1,0) [0|0] \"{dbc_unit}\" X\n");
    std::fs::write(dir.path().join("s.dbc"), dbc).expect("writable");
    let text = format!(
        "[can]\ndbc = \"s.dbc\"\nmaster = \"swing_velocity\"\n[can.signals]\n\
         swing_velocity = {{ message = \"S\", signal = \"v\"{entry} }}\n"
    );
    let map = Map::parse(&text, dir.path().join("map.toml"))?;
    let rows = load::<ExcavatorSensors>(&path, Some(&map))?;
    Ok(rows.last().expect("a row").0.swing_velocity)
}

#[test]
fn the_unit_is_the_dbcs_where_the_map_is_silent_and_a_contradiction_is_reported() {
    let close = |found: Result<f64, Error>, wanted: f64| {
        let found = found.expect("a value");
        assert!((found / wanted - 1.0).abs() < 1e-12, "{found} {wanted}");
    };
    close(speed("rpm", ""), 36.0 * core::f64::consts::TAU / 60.0);
    close(
        speed("1/min", ", unit = \"rpm\""),
        36.0 * core::f64::consts::TAU / 60.0,
    );
    close(speed("deg/s", ""), 36.0_f64.to_radians());
    close(speed("", ""), 36.0);
    close(speed("km/h", ", scale = 0.5"), 5.0);
    close(speed("counts", ", scale = 0.5"), 18.0);
    let error = speed("rpm", ", unit = \"rad/s\"").expect_err("a contradiction");
    assert_eq!(
        error.what,
        "swing_velocity is in rad/s by the map and in rpm by the DBC"
    );
    let error = speed("km/h", "").expect_err("another dimension");
    assert_eq!(
        error.what,
        "swing_velocity is measured in rad/s, not in km/h"
    );
    let error = speed("counts", "").expect_err("an unknown unit");
    assert!(error.what.contains("\"counts\""), "{error}");
}

#[test]
fn a_torque_is_the_difference_of_two_pressures_times_the_displacement() {
    let text = "[columns.swing_torque]\nterms = [{ column = \"pa\", unit = \"bar\" }, \
                { column = \"pb\", unit = \"bar\", sign = -1 }]\nscale = 2e-3\noffset = 5.0\n";
    let rows = through(text, "t,swing_velocity,pa,pb\n0,1,120,20\n1,1,120,\n").expect("rows");
    assert_eq!(rows[0].swing_torque, 20_005.0); // 100 bar = 1e7 Pa
    assert_eq!(
        rows[1].valid,
        e::SWING_VELOCITY,
        "half a difference is none"
    );
    let error = through("[columns]\nswing_torque = { terms = [] }\n", "t\n0\n").expect_err("none");
    assert_eq!(error.what, "swing_torque has no terms");
    let signals = "swing_velocity = { message = \"Swing\", signal = \"rate\" }\n\
                   swing_torque = { terms = [{ message = \"Torque\", signal = \"torque\" }, { constant = 7.0 }] }\n";
    let rows = log("rate = 4", signals, FRAMES).expect("rows");
    assert_eq!(rows[0].swing_torque, 9.0);
}

#[test]
fn a_delayed_signal_belongs_to_the_time_at_which_it_was_measured() {
    // The torque is the time of its measurement [ms] and comes 250 ms later.
    let mut frames = String::new();
    for n in 0..40_u32 {
        let ms = 50 * n;
        let torque = ms as i16 - 250;
        frames += &format!("({}.{:03}) can0 064#0000\n", 100 + ms / 1000, ms % 1000);
        if ms.is_multiple_of(100) && torque >= 0 {
            frames += &format!(
                "({}.{:03}) can0 065#{torque:04X}\n",
                100 + ms / 1000,
                ms % 1000
            );
        }
    }
    let signals = |timing: &str| {
        format!(
            "swing_velocity = {{ message = \"Swing\", signal = \"rate\" }}\n\
             swing_torque = {{ message = \"Torque\", signal = \"torque\", delay = 0.25{timing} }}\n"
        )
    };
    let rows = log(
        "master = \"swing_velocity\"",
        &signals(", interpolate = true"),
        &frames,
    );
    let rows = rows.expect("rows");
    let valid = rows.iter().filter(|r| r.valid & e::SWING_TORQUE != 0);
    assert!(valid.clone().count() > 20);
    for row in valid {
        assert!(
            (row.swing_torque - 1e3 * row.stamp.time).abs() < 1e-6,
            "{row:?}"
        );
    }
    let held = log("master = \"swing_velocity\"", &signals(""), &frames).expect("rows");
    let late = held.iter().filter(|r| r.valid & e::SWING_TORQUE != 0);
    assert!(late.clone().count() > 20);
    // At the end of the log no value of the last 250 ms can come any more.
    let old = |r: &ExcavatorSensors| 1e3 * r.stamp.time - r.swing_torque;
    assert!(late.clone().all(|r| (-1e-6..310.0).contains(&old(r))));
}

#[test]
fn of_two_senders_of_a_parameter_group_the_first_counts() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("run.log");
    let frames = "(0.0) can0 0CF00400#0000002003FFFFFF\n(0.1) can0 0CF00417#0000000000FFFFFF\n\
                  (0.2) can0 0CF00400#0000002003FFFFFF\n(0.3) can0 0CF00400#000000FFFFFFFFFF\n";
    std::fs::write(&path, frames).expect("writable");
    let dbc = "BO_ 2364540158 E: 8 X\n SG_ n : 24|16@1+ (0.125,0) [0|0] \"rpm\" X\nBA_ \"ProtocolType\" \"J1939\";\n";
    std::fs::write(dir.path().join("s.dbc"), dbc).expect("writable");
    let text = |source: &str| {
        format!(
            "[can]\ndbc = \"s.dbc\"\nmaster = \"swing_velocity\"\n[can.signals]\n\
             swing_velocity = {{ message = \"E\", signal = \"n\"{source} }}\n"
        )
    };
    let read = |source: &str| -> Vec<(f64, u32)> {
        let map = Map::parse(&text(source), dir.path().join("map.toml")).expect("a map");
        let rows = load::<ExcavatorSensors>(&path, Some(&map)).expect("rows");
        rows.iter()
            .map(|(s, _)| ((s.swing_velocity * 1e3).round(), s.valid))
            .collect()
    };
    let speed = (10_472.0, e::SWING_VELOCITY); // 100 rpm
    assert_eq!(
        read(""),
        [speed, speed, (0.0, 0)],
        "not available is missing"
    );
    assert_eq!(read(", source = 0x17"), [(0.0, e::SWING_VELOCITY)]);
}

#[test]
fn a_wrong_time_makes_no_rows() {
    let Some(data) = theirs::data("") else { return };
    let map = Map::read(&data.join("faults/rate.toml")).expect("a map");
    let rows = load::<LoaderSensors>(data.join("faults/jump.log"), Some(&map)).expect("rows");
    // Half a second at 100 Hz, and one frame of another century.
    assert!((40..2000).contains(&rows.len()), "{}", rows.len());
    let times = rows
        .windows(2)
        .map(|w| w[1].0.stamp.time - w[0].0.stamp.time);
    assert!(times.fold(0.0, f64::max) < 11.0);
}

fn shipped(name: &str) -> Map {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/maps"));
    Map::read(&folder.join(name)).expect("a shipped map")
}

/// Values of one column at the times of the published decoding.
fn published(data: &Path, column: usize) -> Vec<(f64, f64)> {
    let text = std::fs::read_to_string(data.join("can/truck_decoded_10Hz.csv")).expect("readable");
    let number = |line: &str, i: usize| line.split(',').nth(i).and_then(|c| c.parse().ok());
    let rows = text.lines().skip(1);
    rows.map(|l| {
        (
            number(l, 0).expect("a time"),
            number(l, column).expect("a value"),
        )
    })
    .collect()
}

/// Linear interpolation of a series at `time`; none outside.
fn interpolate(series: &[(f64, f64)], time: f64) -> Option<f64> {
    let after = series.partition_point(|(t, _)| *t < time);
    let ((t0, v0), (t1, v1)) = (series.get(after.checked_sub(1)?)?, series.get(after)?);
    Some(v0 + (v1 - v0) * (time - t0) / (t1 - t0))
}

/// A driving truck's J1939 log against its published decoding at 10 Hz. The publication interpolates
/// between frames and is printed with six digits, hence the tolerance of 2e-5.
#[test]
fn a_trucks_log_decodes_as_published() {
    let Some(data) = theirs::data("") else { return };
    type Get = fn(&messages::LoaderSensors) -> f64;
    let signals: [(&str, usize, Get); 4] = [
        ("front_wheel_speed", 1, |s| s.front_wheel_speed * 0.5 * 3.6),
        ("speed", 6, |s| s.speed * 3.6),
        ("rear_torque", 8, |s| s.rear_torque / 11.09),
        ("rear_wheel_speed", 10, |s| {
            s.rear_wheel_speed * 60.0 / core::f64::consts::TAU
        }),
    ];
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/maps"));
    let text = std::fs::read_to_string(folder.join("truck.toml")).expect("a shipped map");
    for (signal, column, get) in signals {
        let text = text.replace(
            "master = \"front_wheel_speed\"",
            &format!("master = \"{signal}\""),
        );
        let map = Map::parse(&text, folder.join("truck.toml")).expect("a map");
        let rows = load::<LoaderSensors>(data.join("can/truck_normal_drive.log"), Some(&map))
            .expect("rows");
        let series: Vec<(f64, f64)> = rows.iter().map(|(s, _)| (s.stamp.time, get(s))).collect();
        let mut compared = 0;
        for (time, expected) in published(&data, column) {
            // The time is printed with six digits too: the value may be that of up to 50 us beside it.
            let near = [-6e-5, 0.0, 6e-5].map(|d| interpolate(&series, time + d));
            if let [Some(a), Some(b), Some(c)] = near {
                let tolerance = 2e-5 * expected.abs().max(1.0);
                let (low, high) = (a.min(b).min(c) - tolerance, a.max(b).max(c) + tolerance);
                assert!(
                    (low..=high).contains(&expected),
                    "{signal} at {time}: {b} {expected}"
                );
                compared += 1;
            }
        }
        assert!(compared >= 297, "{signal}: {compared}");
    }
}

#[test]
fn the_shipped_maps_read_the_data_of_others() {
    let Some(data) = theirs::data("") else { return };
    let load = |file: &str, map: &str| {
        load::<ExcavatorSensors>(data.join("recorded").join(file), Some(&shipped(map)))
            .expect("rows")
    };
    let rows = load("emps_identification.csv", "emps.toml");
    assert_eq!(rows.len(), 24_841);
    assert_eq!(rows[1].0.swing_angle, 1.43e-5);
    assert_eq!(rows[0].1.inertia, 95.1089);
    let rows = load("hsm150_torque_steps.csv", "hsm150.toml");
    assert_eq!(rows[1].0.swing_torque, 0.0683827);
    let rows = load("excavator_boom_up_80.csv", "excavator_boom_up_80.toml");
    assert_eq!(rows.len(), 892);
    assert!((rows[0].0.boom_angle - -0.59523_f64.to_radians()).abs() < 1e-15);
}

#[test]
fn a_sensor_that_a_loader_does_not_have_is_none_and_not_an_error() {
    let of = |torques: &str| {
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join("run.csv");
        std::fs::write(&path, "t,v,slope,lift_head_pressure\n0,1,0,5e6\n").expect("writable");
        let text = format!(
            "[columns]\nspeed = \"v\"\nfront_wheel_speed = \"none\"\nrear_wheel_speed = \"none\"\n{torques}"
        );
        read::<LoaderSensors>(&path, Some(&map(&text)?))
    };
    let rows = of("front_torque = \"none\"\nrear_torque = \"none\"\n").expect("rows");
    assert_eq!((rows[0].0.speed, rows[0].0.lift_head_pressure), (1.0, 5e6));
    let silent = of("").expect_err("nothing is said of the torques");
    assert!(silent.what.contains("front_torque"), "{silent}");
    let time = through("[columns]\nt = \"none\"\n", "t,swing_velocity\n0,1\n");
    assert!(time.is_err(), "no time is no data");
    // One of two signals of the swing suffices; the absence of both must be stated for both.
    let both = "t,x\n0,1\n";
    assert!(through("[columns]\nswing_velocity = \"none\"\n", both).is_err());
}

#[test]
fn rows_at_even_steps_need_no_column_of_time() {
    let text = "[columns]\nt = { column = \"row\", scale = 0.01 }\n";
    let rows = through(text, "swing_velocity,row_\n1,0\n2,0\n3,0\n").expect("rows");
    let times: Vec<f64> = rows.iter().map(|row| row.stamp.time).collect();
    assert_eq!(times, [0.0, 0.01, 0.02]);
    // A column of that name replaces the row number.
    let rows = through(text, "swing_velocity,row\n1,5\n2,6\n").expect("rows");
    assert_eq!(rows[1].stamp.time, 0.06);
}

#[test]
fn a_zone_by_name_is_what_is_not_read() {
    let table = "t,swing_velocity\n2026-11-21 17:00:00 CET,1\n";
    let error = through("[columns]\nswing_velocity = \"swing_velocity\"\n", table);
    let error = error.expect_err("CET is not read");
    assert!(error.what.ends_with("is no time"), "{error}");
    assert!(error.remedy.contains("zone as a number"), "{error}");
}

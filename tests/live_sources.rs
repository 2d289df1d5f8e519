//! Live sources: standard input or a bus gives the same samples as a log of it, bit for bit;
//! unusable data are reported; no wrong estimate is trusted.
//!
//! The bus is a real one (`vcan0`) if the kernel supports it, or one of a kernel that `tests/tools/with-can`
//! boots; without either the tests on it report that and pass.

#[path = "live_sources/bus.rs"]
mod bus;
mod common;
#[path = "common/theirs.rs"]
mod theirs;
mod vcan;

use std::fmt::Write as _;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use std::time::Duration;

use common::{both, heft, kill, run, run_ok, says};
use messages::ExcavatorSensors;
use messages::channels::EXCAVATOR_SENSORS;
use recording::Reader;
use rustix::process::Signal;
use sim::excavator::{Scenario, Simulation};
use vcan::Frame;

const DBC: &str = "BO_ 100 Swing: 4 X\n SG_ rate : 0|32@1- (0.000001,0) [0|0] \"rad/s\" X\n\
                   BO_ 101 Torque: 4 X\n SG_ torque : 7|32@0- (0.01,0) [0|0] \"N m\" X\n";
const MAP: &str = "[can]\ndbc = \"swing.dbc\"\nrate = 100\nhold = 0.3\n[can.signals]\n\
                   swing_velocity = { message = \"Swing\", signal = \"rate\" }\n\
                   swing_torque = { message = \"Torque\", signal = \"torque\" }\n";

/// A folder with the map and its DBC file.
fn mapped() -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().expect("a folder");
    std::fs::write(dir.path().join("swing.dbc"), DBC).expect("writable");
    let map = dir.path().join("map.toml");
    std::fs::write(&map, MAP).expect("writable");
    (dir, map)
}

/// Simulated swings: time, velocity, torque; and the true inertia at each time.
fn swings(seconds: f64) -> (Vec<[f64; 3]>, Vec<f64>) {
    let scenario = Scenario::parse("constant").expect("a scenario");
    let mut run = sim::excavator::Run::new(scenario);
    (run.rate, run.seed, run.duration) = (100.0, 3, seconds);
    let rows = Simulation::new(&run).expect("a run");
    let measured = |x: Option<f64>| x.unwrap_or(f64::NAN);
    rows.map(|r| {
        let row = [r.time, measured(r.swing_velocity), measured(r.swing_torque)];
        (row, r.truth.inertia)
    })
    .unzip()
}

/// The two frames of a sample.
fn frames([time, velocity, torque]: [f64; 3]) -> [Frame; 2] {
    let velocity = (velocity * 1e6).round() as i32;
    let torque = (torque * 1e2).round() as i32;
    let frame = |time, id, data: [u8; 4]| Frame {
        time,
        id,
        extended: false,
        data: data.to_vec(),
    };
    [
        frame(time, 100, velocity.to_le_bytes()),
        frame(time + 0.001, 101, torque.to_be_bytes()),
    ]
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path")
}

/// `heft run` of standard input, as fast as it goes.
fn piped(machine: &str, input: &Path, map: Option<&Path>, out: &Path) -> Output {
    let mut command = heft();
    command.args([
        "run",
        machine,
        "--input",
        "-",
        "--pace",
        "max",
        "--no-report",
    ]);
    command.args(["--domain", &common::domain("piped"), "--out", text(out)]);
    command.args(map.iter().flat_map(|map| ["--map", text(map)]));
    command.stdin(File::open(input).expect("the input"));
    command.output().expect("heft starts")
}

/// The estimates of `heft estimate` for a file of excavators, or for the truck's log as a loader. The latter is doubtful: the map
/// takes the engine's torque for the wheels', which contradicts the truck's mass.
fn estimates(machine: &str, input: &Path, map: Option<&Path>) -> String {
    let dir = tempfile::tempdir().expect("a folder");
    let out = dir.path().join("out.csv");
    let mut arguments = vec![
        "estimate",
        text(input),
        "--machine",
        machine,
        "-o",
        text(&out),
    ];
    arguments.extend(map.iter().flat_map(|map| ["--map", text(map)]));
    let output = run(&arguments);
    let in_doubt = i32::from(machine == "loader");
    assert_eq!(output.status.code(), Some(in_doubt), "{}", both(&output));
    std::fs::read_to_string(&out).expect("estimates")
}

/// Checks that a run's samples and estimates are those of the file. A bus is read for longer than its log, as long
/// as the test takes to end the run.
fn assert_same(machine: &str, run: &Path, file: &str, is_bus: bool) {
    run_ok(&["replay", text(run), "--verify"]);
    let live = estimates(machine, run, None);
    assert!(file.lines().count() > 250, "{} rows", file.lines().count());
    for (n, (live, file)) in live.lines().zip(file.lines()).enumerate() {
        assert_eq!(live, file, "row {n}");
    }
    let (live, file) = (live.lines().count(), file.lines().count());
    assert!(
        live == file || is_bus && live > file,
        "{live} rows of {file}"
    );
}

#[test]
fn lines_of_candump_in_any_form_give_the_bits_of_their_file() {
    let (dir, map) = mapped();
    let log = dir.path().join("run.log");
    let mut lines = String::from("\u{feff}");
    for row in swings(12.0).0 {
        for frame in frames(row) {
            let time = 1.7e9 + frame.time;
            let bytes = frame.data.iter().map(|b| format!("{b:02X}"));
            let bytes: Vec<String> = bytes.collect();
            let _ = match frame.id {
                100 => writeln!(
                    lines,
                    " ({time:.6})  can0  RX - -  {:03X}   [{}]  {}",
                    frame.id,
                    bytes.len(),
                    bytes.join(" ")
                ),
                id => writeln!(lines, "({time:.6}) can0 {id:03X}#{}", bytes.concat()),
            };
        }
    }
    std::fs::write(&log, lines).expect("writable");
    let out = tempfile::tempdir().expect("a folder");
    let output = piped("excavator", &log, Some(&map), out.path());
    assert!(output.status.success(), "{}", both(&output));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.starts_with("samples: standard input"), "{said}");
    let file = estimates("excavator", &log, Some(&map));
    assert_same("excavator", &out.path().join("run.mcap"), &file, false);
}

#[test]
fn a_trucks_log_on_standard_input_gives_the_bits_of_its_file() {
    let Some(log) = theirs::data("can/truck_normal_drive.log") else {
        return;
    };
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/maps/truck.toml");
    let out = tempfile::tempdir().expect("a folder");
    let output = piped("loader", &log, Some(&map), out.path());
    assert_eq!(output.status.code(), Some(1), "{}", both(&output));
    says(&output, "those at the motor");
    let file = estimates("loader", &log, Some(&map));
    assert_same("loader", &out.path().join("run.mcap"), &file, false);
}

#[test]
fn rows_of_a_table_come_on_standard_input_and_give_the_bits_of_their_file() {
    let dir = tempfile::tempdir().expect("a folder");
    let table = dir.path().join("t.csv");
    let mut lines = String::from("t;swing_velocity;swing_torque\n");
    for [time, velocity, torque] in swings(12.0).0 {
        let row = format!("{time};{velocity};{torque}\n");
        lines += &row.replace('.', ",");
    }
    std::fs::write(&table, &lines).expect("writable");
    let out = tempfile::tempdir().expect("a folder");
    let output = piped("excavator", &table, None, out.path());
    assert!(output.status.success(), "{}", both(&output));
    let file = estimates("excavator", &table, None);
    assert_same("excavator", &out.path().join("run.mcap"), &file, false);

    // A row of another kind is left out and reported.
    lines.push_str("nonsense\n5000,00;0,1;7\n");
    std::fs::write(&table, &lines).expect("writable");
    let rows = lines.lines().count() - 3;
    let output = piped("excavator", &table, None, out.path());
    assert!(output.status.success(), "{}", both(&output));
    let reported = format!("line {} of standard input is no row", rows + 2);
    says(&output, &reported);
    let all = common::sequences::<ExcavatorSensors>(out.path(), EXCAVATOR_SENSORS.name);
    assert_eq!(all.len(), rows + 1);
}

#[test]
fn an_input_that_cannot_be_used_ends_the_run_with_the_remedy() {
    let dir = tempfile::tempdir().expect("a folder");
    let (_dbc, map) = mapped();
    for (lines, map, reason) in [
        ("t,speed_of_swing\n0,1\n0.01,1\n", None, "swing_velocity"),
        ("t,swing_velocity\n", None, "ended without a sample"),
        ("", None, "ended without a sample"),
        (
            "no frame\nneither\n",
            Some(&*map),
            "2 of 2 lines are no frames",
        ),
    ] {
        let input = dir.path().join("input");
        std::fs::write(&input, lines).expect("writable");
        let out = dir.path().join("out");
        let output = piped("excavator", &input, map, &out);
        let said = both(&output);
        assert_eq!(output.status.code(), Some(2), "{lines:?}: {said}");
        assert!(said.contains(reason), "{lines:?}: {said}");
        for line in ["heft: ", "  where: standard input", "  what to do: "] {
            assert!(said.contains(line), "{lines:?}: {said}");
        }
    }
}

#[test]
fn a_source_that_was_killed_goes_on_with_standard_input() {
    let (_dir, map) = mapped();
    let out = tempfile::tempdir().expect("a folder");
    let mut child = heft()
        .args(["run", "excavator", "--input", "-", "--map", text(&map)])
        .args([
            "--no-report",
            "--quiet",
            "--domain",
            &common::domain("again"),
        ])
        .args(["--out", text(out.path())])
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("heft starts");
    let mut pipe = child.stdin.take().expect("a pipe");
    let domain = common::domain("again");
    let source = || {
        let all = common::processes();
        let mut found = all
            .into_iter()
            .filter(|(_, args)| args.contains(&domain) && args.iter().any(|a| a == "sensor"));
        found.next().map(|(pid, _)| pid)
    };
    common::wait_until("a source", Duration::from_secs(20), || source().is_some());
    let first = source().expect("a source");
    for n in 0..600 {
        if n == 300 {
            kill(first, Signal::KILL);
            common::wait_until("another", Duration::from_secs(20), || {
                source().is_some_and(|pid| pid != first)
            });
        }
        let time = 1.7e9 + f64::from(n) * 0.01;
        writeln!(pipe, "({time:.6}) can0 064#{:08X}", n * 1000).expect("somebody reads");
        writeln!(pipe, "({time:.6}) can0 065#{:08X}", n * 1000).expect("somebody reads");
        std::thread::sleep(Duration::from_millis(10));
    }
    drop(pipe);
    let output = child.wait_with_output().expect("heft ends");
    let rows: Vec<ExcavatorSensors> = Reader::open(out.path())
        .and_then(|r| r.messages(EXCAVATOR_SENSORS.name))
        .expect("samples");
    let last = rows.iter().filter(|s| s.stamp.epoch == 1).count();
    assert!(
        last > 200,
        "{last} samples of the second source: {}",
        both(&output)
    );
    assert!(rows.windows(2).all(|w| w[1].stamp.time > w[0].stamp.time));
}

#[test]
fn a_bus_without_a_map_is_refused_with_the_remedy() {
    let output = run(&["run", "excavator", "--input", "can:can0"]);
    assert_eq!(output.status.code(), Some(2), "{}", both(&output));
    says(&output, "heft map");
}

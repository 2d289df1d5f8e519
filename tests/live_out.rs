//! Outputs of a running pipeline: frames on a bus, lines and bytes in a pipe, a program in C.

mod common;
mod vcan;

use std::collections::BTreeMap;
use std::io::Read;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use common::{Running, both, heft, run, run_ok, says};
use messages::channels::{EXCAVATOR_INERTIA_UKF, EXCAVATOR_LOADS};
use messages::{ExcavatorEstimate, ExcavatorLoads, Machine, Message};
use recording::Reader;
use recording::can::Outgoing;
use rustix::process::Signal;

/// The estimates of a recording by their time [µs].
fn recorded(path: &Path) -> BTreeMap<i64, ExcavatorEstimate> {
    let reader = Reader::open(path).expect("a recording");
    let all: Vec<ExcavatorEstimate> = reader
        .messages(EXCAVATOR_INERTIA_UKF.name)
        .expect("estimates");
    let micro = |e: &ExcavatorEstimate| (e.stamp.time * 1e6) as i64;
    all.iter().map(|e| (micro(e), *e)).collect()
}

/// The output of `heft tail` of a run in `seconds`, and the recording of that run.
fn tailed(name: &str, arguments: &[&str], seconds: u64) -> (Vec<u8>, tempfile::TempDir) {
    let running = Running::start(name, &["excavator"]);
    running.wait_for_services();
    std::thread::sleep(Duration::from_secs(1));
    let mut tail = heft()
        .args(["tail", "--domain", &running.domain])
        .args(arguments)
        .stdout(Stdio::piped())
        .spawn()
        .expect("heft starts");
    let mut pipe = tail.stdout.take().expect("a pipe");
    let reader = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        pipe.read_to_end(&mut bytes).expect("what it printed");
        bytes
    });
    std::thread::sleep(Duration::from_secs(seconds));
    running.signal(Signal::TERM);
    let (_, folder) = running.wait();
    let _ = tail.wait();
    (reader.join().expect("what it printed"), folder)
}

/// A program that plots its input must not plot an absent sensor.
#[test]
fn what_is_not_measured_is_null_in_json_and_absent_in_the_line_protocol() {
    let sensors = ["excavator/sensors", "--format"];
    let (json, folder) = tailed("null", &[&sensors[..], &["json"]].concat(), 1);
    let (influx, _) = tailed("absent", &[&sensors[..], &["influx"]].concat(), 1);
    let last = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes).into_owned();
        text.lines().last().expect("a sample").to_owned()
    };
    let sample: serde_json::Value = serde_json::from_str(&last(&json)).expect("JSON");
    assert!(sample["swing_velocity"].is_f64() && sample["swing_angle"].is_null());
    let line = last(&influx);
    assert!(
        line.contains(",swing_velocity=") && !line.contains("swing_angle"),
        "{line}"
    );
    // The table of the same run.
    let path = |path: &Path| path.to_str().expect("a path").to_owned();
    let out = folder.path().join("out");
    run_ok(&["export", &path(folder.path()), "-o", &path(&out)]);
    let table = std::fs::read_to_string(out.join("excavator_inertia_ukf.csv")).expect("a table");
    let (header, row) = (table.lines().next(), table.lines().last());
    let cells = header
        .expect("a header")
        .split(',')
        .zip(row.expect("a row").split(','));
    let cells: BTreeMap<&str, &str> = cells.collect();
    assert!(
        !cells["inertia"].is_empty() && cells["friction"].is_empty(),
        "{cells:?}"
    );
}

#[test]
fn the_frames_that_tail_prints_are_those_of_the_estimates() {
    let arguments = ["--format", "candump", "--rate", "20"];
    let (printed, folder) = tailed("frames", &arguments, 3);
    let estimates = recorded(folder.path());
    let outgoing = Outgoing::new(Machine::Excavator, None).expect("the usual frames");
    let printed = String::from_utf8(printed).expect("text");
    for line in printed.lines() {
        let time = line.get(1..).and_then(|l| l.split(')').next());
        let time: f64 = time.and_then(|t| t.parse().ok()).expect("a time");
        let near = (time * 1e6).round() as i64;
        let (_, estimate) = estimates.range(near - 1..=near + 1).next().expect(line);
        let time_ns = (estimate.stamp.time * 1e9) as i64;
        let envelope = estimate.envelope();
        let mut wanted = outgoing
            .frames(&envelope, time_ns, "heft")
            .map(|f| f.line());
        assert!(wanted.any(|wanted| wanted == line), "{line}");
    }
    assert!(printed.lines().count() > 60, "{printed}");
}

#[test]
fn a_program_in_c_reads_the_samples_that_rust_wrote() {
    let dir = tempfile::tempdir().expect("a folder");
    let header = run_ok(&["schema", "--lang", "c"]);
    let main = "#include <stdio.h>\nint main(void) {\n  heft_ExcavatorEstimate e;\n  \
                while (fread(&e, sizeof e, 1, stdin) == 1)\n    \
                printf(\"%llu %.17g %.17g %u\\n\", (unsigned long long)e.sequence, e.inertia, e.inertia_std, e.flags);\n  \
                return 0;\n}\n";
    let source = dir.path().join("reader.c");
    std::fs::write(&source, header + main).expect("writable");
    let program = dir.path().join("reader");
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-o"]);
    let compiled = compiler.arg(&program).arg(&source).output();
    let Ok(compiled) = compiled else {
        let _ = writeln!(std::io::stderr(), "skipped: there is no C compiler (cc)");
        return;
    };
    assert!(compiled.status.success(), "{}", both(&compiled));
    let (bytes, folder) = tailed("bytes", &["--format", "binary"], 2);
    let input = dir.path().join("bytes");
    std::fs::write(&input, bytes).expect("writable");
    let read = Command::new(&program)
        .stdin(std::fs::File::open(&input).expect("the bytes"))
        .output()
        .expect("it runs");
    let by_number: BTreeMap<u64, ExcavatorEstimate> = recorded(folder.path())
        .into_values()
        .map(|e| (e.stamp.sequence, e))
        .collect();
    let text = String::from_utf8_lossy(&read.stdout).into_owned();
    for line in text.lines() {
        let cells: Vec<&str> = line.split(' ').collect();
        let number: u64 = cells[0].parse().expect("a number");
        let e = by_number.get(&number).expect("a recorded estimate");
        let value = |cell: &str| cell.parse::<f64>().expect("a number").to_bits();
        let wanted = (e.inertia.to_bits(), e.inertia_std.to_bits(), e.flags);
        let flags: u32 = cells[3].parse().expect("bits");
        assert_eq!((value(cells[1]), value(cells[2]), flags), wanted, "{line}");
    }
    assert!(text.lines().count() > 50, "{text}");
}

#[test]
fn what_cannot_be_sent_is_refused_before_anything_starts() {
    for (arguments, word) in [
        (&["--output", "kafka:1"][..], "can:can0"),
        (
            &["--output", "can:vcan0", "--output-map", "/nowhere.toml"],
            "/nowhere.toml",
        ),
    ] {
        let all = [&["run", "excavator"], arguments].concat();
        let output = run(&all);
        assert_eq!(output.status.code(), Some(2), "{}", both(&output));
        says(&output, word);
    }
    let dbc = run_ok(&["schema", "--lang", "dbc"]);
    assert!(
        dbc.contains("SG_ inertia ") && dbc.contains("SG_ cg_height "),
        "{dbc}"
    );
}

#[test]
fn on_a_real_bus() {
    vcan::run_ignored_tests();
}

#[test]
#[ignore = "needs vcan0; run through tests/tools/with-can"]
fn estimates_are_sent_as_frames_and_a_bus_that_goes_costs_no_estimate() {
    let arguments = ["excavator", "--output", "can:vcan1", "--duration", "15"];
    let running = Running::start("sent", &arguments);
    let frames = vcan::Recorder::start("vcan1");
    running.wait_for_services();
    std::thread::sleep(Duration::from_secs(8));
    vcan::set_interface("vcan1", "down");
    std::thread::sleep(Duration::from_secs(2));
    vcan::set_interface("vcan1", "up");
    let (output, folder) = running.wait();
    let said = both(&output);
    assert!(
        !said.contains("died") && !said.contains("panicked"),
        "{said}"
    );
    let frames = frames.stop();
    let outgoing = Outgoing::new(Machine::Excavator, None).expect("the usual frames");
    let estimates = recorded(folder.path());
    let reader = Reader::open(folder.path()).expect("a recording");
    let loads: Vec<ExcavatorLoads> = reader.messages(EXCAVATOR_LOADS.name).expect("loads");
    let all: std::collections::BTreeSet<String> = estimates
        .values()
        .map(Message::envelope)
        .chain(loads.iter().map(Message::envelope))
        .flat_map(|envelope| {
            let frames = outgoing.frames(&envelope, 0, "vcan1").map(|f| f.line());
            frames.collect::<Vec<_>>()
        })
        .collect();
    let unstamped = |line: &str| line.split_once(' ').map(|(_, rest)| rest.to_owned());
    let all: std::collections::BTreeSet<_> = all.iter().filter_map(|l| unstamped(l)).collect();
    let mut claims = 0;
    for line in frames.lines() {
        let frame = unstamped(line).expect("a frame");
        if frame.contains(" 18EEFF80#") {
            claims += 1;
            continue;
        }
        assert!(all.contains(&frame), "{line} is of no estimate");
    }
    assert!(claims >= 2, "one at the start, one when the bus is back");
    assert!(frames.lines().count() > 100, "{frames}");
    assert_eq!(estimates.len(), 1501, "no estimate is missing: {said}");
}

#[test]
#[ignore = "needs vcan0; run through tests/tools/with-can"]
fn two_machines_of_one_computer_are_two_nodes() {
    let frames = vcan::Recorder::start("vcan1");
    let start = |name, machine| {
        let arguments = [machine, "--output", "can:vcan1", "--duration", "8"];
        Running::start(name, &arguments)
    };
    let both_run = [start("node-a", "excavator"), start("node-b", "loader")];
    for running in both_run {
        running.wait();
    }
    let frames = frames.stop();
    let (mut names, mut senders) = (BTreeMap::new(), BTreeMap::new());
    for line in frames.lines() {
        let (id, data) = line.rsplit_once(' ').expect("a frame").1.split_at(8);
        let source = &id[6..];
        if &id[2..4] == "EE" {
            names.insert(data, source);
        } else {
            // 0xff1N are groups of the excavator, 0xff2N of the loader: the last address of each.
            senders.insert(&id[2..5], source);
        }
    }
    assert_eq!(names.len(), 2, "{frames}");
    assert_eq!(senders.len(), 2, "{frames}");
    let addresses: std::collections::BTreeSet<_> = senders.values().collect();
    assert_eq!(addresses.len(), 2, "one address for both: {senders:?}");
}

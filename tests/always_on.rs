//! Endless recordings: parts of a bounded length, a bounded size, a logger that is killed, a full
//! disk.

mod common;

use std::path::Path;
use std::time::Duration;

use common::{Running, both, heft, kill, run_ok, wait_until, words};
use messages::channels::{EXCAVATOR_INERTIA_UKF, EXCAVATOR_SENSORS};
use messages::{ExcavatorEstimate, ExcavatorSensors};
use recording::Reader;
use rustix::process::Signal;

fn text(path: &Path) -> &str {
    path.to_str().expect("a path")
}

/// Numbers of the samples in a recording or its folder.
fn numbers(path: &Path) -> Vec<u64> {
    common::sequences::<ExcavatorSensors>(path, EXCAVATOR_SENSORS.name)
}

/// The recordings and parts in a folder.
fn files(folder: &Path) -> Vec<std::path::PathBuf> {
    let all = std::fs::read_dir(folder).expect("a folder").flatten();
    let all = all.map(|e| e.path());
    all.filter(|p| p.extension().is_some_and(|e| e == "mcap"))
        .collect()
}

#[test]
fn parts_are_whole_and_are_read_as_one() {
    let run = Running::start("parts", "excavator --duration 8 --split 1s".split(' '));
    let (output, folder) = run.wait();
    assert!(files(folder.path()).len() > 3, "{}", both(&output));
    for part in files(folder.path()) {
        let reader = Reader::open(&part).expect("a recording");
        assert!(reader.is_complete(), "{}", part.display());
        let begun = reader
            .metadata()
            .get("wall_clock.start")
            .expect("a wall clock");
        assert!(begun.starts_with("20"), "{begun}");
    }
    assert_eq!(numbers(folder.path()), (0..=800).collect::<Vec<_>>());
    // Every reader accepts the folder.
    let verified = run_ok(&["replay", text(folder.path()), "--verify"]);
    assert!(verified.contains("bit-identical"), "{verified}");
    let out = folder.path().join("out");
    let csv = folder.path().join("estimates.csv");
    let page = folder.path().join("page.html");
    run_ok(&["export", text(folder.path()), "-o", text(&out)]);
    run_ok(&["report", text(folder.path()), "-o", text(&page)]);
    let arguments = ["--machine", "excavator", "-o", text(&csv)];
    run_ok(&[&["estimate", text(folder.path())], &arguments[..]].concat());
    let rows = std::fs::read_to_string(&csv).expect("estimates");
    assert_eq!(rows.lines().count(), 802);
}

#[test]
fn old_parts_make_room_for_new_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |name: &str| {
        let arguments =
            "run excavator --pace max --duration 90 --quiet --no-report --split 200kB --keep 1MB";
        let mut command = heft();
        command.args(arguments.split(' '));
        command.args([
            "--domain",
            &common::domain(name),
            "--out",
            text(folder.path()),
        ]);
        command.output().expect("heft starts")
    };
    let (first, second) = (run("keep1"), run("keep2"));
    let said = both(&first) + &both(&second);
    let sizes = files(folder.path());
    let sizes: Vec<u64> = sizes
        .iter()
        .map(|f| std::fs::metadata(f).map_or(0, |m| m.len()))
        .collect();
    // In addition to the retained parts there is the part being written, of at most twice the length.
    let total: u64 = sizes.iter().sum();
    assert!((200_000..1_400_000).contains(&total), "{sizes:?}: {said}");
    assert!(sizes.iter().all(|s| *s < 400_000), "{sizes:?}: {said}");
    let kept = numbers(folder.path());
    assert!(kept.windows(2).all(|w| w[0] + 1 == w[1]), "without a gap");
    let answers = EXCAVATOR_INERTIA_UKF.name;
    let answers = common::sequences::<ExcavatorEstimate>(folder.path(), answers);
    let is_whole = kept.last() == Some(&9000) && answers.last() == Some(&9000);
    // On a host without a spare processor a service may hang; its losses are reported, with their status.
    assert!(
        is_whole || second.status.code() == Some(1),
        "lost without a word: {:?}, {:?}: {said}",
        kept.last(),
        answers.last()
    );
    // Commands that take files accept the name of the removed first part too, and those that take folders find the recording.
    let name = folder.path().join("run-2.mcap");
    assert!(!name.exists(), "{sizes:?}: {said}");
    run_ok(&["loads", text(folder.path())]);
    run_ok(&["loads", text(&name)]);
    let table = folder.path().join("estimates.csv");
    run_ok(&["estimate", text(&name), "-o", text(&table)]);
}

#[test]
fn a_logger_that_is_killed_at_the_end_of_parts_loses_no_sample() {
    let run = Running::start("killed", "excavator --duration 16 --split 1s".split(' '));
    run.wait_for_services();
    std::thread::sleep(Duration::from_millis(1500));
    for n in 0..6 {
        // Sometimes before, sometimes after the end of a part.
        std::thread::sleep(Duration::from_millis(1400 + 130 * n));
        let old = run.service("logger").expect("a logger");
        kill(old, Signal::KILL);
        wait_until("another logger", Duration::from_secs(20), || {
            run.service("logger").is_some_and(|new| new != old)
        });
    }
    let (output, folder) = run.wait();
    let said = both(&output);
    let died = "logger died (signal: 9 (SIGKILL)); it was started again (6 times)";
    assert!(said.contains(died), "{said}");
    // The writers buffer five seconds at 100 Hz: more than a flush, a visit and the start of a logger take.
    let all: Vec<u64> = (0..=1600).collect();
    assert_eq!(numbers(folder.path()), all, "each once, in order: {said}");
    let answers = EXCAVATOR_INERTIA_UKF.name;
    let answers = common::sequences::<ExcavatorEstimate>(folder.path(), answers);
    assert_eq!(answers, all, "{said}");
    assert!(output.status.success() && !said.contains("gap"), "{said}");
}

#[test]
fn a_disk_without_room_stops_the_recording_and_not_the_estimation() {
    let arguments = words("excavator --verbose --duration 4 --min-free 900000TB");
    let run = Running::start("full", &arguments);
    let (output, folder) = run.wait();
    let said = both(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("--min-free"), "{said}");
    assert!(said.contains("the disk took no more"), "{said}");
    assert!(
        said.contains("401 samples, 0 lost"),
        "estimation goes on: {said}"
    );
    assert!(numbers(folder.path()).len() < 401);
}

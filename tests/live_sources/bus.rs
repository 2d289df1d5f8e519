//! Tests on a real bus.

use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::Duration;

use messages::channels::{EXCAVATOR_INERTIA_UKF, EXCAVATOR_SENSORS, HEALTH, LOADER_SENSORS};
use messages::{ExcavatorEstimate, ExcavatorSensors, Health, excavator_bits};
use recording::Reader;
use rustix::process::Signal;

use crate::common::{self, Running, both, kill, says};
use crate::vcan::{self, Frame, Recorder, Talker, set_interface};
use crate::{assert_same, estimates, frames, mapped, swings, text, theirs};

#[test]
fn on_a_real_bus() {
    vcan::run_ignored_tests();
}

/// A run on vcan0 that receives: the kernel lists its socket among those that get every frame, and it
/// has come to rest after its start.
fn on_bus(name: &str, machine: &str, map: &Path) -> Running {
    let run = Running::start(name, &[machine, "--input", "can:vcan0", "--map", text(map)]);
    common::wait_until("the bus is listened to", Duration::from_secs(120), || {
        let list = std::fs::read_to_string("/proc/net/can/rcvlist_all").unwrap_or_default();
        let line = |l: &str| l.trim().starts_with("vcan0") && l.trim().ends_with("raw");
        list.lines().any(line)
    });
    std::thread::sleep(Duration::from_secs(3));
    run
}

/// Waits until enough is recorded, for a minute at most: a slow kernel on a busy machine takes that long.
fn wait_for_record(run: &Running, mut is_there: impl FnMut(&Reader) -> bool) -> bool {
    (0..120).any(|_| {
        std::thread::sleep(Duration::from_millis(500));
        Reader::open(run.recording()).is_ok_and(|reader| is_there(&reader))
    })
}

/// Checks that no process died. On a slow kernel some may be late.
fn assert_calm(output: &Output) {
    let said = both(output);
    let is_calm = !said.contains("panicked") && !said.contains("died");
    assert!(is_calm && output.status.code() != Some(2), "{said}");
    // Shown where the test fails: whether frames were dropped.
    println!("{said}");
}

/// Ends a run, and returns its recording.
fn end(run: Running) -> (tempfile::TempDir, PathBuf, Output) {
    run.signal(Signal::TERM);
    let recording = run.recording();
    let (output, folder) = run.wait();
    (folder, recording, output)
}

#[test]
#[ignore = "needs vcan0; run through tests/tools/with-can"]
fn a_bus_gives_the_bits_of_its_log() {
    let (dir, map) = mapped();
    let rows = swings(15.0).0;
    let run = on_bus("bits", "excavator", &map);
    let beside = Recorder::start("vcan0");
    Talker::open("vcan0").play(rows.into_iter().flat_map(frames));
    let log = dir.path().join("bus.log");
    std::fs::write(&log, beside.stop()).expect("writable");
    let file = estimates("excavator", &log, Some(&map));
    let samples = EXCAVATOR_SENSORS.name;
    wait_for_record(&run, |reader| {
        reader.counts().get(samples).copied().unwrap_or(0) as usize >= file.lines().count()
    });
    let (_folder, recording, output) = end(run);
    assert_calm(&output);
    assert_same("excavator", &recording, &file, true);
}

#[test]
#[ignore = "needs vcan0; run through tests/tools/with-can"]
fn a_truck_on_the_bus_gives_the_bits_of_its_log() {
    let Some(truck) = theirs::data("can/truck_normal_drive.log") else {
        return;
    };
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/maps/truck.toml");
    let run = on_bus("truck", "loader", &map);
    let beside = Recorder::start("vcan0");
    Talker::open("vcan0").play(vcan::frames_of_log(&truck).into_iter());
    let dir = tempfile::tempdir().expect("a folder");
    let log = dir.path().join("bus.log");
    std::fs::write(&log, beside.stop()).expect("writable");
    let file = estimates("loader", &log, Some(&map));
    let samples = LOADER_SENSORS.name;
    wait_for_record(&run, |reader| {
        reader.counts().get(samples).copied().unwrap_or(0) as usize >= file.lines().count()
    });
    let (_folder, recording, output) = end(run);
    assert_calm(&output);
    assert_same("loader", &recording, &file, true);
}

/// Checks that trusted estimates are within three standard deviations of the truth; returns their number.
fn assert_honest(reader: &Reader, inertia: f64) -> usize {
    let all: Vec<ExcavatorEstimate> = reader.messages(EXCAVATOR_INERTIA_UKF.name).expect("some");
    let trusted = all
        .iter()
        .filter(|e| e.flags & excavator_bits::TRUSTED != 0);
    let off = |e: &&ExcavatorEstimate| (e.inertia - inertia).abs() > 3.0 * e.inertia_std;
    let wrong: Vec<_> = trusted.clone().filter(off).collect();
    let shown = wrong
        .first()
        .map(|e| (e.stamp.time, e.inertia, e.inertia_std));
    assert!(wrong.is_empty(), "{} off {inertia}: {shown:?}", wrong.len());
    trusted.count()
}

#[test]
#[ignore = "needs vcan0; run through tests/tools/with-can"]
fn silence_costs_freshness_and_an_interface_may_go_and_come_back() {
    let (_dir, map) = mapped();
    let (rows, truth) = swings(30.0);
    let third = rows.len() / 3;
    let run = on_bus("silence", "excavator", &map);
    let mut talker = Talker::open("vcan0");
    talker.play(rows[..third].iter().copied().flat_map(frames));
    std::thread::sleep(Duration::from_secs(2));
    talker.play(rows[third..2 * third].iter().copied().flat_map(frames));
    set_interface("vcan0", "down");
    std::thread::sleep(Duration::from_secs(3));
    set_interface("vcan0", "up");
    let mut talker = Talker::open("vcan0");
    talker.play(rows[2 * third..].iter().copied().flat_map(frames));
    let (_folder, recording, output) = end(run);
    assert_calm(&output);
    says(&output, "vcan0 is back");
    let reader = Reader::open(&recording).expect("a recording");
    let live: Vec<ExcavatorSensors> = reader.messages(EXCAVATOR_SENSORS.name).expect("samples");
    assert!(live.iter().all(|s| s.stamp.epoch == 0), "no restart");
    assert!(live.windows(2).all(|w| w[1].stamp.time > w[0].stamp.time));
    let is_missing = |s: &ExcavatorSensors| s.valid & excavator_bits::SWING_VELOCITY == 0;
    let missing: Vec<&ExcavatorSensors> = live.iter().filter(|s| is_missing(s)).collect();
    // Gaps of 2 s and 3 s: each gives 0.7 s at 100 Hz after the hold time, then 10 Hz.
    assert!(
        (150..300).contains(&missing.len()),
        "{} silent",
        missing.len()
    );
    let estimates: Vec<ExcavatorEstimate> = reader
        .messages(EXCAVATOR_INERTIA_UKF.name)
        .expect("estimates");
    // Half a second after the begin of a gap no estimate is fresh, and none is trusted.
    let stale = missing
        .windows(50)
        .filter(|w| w[49].stamp.sequence == w[0].stamp.sequence + 49);
    let mut checked = 0;
    for sequence in stale.map(|w| w[49].stamp.sequence) {
        let found = estimates.iter().find(|e| e.stamp.sequence == sequence);
        let reported = excavator_bits::FRESH | excavator_bits::TRUSTED;
        assert!(
            found.is_some_and(|e| e.flags & reported == 0),
            "sample {sequence}"
        );
        checked += 1;
    }
    assert!(checked > 40, "{checked}");
    let last = live.last().expect("a sample").stamp.time;
    let back = live
        .iter()
        .filter(|s| s.stamp.time > last - 5.0 && !is_missing(s))
        .count();
    assert!(back > 400, "{back} samples after the interface came back");
    assert_honest(&reader, truth[0]);
}

#[test]
#[ignore = "needs vcan0; run through tests/tools/with-can"]
fn a_second_talker_and_random_frames_make_nothing_false_trusted() {
    let (_dir, map) = mapped();
    let (rows, truth) = swings(24.0);
    let half = rows.len() / 2;
    let run = on_bus("talkers", "excavator", &map);
    let mut talker = Talker::open("vcan0");
    talker.play(rows[..half].iter().copied().flat_map(frames));
    // The motion of another machine under the same identifiers, in between.
    let other = |[t, v, m]: [f64; 3]| frames([t + 0.005, 0.4 - 0.7 * v, 0.3 * m]);
    let both_talk = rows[half..]
        .iter()
        .flat_map(|r| frames(*r).into_iter().chain(other(*r)));
    talker.play(both_talk);
    let mut state = 7_u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) as u32
    };
    let anything = (0..10_000).map(|n| {
        let (id, length) = (random() % 0x7ff, random() as usize % 9);
        Frame {
            time: f64::from(n) * 0.0005,
            id: if random() % 8 == 0 { 100 + id % 2 } else { id },
            extended: false,
            data: (0..length).map(|_| random() as u8).collect(),
        }
    });
    talker.play(anything);
    let (_folder, recording, output) = end(run);
    assert_calm(&output);
    let reader = Reader::open(&recording).expect("a recording");
    assert_honest(&reader, truth[0]);
}

#[test]
#[ignore = "needs vcan0; run through tests/tools/with-can"]
fn frames_that_the_kernel_dropped_are_counted() {
    let (_dir, map) = mapped();
    let run = on_bus("dropped", "excavator", &map);
    let sensor = run.service("sensor").expect("a source");
    let mut talker = Talker::open("vcan0");
    talker.play(frames([0.0, 0.1, 1.0]).into_iter());
    // The supervisor would end a stopped source, and a slow kernel takes longer to fill the queue.
    run.signal(Signal::STOP);
    kill(sensor, Signal::STOP);
    // More frames than any queue holds.
    for _ in 0..4_000 {
        talker.say(&frames([0.0, 0.1, 1.0])[0]);
    }
    kill(sensor, Signal::CONT);
    std::thread::sleep(Duration::from_secs(1));
    run.signal(Signal::CONT);
    // The number of dropped frames comes with the next frame that fits into the queue.
    let is_counted = wait_for_record(&run, |reader| {
        talker.say(&frames([0.0, 0.1, 1.0])[0]);
        let health: Vec<Health> = reader.messages(HEALTH.name).unwrap_or_default();
        health.iter().any(|h| h.process == 0 && h.lost > 1000)
    });
    let (_folder, _recording, output) = end(run);
    let said = both(&output);
    assert!(is_counted && output.status.code() == Some(1), "{said}");
    assert!(said.contains("frames were dropped by the kernel"), "{said}");
}

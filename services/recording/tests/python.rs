//! A recording is opened by Python's `mcap` and `mcap-protobuf-support` from PyPI. The packages are
//! installed into a virtual environment below the target folder; where that is not possible within
//! a minute, the test says so and passes.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use messages::ExcavatorSensors;
use messages::channels::EXCAVATOR_SENSORS;
use recording::{Metadata, Writer};

/// Runs a command for at most a minute; whether it ended well.
fn works(command: &mut Command) -> bool {
    let quiet = command.stdout(Stdio::null()).stderr(Stdio::null());
    let Ok(mut child) = quiet.spawn() else {
        return false;
    };
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(60) {
        match child.try_wait() {
            Ok(Some(status)) => return status.success(),
            Ok(None) => std::thread::sleep(Duration::from_millis(100)),
            Err(_) => break,
        }
    }
    let _ = child.kill();
    let _ = child.wait();
    false
}

/// A Python that has the packages.
fn python() -> Option<PathBuf> {
    let has = |python: &Path| works(Command::new(python).args(["-c", "import mcap_protobuf"]));
    let venv = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python");
    let own = venv.join("bin/python");
    if has(&own) {
        return Some(own);
    }
    works(Command::new("python3").args(["-m", "venv"]).arg(&venv));
    let packages = ["mcap", "mcap-protobuf-support"];
    works(
        Command::new(&own)
            .args(["-m", "pip", "install", "--quiet"])
            .args(packages),
    );
    let found = has(&own);
    if !found {
        println!("skipped: python3 with mcap and mcap-protobuf-support cannot be installed here");
    }
    found.then_some(own)
}

#[test]
fn python_reads_values_units_and_metadata_from_a_recording() {
    let Some(python) = python() else { return };
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("run.mcap");
    let metadata: Metadata = [("seed".to_owned(), "7".to_owned())].into();
    let mut writer = Writer::create(&path, &metadata).expect("a file");
    for n in 0..250_u64 {
        let mut sensors = ExcavatorSensors {
            swing_velocity: -0.0625,
            valid: 3,
            ..Default::default()
        };
        sensors.stamp.sequence = n;
        sensors.stamp.measured_ns = 1_000_000_000 + n;
        writer.write(&EXCAVATOR_SENSORS, &sensors).expect("room");
    }
    writer.finish().expect("room");
    let script = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/tools/read_recording.py"
    );
    let output = Command::new(python)
        .arg(script)
        .arg(&path)
        .output()
        .expect("python runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    for expected in [
        "\"seed\": \"7\"",
        "\"type\": \"heft.ExcavatorSensors\"",
        "\"messages\": 250",
        "\"swing_velocity\": \"rad/s\"",
        "\"swing_velocity\": -0.0625",
        "\"sequence\": 249",
        "\"valid\": 3",
        "\"log_time\": 1000000249",
    ] {
        assert!(
            text.contains(expected),
            "no {expected} in:\n{text}\n{errors}"
        );
    }
}

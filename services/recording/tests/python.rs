//! Python's `mcap` and `mcap-protobuf-support` from PyPI open a recording, and `cantools` decodes frames. The packages are
//! installed into a virtual environment below the target folder; if that is not possible within
//! a minute, the test reports that and passes.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use messages::channels::EXCAVATOR_SENSORS;
use messages::{
    ExcavatorEstimate, ExcavatorSensors, LoaderEstimate, Machine, Message, excavator_bits as e,
    loader_bits as l,
};
use recording::can::Outgoing;
use recording::{Metadata, Writer};

/// Runs a command for at most a minute; returns whether it succeeded.
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

/// A Python with these packages, by which `module` can be imported.
fn python(module: &str, packages: &[&str]) -> Option<PathBuf> {
    let import = format!("import {module}");
    let has = |python: &Path| works(Command::new(python).args(["-c", &import]));
    // A separate one for each: tests run at the same time.
    let venv = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("python-{module}"));
    let own = venv.join("bin/python");
    if has(&own) {
        return Some(own);
    }
    works(Command::new("python3").args(["-m", "venv"]).arg(&venv));
    works(
        Command::new(&own)
            .args(["-m", "pip", "install", "--quiet"])
            .args(packages),
    );
    let found = has(&own);
    if !found {
        let _ = writeln!(
            std::io::stderr(),
            "skipped: python3 with {} cannot be installed here",
            packages.join(" and ")
        );
    }
    found.then_some(own)
}

#[test]
fn python_reads_values_units_and_metadata_from_a_recording() {
    let Some(python) = python("mcap_protobuf", &["mcap", "mcap-protobuf-support"]) else {
        return;
    };
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

/// Rows for the script: a signal of a frame of an estimate, and the expected value.
#[derive(Default)]
struct Rows(String);

impl Rows {
    fn add<M: Message>(
        &mut self,
        outgoing: &Outgoing,
        estimate: &M,
        kind: usize,
        signal: &str,
        wanted: &str,
    ) {
        let envelope = estimate.envelope();
        let frame = outgoing.frames(&envelope, 0, "can0").nth(kind);
        let frame = frame.expect("a frame of each kind");
        let data: String = frame.data().iter().map(|b| format!("{b:02x}")).collect();
        self.0 += &format!("{},{data},{signal},{wanted}\n", frame.id);
    }

    /// A quantity and its standard deviation: present if it is trusted.
    fn quantity<M: Message>(
        &mut self,
        outgoing: &Outgoing,
        estimate: &M,
        kind: usize,
        name: &str,
        trusted: bool,
    ) {
        for signal in [name.to_owned(), format!("{name}_std")] {
            let value = estimate.number(&signal).expect("a field of the estimate");
            let wanted = if trusted {
                format!("{value:?}")
            } else {
                String::new()
            };
            self.add(outgoing, estimate, kind, &signal, &wanted);
        }
    }
}

fn excavator_estimate(x: f64, trusted: bool) -> ExcavatorEstimate {
    ExcavatorEstimate {
        inertia: 1999.377 * x,
        inertia_std: 7.77 * x,
        payload: 31.4159 * x - 500.0,
        payload_std: 0.123_456 + x,
        damping: 271.828 * x,
        damping_std: 1.414 * x,
        flags: if trusted {
            e::TRUSTED | e::FRESH
        } else {
            e::FRESH
        },
        estimated: e::INERTIA | e::PAYLOAD | e::DAMPING,
        ..ExcavatorEstimate::default()
    }
}

fn loader_estimate(x: f64, ratio: bool, height: bool) -> LoaderEstimate {
    LoaderEstimate {
        cg_ratio: 0.004 * x,
        cg_ratio_std: 0.000_777 * x,
        cg_height: 0.0314 * x,
        cg_height_std: 0.001_41 * x,
        flags: if ratio { l::TRUSTED_RATIO } else { 0 }
            | if height { l::TRUSTED_HEIGHT } else { 0 },
        estimated: l::STATE,
        ..LoaderEstimate::default()
    }
}

#[test]
fn cantools_reads_what_is_trusted_within_half_a_bit_and_nothing_else() {
    let Some(python) = python("cantools", &["cantools"]) else {
        return;
    };
    let machines = [Machine::Excavator, Machine::Loader];
    let [excavator, loader] = machines.map(|m| Outgoing::new(m, None).expect("the usual frames"));
    let mut rows = Rows::default();
    for n in 0..250 {
        // Irrational steps over the range of a machine, so that every fraction of a bit occurs.
        let x = f64::from(n) + (f64::from(n) * 0.618_033_988_749).fract();
        let (trusted, height) = (n % 4 != 0, n % 3 == 0);
        let estimate = excavator_estimate(x, trusted);
        for (kind, name) in ["inertia", "payload", "damping"].into_iter().enumerate() {
            rows.quantity(&excavator, &estimate, kind, name, trusted);
        }
        let verdict = format!("{:?}", f64::from(u8::from(trusted)));
        rows.add(&excavator, &estimate, 3, "trusted", &verdict);
        let estimate = loader_estimate(x, trusted, height);
        rows.quantity(&loader, &estimate, 0, "cg_ratio", trusted);
        rows.quantity(&loader, &estimate, 1, "cg_height", height);
    }
    let dir = tempfile::tempdir().expect("a folder");
    let (dbc, frames) = (dir.path().join("heft.dbc"), dir.path().join("frames.csv"));
    std::fs::write(&dbc, Outgoing::dbc(&[excavator, loader])).expect("writable");
    std::fs::write(&frames, rows.0).expect("writable");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/can/decode.py");
    let output = Command::new(python)
        .arg(script)
        .args([&dbc, &frames])
        .output()
        .expect("python runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    let words: Vec<&str> = text.split_whitespace().collect();
    let [values, "values,", absent, "not", "available,", bits, "bits"] = words[..] else {
        panic!("{text}\n{errors}");
    };
    // 187 of 250 are trusted, of the heights 84; and every verdict is read.
    assert_eq!((values, absent), ("1914", "836"), "{text}");
    // And the rounding of a double near the offset of the payload.
    let bits: f64 = bits.parse().expect("a number");
    assert!(bits <= 0.500_1, "{text}");
}

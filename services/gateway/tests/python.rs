//! `examples/fleet/subscribe.py`: a subscriber in another language. Needs python3 with eclipse-zenoh and protobuf,
//! or such an interpreter in HEFT_PYTHON.

use std::process::Command;

use crate::common::{Router, gateway, machine, of_repository};

#[test]
fn a_subscriber_in_python_prints_and_plots_what_machines_send() {
    let python = std::env::var("HEFT_PYTHON").unwrap_or_else(|_| "python3".into());
    let has = |modules: &str| {
        let mut command = Command::new(&python);
        let tried = command.args(["-c", &format!("import {modules}")]).output();
        tried.is_ok_and(|out| out.status.success())
    };
    if !has("zenoh, google.protobuf") {
        println!(
            "left out: no python3 with eclipse-zenoh and protobuf (HEFT_PYTHON names another)"
        );
        return;
    }
    let router = Router::start();
    let machines = [machine(100.0, 30.0, None), machine(100.0, 30.0, None)];
    let _gateways = [
        gateway(&machines[0], "ex-1", &router.address),
        gateway(&machines[1], "ex-2", &router.address),
    ];
    // The machines provide the schemas of their messages, so they must be running.
    crate::common::sleep(3.0);
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("inertia.png");
    let mut command = Command::new(&python);
    command.arg(of_repository("examples/fleet/subscribe.py"));
    command.args([
        "--connect",
        &router.address,
        "--site",
        "north",
        "--seconds",
        "4",
    ]);
    let plots = has("matplotlib");
    if plots {
        command.arg("--plot").arg(&picture);
    }
    let out = command.output().expect("it runs");
    let (printed, said) = (
        String::from_utf8_lossy(&out.stdout),
        String::from_utf8_lossy(&out.stderr),
    );
    assert!(out.status.success(), "{said}");
    for name in ["ex-1", "ex-2"] {
        let its: Vec<&str> = printed.lines().filter(|l| l.starts_with(name)).collect();
        // Two streams of ten messages per second for four seconds.
        assert!(
            (40..=100).contains(&its.len()),
            "{} of {name}: {printed}",
            its.len()
        );
        for line in its {
            let value = line.rsplit_once("inertia=").map(|(_, v)| v.parse::<f64>());
            // The inertia that the stand-in sends.
            let is_right = value.is_some_and(|v| v.is_ok_and(|v| (5790.0..5810.0).contains(&v)));
            assert!(
                is_right && line.contains(" run ") && line.contains(" t="),
                "{line}"
            );
        }
    }
    if plots {
        let bytes = std::fs::read(&picture).expect("a picture");
        assert!(
            bytes.starts_with(b"\x89PNG") && bytes.len() > 5000,
            "{}",
            bytes.len()
        );
    }
}

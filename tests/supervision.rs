//! Faults that the supervisor detects, reports and survives: services that hang, or die while the run starts
//! or ends; signals; a standard output without a reader.

mod common;

use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use common::{Running, both, heft, kill, says, wait_until, words};
use rustix::process::Signal;

fn cycle(name: &str, seconds: &str) -> Running {
    let args = ["excavator", "--scenario", "cycle", "--duration", seconds];
    let running = Running::start(name, &args);
    running.wait_for_services();
    wait_until("it records", Duration::from_secs(20), || {
        let about = running.recording().metadata();
        about.is_ok_and(|file| file.len() > 20_000)
    });
    running
}

#[test]
fn a_stopped_service_is_noticed_within_a_second_started_again_reported_and_costs_the_status() {
    let running = cycle("stop", "60");
    std::thread::sleep(Duration::from_secs(1));
    for name in ["ukf", "sensor", "logger"] {
        let victim = running.service(name).expect("it runs");
        let begun = Instant::now();
        kill(victim, Signal::STOP);
        wait_until("another is there", Duration::from_secs(5), || {
            running.service(name).is_some_and(|pid| pid != victim)
        });
        let noticed = begun.elapsed();
        // A tenth for the restart, two for a loaded test machine.
        assert!(noticed < Duration::from_millis(1300), "{name}: {noticed:?}");
        std::thread::sleep(Duration::from_millis(300));
    }
    running.signal(Signal::TERM);
    let (output, _folder) = running.wait();
    let text = both(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    for words in [
        "ukf hung",
        "sensor hung",
        "logger hung",
        "not answered by ukf",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn a_short_stop_is_forgiven() {
    let running = cycle("nap", "4");
    let victim = running.service("rls").expect("it runs");
    kill(victim, Signal::STOP);
    std::thread::sleep(Duration::from_millis(200));
    kill(victim, Signal::CONT);
    let (output, _folder) = running.wait();
    assert!(output.status.success(), "{}", both(&output));
    assert!(!both(&output).contains("hung"), "{}", both(&output));
}

#[test]
fn a_run_ends_within_five_seconds_whatever_hangs() {
    let running = cycle("hang", "60");
    std::thread::sleep(Duration::from_millis(500));
    for name in ["sensor", "kalman", "rls", "ukf", "logger"] {
        kill(running.service(name).expect("it runs"), Signal::STOP);
    }
    let begun = Instant::now();
    running.signal(Signal::TERM);
    let (output, _folder) = running.wait();
    assert!(
        begun.elapsed() < Duration::from_secs(5),
        "{:?}",
        begun.elapsed()
    );
    assert_eq!(output.status.code(), Some(1), "{}", both(&output));
    says(&output, "ukf hung");
}

#[test]
fn a_death_before_the_service_is_ready_is_a_death_like_any_other() {
    for name in ["sensor", "kalman", "logger"] {
        let early = (0..20).find_map(|_| killed_before_it_was_ready(name));
        let (output, text) = early.expect("one of twenty kills is early");
        assert!(output.status.success(), "nothing was lost: {text}");
        assert!(text.contains(&format!("{name} died")), "{text}");
    }
}

/// The output of a run whose service was killed as soon as it appeared. `None` if it had been ready by
/// then, as on a busy machine: it was ready twice.
fn killed_before_it_was_ready(name: &str) -> Option<(Output, String)> {
    let mut heft = heft();
    heft.env("RUST_LOG", "heft=info");
    let args = ["excavator", "--duration", "1"];
    let running = Running::start_with(heft, &format!("early-{name}"), &args);
    let mut victim = None;
    wait_until("it appears", Duration::from_secs(10), || {
        victim = running.service(name);
        victim.is_some()
    });
    kill(victim.expect("a process"), Signal::KILL);
    let (output, _folder) = running.wait();
    let text = both(&output);
    let ready = format!("ready service=\"{name}\"");
    (text.matches(&ready).count() == 1).then_some((output, text))
}

#[test]
fn a_logger_that_dies_while_the_run_ends_is_reported_and_its_recording_can_be_read() {
    let running = cycle("drain", "60");
    std::thread::sleep(Duration::from_millis(1500));
    // The drain waits for a blocked stage.
    kill(running.service("ukf").expect("it runs"), Signal::STOP);
    running.signal(Signal::TERM);
    std::thread::sleep(Duration::from_millis(200));
    kill(running.service("logger").expect("it runs"), Signal::KILL);
    let (output, folder) = running.wait();
    let text = both(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("logger died"), "{text}");
    let numbers = common::sequences::<messages::ExcavatorSensors>(
        &folder.path().join("run.mcap"),
        "excavator/sensors",
    );
    assert!(numbers.len() > 50, "{} samples", numbers.len());
}

#[test]
fn a_recording_that_was_removed_meanwhile_is_not_listed() {
    let running = cycle("gone", "60");
    std::fs::remove_dir_all(running.folder.path()).expect("removed");
    running.signal(Signal::TERM);
    let (output, _folder) = running.wait();
    let text = both(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    says(&output, "the recording is incomplete");
    assert!(
        !text.contains("  recording  ") && !text.contains("in parts"),
        "{text}"
    );
}

#[test]
fn a_terminal_that_hangs_up_ends_a_run_in_order() {
    let running = cycle("hup", "60");
    std::thread::sleep(Duration::from_millis(500));
    running.signal(Signal::HUP);
    let (output, _folder) = running.wait();
    assert!(output.status.success(), "{}", both(&output));
    says(&output, "recording");
}

#[test]
fn an_answer_that_no_reader_takes_is_reported_on_standard_error_and_sets_the_status() {
    let full = || {
        std::fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .expect("/dev/full")
    };
    let folder = tempfile::tempdir().expect("a folder");
    let run = words("run excavator --duration 0.5 --no-report --out");
    let commands = [
        vec!["doctor"],
        vec!["completions", "bash"],
        vec!["run", "loader", "--scenario", "list"],
        run.to_vec(),
    ];
    for (i, mut args) in commands.into_iter().enumerate() {
        if i == 3 {
            args.push(folder.path().to_str().expect("a path"));
        }
        let output = heft()
            .args(&args)
            .stdout(Stdio::from(full()))
            .output()
            .expect("heft starts");
        let text = both(&output);
        assert_eq!(output.status.code(), Some(1), "{args:?}: {text}");
        assert!(text.contains("cannot write the answer"), "{args:?}: {text}");
        let output = heft()
            .args(&args)
            .stderr(Stdio::from(full()))
            .output()
            .expect("heft starts");
        assert!(
            output.status.code().is_some_and(|c| c < 2),
            "{args:?}: {}",
            output.status
        );
    }
}

/// As with `| head`.
#[test]
fn a_reader_who_leaves_early_gets_no_message() {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let output = heft()
        .args(["completions", "bash"])
        .stdout(writer)
        .output()
        .expect("heft starts");
    assert_eq!(both(&output), "");
    assert_eq!(output.status.code(), Some(141));
}

/// As programs do that do not wait for their children: ignored signals are inherited.
#[test]
fn a_run_that_was_started_with_the_ends_of_children_ignored_ends_in_order() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = std::process::Command::new("env")
        .args(["--ignore-signal=CHLD", env!("CARGO_BIN_EXE_heft")])
        .args(["run", "excavator", "--duration", "0.5", "--quiet"])
        .args(["--no-report", "--out"])
        .arg(folder.path())
        .output()
        .expect("env");
    assert_eq!(output.status.code(), Some(0), "{}", both(&output));
}

#[test]
fn few_open_files_are_refused_with_the_command_that_helps() {
    let folder = tempfile::tempdir().expect("a folder");
    let script = format!(
        "ulimit -n 64; {} run excavator --duration 1 --out {}",
        env!("CARGO_BIN_EXE_heft"),
        folder.path().display()
    );
    let output = std::process::Command::new("sh")
        .args(["-c", &script])
        .output()
        .expect("sh");
    assert_eq!(output.status.code(), Some(2), "{}", both(&output));
    says(&output, "ulimit -n");
}

#[test]
fn the_service_manager_is_notified_that_a_run_is_ready_and_awake() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("notify");
    let socket = std::os::unix::net::UnixDatagram::bind(&path).expect("a socket");
    socket
        .set_read_timeout(Some(Duration::from_secs(10)))
        .expect("a limit");
    let mut child = heft()
        .args("run excavator --duration 2 --quiet --no-report --out".split(' '))
        .arg(folder.path().join("out"))
        .env("NOTIFY_SOCKET", &path)
        .env("WATCHDOG_USEC", "900000")
        .stdout(Stdio::null())
        .spawn()
        .expect("heft starts");
    let mut received = Vec::new();
    while received.last().is_none_or(|w| w != "STOPPING=1") {
        let mut word = [0; 64];
        let n = socket.recv(&mut word).expect("a word in time");
        received.push(String::from_utf8_lossy(&word[..n]).into_owned());
    }
    assert!(child.wait().expect("it ends").success());
    let ready = received.iter().position(|w| w == "READY=1").expect("ready");
    let awake = received[ready..]
        .iter()
        .filter(|w| *w == "WATCHDOG=1")
        .count();
    assert!(awake >= 4, "{received:?}");
}

/// Whether a gateway that takes this number of seconds had ended by itself when `heft run` ended.
fn run_with_gateway(seconds: u32, is_service: bool) -> bool {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let (beside, done) = (folder.path().join("heft"), folder.path().join("done"));
    std::fs::hard_link(env!("CARGO_BIN_EXE_heft"), &beside)
        .or_else(|_| std::fs::copy(env!("CARGO_BIN_EXE_heft"), &beside).map(|_| ()))
        .expect("heft");
    let gateway = folder.path().join("heft-gateway");
    let script = format!("#!/bin/sh\nsleep {seconds}\ntouch {}\n", done.display());
    std::fs::write(&gateway, script).expect("a script");
    std::fs::set_permissions(&gateway, std::fs::Permissions::from_mode(0o700)).expect("ours");
    let path = folder.path().join("notify");
    let _socket = std::os::unix::net::UnixDatagram::bind(&path).expect("a socket");
    let mut command = std::process::Command::new(&beside);
    command.args("run excavator --duration 1 --quiet --no-report".split(' '));
    command.args("--fleet tcp/127.0.0.1:1 --site north --machine-id ex-1 --out".split(' '));
    command.arg(folder.path().join("out"));
    command.env("XDG_STATE_HOME", folder.path());
    command.env_remove("NOTIFY_SOCKET");
    if is_service {
        command.env("NOTIFY_SOCKET", &path);
    }
    // It holds the standard error that it is given.
    command.stdout(Stdio::null()).stderr(Stdio::null());
    assert!(command.status().expect("it runs").success());
    done.exists()
}

#[test]
fn a_service_waits_for_its_gateway_and_a_run_by_hand_does_not() {
    assert!(run_with_gateway(5, true), "what is left would be killed");
    assert!(!run_with_gateway(20, false));
}

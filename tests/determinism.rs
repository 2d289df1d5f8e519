//! One thread, several processes and a replay give identical bits.

mod common;

use std::path::Path;

use common::{Running, both, golden, run_ok, says};
use messages::{
    ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth, LoaderEstimate, LoaderSensors, Message,
};

fn path(path: &Path) -> &str {
    path.to_str().expect("a printable path")
}

/// Rows of a CSV file as text: two files are equal if every digit is.
fn rows(file: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(file).expect("a CSV file");
    text.lines().map(str::to_owned).collect()
}

fn processes_agree_with_one_thread(machine: &str, method: &str, input: &Path, channel: &str) {
    services_agree_with_one_thread(machine, method, input, channel, &[]);
}

fn services_agree_with_one_thread(
    machine: &str,
    method: &str,
    input: &Path,
    channel: &str,
    more: &[&str],
) {
    let args = [
        machine,
        "--input",
        path(input),
        "--pace",
        "max",
        "--method",
        method,
    ];
    let name = format!("det-{machine}-{method}-{}", more.len());
    let running = Running::start(&name, &[&args[..], more].concat());
    let (output, folder) = running.wait();
    assert!(output.status.success(), "{}", both(&output));
    let recording = folder.path().join("run.mcap");

    // Through the same writer, so that the comparison is of estimates and not of formats.
    let (single, several) = (
        folder.path().join("one.csv"),
        folder.path().join("many.csv"),
    );
    run_ok(&[
        "estimate",
        path(input),
        "--machine",
        machine,
        "--method",
        method,
        "-o",
        path(&single),
    ]);
    let reader = recording::Reader::open(&recording).expect("a recording");
    if machine == "excavator" {
        let estimates: Vec<ExcavatorEstimate> = reader.messages(channel).expect("estimates");
        let mut writer =
            recording::EstimateWriter::<ExcavatorEstimate>::create(&several).expect("a file");
        for estimate in estimates
            .iter()
            .filter(|e| e.flags & messages::excavator_bits::REFUSED == 0)
        {
            writer.write(estimate).expect("a row");
        }
        writer.finish().expect("a file");
    } else {
        let estimates: Vec<LoaderEstimate> = reader.messages(channel).expect("estimates");
        let mut writer =
            recording::EstimateWriter::<LoaderEstimate>::create(&several).expect("a file");
        for estimate in estimates
            .iter()
            .filter(|e| e.flags & messages::loader_bits::REFUSED == 0)
        {
            writer.write(estimate).expect("a row");
        }
        writer.finish().expect("a file");
    }
    let (single, several) = (rows(&single), rows(&several));
    assert!(single.len() > 300, "{} rows", single.len());
    assert_eq!(single.len(), several.len(), "none lost");
    for (i, (a, b)) in single.iter().zip(&several).enumerate() {
        assert_eq!(a, b, "row {i}");
    }

    let text = run_ok(&["replay", path(&recording), "--verify"]);
    assert!(text.contains("bit-identical"), "{text}");
}

#[test]
fn excavator_processes_and_one_thread_agree_to_the_last_bit() {
    let input = golden("excavator_input_drop.csv");
    processes_agree_with_one_thread("excavator", "auto", &input, "excavator/inertia_ukf");
}

#[test]
fn threads_of_one_process_agree_to_the_last_bit_too() {
    for (machine, method, input, channel) in [
        (
            "excavator",
            "auto",
            "excavator_input_drop.csv",
            "excavator/inertia_ukf",
        ),
        (
            "loader",
            "full",
            "loader_input_S4_tierB.csv",
            "loader/cg_ukf",
        ),
    ] {
        services_agree_with_one_thread(machine, method, &golden(input), channel, &["--threads"]);
    }
}

#[test]
fn a_run_of_threads_has_one_process_and_ends_in_order_when_it_is_asked_to() {
    let mut heft = common::heft();
    heft.env("HEFT_LOG", "debug").env("HEFT_LOG_FORMAT", "json");
    let running = Running::start_with(heft, "one-process", "excavator --threads --view".split(' '));
    common::wait_until("a recording", std::time::Duration::from_secs(20), || {
        running
            .recording()
            .metadata()
            .is_ok_and(|file| file.len() > 50_000)
    });
    assert_eq!(running.service("logger"), None, "no process of its own");
    running.signal(rustix::process::Signal::INT);
    let (output, folder) = running.wait();
    assert!(output.status.success(), "{}", both(&output));
    for service in ["sensor", "kalman", "rls", "ukf", "logger"] {
        let named = format!("\"process\":\"{service}\"");
        assert!(both(&output).contains(&named), "{service} logs as itself");
    }
    let recording = folder.path().join("run.mcap");
    let sent = common::sequences::<ExcavatorSensors>(&recording, "excavator/sensors");
    let answered = common::sequences::<ExcavatorEstimate>(&recording, "excavator/inertia_ukf");
    assert!(sent.len() > 20);
    assert_eq!(sent, answered);
}

#[test]
fn excavator_regression_processes_and_one_thread_agree_to_the_last_bit() {
    let input = golden("excavator_input_bad.csv");
    processes_agree_with_one_thread("excavator", "svf-rls", &input, "excavator/inertia_rls");
}

#[test]
fn loader_processes_and_one_thread_agree_to_the_last_bit() {
    let input = golden("loader_input_S4_tierB.csv");
    processes_agree_with_one_thread("loader", "full", &input, "loader/cg_ukf");
}

#[test]
fn a_lossless_run_records_every_row_of_its_input() {
    let input = golden("loader_input_S6_60s_tierA.csv");
    let running = Running::start(
        "lossless",
        &["loader", "--input", path(&input), "--pace", "max"],
    );
    let (output, folder) = running.wait();
    assert!(output.status.success(), "{}", both(&output));
    let recording = folder.path().join("run.mcap");
    let sensors = common::sequences::<LoaderSensors>(&recording, "loader/sensors");
    let rows = std::fs::read_to_string(&input)
        .expect("the input")
        .lines()
        .count()
        - 1;
    assert_eq!(sensors.len(), rows);
    for channel in ["loader/cg_ekf", "loader/cg_ukf"] {
        assert_eq!(
            common::sequences::<LoaderEstimate>(&recording, channel),
            sensors,
            "{channel}"
        );
    }
}

#[test]
fn a_changed_estimate_is_found_by_the_replay() {
    let input = golden("excavator_input_base_case1.csv");
    let running = Running::start(
        "forged",
        &["excavator", "--input", path(&input), "--pace", "max"],
    );
    let (output, folder) = running.wait();
    assert!(output.status.success(), "{}", both(&output));
    let reader = recording::Reader::open(folder.path().join("run.mcap")).expect("a recording");
    let forged = folder.path().join("forged.mcap");
    let mut writer = recording::Writer::create(&forged, reader.metadata()).expect("a file");
    let sensors: Vec<ExcavatorSensors> = reader.messages("excavator/sensors").expect("sensors");
    let mut estimates: Vec<ExcavatorEstimate> =
        reader.messages("excavator/inertia_ukf").expect("estimates");
    // The smallest possible change, in one number of one estimate.
    estimates[100].inertia = f64::from_bits(estimates[100].inertia.to_bits() + 1);
    for message in &sensors {
        writer
            .write(&messages::channels::EXCAVATOR_SENSORS, message)
            .expect("a message");
    }
    for message in &estimates {
        writer
            .write(&messages::channels::EXCAVATOR_INERTIA_UKF, message)
            .expect("a message");
    }
    writer.finish().expect("a file");
    let output = common::run(&["replay", path(&forged), "--verify"]);
    assert_eq!(output.status.code(), Some(1), "{}", both(&output));
    says(&output, "`inertia` of sample 100");
}

#[test]
fn the_truth_goes_into_the_recording_and_not_into_the_estimate() {
    let input = golden("excavator_input_base_case2.csv");
    let folder = tempfile::tempdir().expect("a folder");
    let without = folder.path().join("without_truth.csv");
    let text = std::fs::read_to_string(&input).expect("the input");
    let header: Vec<&str> = text.lines().next().expect("a header").split(',').collect();
    let keep: Vec<usize> = (0..header.len())
        .filter(|&i| !header[i].starts_with("true_"))
        .collect();
    assert!(keep.len() < header.len(), "the input has truth columns");
    let cut: String = text
        .lines()
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            keep.iter().map(|&i| cells[i]).collect::<Vec<_>>().join(",") + "\n"
        })
        .collect();
    std::fs::write(&without, cut).expect("a file");
    let (a, b) = (folder.path().join("a.csv"), folder.path().join("b.csv"));
    run_ok(&[
        "estimate",
        path(&input),
        "--machine",
        "excavator",
        "-o",
        path(&a),
    ]);
    run_ok(&[
        "estimate",
        path(&without),
        "--machine",
        "excavator",
        "-o",
        path(&b),
    ]);
    assert_eq!(rows(&a), rows(&b));

    let rows = recording::load::<messages::ExcavatorSensors>(&input, None).expect("the input");
    let known: Vec<&ExcavatorTruth> = rows.iter().map(|r| &r.1).filter(|t| t.known != 0).collect();
    assert_eq!(known.len(), rows.len());
    assert!(
        known
            .iter()
            .all(|t| t.stamp().time >= 5.0 && t.inertia > 4000.0)
    );
}

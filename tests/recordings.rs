//! No command destroys a recording, an input or another file, even if the user names the wrong one.

mod common;

use std::path::Path;
use std::time::Duration;

use common::table::Table;
use common::{Running, both, kill, run, run_ok, says, sequences, wait_until, words};
use messages::ExcavatorSensors;
use recording::Reader;
use rustix::process::Signal;

fn path(path: &Path) -> &str {
    path.to_str().expect("a path")
}

/// A short run into `folder`.
fn record(folder: &Path, more: &[&str]) -> String {
    let domain = common::domain(&format!("rec-{}", more.len()));
    let run = words("run excavator --pace max --quiet --duration 4");
    let place = ["--domain", &domain, "--out", path(folder)];
    run_ok(&[&run[..], &place, more].concat())
}

#[test]
fn a_simulated_load_cycle_is_not_doubted() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = path(folder.path());
    let domain = common::domain("cycle");
    let run = words("run loader --scenario load-cycle --pace max --quiet");
    run_ok(&[&run[..], &["--domain", &domain, "--out", out]].concat());
    run_ok(&["export", out, "-o", out]);
    let table = folder.path().join("loader_sensors.csv");
    for input in [folder.path().join("run.mcap"), table] {
        let estimates = folder.path().join("estimates.csv");
        run_ok(&[
            "estimate",
            path(&input),
            "--machine",
            "loader",
            "-o",
            path(&estimates),
        ]);
    }
}

#[test]
fn another_described_size_than_the_simulated_one_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let warned = |more: &[&str]| {
        let run_of = ["run", more[0], "--pace", "max", "--duration", "1"];
        let place = ["--out", path(folder.path()), "--quiet"];
        let said = both(&run(&[&run_of[..], &place, &more[1..]].concat()));
        said.contains("warning: the simulated")
    };
    for another in ["excavator", "loader"].map(|machine| [machine, "--class", "21t"]) {
        assert!(warned(&another), "{another:?}");
        assert!(!warned(&another[..1]), "{another:?}");
    }
    assert!(warned(&["excavator", "--class", "21t", "--machines", "2"]));
    assert!(!warned(&["excavator", "--class", "5.5t"]));
}

#[test]
fn a_second_run_into_a_folder_leaves_the_first_recording_and_report_as_they_are() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), &[]);
    let first = folder.path().join("run.mcap");
    let before = std::fs::read(&first).expect("a recording");
    let page = std::fs::read(folder.path().join("report.html")).expect("a report");
    let text = record(folder.path(), &[]);
    assert!(
        text.contains("run-2.mcap") && text.contains("report-2.html"),
        "{text}"
    );
    assert_eq!(std::fs::read(&first).expect("a recording"), before);
    assert_eq!(
        std::fs::read(folder.path().join("report.html")).expect("a report"),
        page
    );
    // Two runs at once.
    let start = |name: &str| {
        let mut command = common::heft();
        command.args("run excavator --quiet --no-report --duration 1 --domain".split(' '));
        command
            .arg(common::domain(name))
            .arg("--out")
            .arg(folder.path());
        command.spawn().expect("heft starts")
    };
    for mut child in [start("one"), start("two")] {
        assert!(child.wait().expect("heft ends").success());
    }
    for name in ["run-2.mcap", "run-3.mcap", "run-4.mcap"] {
        assert!(
            Reader::open(folder.path().join(name))
                .expect(name)
                .is_complete()
        );
    }
}

#[test]
fn the_recording_of_a_running_pipeline_can_be_read_and_is_complete_in_the_end() {
    let running = Running::start("readers", "excavator --duration 6 --rate 500".split(' '));
    running.wait_for_services();
    let recording = running.recording();
    let estimates = ["excavator/inertia_rls", "excavator/inertia_ukf"];
    wait_until("estimates are recorded", Duration::from_secs(20), || {
        Reader::open(&recording).is_ok_and(|r| {
            let counts = r.counts();
            estimates.iter().all(|e| counts.get(*e) > Some(&0))
        })
    });
    let out = tempfile::tempdir().expect("a folder");
    let (page, tables) = (out.path().join("r.html"), out.path().join("tables"));
    let readers: [&[&str]; 3] = [
        &["report", path(&recording), "-o", path(&page)],
        &["replay", path(&recording), "--verify"],
        &["export", path(&recording), "-o", path(&tables)],
    ];
    for args in readers {
        let output = run(args);
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", both(&output));
        says(&output, "it is being written");
    }
    let output = run(&["recover", path(&recording)]);
    assert_eq!(output.status.code(), Some(2), "{}", both(&output));
    let (output, folder) = running.wait();
    assert!(output.status.success(), "{}", both(&output));
    let sensors =
        sequences::<ExcavatorSensors>(&folder.path().join("run.mcap"), "excavator/sensors");
    assert_eq!(sensors, (0..=3000).collect::<Vec<_>>());
}

#[test]
fn after_a_power_cut_the_parts_of_a_restarted_logger_are_read_as_one() {
    let running = Running::start("parts", "excavator --duration 60 --rate 200".split(' '));
    running.wait_for_services();
    std::thread::sleep(Duration::from_secs(2));
    kill(running.service("logger").expect("a process"), Signal::KILL);
    let second = running.folder.path().join("run.part2.mcap");
    wait_until("the next part is written", Duration::from_secs(20), || {
        Reader::open(&second).is_ok_and(|r| !r.channels().is_empty())
    });
    std::thread::sleep(Duration::from_secs(1));
    let names = ["sensor", "kalman", "rls", "ukf", "logger"];
    let all: Vec<u32> = names.iter().filter_map(|n| running.service(n)).collect();
    running.signal(Signal::KILL);
    all.into_iter().for_each(|pid| kill(pid, Signal::KILL));
    let (_, folder) = running.wait();
    let first = folder.path().join("run.mcap");
    let count = |file: &Path| sequences::<ExcavatorSensors>(file, "excavator/sensors");
    let (alone, both_parts) = (count(&second), count(&first));
    assert!(
        alone.len() > 100 && both_parts.len() > alone.len() + 200,
        "{} {}",
        alone.len(),
        both_parts.len()
    );
    assert_eq!(
        count(folder.path()),
        both_parts,
        "the folder stands for its recording"
    );
    let text = run_ok(&["recover", path(&first)]);
    assert!(text.contains("from 2 parts"), "{text}");
    assert_eq!(count(&folder.path().join("run.recovered.mcap")), both_parts);
    assert!(first.exists() && second.exists(), "the parts stay");
}

#[test]
fn of_a_recording_that_was_cut_off_every_command_says_how_far_it_was_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| path(&folder.path().join(name)).to_owned();
    record(folder.path(), &["--no-report"]);
    let bytes = std::fs::read(at("run.mcap")).expect("a recording");
    // Within the index at its end: all samples are there.
    std::fs::write(at("cut.mcap"), &bytes[..bytes.len() - 40]).expect("writable");
    let (cut, again) = (at("cut.mcap"), at("whole.mcap"));
    let calls: [&[&str]; 6] = [
        &["estimate", &cut, "-o", &at("estimates.csv")],
        &["loads", &cut],
        &["report", &cut],
        &["report", "--each", &cut],
        &["export", &cut, "-o", &at("tables")],
        &["replay", &cut],
    ];
    for call in calls {
        let output = run(call);
        assert_eq!(output.status.code(), Some(1), "{call:?}: {}", both(&output));
        says(
            &output,
            "the end of the input is missing; what is before it was read, up to t = ",
        );
        says(&output, "cut.mcap: it was cut off");
    }
    run_ok(&["recover", &cut, "-o", &again]);
    run_ok(&["replay", &again, "--verify"]);
}

#[test]
fn nothing_is_written_over_what_is_read_or_over_a_foreign_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::copy(
        common::golden("excavator_input_base_case1.csv"),
        at("x.csv"),
    )
    .expect("copied");
    std::fs::copy(
        common::golden("recordings/excavator-cfdbb98.mcap"),
        at("run.mcap"),
    )
    .expect("copied");
    std::fs::hard_link(at("x.csv"), at("same.csv")).expect("linked");
    std::os::unix::fs::symlink(at("run.mcap"), at("link.html")).expect("linked");
    std::fs::write(at("notes.csv"), "day,fuel\n1,20\n").expect("written");
    let (csv, mcap) = (at("x.csv"), at("run.mcap"));
    let before = [std::fs::read(&csv), std::fs::read(&mcap)].map(|b| b.expect("there"));
    let estimate = |to: &str| {
        vec![
            "estimate".to_owned(),
            path(&csv).into(),
            "--machine".into(),
            "excavator".into(),
            "-o".into(),
            path(&at(to)).into(),
        ]
    };
    let report = |to: &str| {
        vec![
            "report".to_owned(),
            path(&mcap).into(),
            "-o".into(),
            path(&at(to)).into(),
        ]
    };
    for args in [
        estimate("x.csv"),
        estimate("same.csv"),
        estimate("notes.csv"),
        estimate("run.mcap"),
        report("run.mcap"),
        report("link.html"),
        report("x.csv"),
    ] {
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let output = run(&args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", both(&output));
    }
    let output = run(&["export", path(&mcap), "-o", path(&csv)]);
    says(&output, "name a folder, not a file");
    let after = [std::fs::read(&csv), std::fs::read(&mcap)].map(|b| b.expect("there"));
    assert!(before == after);
    // An earlier result of the same kind is replaced.
    for _ in 0..2 {
        let args = estimate("estimates.csv");
        run_ok(&args.iter().map(String::as_str).collect::<Vec<_>>());
    }
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("there").count(),
        6,
        "nothing beside"
    );
}

#[test]
fn a_split_run_is_whole_in_every_part_and_as_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = record(folder.path(), &["--rate", "1000", "--split", "1s"]);
    assert!(text.contains("run.mcap"), "{text}");
    let parts: Vec<_> = std::fs::read_dir(folder.path())
        .expect("there")
        .map(|e| e.expect("an entry").path())
        .filter(|p| p.extension().is_some_and(|e| e == "mcap"))
        .collect();
    assert!(!parts.is_empty());
    let sensors = sequences::<ExcavatorSensors>(folder.path(), "excavator/sensors");
    assert_eq!(sensors, (0..=4000).collect::<Vec<_>>());
    let text = run_ok(&["replay", path(folder.path()), "--verify"]);
    assert!(!text.contains("cannot be checked"), "{text}");
}

#[test]
fn a_recording_brings_its_machine_and_its_description_unless_another_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), &["--set", "prior.payload=500"]);
    let recording = folder.path().join("run.mcap");
    let first_inertia = |more: &[&str]| -> f64 {
        let out = folder.path().join("out.csv");
        run_ok(&[&["estimate", path(&recording), "-o", path(&out)], more].concat());
        let first = Table::read(&out).rows().next().map(|r| r.number("inertia"));
        first.expect("a row")
    };
    let own = first_inertia(&[]);
    assert_eq!(own, first_inertia(&["--machine", "excavator"]));
    assert_ne!(own, first_inertia(&["--class", "36t"]));
    assert_ne!(own, first_inertia(&["--set", "prior.payload=100"]));
    // For a program in C, or another recording: a recording contains a machine file.
    let file = folder.path().join("machine.toml");
    let text = run_ok(&["check", path(&recording), "--print"]);
    std::fs::write(&file, text).expect("a machine file");
    assert_eq!(own, first_inertia(&["--config", path(&file)]));
}

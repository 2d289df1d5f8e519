//! Many inputs in one command: each result beside its input, one table, no result computed twice; one bad input does not affect
//! the others.

mod common;

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use common::{both, golden, run, run_ok, says};

fn text(path: &Path) -> &str {
    path.to_str().expect("a path")
}

/// A folder with two valid tables, a recording in a subfolder, and a table of another kind.
fn site() -> (tempfile::TempDir, Vec<PathBuf>) {
    let folder = tempfile::tempdir().expect("a folder");
    let inner = folder.path().join("night");
    std::fs::create_dir(&inner).expect("a folder");
    let named = [
        ("excavator_input_constant.csv", "a.csv"),
        ("excavator_input_two_swings.csv", "b.csv"),
        ("recordings/excavator-cfdbb98.mcap", "night/run.mcap"),
    ];
    let copy = |(from, to): (&str, &str)| {
        let to = folder.path().join(to);
        std::fs::copy(golden(from), &to).expect("a copy");
        to
    };
    let good = named.map(copy).to_vec();
    std::fs::write(inner.join("other.csv"), "day,rain\n1,2\n").expect("a file");
    (folder, good)
}

fn read(file: &Path) -> String {
    std::fs::read_to_string(file).expect("a text")
}

fn made(file: &Path) -> SystemTime {
    let about = std::fs::metadata(file).expect("a result");
    about.modified().expect("a time")
}

#[test]
fn a_folder_gives_a_result_beside_each_input_and_is_not_done_twice() {
    let (folder, good) = site();
    let table = folder.path().join("all.csv");
    let command = ["estimate", text(folder.path()), "--machine", "excavator"];
    let command = [&command[..], &["--summary", text(&table)]].concat();
    let first = run(&command);
    let said = both(&first);
    assert_eq!(first.status.code(), Some(2), "one input is no good: {said}");
    assert!(said.contains("other.csv"), "{said}");
    assert!(said.contains("1 of 4 inputs"), "{said}");

    // The same as individually.
    let results: Vec<PathBuf> = good
        .iter()
        .map(|g| g.with_extension("estimates.csv"))
        .collect();
    for (input, result) in good.iter().zip(&results) {
        let alone = folder.path().join("alone.csv");
        run_ok(&[
            "estimate",
            text(input),
            "--machine",
            "excavator",
            "-o",
            text(&alone),
        ]);
        assert_eq!(read(&alone), read(result), "{}", input.display());
        std::fs::remove_file(alone).expect("a file");
        let summary = read(&input.with_extension("estimates.json"));
        let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
        assert_eq!(summary["rows"], read(result).lines().count() - 1);
        assert!(summary["quantities"][0]["value"].is_f64(), "{summary}");
    }

    let summary = read(&table);
    assert_eq!(summary.lines().count(), 5, "{summary}");
    assert!(summary.starts_with("input,result,rows,"), "{summary}");

    let before: Vec<SystemTime> = results.iter().map(|r| made(r)).collect();
    let again = both(&run(&command));
    assert_eq!(again.matches(" up to date\n").count(), 3, "{again}");
    assert!(results.iter().map(|r| made(r)).eq(before.iter().copied()));

    // Another method gives another result; on request the same is computed again.
    let other = run(&[&command[..], &["--method", "torque"]].concat());
    assert_eq!(
        both(&other).matches(" done\n").count(),
        3,
        "{}",
        both(&other)
    );
    let same = run(&[&command[..], &["--method", "torque", "--again"]].concat());
    assert_eq!(both(&same).matches(" done\n").count(), 3, "{}", both(&same));
}

#[test]
fn results_of_the_last_time_are_no_inputs() {
    let (_folder, good) = site();
    let names: Vec<PathBuf> = good[..2]
        .iter()
        .map(|g| g.with_extension("estimates.csv"))
        .collect();
    run_ok(&[
        "estimate",
        text(&good[0]),
        text(&good[1]),
        "--machine",
        "excavator",
    ]);
    let all: Vec<&str> = good[..2].iter().chain(&names).map(|p| text(p)).collect();
    let said = run_ok(&[&["estimate", "--machine", "excavator"], &all[..]].concat());
    assert_eq!(said.matches(" up to date\n").count(), 2, "{said}");
    assert!(!said.contains("estimates.csv "), "{said}");
}

#[test]
fn each_recording_gets_a_page() {
    let (folder, good) = site();
    let command = ["report", "--each", text(folder.path())];
    let said = run_ok(&command);
    let page = good[2].with_extension("html");
    assert!(
        said.contains(&format!("{}: done", page.display())),
        "{said}"
    );
    assert!(run_ok(&command).contains("html: up to date"));
}

#[test]
fn several_inputs_and_one_output_are_refused() {
    let (folder, good) = site();
    let out = folder.path().join("out.csv");
    let output = run(&[
        "estimate",
        text(&good[0]),
        text(&good[1]),
        "--machine",
        "excavator",
        "-o",
        text(&out),
    ]);
    assert_eq!(output.status.code(), Some(2));
    says(&output, "leave --output out");
    let nothing = tempfile::tempdir().expect("a folder");
    let output = run(&["estimate", text(nothing.path()), "--machine", "excavator"]);
    assert_eq!(output.status.code(), Some(2));
    says(&output, "nothing to read");
}

#[test]
fn the_size_of_the_machine_counts_in_a_folder_as_for_one_file() {
    let (folder, good) = site();
    let one = folder.path().join("one.out");
    let ask = ["estimate", "--machine", "excavator", "--class", "36t"];
    run_ok(&[&ask[..], &["-o", text(&one), text(&good[0])]].concat());
    let both = [&ask[..], &[text(&good[0]), text(&good[1])]].concat();
    run_ok(&both);
    assert_eq!(read(&one), read(&good[0].with_extension("estimates.csv")));
    let again = run_ok(&both);
    assert_eq!(again.matches("up to date").count(), 2, "{again}");
}

/// A foreign recording needs its map in every command; the size of its machine is not stated.
#[test]
fn a_bag_is_read_through_its_map_with_and_without_an_output() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let (bag, map) = (at("bag.mcap"), at("map.toml"));
    let others = Path::new(env!("CARGO_MANIFEST_DIR"));
    let others = others.join("services/recording/tests/others/ros2.zstd.mcap");
    std::fs::copy(others, &bag).expect("a copy");
    let topics = r#"[topics]
master = "swing_velocity"
[topics.signals]
swing_velocity = { topic = "/joint_states", field = "velocity", name = "swing_joint" }
swing_torque = { topic = "/swing/pressure", field = "fluid_pressure", unit = "Pa", scale = 0.01 }
"#;
    std::fs::write(&map, topics).expect("a map");
    let with_map = |command: &[&str], output: &[&str]| {
        let input = [text(&bag), "--map", text(&map)];
        both(&run(&[command, &input, output].concat()))
    };
    let excavator = ["estimate", "--machine", "excavator"];
    let alone = at("alone.csv");
    let said = with_map(&excavator, &["-o", text(&alone)]);
    assert!(said.contains("taken for the reference machine"), "{said}");
    with_map(&excavator, &[]);
    assert_eq!(read(&alone), read(&at("bag.estimates.csv")));
    let said = with_map(&["calibrate", "excavator"], &["-o", text(&at("own.toml"))]);
    assert!(!said.contains("no samples"), "{said}");
}

#[test]
fn a_result_of_another_map_is_not_up_to_date_however_old_the_map_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let table = folder.path().join("a.csv");
    std::fs::copy(golden("excavator_input_two_swings.csv"), table).expect("a copy");
    let map = folder.path().join("map.toml");
    let of = |scale: &str| {
        let torque = format!("swing_torque = {{ column = \"swing_torque\", scale = {scale} }}");
        std::fs::write(&map, format!("[columns]\n{torque}\n")).expect("a map");
        let file = std::fs::File::open(&map).expect("the map");
        file.set_modified(SystemTime::UNIX_EPOCH).expect("a time");
        let command = ["estimate", text(folder.path()), "--machine", "excavator"];
        both(&run(&[&command[..], &["--map", text(&map)]].concat()))
    };
    for (scale, end) in [
        ("1.0", " done\n"),
        ("1.0", " up to date\n"),
        ("1.01", " done\n"),
    ] {
        let said = of(scale);
        assert!(said.contains(end), "{scale}: {said}");
    }
}

#[test]
fn of_one_file_the_share_trusted_in_motion_and_the_main_reason_are_stated_and_the_last_row_is_called_so()
 {
    let folder = tempfile::tempdir().expect("a folder");
    let [out, json] = ["e.csv", "e.json"].map(|name| common::path_in(folder.path(), name));
    let file = common::golden("machines/excavator_5_22t_gain.csv");
    let file = file.to_str().expect("a path");
    let said = common::run_ok(&[
        "estimate",
        file,
        "--machine",
        "excavator",
        "--class",
        "22t",
        "-o",
        &out,
        "--json",
        &json,
    ]);
    let plain = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        plain.contains("In the last row: The swing inertia is"),
        "{plain}"
    );
    let text = std::fs::read_to_string(json).expect("a summary");
    let found: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let quantity = &found["quantities"][0];
    let share = quantity["trusted_share_in_motion"]
        .as_f64()
        .expect("a share");
    assert!(share < 0.9, "{quantity}");
    let reason = quantity["main_reason"].as_str().expect("a reason");
    let to_do = quantity["what_to_do"].as_str().expect("what to do");
    assert!(
        !reason.contains("stands still"),
        "a reason of the motion: {reason}"
    );
    let share = format!(
        "trusted in {:.0} % of the motion; the rest mostly not, because",
        100.0 * share
    );
    assert!(plain.contains(&share), "{share}: {plain}");
    assert!(plain.contains(to_do), "{to_do}: {plain}");
}

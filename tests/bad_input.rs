//! Wrong use and bad input: messages of what, where, what to do; exit status 2; no partial output.

mod common;
#[path = "bad_input/misplaced.rs"]
mod misplaced;
#[path = "bad_input/named.rs"]
mod named;
#[path = "bad_input/streams.rs"]
mod streams;

use std::fs;
use std::io::Write as _;
use std::path::Path;

use common::{both, golden, run, says};

/// Expects exit status 2, the words, and no output file.
fn refused(args: &[&str], words: &[&str], output: &Path) {
    let result = run(args);
    let text = both(&result);
    assert_eq!(result.status.code(), Some(2), "{args:?}\n{text}");
    for word in words {
        assert!(
            text.contains(word),
            "`{word}` is missing for {args:?}:\n{text}"
        );
    }
    assert!(!text.contains("panicked"), "{text}");
    assert!(!output.exists(), "{args:?} left {}", output.display());
    let folder = output.parent().expect("a folder");
    let leftovers: Vec<_> = fs::read_dir(folder)
        .expect("the folder")
        .flatten()
        .filter(|e| e.file_name().to_string_lossy().contains("out.csv"))
        .collect();
    assert!(leftovers.is_empty(), "{leftovers:?}");
}

fn estimate(machine: &str, name: &str, content: &str, words: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    let (input, output) = (folder.path().join(name), folder.path().join("out.csv"));
    fs::write(&input, content).expect("a file");
    let (i, o) = (
        input.to_str().expect("a path"),
        output.to_str().expect("a path"),
    );
    refused(
        &["estimate", i, "--machine", machine, "-o", o],
        words,
        &output,
    );
}

#[test]
fn a_missing_column_is_named_with_the_nearest_one() {
    estimate(
        "excavator",
        "in.csv",
        "t,swing_velocty\n0,1\n",
        &["swing_velocity", "swing_velocty", "in.csv"],
    );
    estimate(
        "loader",
        "in.csv",
        "t,speed,front_wheel_speed,rear_wheel_speed,front_torque,rear_torque\n0,1,1,1,1,1\n",
        &["slope"],
    );
}

#[test]
fn text_in_a_number_is_named_with_row_and_column() {
    estimate(
        "excavator",
        "in.csv",
        "t,swing_velocity\n0,0.1\n0.01,fast\n",
        &["fast", "swing_velocity", "3"],
    );
}

#[test]
fn what_a_cell_should_be_is_said_where_it_is_something_else() {
    let refused = |content: &str, words: &[&str]| estimate("excavator", "in.csv", content, words);
    // An American date may begin with its month.
    let date = "t,swing_velocity\n03/04/2026 12:59:50 PM,0.1\n";
    let ambiguous = "may begin with its day or with its month";
    refused(date, &["03/04/2026", ambiguous, "2026-11-21 16:00:00.25"]);
    let thousands = "t,swing_velocity,swing_torque\n0,0,\"12,50.5\"\n";
    refused(thousands, &["12,50.5", "decimal point"]);
    let twice = "t,swing_velocity\n0,0\n0.01,0\nt,swing_velocity\n0,0\n";
    refused(twice, &["in.csv:4", "header stands here once more"]);
    // Without the second header its rows would be assigned to other columns.
    let turned = "t,swing_velocity\n0,0\n0.01,0\nswing_velocity,t\n0,0\n";
    refused(turned, &["in.csv:4", "make a file of each"]);
    let quote = "t,swing_velocity\n0,0\n\"0.01,0\n0.02,0\n";
    refused(quote, &["in.csv:3", "close the quote"]);
    let preface = "Logger 2.1\nMachine: EX-22\nt [s] swing velocity\n0 0\n";
    refused(preface, &["Logger 2.1", "delete what stands above"]);
    let blanks = "t swing_velocity\n2026-11-26 01:02:03 0\n";
    refused(blanks, &["t swing_velocity", "separate the columns by"]);
}

#[test]
fn a_map_that_lacks_what_is_needed_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = folder.path().join("in.csv");
    fs::write(&input, "Time [s],Boom [deg],A7\n0,1,2\n").expect("a file");
    let input = input.to_str().expect("a path");
    let result = run(&["map", input, "--machine", "excavator"]);
    let words = String::from_utf8_lossy(&result.stderr).into_owned();
    assert!(
        words.contains("needed: swing_velocity or swing_angle;"),
        "{words}"
    );
    // A line on the logger is no header either.
    fs::write(input, "Logger 2.1\nTime [s],Boom [deg],A7\n0,1,2\n").expect("a file");
    let words = both(&run(&["map", input, "--machine", "excavator"]));
    assert!(
        words.contains("boom_angle = { column = \"Boom [deg]\""),
        "{words}"
    );
}

#[test]
fn empty_files_and_headers_without_rows_are_refused() {
    estimate("excavator", "in.csv", "", &["empty"]);
    estimate("excavator", "in.csv", "t,swing_velocity\n", &["no rows"]);
}

#[test]
fn files_that_do_not_exist_or_have_foreign_endings_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("out.csv");
    let o = output.to_str().expect("a path");
    refused(
        &[
            "estimate",
            "/nowhere/in.csv",
            "--machine",
            "excavator",
            "-o",
            o,
        ],
        &["/nowhere/in.csv"],
        &output,
    );
    let foreign = folder.path().join("in.xlsx");
    fs::write(&foreign, "PK").expect("a file");
    refused(
        &[
            "estimate",
            foreign.to_str().expect("a path"),
            "--machine",
            "excavator",
            "-o",
            o,
        ],
        &["spreadsheet", "save the sheet as CSV", "in.xlsx"],
        &output,
    );
}

#[test]
fn an_output_that_cannot_be_written_is_reported() {
    let input = golden("excavator_input_base_case1.csv");
    let result = run(&[
        "estimate",
        input.to_str().expect("a path"),
        "--machine",
        "excavator",
        "-o",
        "/nowhere/out.csv",
    ]);
    assert_eq!(result.status.code(), Some(2));
    says(&result, "/nowhere/out.csv");
}

#[test]
fn a_full_disk_ends_an_estimate_with_a_word() {
    let input = golden("excavator_input_base_case1.csv");
    let input = input.to_str().expect("a path");
    let result = run(&[
        "estimate",
        input,
        "--machine",
        "excavator",
        "-o",
        "/dev/full",
    ]);
    assert_eq!(result.status.code(), Some(2), "{}", both(&result));
    says(&result, "cannot write the estimates");
}

#[test]
fn a_report_of_what_is_no_recording_is_refused() {
    let input = golden("excavator_input_base_case1.csv");
    let input = input.to_str().expect("a path");
    let result = run(&["report", input, "-o", "/dev/null/x.html"]);
    assert_eq!(result.status.code(), Some(2), "{}", both(&result));
}

#[test]
fn nan_backward_and_repeated_times_lose_nothing_but_their_rows() {
    let folder = tempfile::tempdir().expect("a folder");
    let (input, output) = (folder.path().join("in.csv"), folder.path().join("out.csv"));
    let mut text = String::from("t,swing_velocity,swing_torque\n");
    for k in 0..400 {
        let t = 0.01 * f64::from(k);
        text += &match k {
            50 => format!("{t},nan,100\n"),
            60 => format!("{t},,\n"),
            70 => "nan,0.1,100\n".to_owned(),
            80 => "0.1,0.1,100\n".to_owned(),
            90 => format!("{t},inf,-inf\n"),
            _ => format!("{t},{},{}\n", 0.3 * (1.0 - (-t).exp()), 900.0 * (-t).exp()),
        };
    }
    fs::write(&input, text).expect("a file");
    let (i, o) = (
        input.to_str().expect("a path"),
        output.to_str().expect("a path"),
    );
    for method in [
        "auto",
        "svf-rls",
        "multi-forgetting-rls",
        "torque",
        "velocity",
    ] {
        let result = run(&[
            "estimate",
            i,
            "--machine",
            "excavator",
            "--method",
            method,
            "-o",
            o,
        ]);
        assert!(result.status.success(), "{method}: {}", both(&result));
        let text = fs::read_to_string(&output).expect("the estimates");
        assert_eq!(
            text.lines().count(),
            1 + 398,
            "{method}: a row per row with a valid time"
        );
        assert!(
            !text.contains("NaN") && !text.contains("inf,") && !text.contains("nan"),
            "{method}"
        );
    }
}

#[test]
fn wrong_keys_and_values_of_a_description_are_reported_with_line_and_suggestion() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("m.toml");
    let f = file.to_str().expect("a path");
    fs::write(&file, "[sensors]\nrate = 100\nswing_velocty_std = 0.005\n").expect("a file");
    let result = run(&["check", f, "--machine", "excavator"]);
    let text = both(&result);
    assert_eq!(result.status.code(), Some(2), "{text}");
    for word in ["m.toml:3", "swing_velocty_std", "swing_velocity_std"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    fs::write(&file, "[sensors]\nrate = -5\n").expect("a file");
    let result = run(&["check", f, "--machine", "excavator"]);
    let text = both(&result);
    assert_eq!(result.status.code(), Some(2), "{text}");
    assert!(text.contains("m.toml:2") && text.contains("rate"), "{text}");
    fs::write(&file, "[machine]\nkind = \"loader\"\n").expect("a file");
    let result = run(&["check", f, "--machine", "excavator"]);
    let text = both(&result);
    assert_eq!(result.status.code(), Some(2), "{text}");
    assert!(
        text.contains("is for the loader, not for the excavator"),
        "{text}"
    );
}

#[test]
fn unknown_methods_scenarios_and_domains_name_the_choices() {
    for (args, word) in [
        (vec!["run", "excavator", "--scenario", "bsae"], "base"),
        (vec!["run", "excavator", "--method", "magic"], "magic"),
        (vec!["run", "loader", "--method", "magic"], "magic"),
        (
            vec!["run", "excavator", "--domain", "a/b", "--duration", "1"],
            "a/b",
        ),
        (vec!["run", "excavator", "--rate", "1e9"], "rate"),
        (vec!["tail", "--rate", "0"], "above 0"),
        (vec!["tail", "--rate", "nan"], "no number"),
        (
            vec!["run", "excavator", "--duration", "5 minutes"],
            "like 500ms, 90s, 5m, 2h",
        ),
        (vec!["run", "excavator", "--duration", "0"], "above 0"),
        (vec!["latency", "--duration", "-1"], "like 500ms"),
        (vec!["run", "loader", "--target", "24"], "--target 24t"),
        (
            vec![
                "evaluate",
                "excavator",
                "--table",
                "nothing",
                "--seeds",
                "1",
            ],
            "table1",
        ),
    ] {
        let result = run(&args);
        assert_eq!(result.status.code(), Some(2), "{args:?}: {}", both(&result));
        assert!(both(&result).contains(word), "{args:?}: {}", both(&result));
    }
}

#[test]
fn a_service_without_a_supervisor_says_how_to_start_one() {
    let result = run(&["service", "kalman", "--domain", "nowhere"]);
    assert_eq!(result.status.code(), Some(2));
    says(&result, "what to do");
}

/// Runs a shell script in a mount namespace of its own; `None`, with a message, if that is forbidden.
fn with_own_mounts(script: &str) -> Option<std::process::Output> {
    let output = std::process::Command::new("unshare")
        .args(["--mount", "sh", "-c", script])
        .output();
    match output {
        Ok(output) if !both(&output).contains("not permitted") => Some(output),
        _ => {
            let _ = writeln!(
                std::io::stderr(),
                "skipped: this user may not make a mount namespace"
            );
            None
        }
    }
}

#[test]
fn a_full_shared_memory_is_reported_before_anything_starts() {
    let heft = env!("CARGO_BIN_EXE_heft");
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().display();
    let script = format!(
        "mount -t tmpfs -o size=1m tmpfs /dev/shm || exit 99; {heft} run excavator --duration 1 --quiet --no-report --out {out}"
    );
    let Some(output) = with_own_mounts(&script) else {
        return;
    };
    if output.status.code() == Some(99) {
        let _ = writeln!(std::io::stderr(), "skipped: this user may not mount");
        return;
    }
    assert_eq!(output.status.code(), Some(2), "{}", both(&output));
    says(&output, "shared memory has");
}

#[test]
fn a_full_disk_stops_the_recording_and_not_the_estimation() {
    let heft = env!("CARGO_BIN_EXE_heft");
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().display();
    let script = format!(
        "mount -t tmpfs -o size=256k tmpfs {out} || exit 99; \
         {heft} run excavator --scenario cycle --rate 1000 --duration 4 --verbose --quiet --no-report --out {out}; \
         code=$?; {heft} recover {out}/run.mcap; exit $code"
    );
    let Some(output) = with_own_mounts(&script) else {
        return;
    };
    if output.status.code() == Some(99) {
        let _ = writeln!(std::io::stderr(), "skipped: this user may not mount");
        return;
    }
    let text = both(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("the recording is incomplete"), "{text}");
    assert!(
        text.contains("4001 samples, 0 lost"),
        "estimation goes on to the end: {text}"
    );
}

#[test]
fn cores_that_the_chain_cannot_use_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("latency.json");
    let o = output.to_str().expect("a path");
    for cores in ["0", "1000"] {
        let args = ["latency", "--rt", "--cores", cores, "--json", o];
        refused(&args, &["--cores", cores, "nproc"], &output);
    }
    refused(
        &["latency", "--cores", "1", "--json", o],
        &["--rt"],
        &output,
    );
    let run = ["run", "excavator", "--core", "1000", "--out", o];
    refused(&run, &["core 1000", "--core", "one of 0"], &output);
}

#[test]
fn a_key_by_its_old_name_is_read_with_a_note_and_a_file_without_end_is_named_as_such() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("loader.toml");
    fs::write(&file, "[sensors]\nslope_follows = 0.3\n").expect("a file");
    let output = run(&["check", file.to_str().expect("a path"), "--print"]);
    let text = both(&output);
    assert!(output.status.success(), "{text}");
    let note = "slope_follows is called sensors.slope_acceleration_sensitivity today";
    assert!(text.contains(note), "{text}");
    assert!(
        text.contains("slope_acceleration_sensitivity = 0.3"),
        "{text}"
    );

    let endless = run(&["check", "/dev/zero"]);
    assert_eq!(endless.status.code(), Some(2));
    assert!(both(&endless).contains("name a machine file"));
}

#[test]
fn no_name_of_a_file_or_column_steers_the_terminal() {
    let folder = tempfile::tempdir().expect("a folder");
    let name = "a\x1b[31mred\x1b]0;title\x07";
    let place = |ending: &str| folder.path().join(format!("{name}{ending}"));
    let table = place(".csv");
    let mut rows = String::from("t,swing_velocity,swing_torque,x\x1b[2J\n");
    for i in 0..300 {
        rows += &format!("{:.2},0.1,100,0\n", f64::from(i) * 0.01);
    }
    fs::write(&table, rows).expect("a table");
    let text = |path: &std::path::Path| path.to_str().expect("a path").to_owned();
    let (input, map, run_folder) = (text(&table), text(&place(".toml")), text(&place("")));
    let (out, report, exported) = (
        text(&place(".out.csv")),
        text(&place(".html")),
        text(&place("-x")),
    );
    let commands: [&[&str]; 12] = [
        &["map", &input],
        &["map", &input, "-o", &map],
        &["estimate", &input, "--machine", "excavator"],
        &[
            "estimate",
            &input,
            "--machine",
            "excavator",
            "-o",
            &out,
            "--report",
            &report,
        ],
        &["loads", &input, "--machine", "excavator", "-o", &out],
        &["calibrate", "excavator", &input, "-o", &map],
        &[
            "run",
            "excavator",
            "--input",
            &input,
            "--pace",
            "max",
            "--out",
            &run_folder,
        ],
        &["report", &run_folder],
        &["export", &run_folder, "-o", &exported],
        &["recover", &run_folder],
        &["replay", &run_folder],
        &["check", &input],
    ];
    for command in commands {
        let said = both(&run(command));
        let steers = |c: char| c.is_control() && c != '\n' && c != '\t';
        assert!(
            !said.contains(steers),
            "{command:?}: {}",
            said.escape_debug()
        );
    }
}

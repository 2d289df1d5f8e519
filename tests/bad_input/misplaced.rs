//! Arguments at the wrong place of the command line: the message names the argument and its place.

use std::fs;

use crate::common::{both, golden, path_in, run, run_ok, says};
use crate::refused;

/// Checks that a line is refused with these words. Present are the golden excavator of 13 t as `day 1.csv`, a map, and a folder of the data.
fn said(line: &[&str], words: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| path_in(folder.path(), name);
    let data = golden("machines/excavator_1_13t_level.csv");
    fs::create_dir(place("site")).expect("a folder");
    for copy in ["day 1.csv", "site/day.csv"] {
        fs::copy(&data, place(copy)).expect("a copy");
    }
    let map = "# A map.\n[columns]\nt = \"t\"\n";
    fs::write(place("map.toml"), map).expect("a map");
    let names = ["day 1.csv", "site", "map.toml", "out.csv"];
    let args = line.iter().map(|word| match names.contains(word) {
        true => place(word),
        false => (*word).to_owned(),
    });
    let args: Vec<String> = args.collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    refused(&args, words, &folder.path().join("out.csv"));
}

#[test]
fn a_file_or_a_machine_at_the_wrong_place_gets_a_message_with_its_own() {
    let named = ["this is a machine, and --machine names it"];
    said(&["estimate", "excavator", "day 1.csv"], &named);
    said(&["loads", "day 1.csv", "loader"], &named);
    said(&["day 1.csv"], &["is a file: the command comes before it"]);
    said(
        &["calibrate", "day 1.csv"],
        &["is a file: the machine comes before it"],
    );
    let run = ["run", "excavator", "day 1.csv"];
    said(&run, &["is a file: heft run takes one by --input"]);
    let of_set = ["--set", "machine.operating_mass", "21500", "-o", "out.csv"];
    let estimate = ["estimate", "day 1.csv", "--machine", "excavator"];
    let line = [&estimate[..], &of_set].concat();
    said(&line, &["--set", "without blanks, like sensors.rate=100"]);
}

#[test]
fn a_machine_by_an_option_that_the_command_lacks_gets_a_message_with_its_place() {
    let alone = [
        "unexpected argument '--machine'",
        "the machine as a word of its own",
    ];
    said(&["serve", "day 1.csv", "--machine", "excavator"], &alone);
    said(&["run", "--machine", "excavator"], &alone);
    let none = ["unexpected argument '--machine'", "needs no machine"];
    said(&["report", "day 1.csv", "--machine", "excavator"], &none);
}

#[test]
fn an_output_that_the_command_lacks_gets_a_message_with_what_it_has() {
    for (command, words) in [
        (
            "check",
            "--print writes the machine file to standard output",
        ),
        ("weigh", "--json FILE writes the result"),
        ("replay", "heft export writes the recording as tables"),
    ] {
        for option in ["-o", "--output"] {
            let line = [command, "day 1.csv", option, "out.csv"];
            said(&line, &["unexpected argument", words]);
        }
    }
}

#[test]
fn a_result_of_heft_is_named_as_one_where_samples_are_wanted() {
    let folder = tempfile::tempdir().expect("a folder");
    let estimates = path_in(folder.path(), "estimates.csv");
    let machine = ["--machine", "excavator"];
    let data = golden("machines/excavator_1_13t_level.csv");
    let data = data.to_str().expect("a path");
    let made = ["estimate", data, "-o", &estimates];
    let made = run(&[&made[..], &machine].concat());
    assert!(fs::exists(&estimates).expect("a folder"), "{}", both(&made));
    let out = path_in(folder.path(), "out.csv");
    for line in [
        &["estimate", &estimates, "-o", &out][..],
        &["loads", &estimates],
        &["map", &estimates],
    ] {
        let line = [line, &machine].concat();
        let words = ["this table is a result of heft", "the table of sensors"];
        refused(&line, &words, &folder.path().join("out.csv"));
    }
}

#[test]
fn what_is_no_data_is_named_before_the_machine_that_is_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = path_in(folder.path(), "photo.jpg");
    fs::write(&file, [0, 1, 2, 3, 4, 5, 6, 7].repeat(99)).expect("a file");
    let out = folder.path().join("out.csv");
    for command in ["loads", "estimate"] {
        refused(&[command, &file], &["this is no text"], &out);
    }
    let table = path_in(folder.path(), "day.csv");
    fs::write(&table, "t,speed\n0,1\n").expect("a file");
    refused(&["loads", &table], &["the machine is not known"], &out);
}

#[test]
fn a_folder_of_data_has_no_single_result() {
    let line = [
        "estimate",
        "site",
        "--machine",
        "excavator",
        "-o",
        "out.csv",
    ];
    said(
        &line,
        &["this is a folder without a recording", "leave --output out"],
    );
    for option in ["--json", "--report"] {
        let many = ["estimate", "site", "day 1.csv", option, "out.csv"];
        let words = format!("where: {option} ");
        said(&many, &["several inputs cannot have one result", &words]);
        let machine = ["estimate", "excavator", "day 1.csv", option, "out.csv"];
        said(&machine, &["this is a machine, and --machine names it"]);
        let one = ["estimate", "day 1.csv", option, "out.csv"];
        said(&one, &[&words, "--output OUT.csv"]);
    }
}

#[test]
fn a_signal_map_is_neither_data_nor_a_machine_file() {
    said(
        &["map", "map.toml"],
        &["this is TOML", "a signal map by --map"],
    );
    let line = [
        "estimate",
        "map.toml",
        "--machine",
        "excavator",
        "-o",
        "out.csv",
    ];
    said(&line, &["this is TOML", "a signal map by --map"]);
    said(
        &["check", "map.toml"],
        &["map.toml:2", "of a signal map: give that with --map"],
    );
}

#[test]
fn a_command_that_heft_proposes_runs_as_it_stands() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = path_in(folder.path(), "Tag 1 (Größe).csv");
    fs::copy(golden("machines/excavator_1_13t_level.csv"), &file).expect("a copy");
    let map = run_ok(&["map", &file]);
    let line = map
        .lines()
        .find_map(|line| line.strip_prefix("# Then: heft "));
    let line = line
        .expect("a command")
        .replace("--map THIS_FILE", "--class 13t");
    let heft = env!("CARGO_BIN_EXE_heft");
    let out = std::process::Command::new("sh")
        .args(["-c", &format!("{heft} {line}")])
        .current_dir(&folder)
        .output()
        .expect("sh runs");
    assert!(out.status.success(), "{line}: {}", both(&out));
    assert!(folder.path().join("out.csv").exists(), "{line}");
}

/// The values that follow from a stated mass; none of them for data that cannot be read.
#[test]
fn who_states_the_mass_is_shown_what_follows_from_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = path_in(folder.path(), "out.csv");
    let of = |machine: &str, file: &str, options: &[&str]| {
        let file = golden(&format!("machines/{file}.csv"));
        let file = file.to_str().expect("a path");
        let line = ["estimate", file, "--machine", machine, "-o", &out];
        both(&run(&[&line[..], options].concat()))
    };
    let excavator = |options: &[&str]| of("excavator", "excavator_1_13t_level", options);
    for options in [
        ["--class", "5.5t"],
        ["--set", "machine.operating_mass=5500"],
    ] {
        let text = excavator(&options);
        assert!(!text.contains("the reference machine"), "{text}");
        let words = "those of a usual excavator of 5.5 t, as machine.nominal_damping";
        assert!(text.contains(words), "{text}");
    }
    let stated = [
        "--class",
        "13t",
        "--set",
        "machine.geometry.boom_length=4.6",
    ];
    let text = excavator(&stated);
    assert!(!text.contains("boom_length 4"), "{text}");
    // The command shows the assumed values.
    let (_, command) = text.split_once("`heft ").expect("a command");
    let command = command.split('`').next().expect("a command");
    let all = run_ok(&command.split(' ').collect::<Vec<_>>());
    assert!(all.contains("\nboom_length = 4.6\n"), "{command}: {all}");
    assert!(all.contains("\noperating_mass = 13000.0\n"), "{command}");

    let loader = |options: &[&str]| of("loader", "loader_2_12t_late", options);
    let text = loader(&["--class", "12t"]);
    assert!(
        text.contains("usual loader of 12 t, as machine.wheel_radius"),
        "{text}"
    );
    let text = loader(&["--set", "machine.mass=4700"]);
    assert!(
        text.contains("the reference loader, whose mass this is"),
        "{text}"
    );

    // A run on data reports it too.
    let data = golden("machines/excavator_1_13t_level.csv");
    let line = [
        "run",
        "excavator",
        "--pace",
        "max",
        "--quiet",
        "--no-report",
        "--input",
    ];
    let folder = path_in(folder.path(), "run");
    let more = [data.to_str().expect("a path"), "--out", &folder];
    let text = both(&run(&[&line[..], &more].concat()));
    assert!(text.contains("the reference machine of 5.5 t"), "{text}");

    let refused = both(&run(&[
        "estimate",
        "nowhere.csv",
        "--machine",
        "loader",
        "-o",
        &out,
    ]));
    assert!(!refused.contains("note:"), "{refused}");
}

#[test]
fn a_machine_of_another_mass_is_not_called_the_reference_machine() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = path_in(folder.path(), "out.csv");
    let data = golden("weighed/loader_2_24t_locked.csv");
    let line = ["estimate", "--machine", "loader", "-o", &out];
    let said = |sets: &[&str]| {
        let sets = sets.iter().flat_map(|set| ["--set", set]);
        let data = data.to_str().into_iter();
        let line: Vec<&str> = line.into_iter().chain(data).chain(sets).collect();
        let said = both(&run(&line));
        fs::remove_file(&out).expect("a result");
        said
    };
    let size = [
        "machine.mass=23713",
        "machine.wheel_radius=0.9",
        "machine.wheelbase=3.8",
    ];
    let words = said(&size);
    assert!(!words.contains("the reference loader"), "{words}");
    let more = [
        "machine.mass=23713",
        "sensors.rate=100",
        "sensors.speed_std=0.02",
        "sensors.slope_std=0.002",
        "sensors.acceleration_std=0.05",
        "sensors.wheel_speed_std=0.002",
    ];
    let words = said(&more);
    let command = "`heft check --machine loader --print` with the same --set shows all";
    assert!(words.contains(command), "{words}");
}

#[test]
fn where_results_go_and_an_interface_that_cannot_be_are_reported() {
    for (command, words) in [
        (
            "run excavator -o FILE",
            "--out FOLDER says where recording and report go",
        ),
        ("serve excavator -o FILE", "end the command with > FILE"),
        (
            "run loader --input can:averyveryverylongname",
            "no interface has a name of more than 15 bytes",
        ),
    ] {
        let args: Vec<&str> = command.split(' ').collect();
        let output = run(&args);
        assert_eq!(output.status.code(), Some(2), "{}", both(&output));
        says(&output, words);
        assert!(!both(&output).contains("-- -o"), "{}", both(&output));
    }
}

//! Faults of the data are named, and no data are dropped silently.

use std::fs;
use std::path::Path;
use std::process::{Output, Stdio};
use std::time::Instant;

use crate::common::{both, golden, heft, path_in, run, run_ok, says};

/// The golden excavator of 13 t with one column changed.
fn treated(folder: &Path, column: &str, treat: impl Fn(usize, f64) -> String) -> String {
    let text = fs::read_to_string(golden("machines/excavator_1_13t_level.csv")).expect("golden");
    let mut lines = text.lines();
    let header = lines.next().expect("a header");
    let at = header.split(',').position(|name| name == column);
    let at = at.expect("the column");
    let rows = lines.enumerate().map(|(n, row)| {
        let cells = row.split(',').enumerate().map(|(i, cell)| match i == at {
            true => treat(n, cell.parse().expect("a number")),
            false => cell.to_owned(),
        });
        cells.collect::<Vec<_>>().join(",") + "\n"
    });
    let file = path_in(folder, "day.csv");
    fs::write(&file, format!("{header}\n{}", rows.collect::<String>())).expect("writable");
    file
}

fn estimate(input: &str, folder: &Path) -> Output {
    estimate_of("excavator", input, folder, &["--class", "13t"])
}

/// The same for a machine, with other options.
fn estimate_of(machine: &str, input: &str, folder: &Path, options: &[&str]) -> Output {
    let out = path_in(folder, "out.csv");
    let args = ["estimate", input, "--machine", machine, "-o", &out];
    run(&[&args[..], options].concat())
}

/// `heft run` of the same data on standard input.
fn piped(input: &str, folder: &Path) -> Output {
    let out = path_in(folder, "run");
    heft()
        .args("run excavator --class 13t --input - --pace max --quiet".split(' '))
        .args(["--out", &out])
        .stdin(Stdio::from(fs::File::open(input).expect("the input")))
        .output()
        .expect("heft starts")
}

/// Checks that both end with status 1 and these words.
fn in_doubt(input: &str, folder: &Path, words: &str) {
    for output in [estimate(input, folder), piped(input, folder)] {
        assert_eq!(output.status.code(), Some(1), "{}", both(&output));
        says(&output, words);
    }
}

#[test]
fn a_torque_that_never_changes_while_the_machine_swings_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    for value in ["0", "500"] {
        let day = treated(folder.path(), "swing_torque", |_, _| value.into());
        let words = format!("swing_torque is exactly {value} N m in all");
        in_doubt(&day, folder.path(), &words);
    }
}

#[test]
fn what_comes_on_standard_input_is_doubted_like_a_file() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = treated(dir.path(), "t", |_, t| (1000.0 * t).to_string());
    in_doubt(&file, dir.path(), "is the time in ms?");
    let dir = tempfile::tempdir().expect("a folder");
    let file = treated(dir.path(), "swing_torque", |_, torque| {
        (torque / 1000.0).to_string()
    });
    in_doubt(&file, dir.path(), "unit = \"kNm\"");
    // A boom that points into the ground, and times with two rows each.
    let dir = tempfile::tempdir().expect("a folder");
    let file = treated(dir.path(), "boom_angle", |_, angle| (-angle).to_string());
    in_doubt(&file, dir.path(), "boom_angle seems to have the other sign");
    let dir = tempfile::tempdir().expect("a folder");
    let file = treated(dir.path(), "t", |row, t| match row % 2 {
        0 => t.to_string(),
        _ => (t - 0.01).to_string(),
    });
    in_doubt(&file, dir.path(), "rows were refused, more than one in 10");
}

#[test]
fn rows_that_are_too_far_apart_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(golden("machines/excavator_1_13t_level.csv")).expect("golden");
    let (header, rows) = text.split_once('\n').expect("a header");
    let each: Vec<&str> = rows.lines().step_by(100).collect();
    let file = path_in(folder.path(), "day.csv");
    fs::write(&file, format!("{header}\n{}\n", each.join("\n"))).expect("writable");
    let words = "the rows are 1 s apart: of so few nothing is trusted, and loads are missed";
    says(&estimate(&file, folder.path()), words);
    says(&run(&["loads", &file, "--machine", "excavator"]), words);
}

#[test]
fn rows_that_are_too_close_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = treated(folder.path(), "t", |_, t| (t / 1000.0).to_string());
    let words = "the rows are 0.00001 s apart: no sensor of a machine measures so often";
    says(&estimate(&file, folder.path()), words);
    says(&run(&["loads", &file, "--machine", "excavator"]), words);
}

#[test]
fn of_a_table_that_was_cut_off_the_whole_rows_count_and_the_cut_row_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(golden("machines/excavator_1_13t_level.csv")).expect("golden");
    let (file, rows) = (path_in(folder.path(), "day.csv"), text.lines().count() - 1);
    let words = "the last row was cut off (2 of ";
    for cut in ["999,0", "999,0\n", "999,\"0"] {
        fs::write(&file, format!("{text}{cut}")).expect("writable");
        let output = estimate(&file, folder.path());
        assert_eq!(output.status.code(), Some(1), "{}", both(&output));
        says(&output, &format!("day.csv:{}: {words}", rows + 2));
        says(&output, &format!("{rows} estimates in"));
        let output = run(&["loads", &file, "--machine", "excavator", "--class", "13t"]);
        assert_eq!(output.status.code(), Some(1), "{}", both(&output));
        says(&output, words);
        run_ok(&["map", &file]);
        // Lines as they come: what is no row is left out and named.
        let output = piped(&file, folder.path());
        assert_eq!(output.status.code(), Some(0), "{}", both(&output));
        says(&output, "the row has 2 cells");
    }
    // Without a line end a whole row is whole.
    fs::write(&file, text.trim_end()).expect("writable");
    let output = estimate(&file, folder.path());
    assert_eq!(output.status.code(), Some(0), "{}", both(&output));
    // A short row before others is no cut.
    let line = text.find('\n').expect("rows") + 1;
    fs::write(&file, format!("{}0,0\n{}", &text[..line], &text[line..])).expect("writable");
    let output = estimate(&file, folder.path());
    assert_eq!(output.status.code(), Some(2), "{}", both(&output));
}

#[test]
fn times_that_run_backwards_are_refused_as_they_come() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = treated(dir.path(), "t", |_, t| (100.0 - t).to_string());
    for output in [estimate(&file, dir.path()), piped(&file, dir.path())] {
        assert_eq!(output.status.code(), Some(2), "{}", both(&output));
        says(&output, "rows were refused");
    }
}

#[test]
fn a_column_without_a_value_is_named() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = treated(dir.path(), "swing_torque", |_, _| String::new());
    let words = "column swing_torque holds no value in any row";
    for output in [estimate(&file, dir.path()), piped(&file, dir.path())] {
        says(&output, words);
    }
    let dir = tempfile::tempdir().expect("a folder");
    let file = treated(dir.path(), "swing_velocity", |_, _| String::new());
    let words = "column swing_velocity holds no value in any row";
    for output in [estimate(&file, dir.path()), piped(&file, dir.path())] {
        assert_eq!(output.status.code(), Some(2), "{}", both(&output));
        says(&output, words);
    }
}

#[test]
fn without_a_stated_size_the_assumed_one_is_reported() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = golden("machines/excavator_1_13t_level.csv");
    let file = file.to_str().expect("a path");
    let out = path_in(dir.path(), "o.csv");
    let said = |more: &[&str]| {
        let estimate = ["estimate", file, "--machine", "excavator", "-o", &out];
        both(&run(&[&estimate[..], more].concat())).contains("reference machine of 5.5 t")
    };
    assert!(said(&[]) && said(&["--set", "prior.payload=500"]));
    assert!(!said(&["--class", "13t"]) && !said(&["--set", "machine.operating_mass=13000"]));
}

#[test]
fn a_number_in_the_place_of_missing_samples_is_named_and_a_word_is_none() {
    let dir = tempfile::tempdir().expect("a folder");
    let said = |mark: &str| {
        let file = treated(dir.path(), "boom_angle", |row, angle| match row % 7 {
            0 => mark.into(),
            _ => angle.to_string(),
        });
        [estimate(&file, dir.path()), piped(&file, dir.path())].map(|output| both(&output))
    };
    for words in said("-3") {
        assert!(words.contains("boom_angle is -3 rad in"), "{words}");
    }
    for words in ["No Data", "Bad", "(null)"].map(said).concat() {
        assert!(!words.contains("boom_angle"), "{words}");
    }
}

#[test]
fn numbers_of_any_size_end_a_calibration_soon() {
    for (column, huge, words) in [
        ("t", 1e300, "larger than any measurement"),
        ("t", 1e6, "s apart"),
        ("swing_torque", 1e300, "larger than any measurement"),
        ("swing_velocity", 1e300, "larger than any measurement"),
    ] {
        let dir = tempfile::tempdir().expect("a folder");
        let file = treated(dir.path(), column, |n, x| match (column, n % 3) {
            ("t", _) => (huge / 4000.0 * (n + 1) as f64).to_string(),
            (_, 0) => huge.to_string(),
            _ => x.to_string(),
        });
        let begun = Instant::now();
        let out = path_in(dir.path(), "found.toml");
        let output = run(&[
            "calibrate",
            "excavator",
            &file,
            "--class",
            "13t",
            "-o",
            &out,
        ]);
        assert!(begun.elapsed().as_secs() < 60, "{column}");
        assert!(
            output.status.code().is_some_and(|code| code > 0),
            "{}",
            both(&output)
        );
        assert!(both(&output).contains(words), "{column}: {}", both(&output));
    }
}

#[test]
fn a_whole_recording_is_copied_where_a_copy_was_asked_for() {
    let dir = tempfile::tempdir().expect("a folder");
    let whole = golden("recordings/loader-cfdbb98.mcap");
    let copy = path_in(dir.path(), "x.mcap");
    let said = run_ok(&["recover", whole.to_str().expect("a path"), "-o", &copy]);
    assert!(said.contains("nothing was damaged; a copy is in"), "{said}");
    run_ok(&["export", &copy, "-o", &path_in(dir.path(), "tables")]);
}

#[test]
fn a_mass_is_no_weight() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = path_in(dir.path(), "scales.csv");
    fs::write(
        &file,
        "pitch,front_load,rear_load\nrad,kg,kg\n0,2500,2200\n",
    )
    .expect("writable");
    let output = run(&["weigh", &file]);
    assert_eq!(output.status.code(), Some(2), "{}", both(&output));
    says(&output, "one of N, kN, MN, daN, kgf, tf, klbf, lbf");
    // Without a row of units the machine's mass determines the unit.
    fs::write(&file, "pitch,front_load,rear_load\n0,2500,2200\n").expect("writable");
    let output = run(&["weigh", &file]);
    assert_eq!(output.status.code(), Some(2), "{}", both(&output));
    says(&output, "seem to be in kg");
    run_ok(&["weigh", &file, "--set", "machine.mass=480"]);
}

#[test]
fn a_centre_of_gravity_below_the_ground_is_a_pitch_of_the_wrong_sign() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = path_in(dir.path(), "scales.csv");
    let weigh = |pitch: f64| {
        let scales = format!("pitch,front_load,rear_load\n0,20000,26000\n{pitch},18000,28000\n");
        fs::write(&file, scales).expect("writable");
        run(&["weigh", &file])
    };
    let wrong = weigh(-0.2);
    assert_eq!(wrong.status.code(), Some(2), "{}", both(&wrong));
    says(&wrong, "0.49 m below the ground");
    says(&wrong, "front up is positive");
    says(&weigh(0.2), "height of the centre of gravity      0.49");
}

#[test]
fn a_name_cannot_turn_the_words_around_it() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = path_in(dir.path(), "day\u{202e}vsc.csv");
    fs::write(&file, "t,sw\u{202e}ing_velocity\n0,1\n").expect("writable");
    for output in [
        estimate(&file, dir.path()),
        run(&["map", &file, "--machine", "excavator"]),
        run(&["loads", &file, "--machine", "excavator"]),
        run(&["report", &file, "-o", &path_in(dir.path(), "r.html")]),
        run(&["serve", "excavator", &file]),
    ] {
        let said = both(&output);
        assert!(!said.contains('\u{202e}'), "{said:?}");
        assert!(
            said.contains("u{202e}") || said.contains("U0000202E") || said.contains('\u{fffd}'),
            "{said}"
        );
    }
}

#[test]
fn a_line_break_in_a_name_keeps_an_error_in_its_three_lines() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = path_in(dir.path(), "a\nheft: done.csv");
    fs::write(&file, "t,\"swing_\nvelocity\"\n0,1\n").expect("writable");
    for output in [
        estimate(&file, dir.path()),
        run(&["weigh", &file]),
        run(&["report", &file, "-o", &path_in(dir.path(), "r.html")]),
        run(&["check", &file]),
    ] {
        assert_eq!(output.status.code(), Some(2), "{}", both(&output));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(said.lines().count(), 3, "{said}");
    }
}

#[test]
fn a_number_may_begin_with_its_point() {
    let dir = tempfile::tempdir().expect("a folder");
    let (input, out) = (
        golden("excavator_input_base_case1.csv"),
        path_in(dir.path(), "o.csv"),
    );
    let input = input.to_str().expect("a path");
    let set = "sensors.swing_torque_delay=.05";
    run_ok(&[
        "estimate",
        input,
        "--machine",
        "excavator",
        "-o",
        &out,
        "--set",
        set,
    ]);
}

#[test]
fn what_is_said_of_an_input_is_said_of_many_too() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = treated(dir.path(), "swing_torque", |row, torque| match row % 100 {
        0 => "1e300".into(),
        _ => torque.to_string(),
    });
    fs::rename(&file, dir.path().join("-day.csv")).expect("another name");
    let output = heft()
        .args("estimate --machine excavator --class 13t -- -day.csv".split(' '))
        .current_dir(dir.path())
        .output()
        .expect("heft starts");
    assert!(output.status.success(), "{}", both(&output));
    says(
        &output,
        "-day.csv: swing_torque is larger than any measurement",
    );
}

#[test]
fn a_result_in_doubt_stays_in_doubt() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = treated(dir.path(), "swing_torque", |_, torque| {
        (torque / 1000.0).to_string()
    });
    let estimate = |more: &[&str]| {
        let args = [
            "estimate",
            &file,
            "--machine",
            "excavator",
            "--class",
            "13t",
        ];
        run(&[&args, more].concat())
    };
    for _ in 0..2 {
        let output = estimate(&[]);
        assert_eq!(output.status.code(), Some(1), "{}", both(&output));
    }
    treated(dir.path(), "swing_torque", |_, _| String::new());
    for more in [&[][..], &["--require-trust"], &["--require-trust"]] {
        let output = estimate(more);
        let expected = i32::from(!more.is_empty());
        assert_eq!(output.status.code(), Some(expected), "{}", both(&output));
    }
}

#[test]
fn a_damaged_recording_is_in_doubt_as_often_as_its_page_is_asked_for() {
    let dir = tempfile::tempdir().expect("a folder");
    let mut bytes = fs::read(golden("recordings/excavator-cfdbb98.mcap")).expect("golden");
    let middle = bytes.len() / 2;
    bytes[middle..middle + 50]
        .iter_mut()
        .for_each(|b| *b ^= 0x55);
    let file = path_in(dir.path(), "run.mcap");
    fs::write(&file, bytes).expect("writable");
    for _ in 0..2 {
        let output = run(&["report", "--each", &file]);
        assert_eq!(output.status.code(), Some(1), "{}", both(&output));
    }
}

#[test]
fn whoever_ends_a_command_of_many_inputs_ends_their_processes() {
    let dir = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(golden("machines/excavator_1_13t_level.csv")).expect("golden");
    let (header, rows) = text.split_once('\n').expect("rows");
    // Long enough to be read for seconds: only the first round is accepted, the rest is refused.
    let file = path_in(dir.path(), "day.csv");
    fs::write(&file, format!("{header}\n{}", rows.repeat(200))).expect("writable");
    let mut command = heft();
    command.args(["estimate", &file, "--machine", "excavator"]);
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("heft");
    let own = || {
        let all = fs::read_dir("/proc").expect("/proc").flatten();
        let lines = all.filter_map(|p| fs::read_to_string(p.path().join("cmdline")).ok());
        lines.filter(|line| line.contains(&file)).count()
    };
    crate::common::wait_until(
        "its process runs",
        std::time::Duration::from_secs(10),
        || own() == 2,
    );
    let pid = rustix::process::Pid::from_child(&child);
    rustix::process::kill_process(pid, rustix::process::Signal::TERM).expect("a process");
    let status = child.wait().expect("its end");
    assert!(!status.success());
    crate::common::wait_until("none is left", std::time::Duration::from_secs(5), || {
        own() == 0
    });
}

#[test]
fn a_column_that_is_empty_for_one_machine_of_many_is_named_with_it() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = path_in(dir.path(), "fleet.csv");
    let rows = (0..200).map(|k| {
        let (t, torque) = (f64::from(k) / 100.0, f64::from(k % 7));
        format!("{t},a,0.1,{torque}\n{t},b,0.1,\n")
    });
    let table = "t,machine,swing_velocity,swing_torque\n".to_owned() + &rows.collect::<String>();
    fs::write(&file, table).expect("writable");
    let said = both(&run(&["serve", "excavator", &file]));
    let words = "column swing_torque holds no value in any row; it counts as absent: machine b\n";
    assert!(said.contains(words), "{said}");
}

#[test]
fn a_clock_that_is_set_back_an_hour_is_no_joint_that_jumps() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = treated(dir.path(), "t", |row, t| match row {
        0..1000 => t.to_string(),
        _ => (t - 3600.0).to_string(),
    });
    let output = estimate(&file, dir.path());
    assert_eq!(output.status.code(), Some(0), "{}", both(&output));
    let rows = fs::read_to_string(dir.path().join("out.csv")).expect("estimates");
    assert!(!rows.contains(",jump"), "the reason");
}

#[test]
fn a_map_for_a_machine_file_and_a_map_of_something_else_are_named() {
    let dir = tempfile::tempdir().expect("a folder");
    let names = ["map", "machine", "geometry", "topics", "empty"];
    let [map, machine, geometry, topics, empty] =
        names.map(|name| path_in(dir.path(), &format!("{name}.toml")));
    fs::write(
        &map,
        "[columns]\nboom_angle = { column = \"boom_angle\", unit = \"°\" }\n",
    )
    .expect("writable");
    fs::write(&machine, "[machine]\noperating_mass = 13000\n").expect("writable");
    fs::write(&geometry, "[geometry]\nboom_length = 5.7\n").expect("writable");
    fs::write(
        &topics,
        "[topics]\nrate = 100\n[topics.signals]\nspeed = { topic = \"/a\", field = \"b\" }\n",
    )
    .expect("writable");
    fs::write(&empty, "\n").expect("writable");
    let recording = golden("recordings/excavator-cfdbb98.mcap");
    let output = run(&["map", recording.to_str().expect("a path")]);
    says(&output, "needs no signal map");
    let input = golden("machines/excavator_1_13t_level.csv");
    let input = input.to_str().expect("a path");
    for (option, file, words) in [
        ("--config", &map, "give that with --map"),
        ("--map", &map, "did you mean deg?"),
        ("--config", &geometry, "did you mean [machine.geometry]?"),
        ("--map", &topics, "names no columns"),
        ("--config", &empty, "the machine file is empty"),
        ("--map", &machine, "give that with --config"),
    ] {
        let output = estimate_of("excavator", input, dir.path(), &[option, file]);
        assert_eq!(output.status.code(), Some(2), "{}", both(&output));
        says(&output, words);
    }
}

#[test]
fn what_a_logger_writes_where_it_has_no_sample_is_counted() {
    for (column, written) in [
        ("swing_velocity", "65535"),
        ("boom_angle", "-999.25"),
        ("swing_torque", "-1e30"),
    ] {
        let dir = tempfile::tempdir().expect("a folder");
        let file = treated(dir.path(), column, |row, x| match row % 50 {
            0 => written.to_owned(),
            _ => x.to_string(),
        });
        let output = estimate(&file, dir.path());
        assert_eq!(output.status.code(), Some(0), "{}", both(&output));
        let words = format!("{column} is larger than any measurement in 81 rows");
        says(&output, &words);
    }
}

#[test]
fn frames_without_a_map_and_what_is_no_text_are_named_as_they_come() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = path_in(dir.path(), "x");
    for (content, words) in [
        (
            &b"(0.0) can0 123#0011\n"[..],
            "a CAN log needs a signal map",
        ),
        (b"\xa3\x95\x80\x01\x02\x03abc\x04\n", "this is no text"),
        (b"abc\x00\x01\x02\x03,def\n0,1\n", "no text"),
    ] {
        fs::write(&file, content).expect("writable");
        for output in [estimate(&file, dir.path()), piped(&file, dir.path())] {
            assert_eq!(output.status.code(), Some(2), "{}", both(&output));
            says(&output, words);
        }
    }
}

#[test]
fn a_table_gives_the_same_estimates_however_its_cells_and_dates_are_written() {
    let dir = tempfile::tempdir().expect("a folder");
    let table = treated(dir.path(), "t", |_, t| format!("{t:.2}"));
    let estimates = |input: &str| {
        let output = estimate(input, dir.path());
        assert_eq!(output.status.code(), Some(0), "{}", both(&output));
        fs::read_to_string(dir.path().join("out.csv")).expect("estimates")
    };
    let expected = estimates(&table);
    let text = fs::read_to_string(&table).expect("the table");
    let aligned = text.replace(',', "   ").replace('\n', " \r\n  ");
    for (name, other) in [("blanks", aligned), ("same", text)] {
        let file = path_in(dir.path(), name);
        fs::write(&file, other).expect("writable");
        assert!(estimates(&file) == expected, "{name}");
        assert_eq!(piped(&file, dir.path()).status.code(), Some(0), "{name}");
    }
    for day in ["2026-11-26", "11/26/2026", "26/11/2026", "26-Nov-2026"] {
        let dated = treated(dir.path(), "t", |_, t| {
            format!("{day} 01:{:02}:{:05.2}", (t / 60.0) as u32, t % 60.0)
        });
        assert!(estimates(&dated) == expected, "{day}");
    }
    let dated = treated(dir.path(), "t", |_, t| format!("12/11/2026 01:02:{t:05.2}"));
    for output in [estimate(&dated, dir.path()), piped(&dated, dir.path())] {
        let said = both(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains("may begin with its day or with its month"),
            "{said}"
        );
        assert!(said.contains("write the year first"), "{said}");
    }
}

#[test]
fn decimal_commas_in_quotes_are_read() {
    let dir = tempfile::tempdir().expect("a folder");
    let table = treated(dir.path(), "t", |_, t| format!("{t:.2}"));
    let text = fs::read_to_string(&table).expect("the table");
    let quoted: String = text
        .lines()
        .map(|line| format!("\"{}\"\n", line.replace(',', "\",\"").replace('.', ",")))
        .collect();
    let said = [text, quoted].map(|content| {
        let file = path_in(dir.path(), "commas.csv");
        fs::write(&file, content).expect("writable");
        both(&estimate(&file, dir.path()))
    });
    assert!(said[0].contains("The swing inertia is"), "{}", said[0]);
    assert_eq!(said[0], said[1]);
}

#[test]
fn what_exports_do_to_a_table_is_named_with_what_to_do() {
    let dir = tempfile::tempdir().expect("a folder");
    let table = treated(dir.path(), "t", |_, t| format!("{t:.2}"));
    let text = fs::read_to_string(&table).expect("the table");
    let german = text.replace(',', ";").replace('.', ",");
    let thousands = treated(dir.path(), "swing_torque", |_, x| match x.abs() as u32 {
        all @ 1000.. => format!("{}.{:03}", all / 1000, all % 1000),
        all => all.to_string(),
    });
    let thousands = fs::read_to_string(thousands).expect("the table");
    let thousands = thousands.lines().map(|line| {
        let mut cells: Vec<String> = line.split(',').map(|cell| cell.replace('.', ",")).collect();
        cells[2] = cells[2].replace(',', ".");
        cells.join(";") + "\n"
    });
    let (header, rows) = text.split_once('\n').expect("rows");
    let names: Vec<&str> = header.split(',').rev().collect();
    let half = rows.len() / 2 + rows[rows.len() / 2..].find('\n').expect("a row") + 1;
    let hole = "\0".repeat(4096);
    for (content, words) in [
        (
            text.replace(".", ","),
            "where commas are decimal marks, separate the columns by ;",
        ),
        (
            thousands.collect(),
            "column swing_torque has numbers like 12.345",
        ),
        (
            text.replacen(',', ";", header.matches(',').count()),
            "separated by ';'",
        ),
        (
            format!(
                "{header}\n{}{}\n{}",
                &rows[..half],
                names.join(","),
                &rows[half..]
            ),
            "the header stands here once more",
        ),
        (
            format!("{header}\n{}{hole}\n{}", &rows[..half], &rows[half..]),
            "it holds bytes of zero, as after a loss of power",
        ),
        (
            format!("{header}\n{}{hole}{}", &rows[..half], &rows[half..]),
            "it holds bytes of zero, as after a loss of power",
        ),
    ] {
        let file = path_in(dir.path(), "odd.csv");
        fs::write(&file, content).expect("writable");
        let output = estimate(&file, dir.path());
        assert_eq!(output.status.code(), Some(2), "{words}: {}", both(&output));
        assert!(both(&output).contains(words), "{words}: {}", both(&output));
    }
    for (content, words) in [
        (german, ""),
        (text.replacen('\n', ",\n", 1), ""),
        (format!("\u{feff}\u{feff}{text}"), ""),
        (text.replacen('\n', "\ns,-,-,-,-,-,-,-,-\n", 1), ""),
        (
            text.replacen("swing_torque", "\"swing\ntorque\"", 1),
            "the column swing\\ntorque is not used",
        ),
    ] {
        let file = path_in(dir.path(), "odd.csv");
        fs::write(&file, content).expect("writable");
        let output = estimate(&file, dir.path());
        assert_eq!(output.status.code(), Some(0), "{}", both(&output));
        says(&output, words);
    }
}

#[test]
fn frames_in_tables_of_other_tools_and_a_bus_without_a_name_are_named() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = path_in(dir.path(), "frames.csv");
    for header in [
        "Time,Channel,ID,Flags,DLC,Data0,Data1",
        "Line,Abs Time(Sec),Description,Arb ID,Remote,B1,B2",
    ] {
        let row = vec!["1"; header.split(',').count()].join(",");
        fs::write(&file, format!("Logger 3.1\n{header}\n{row}\n{row}\n")).expect("writable");
        for args in [["map", &file], ["estimate", &file]] {
            let output = run(&[&args[..], &["--machine", "excavator"]].concat());
            assert_eq!(output.status.code(), Some(2), "{}", both(&output));
            let words = "this is a table of CAN frames";
            says(&output, words);
        }
    }
    let map = path_in(dir.path(), "map.toml");
    fs::write(&map, "[can]\ndbc = []\n").expect("writable");
    let output = run(&["run", "excavator", "--input", "can:", "--map", &map]);
    assert_eq!(output.status.code(), Some(2), "{}", both(&output));
    says(&output, "no CAN interface is named");
}

#[test]
fn times_in_digits_of_the_clock_are_named_and_so_is_a_gap() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = treated(dir.path(), "t", |_, t| {
        let t = 3000.0 + 10.0 * t;
        format!(
            "{:02}{:02}{:05.2}",
            (t / 3600.0) as u32,
            (t / 60.0) as u32 % 60,
            t % 60.0
        )
    });
    in_doubt(&file, dir.path(), "seem to be written as hhmmss");
    let file = treated(dir.path(), "t", |_, t| match t > 10.0 {
        true => (t + 3600.0).to_string(),
        false => t.to_string(),
    });
    let output = estimate(&file, dir.path());
    assert_eq!(output.status.code(), Some(0), "{}", both(&output));
    let words = "the times have a gap of more than 10 s, the longest of 3600 s";
    says(&output, words);
}

#[test]
fn a_slope_in_percent_is_mapped_as_a_grade() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = path_in(dir.path(), "day.csv");
    let header = "t,speed,front_wheel_speed,rear_wheel_speed,front_torque,rear_torque";
    for (name, most, line) in [
        (
            "slope_pct",
            5.0,
            "column = \"slope_pct\", unit = \"%\", scale = 1.0",
        ),
        (
            "grade [%]",
            5.0,
            "column = \"grade [%]\", unit = \"%\", scale = 1.0",
        ),
        (
            "slope",
            60.0,
            "column = \"slope\", unit = \"%\", scale = 1.0",
        ),
        (
            "slope",
            12.0,
            "values beyond 0.61 rad: deg? A grade in % has",
        ),
        ("slope", 0.2, "slope = \"slope\""),
    ] {
        let rows = (0..200).map(|i| {
            let t = 0.01 * f64::from(i);
            format!("{t},1,2,2,100,100,{}\n", most * (8.0 * t).sin())
        });
        fs::write(
            &file,
            format!("{header},{name}\n{}", rows.collect::<String>()),
        )
        .expect("writable");
        let map = run_ok(&["map", &file, "--machine", "loader"]);
        assert!(map.contains(line), "{name} {most}: {map}");
    }
}

#[test]
fn a_loader_s_units_and_size_are_doubted_too() {
    let text = fs::read_to_string(golden("machines/loader_1_5t_sound.csv")).expect("golden");
    let dir = tempfile::tempdir().expect("a folder");
    let file = path_in(dir.path(), "day.csv");
    let (kmh, knm) = (Some("unit = \"km/h\""), Some("unit = \"kNm\""));
    // As one table, and as two merged ones, whose columns never come in the same row.
    for (class, column, by, is_merged, words) in [
        ("5t", "speed", 1.0, false, None),
        ("5t", "speed", 3.6, false, kmh),
        ("5t", "torque", 1e-3, false, knm),
        ("5t", "torque", -1.0, false, Some("sign = -1")),
        ("20t", "speed", 1.0, false, Some("a loader of about 5")),
        ("5t", "speed", 1.0, true, None),
        ("5t", "speed", 3.6, true, kmh),
        ("5t", "torque", 1e-3, true, knm),
    ] {
        let mut lines = text.lines();
        let header = lines.next().expect("a header");
        let is_meant = |name: &str| name == column || column == "torque" && name.ends_with(column);
        let meant: Vec<bool> = header.split(',').map(is_meant).collect();
        let names: Vec<&str> = header.split(',').collect();
        let rows = lines.enumerate().map(|(n, row)| {
            let cells = row.split(',').zip(&meant).zip(&names);
            let cells = cells.map(|((cell, meant), name)| match meant {
                _ if is_merged && *name != "t" && (n % 2 == 0) == (*name == "speed") => {
                    String::new()
                }
                true => (by * cell.parse::<f64>().expect("a number")).to_string(),
                false => cell.to_owned(),
            });
            cells.collect::<Vec<_>>().join(",") + "\n"
        });
        let table = header.replace("true_", "was_") + "\n" + &rows.collect::<String>();
        fs::write(&file, table).expect("writable");
        let output = estimate_of("loader", &file, dir.path(), &["--class", class]);
        let expected = i32::from(words.is_some());
        assert_eq!(output.status.code(), Some(expected), "{}", both(&output));
        says(&output, words.unwrap_or(""));
    }
}

/// Opening a pipe blocks until it has a writer.
#[test]
fn pipes_in_a_folder_of_recordings_are_passed_over() {
    let dir = tempfile::tempdir().expect("a folder");
    let name = |name: &str| path_in(dir.path(), name);
    fs::copy(golden("excavator_input_drop.csv"), name("day.csv")).expect("a copy");
    for pipe in ["a.csv", "b.log", "c.mcap"] {
        let made = std::process::Command::new("mkfifo")
            .arg(name(pipe))
            .status();
        assert!(made.expect("mkfifo").success());
    }
    let folder = dir.path().to_str().expect("a path");
    run_ok(&["estimate", folder, "--machine", "excavator"]);
    assert!(dir.path().join("day.estimates.csv").exists());
    for pipe in ["a.csv", "c.mcap"] {
        let output = run(&["loads", &name(pipe), "--machine", "excavator"]);
        assert_eq!(output.status.code(), Some(2), "{}", both(&output));
        says(&output, "a pipe or a device");
    }
}

#[test]
fn a_map_elsewhere_finds_the_dbc_file() {
    let dir = tempfile::tempdir().expect("a folder");
    let dbc = "BO_ 256 Swing: 8 ECU\n SG_ SwingSpeed : 0|16@1- (0.001,0) [0|0] \"rad/s\" ECU\n";
    let frames = (0..200).map(|k| format!("({k}.00) can0 100#{k:02X}00\n"));
    fs::create_dir(dir.path().join("maps")).expect("a folder");
    fs::write(dir.path().join("m.dbc"), dbc).expect("writable");
    fs::write(dir.path().join("day.log"), frames.collect::<String>()).expect("writable");
    let said_of = |args: &[&str]| {
        let output = heft().args(args).current_dir(&dir).output();
        both(&output.expect("heft"))
    };
    said_of(&["map", "day.log", "--dbc", "m.dbc", "-o", "maps/day.toml"]);
    let said = said_of(&[
        "estimate",
        "day.log",
        "--machine",
        "excavator",
        "--map",
        "maps/day.toml",
        "-o",
        "out.csv",
    ]);
    assert!(said.contains("estimates in out.csv"), "{said}");
    // The logger was switched off within a frame.
    let mut log = fs::OpenOptions::new()
        .append(true)
        .open(dir.path().join("day.log"))
        .expect("a log");
    std::io::Write::write_all(&mut log, b"(200.0) can0 1").expect("writable");
    for words in ["estimate -o out.csv", "loads"] {
        let mut cut = heft();
        cut.args(words.split(' '))
            .args("--machine excavator --map maps/day.toml day.log".split(' '));
        let output = cut.current_dir(&dir).output().expect("heft");
        assert_eq!(output.status.code(), Some(1), "{}", both(&output));
        says(&output, "day.log:201: the last line was cut off");
    }
}

#[test]
fn a_wheelbase_that_is_not_stated_is_guessed_from_the_scales_and_reported() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = path_in(dir.path(), "scales.csv");
    let scales = "pitch,front_load,rear_load\n0,58000,64000\n0.15,50000,72000\n";
    fs::write(&file, scales).expect("writable");
    let guessed = both(&run(&["weigh", &file]));
    assert!(
        guessed.contains("nobody states the wheelbase: 3.15 m"),
        "{guessed}"
    );
    assert!(guessed.contains("the scales show 12.4 t"), "{guessed}");
    let width = |said: &str| -> f64 {
        let line = said.lines().find(|line| line.starts_with("front axle to"));
        let std = line
            .and_then(|line| line.split('±').nth(1))
            .expect("a width");
        std.trim().trim_end_matches(" m").parse().expect("a number")
    };
    assert!(width(&guessed) > 0.07, "{guessed}");
    let stated = both(&run(&["weigh", &file, "--set", "machine.wheelbase=2.3"]));
    assert!(!stated.contains("nobody states"), "{stated}");
    assert!(width(&stated) < 0.01, "{stated}");
    let class = both(&run(&["weigh", &file, "--class", "12t"]));
    assert!(width(&class) > 0.07, "{class}");
}

#[test]
fn a_sign_that_the_map_has_wrongly_is_to_be_removed() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = treated(dir.path(), "swing_torque", |_, torque| torque.to_string());
    let map = path_in(dir.path(), "map.toml");
    let line = "swing_torque = { column = \"swing_torque\", sign = -1 }";
    fs::write(&map, format!("[columns]\n{line}\n")).expect("writable");
    let output = estimate_of(
        "excavator",
        &file,
        dir.path(),
        &["--class", "13t", "--map", &map],
    );
    assert_eq!(output.status.code(), Some(1), "{}", both(&output));
    let said = both(&output);
    assert!(
        said.contains("remove `sign = -1` for swing_torque"),
        "{said}"
    );
}

#[test]
fn a_mass_of_the_data_is_no_pounds_where_only_the_size_is_unstated() {
    let dir = tempfile::tempdir().expect("a folder");
    let loader = golden("machines/loader_2_12t_late.csv");
    let output = estimate_of("loader", &loader.display().to_string(), dir.path(), &[]);
    let said = both(&output);
    assert!(
        said.contains("say how large yours is (--class 12.1t"),
        "{said}"
    );
    assert!(!said.contains("seems to be in pounds"), "{said}");
}

/// The golden excavator of 13 t, and one with half of its torques, by a column that is called otherwise than `machine`.
fn two_machines(folder: &Path, are_in_turn: bool) -> String {
    let table = |factor: f64| {
        let file = treated(folder, "swing_torque", |_, torque| {
            (factor * torque).to_string()
        });
        fs::read_to_string(file).expect("the table")
    };
    let (first, second) = (table(1.0), table(0.5));
    let header = first.lines().next().expect("a header");
    let of = |table: &str, name: &str| {
        let rows = table.lines().skip(1);
        rows.map(|row| format!("{row},{name}\n"))
            .collect::<Vec<_>>()
    };
    let (first, second) = (of(&first, "EX-01"), of(&second, "EX-02"));
    let both: String = match are_in_turn {
        true => first
            .iter()
            .zip(&second)
            .flat_map(|(a, b)| [a.as_str(), b])
            .collect(),
        false => first.iter().chain(&second).map(String::as_str).collect(),
    };
    let file = path_in(folder, "fleet.csv");
    fs::write(&file, format!("{header},Serial No\n{both}")).expect("writable");
    file
}

#[test]
fn a_table_of_two_machines_is_named_by_the_column_that_parts_it() {
    for are_in_turn in [true, false] {
        let folder = tempfile::tempdir().expect("a folder");
        let output = estimate(&two_machines(folder.path(), are_in_turn), folder.path());
        assert_eq!(output.status.code(), Some(1), "{}", both(&output));
        says(
            &output,
            "several machines or recordings, by the column Serial No: EX-01, EX-02",
        );
        says(&output, "heft serve");
    }
}

#[test]
fn rows_in_the_reverse_order_are_called_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(golden("machines/excavator_1_13t_level.csv")).expect("golden");
    let (header, rows) = text.split_once('\n').expect("a header");
    let turned: String = rows.lines().rev().map(|row| format!("{row}\n")).collect();
    let file = path_in(folder.path(), "day.csv");
    fs::write(&file, format!("{header}\n{turned}")).expect("writable");
    let output = estimate(&file, folder.path());
    assert_eq!(output.status.code(), Some(2), "{}", both(&output));
    says(&output, "they stand in the reverse order");
}

#[test]
fn files_of_a_folder_in_formats_that_are_not_read_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| path_in(folder.path(), name);
    fs::copy(golden("machines/excavator_1_13t_level.csv"), at("a.csv")).expect("copied");
    fs::write(at("b.parquet"), b"PAR1\x15\x04\0\0").expect("writable");
    fs::write(at("page.html"), b"<!DOCTYPE html><html>").expect("writable");
    let output = run(&[
        "estimate",
        &at(""),
        "--machine",
        "excavator",
        "--class",
        "13t",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", both(&output));
    says(&output, "b.parquet: a Parquet file");
    assert!(!both(&output).contains("page.html"), "{}", both(&output));
}

//! Loads from a simulated run and its recording: rows, sums, a page; a target, trucks, and refusals.

mod common;

use std::path::Path;

use common::table::Table;
use common::{both, run, run_ok, words};
use messages::channels::LOADER_LOADS;
use messages::{ExcavatorLoads, LoaderLoads, SIMULATED, loads_bits};
use recording::Reader;
use serde_json::Value;

/// A minute of loading, recorded at full speed.
fn recorded(folder: &Path, machine: &str, scenario: &str, more: &[&str]) -> (String, String) {
    let out = folder.join(machine);
    let out = out.to_str().expect("a path");
    let args = [
        "run",
        machine,
        "--scenario",
        scenario,
        "--duration",
        "56",
        "--pace",
        "max",
    ];
    let args = [&args[..], &["--out", out, "--no-report", "--quiet"], more].concat();
    let said = run_ok(&args);
    (format!("{out}/run.mcap"), said)
}

fn number(value: &Value, key: &str) -> f64 {
    value[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} in {value}"))
}

/// The result of `heft loads` for a recording, as JSON.
fn counted(folder: &Path, recording: &str, more: &[&str]) -> Value {
    let json = folder.join("loads.json");
    let json = json.to_str().expect("a path");
    run_ok(&[&["loads", recording, "--json", json], more].concat());
    let text = std::fs::read_to_string(json).expect("a summary");
    serde_json::from_str(&text).expect("JSON")
}

/// Checks that the report of a recording, and that of its recomputed estimates, have a row for each counted load.
fn the_pages_show(folder: &Path, recording: &str, loads: &[Value]) {
    let [of_run, of_estimates, rows] =
        ["run.html", "est.html", "est.csv"].map(|name| common::path_in(folder, name));
    run_ok(&["report", recording, "-o", &of_run]);
    run_ok(&[
        "estimate",
        recording,
        "-o",
        &rows,
        "--report",
        &of_estimates,
    ]);
    for page in [of_run, of_estimates] {
        let page = std::fs::read_to_string(page).expect("a page");
        let (_, after) = page.split_once("<h2>Loads</h2>").expect("a table of loads");
        let (table, _) = after.split_once("</section>").expect("its end");
        assert_eq!(
            table.matches("<td>yes</td>").count(),
            loads.len(),
            "{table}"
        );
        for load in loads {
            let held = &load["in_bucket"];
            let (kg, _) = view::number::value_and_std(number(held, "kg"), number(held, "std"));
            let interval = view::number::interval_95(number(held, "kg"), number(held, "std"));
            assert!(
                table.contains(&format!("<td>{kg}</td><td>{interval}</td>")),
                "{kg}, {interval}: {table}"
            );
        }
    }
}

#[test]
fn a_loader_weighs_its_loads_by_the_lift_pressures_and_the_truck_gets_their_sum() {
    let folder = tempfile::tempdir().expect("a folder");
    // The gain of these sensors is exactly that of the simulator.
    let more = words("--payload 1200 --set sensors.pressure_gain_std=0.01");
    let (recording, said) = recorded(folder.path(), "loader", "loading", &more);
    assert!(
        said.contains("load 1") && said.contains("by pressure"),
        "{said}"
    );
    let counted = counted(folder.path(), &recording, &["--target", "5000"]);
    let account = &counted["recordings"][0];
    let loads = account["loads"].as_array().expect("loads");
    assert_eq!(loads.len(), 2, "{account}");
    for load in loads {
        let held = &load["in_bucket"];
        assert_eq!(load["witness"], "pressure");
        assert!(
            number(held, "low") < 1200.0 && 1200.0 < number(held, "high"),
            "{load}"
        );
    }
    // After the first dump the empty bucket is a known weight.
    let stds: Vec<f64> = loads
        .iter()
        .map(|load| number(&load["in_bucket"], "std"))
        .collect();
    assert!(stds[0] < 170.0 && stds[1] < 0.9 * stds[0], "{stds:?}");
    let truck = &account["trucks"][0];
    let sum: f64 = loads.iter().map(|l| number(&l["delivered"], "kg")).sum();
    assert!((number(&truck["total"], "kg") - sum).abs() < 1.0, "{truck}");
    assert!(
        (number(truck, "remaining") - (5000.0 - sum)).abs() < 1.0,
        "{truck}"
    );
    the_pages_show(folder.path(), &recording, loads);
    // The run reported the same on its channel.
    let reader = Reader::open(Path::new(&recording)).expect("a recording");
    let reported: Vec<LoaderLoads> = reader.messages(LOADER_LOADS.name).expect("loads");
    let last = reported.last().expect("a message");
    assert_eq!((last.load, last.truck, last.truck_loads), (2, 1, 2));
    assert!((last.truck_mass - sum).abs() < 0.02 * sum, "{last:?}");
    assert!(last.flags & (loads_bits::FINAL | SIMULATED) == loads_bits::FINAL | SIMULATED);
    let carried = |m: &&LoaderLoads| m.flags & loads_bits::CARRIED != 0 && m.load == 1;
    let carried = reported
        .iter()
        .rfind(carried)
        .expect("the first load in the bucket");
    assert!(
        (carried.mass - 1200.0).abs() < 1.96 * carried.mass_std,
        "{carried:?}"
    );
    assert!(
        reported.len() > 400,
        "ten times a second: {}",
        reported.len()
    );
    // Errors that both loads have in common add up: the sum is less certain than that of independent ones.
    let own: f64 = loads
        .iter()
        .map(|l| number(&l["delivered"], "std").powi(2))
        .sum();
    assert!(number(&truck["total"], "std") > own.sqrt(), "{truck}");
}

/// Dumped mass of each load of an independent recording: the largest content minus the carry-back \[kg\].
fn dumped(file: &Path) -> Vec<f64> {
    let recording = Table::read(file);
    let payloads: Vec<f64> = recording.rows().map(|r| r.number("true_payload")).collect();
    let full = payloads.iter().copied().fold(0.0, f64::max);
    let (mut dumped, mut most, mut is_full) = (Vec::new(), 0.0_f64, false);
    for payload in payloads {
        is_full |= payload > 0.4 * full;
        most = most.max(payload);
        if is_full && payload < 0.05 * full {
            dumped.push(most - payload);
            (most, is_full) = (0.0, false);
        }
    }
    dumped
}

#[test]
fn each_load_of_other_machines_is_counted_by_their_mass_alone_and_the_sum_holds_what_was_dumped() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut held, mut all) = (0, 0);
    for file in std::fs::read_dir(common::golden("machines")).expect("recordings") {
        let file = file.expect("a file").path();
        let name = file
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        let Some(class) = name
            .split('_')
            .nth(2)
            .filter(|_| name.starts_with("excavator_"))
        else {
            continue;
        };
        let of = file.to_str().expect("a path");
        let counted = counted(
            folder.path(),
            of,
            &["--machine", "excavator", "--class", class],
        );
        let truth = dumped(&file);
        let total = &counted["recordings"][0]["total"];
        assert_eq!(
            number(total, "loads") as usize,
            truth.len(),
            "{name}: {total}"
        );
        let kg: f64 = truth.iter().sum();
        all += 1;
        held += usize::from(number(total, "low") <= kg && kg <= number(total, "high"));
    }
    assert!(all == 8 && held >= 7, "{held} of {all}");
}

/// A pressure that is wrong from the middle of a carried load on hides that the load leaves.
#[test]
fn where_a_lift_sensor_breaks_while_loaded_the_sum_still_holds_what_was_dumped() {
    let folder = tempfile::tempdir().expect("a folder");
    let golden = common::golden("weighed/loader_1_5t_good.csv");
    let truth: f64 = dumped(&golden).iter().sum();
    let text = std::fs::read_to_string(golden).expect("a recording");
    let mut lines = text.lines();
    let header = lines.next().expect("a header");
    let names: Vec<&str> = header.split(',').collect();
    let head = names.iter().position(|name| *name == "lift_head_pressure");
    let rows = lines.map(|line| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let number = |at: usize| cells[at].parse::<f64>().expect("a number");
        let at = head.expect("the pressure");
        if number(0) > 25.0 {
            cells[at] = (0.7 * number(at)).to_string();
        }
        cells.join(",") + "\n"
    });
    let broken = common::path_in(folder.path(), "broken.csv");
    std::fs::write(&broken, format!("{header}\n{}", rows.collect::<String>())).expect("writable");
    let machines = std::fs::read_to_string(common::golden("weighed/machines.json"));
    let machines: Value = serde_json::from_str(&machines.expect("machines")).expect("JSON");
    let stated = machines["loader_1_5t_good"]["sets"].as_object();
    let stated = stated.expect("keys").iter();
    let sets: Vec<String> = stated
        .map(|(key, value)| format!("--set={key}={value}"))
        .collect();
    let more = ["--machine", "loader"].into_iter();
    let more: Vec<&str> = more.chain(sets.iter().map(String::as_str)).collect();
    let counted = counted(folder.path(), &broken, &more);
    let loads = counted["recordings"][0]["loads"].as_array().expect("loads");
    assert!(number(&loads[0], "dumped") < 30.0, "{loads:?}");
    let total = &counted["recordings"][0]["total"];
    assert!(
        number(total, "low") <= truth && truth <= number(total, "high"),
        "{truth} {total}"
    );
}

#[test]
fn without_pressure_a_simulated_loader_has_none_and_the_recording_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let more = ["--without", "pressure", "--payload", "1200"];
    let (recording, _) = recorded(folder.path(), "loader", "loading", &more);
    let counted = counted(folder.path(), &recording, &[]);
    let loads = counted["recordings"][0]["loads"].as_array().expect("loads");
    assert!(!loads.is_empty(), "{counted}");
    assert!(
        loads.iter().all(|l| l["witness"] != "pressure"),
        "{counted}"
    );
    let reader = recording::Reader::open(Path::new(&recording)).expect("a recording");
    assert_eq!(
        reader.metadata().get("without").map(String::as_str),
        Some("pressure")
    );
}

#[test]
fn an_excavator_s_loads_are_rows_of_a_table_and_of_a_page_and_the_witness_is_both() {
    let folder = tempfile::tempdir().expect("a folder");
    let (recording, _) = recorded(folder.path(), "excavator", "cycle", &[]);
    let [table, page] = ["l.csv", "l.html"].map(|name| common::path_in(folder.path(), name));
    let said = run_ok(&[
        "loads", &recording, "-o", &table, "--report", &page, "--pause", "12",
    ]);
    // The loads of the cycle, in turn.
    let table = Table::read(&table);
    assert!(table.rows().len() >= 3, "{said}");
    for (row, truth) in table.rows().zip([288.0, 423.0, 200.0]) {
        let (low, high) = (row.number("kg_low"), row.number("kg_high"));
        assert!(low < truth && truth < high, "{low} to {high}: {truth}");
        assert_eq!(row.cell("witness"), "motion and pressure");
    }
    // Twelve seconds without a load: the next load goes to another truck.
    assert!(said.contains("truck 3:"), "{said}");
    let page = std::fs::read_to_string(&page).expect("a page");
    assert!(page.contains("truck 1:") && page.contains("motion and pressure"));
}

#[test]
fn what_cannot_be_counted_is_refused_in_words_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let csv = common::path_in(folder.path(), "rain.csv");
    std::fs::write(&csv, "day,rain\n1,2\n").expect("a file");
    let out = common::path_in(folder.path(), "out.csv");
    for args in [
        vec!["loads", csv.as_str(), "-o", out.as_str()],
        vec![
            "loads",
            csv.as_str(),
            "--machine",
            "excavator",
            "-o",
            out.as_str(),
        ],
        vec![
            "loads",
            csv.as_str(),
            "--machine",
            "excavator",
            "--target",
            "-3",
        ],
    ] {
        let output = run(&args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", both(&output));
    }
    let same = [
        "loads",
        &csv,
        "--machine",
        "excavator",
        "-o",
        &out,
        "--json",
        &out,
    ];
    let said = both(&run(&same));
    assert!(said.contains("have the same name"), "{said}");
    assert!(!Path::new(&out).exists());
}

#[test]
fn an_exported_recording_is_counted_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let more = ["--payload", "1200"];
    let (recording, _) = recorded(folder.path(), "loader", "loading", &more);
    let of = Path::new(&recording).parent().expect("a folder");
    let of = of.to_str().expect("a path");
    run_ok(&["export", of, "-o", of]);
    let said = run_ok(&["loads", of, "--machine", "loader"]);
    assert!(!said.contains("loader_sensors.csv"), "{said}");
    // Named explicitly it is a table like any other.
    let sensors = common::path_in(Path::new(of), "loader_sensors.csv");
    let said = run_ok(&["loads", &sensors, "--machine", "loader"]);
    assert!(said.contains("loader_sensors.csv"), "{said}");
}

/// Begin of the first chunk of samples in an MCAP file: records are an opcode, a length of 8 bytes, and their content.
fn first_block(bytes: &[u8]) -> usize {
    const MAGIC: usize = 8;
    const CHUNK: u8 = 6;
    let mut at = MAGIC;
    while bytes[at] != CHUNK {
        let length = bytes[at + 1..at + 9].try_into().expect("8 bytes");
        at += 9 + u64::from_le_bytes(length) as usize;
    }
    at
}

#[test]
fn of_a_folder_what_can_be_read_is_counted_and_the_rest_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let more = ["--payload", "1200"];
    let (recording, _) = recorded(folder.path(), "loader", "loading", &more);
    let bytes = std::fs::read(&recording).expect("the recording");
    let few = folder.path().join("few");
    std::fs::create_dir(&few).expect("a folder");
    let put = |name: &str, bytes: &[u8]| std::fs::write(few.join(name), bytes).expect("a file");
    put("whole.mcap", &bytes);
    // Within the first chunk of samples.
    put("cut.mcap", &bytes[..first_block(&bytes) + 100]);
    put("rain.csv", b"day,rain\n1,2\n");
    // Its last row is cut off.
    put("still.csv", b"t,swing_velocity\n0,0\n0.01,0\n0.0");
    let out = common::path_in(folder.path(), "out.csv");
    let few = few.to_str().expect("a path");
    let output = run(&["loads", few, "--machine", "excavator", "-o", &out]);
    let said = both(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    // Its own result is no input of the next call.
    let result = common::path_in(Path::new(few), "loads.csv");
    for _ in 0..2 {
        let again = both(&run(&[
            "loads",
            few,
            "--machine",
            "excavator",
            "-o",
            &result,
        ]));
        assert!(again.contains("2 of 4 inputs"), "{again}");
    }
    for words in [
        "whole.mcap: it is of the loader",
        "cut.mcap: the recording is damaged",
        "rain.csv: there is no column t",
        "still.csv:4: the last row was cut off",
        "only the swing motion weighs",
        "2 of 4 inputs could not be counted",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let rows = std::fs::read_to_string(&out).expect("the loads");
    let of_whole = rows.lines().filter(|l| l.contains("whole.mcap")).count();
    assert_eq!(of_whole, 2, "{rows}");
}

#[test]
fn rows_that_give_no_result_leave_an_earlier_one_alone_and_another_unit_of_time_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let [table, out, loads] =
        ["in.csv", "out.csv", "loads.csv"].map(|name| common::path_in(folder.path(), name));
    let commands: [&[&str]; 2] = [
        &["loads", &table, "--machine", "excavator", "-o", &loads],
        &["estimate", &table, "--machine", "excavator", "-o", &out],
    ];
    let run_on = |row: fn(f64) -> String, args: &[&str]| {
        let rows: String = (0..500).map(|k| row(0.01 * f64::from(k))).collect();
        let text = format!("t,swing_velocity,swing_torque\n{rows}");
        std::fs::write(&table, text).expect("a table");
        let output = run(args);
        (output.status.code(), both(&output))
    };
    for args in commands {
        let file = args.last().expect("a result");
        let (status, said) = run_on(|t| format!("{},0.1,100\n", 1000.0 * t), args);
        assert_eq!(status, Some(1), "{said}");
        assert!(said.contains("is the time in ms?"), "{said}");
        let before = std::fs::read(file).expect("a result");
        let (status, said) = run_on(|t| format!("{},0.1,100\n", 5.0 - t), args);
        assert_eq!(status, Some(2), "{said}");
        assert!(said.contains("499 of 500 rows were refused"), "{said}");
        let (status, said) = run_on(|t| format!("{t},nan,\n"), args);
        assert_eq!(status, Some(2), "{said}");
        assert!(
            said.contains("column swing_velocity holds no value"),
            "{said}"
        );
        assert_eq!(std::fs::read(file).expect("a result"), before, "{args:?}");
    }
}

/// A table with a number added to a column from a time on.
fn shifted(text: &str, column: &str, by: f64, from: f64) -> String {
    changed(text, column, from, |value| value + by)
}

/// The table with the values of a column changed from this time on \[s\].
fn changed(text: &str, column: &str, from: f64, mut change: impl FnMut(f64) -> f64) -> String {
    let header = text.lines().next().expect("a header");
    let at = |name: &str| header.split(',').position(|n| n == name);
    let (t, at) = (at("t").expect("a time"), at(column).expect("the column"));
    let row = |row: &str| {
        let mut cells: Vec<_> = row.split(',').map(str::to_owned).collect();
        if cells[t].parse().is_ok_and(|time: f64| time >= from) {
            let value: f64 = cells[at].parse().expect("a number");
            cells[at] = change(value).to_string();
        }
        cells.join(",") + "\n"
    };
    let rows: String = text.lines().skip(1).map(row).collect();
    format!("{header}\n{rows}")
}

#[test]
fn loads_that_nothing_weighed_do_not_end_an_outage() {
    let folder = tempfile::tempdir().expect("a folder");
    let [out, table] = ["run", "t.csv"].map(|n| common::path_in(folder.path(), n));
    let run_it = "run excavator --scenario cycle --duration 120 --pace max --no-report --quiet";
    let out_of = ["--without", "pressure", "--out", &out];
    run_ok(&[&words(run_it)[..], &out_of].concat());
    run_ok(&["export", &out, "-o", &out]);
    let text = std::fs::read_to_string(format!("{out}/excavator_sensors.csv")).expect("a table");
    let mut first = None;
    let frozen = changed(&text, "swing_torque", 50.0, |torque| {
        *first.get_or_insert(torque)
    });
    for (text, status) in [(text, 0), (frozen, 1)] {
        std::fs::write(&table, text).expect("a table");
        let output = run(&["loads", &table, "--machine", "excavator"]);
        let said = both(&output);
        assert_eq!(output.status.code(), Some(status), "{said}");
        assert_eq!(said.contains("  nothing  "), status == 1, "{said}");
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        let named = said.contains("no load was weighed, because a sensor repeats one value");
        assert_eq!(named, status == 1, "{said}");
    }
}

#[test]
fn where_a_jump_ends_the_weighing_the_sum_says_from_when_on_and_why() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = common::path_in(folder.path(), "run");
    let run_it =
        words("run excavator --scenario cycle --duration 150 --pace max --no-report --quiet");
    run_ok(&[&run_it[..], &["--out", &out]].concat());
    run_ok(&["export", &out, "-o", &out]);
    let text = std::fs::read_to_string(format!("{out}/excavator_sensors.csv")).expect("a table");
    let [table, json, page] =
        ["t.csv", "l.json", "l.html"].map(|n| common::path_in(folder.path(), n));
    let loads = ["loads", &table, "--machine", "excavator", "--json", &json];
    let count = |text: &str| {
        std::fs::write(&table, text).expect("a table");
        let output = run(&[&loads[..], &["--report", &page]].concat());
        let value = std::fs::read_to_string(&json).expect("a summary");
        let value: Value = serde_json::from_str(&value).expect("JSON");
        (output.status.code(), both(&output), value)
    };
    let (status, said, value) = count(&text);
    assert_eq!(status, Some(0), "{said}");
    assert_eq!(value["recordings"][0]["outages"], serde_json::json!([]));
    let (status, said, value) = count(&shifted(&text, "arm_angle", 0.6, 60.0));
    assert_eq!(status, Some(1), "{said}");
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    for words in [
        "to the end",
        "no load was weighed, because a joint angle has jumped",
        "loads may be missing in the sum. What to do: check the angle sensor",
        "heft: the sum may lack loads",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let outage = &value["recordings"][0]["outages"][0];
    assert!((60.0..62.0).contains(&number(outage, "from")), "{outage}");
    assert_eq!(outage["to_the_end"], true, "{outage}");
    let page = std::fs::read_to_string(&page).expect("a page");
    assert!(page.contains("loads may be missing in the sum"), "{page}");
    // A run on it says so at its end.
    let run_it = words("run excavator --pace max --no-report --quiet --input");
    let again = common::path_in(folder.path(), "again");
    let output = run(&[&run_it[..], &[&table, "--out", &again]].concat());
    let said = both(&output);
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        said.contains("further than a joint moves: loads may be missing in the sum"),
        "{said}"
    );
    let reader = Reader::open(Path::new(&again)).expect("a recording");
    let reported: Vec<ExcavatorLoads> = reader.messages("excavator/loads").expect("loads");
    let is_out = |m: &ExcavatorLoads| m.flags & loads_bits::OUTAGE != 0;
    let first_and_last = (reported.first().map(is_out), reported.last().map(is_out));
    assert_eq!(first_and_last, (Some(false), Some(true)));
}

#[test]
fn where_lengths_are_guessed_the_loads_say_what_to_measure_and_where_they_are_stated_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let (recording, _) = recorded(folder.path(), "excavator", "cycle", &[]);
    let [five, page, report, csv, json] = ["five.toml", "l.html", "r.html", "e.csv", "e.json"]
        .map(|name| common::path_in(folder.path(), name));
    let numbers = "[machine]\nkind = \"excavator\"\noperating_mass = 5500\nrated_payload = 500\nswing_torque = 12000\n\
        [machine.geometry]\nboom_length = 3.0\narm_length = 1.6\n";
    let key = "machine.geometry.boom_pin";
    let said = [false, true].map(|is_stated| {
        let pin = if is_stated { "boom_pin = 0.6317\n" } else { "" };
        std::fs::write(&five, format!("{numbers}{pin}")).expect("a machine file");
        let with = [&recording, "--config", &five];
        let loads = run_ok(&[&["loads"], &with[..], &["--report", &page]].concat());
        let more = ["-o", &csv, "--json", &json, "--report", &report];
        let estimate = run_ok(&[&["estimate"], &with[..], &more].concat());
        let files =
            [&page, &report, &json].map(|file| std::fs::read_to_string(file).expect("a file"));
        let counted = counted(folder.path(), &recording, &["--config", &five]).to_string();
        [loads, estimate, counted]
            .into_iter()
            .chain(files)
            .map(|text| text.contains(key))
            .collect::<Vec<_>>()
    });
    assert_eq!(said, [vec![true; 6], vec![false; 6]]);
}

#[test]
fn check_names_the_stated_deviations_that_limit_the_interval_of_a_load() {
    let folder = tempfile::tempdir().expect("a folder");
    let (recording, _) = recorded(folder.path(), "loader", "loading", &[]);
    let half_width = |text: &str, after: &str| -> f64 {
        let from = text
            .split(after)
            .nth(1)
            .unwrap_or_else(|| panic!("{after}: {text}"));
        let number: String = from
            .chars()
            .take_while(|c| *c != 'k')
            .filter(char::is_ascii_digit)
            .collect();
        number.parse().expect("a half width")
    };
    let said = run_ok(&["check", &recording, "--data", &recording]);
    let (_, load) = said.split_once("Payload: ").expect("a payload");
    let now = half_width(&said, "Payload: ± ");
    let line = load
        .lines()
        .find(|line| line.contains("sensors.pressure_gain_std"));
    let line = line.unwrap_or_else(|| panic!("{said}"));
    let exact = half_width(line, "± ");
    assert!(exact < 0.9 * now, "{said}");
    // What it promises comes true.
    let set = ["--set", "sensors.pressure_gain_std=0.0003"];
    let said = run_ok(&[&["check", &recording, "--data", &recording], &set[..]].concat());
    assert!(
        (half_width(&said, "Payload: ± ") - exact).abs() < 0.02 * exact,
        "{said}"
    );
    assert!(!said.contains("pressure_gain_std"), "{said}");
}

//! `heft loads` as a user runs it, on machines that are not our simulator.

mod common;

use std::path::Path;

use common::{both, golden, path_in, run, run_ok};
use serde_json::Value;

/// What a competent user states of a machine in `golden/machines`, as arguments.
fn stated(kind: &str, name: &str) -> Vec<String> {
    let file = golden(&format!("machines/{kind}.json"));
    let text = std::fs::read_to_string(file).expect("a file");
    let all: Value = serde_json::from_str(&text).expect("JSON");
    let sets = all[name]["sets"]
        .as_object()
        .expect("settings by key")
        .clone();
    let table = golden(&format!("machines/{name}.csv"));
    let table = table.to_str().expect("a path").to_owned();
    let mut arguments = vec!["loads".to_owned(), table, "--machine".into(), kind.into()];
    arguments.extend(
        sets.iter()
            .flat_map(|(k, v)| ["--set".to_owned(), format!("{k}={v}")]),
    );
    arguments
}

fn json(file: &Path) -> Value {
    let text = std::fs::read_to_string(file).expect("a file");
    serde_json::from_str(&text).expect("JSON")
}

/// Counts the loads of a machine; the summary of its recording.
fn counted(kind: &str, name: &str, more: &[&str]) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let out = path_in(folder.path(), "loads.json");
    let mut arguments = stated(kind, name);
    arguments.extend(["--json".to_owned(), out.clone()]);
    arguments.extend(more.iter().map(|&a| a.to_owned()));
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    run_ok(&arguments);
    json(Path::new(&out))["recordings"][0].clone()
}

/// True loads of an excavator's table: the largest payload between two empty buckets.
fn true_loads(name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(golden(&format!("machines/{name}.csv"))).expect("a table");
    let mut lines = text.lines();
    let column = |header: &str| header.split(',').position(|c| c == "true_payload");
    let at = lines.next().and_then(column).expect("the truth");
    let payloads = lines.map(|l| {
        l.split(',')
            .nth(at)
            .and_then(|c| c.parse().ok())
            .expect("a number")
    });
    let (mut loads, mut most) = (Vec::new(), 0.0_f64);
    for payload in payloads {
        let payload: f64 = payload;
        most = most.max(payload);
        if payload < 0.2 * most && most > 300.0 {
            loads.push(most);
            most = 0.0;
        } else if payload < 100.0 && most < 300.0 {
            most = 0.0;
        }
    }
    loads
}

#[test]
fn every_load_of_five_unknown_excavators_is_found_and_its_interval_covers_it() {
    let (mut covered, mut all) = (0, 0);
    for name in [
        "excavator_1_13t_level",
        "excavator_2_22t_slope",
        "excavator_4_13t_losses",
        "excavator_6_36t_drop",
        "excavator_8_13t_good",
    ] {
        let truth = true_loads(name);
        let account = counted("excavator", name, &[]);
        let loads = account["loads"].as_array().expect("loads").clone();
        assert_eq!(loads.len(), truth.len(), "{name}: {account}");
        for (load, truth) in loads.iter().zip(truth) {
            let end = |key: &str| load["in_bucket"][key].as_f64().expect("a number");
            covered += usize::from(end("low") <= truth && truth <= end("high"));
            all += 1;
            assert!(load["carry_back_weighed"] == true, "{load}");
        }
    }
    assert!(all >= 15 && covered >= all - 1, "{covered} of {all}");
}

#[test]
fn a_loader_with_a_scale_has_its_loads_though_its_mass_is_described_wrong() {
    let account = counted("loader", "loader_5_12t_payload", &["--target", "8000"]);
    let loads = account["loads"].as_array().expect("loads");
    let truth = [3473.7, 2551.2, 2488.8];
    assert_eq!(loads.len(), truth.len(), "{account}");
    for (load, truth) in loads.iter().zip(truth) {
        let end = |key: &str| load["delivered"][key].as_f64().expect("a number");
        assert!(end("low") <= truth && truth <= end("high"), "{load}");
    }
    let truck = &account["trucks"][0];
    let missing = truck["remaining"].as_f64().expect("a number");
    let held = truck["total"]["kg"].as_f64().expect("a number");
    assert!((missing + held - 8000.0).abs() < 1e-6);
    assert!((held - truth.iter().sum::<f64>()).abs() < 200.0, "{truck}");
}

#[test]
fn a_table_and_a_page_are_written_and_nothing_else_is_overwritten() {
    let folder = tempfile::tempdir().expect("a folder");
    let (table, page) = (
        path_in(folder.path(), "l.csv"),
        path_in(folder.path(), "l.html"),
    );
    let mut arguments = stated("excavator", "excavator_8_13t_good");
    arguments.extend(["-o".into(), table.clone(), "--report".into(), page.clone()]);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    run_ok(&arguments);
    run_ok(&arguments);
    let text = std::fs::read_to_string(&table).expect("a table");
    assert_eq!(text.lines().count(), 4, "{text}");
    let html = std::fs::read_to_string(&page).expect("a page");
    assert!(html.contains("truck 1") && html.contains("delivered, kg"));
    std::fs::write(&table, "mine").expect("written");
    let refused = run(&arguments);
    assert_eq!(refused.status.code(), Some(2), "{}", both(&refused));
    assert_eq!(std::fs::read_to_string(&table).expect("a text"), "mine");
}

#[test]
fn a_recording_of_heft_needs_no_more_than_its_name_and_a_table_its_machine() {
    let recording = golden("recordings/excavator-cfdbb98.mcap");
    let text = run_ok(&["loads", recording.to_str().expect("a path")]);
    assert!(text.contains("excavator-cfdbb98"), "{text}");
    let table = golden("machines/excavator_8_13t_good.csv");
    let refused = run(&["loads", table.to_str().expect("a path")]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(both(&refused).contains("--machine excavator"));
}

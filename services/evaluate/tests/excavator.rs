//! The excavator's tables with few seeds. Limits on averages are those of the full evaluation; percentiles of a dozen
//! seeds scatter and are not tested here.

use evaluate::excavator::{Case, Setup};
use evaluate::{Error, Options, Report};
use serde_json::Value;
use sim::excavator::{Scenario, Sensors};

fn table(name: &str, seeds: usize) -> Report {
    let options = Options {
        table: Some(name.into()),
        seeds,
    };
    evaluate::excavator::evaluate(&options).expect("a table")
}

fn number(value: &Value, key: &str) -> f64 {
    value[key]
        .as_f64()
        .unwrap_or_else(|| panic!("a number `{key}`"))
}

fn summary(list: &Value, mode: &str, scenario: &str, payload: f64) -> Value {
    let lines = list.as_array().expect("a list");
    let line = lines.iter().find(|line| {
        line["mode"] == mode && line["scenario"] == scenario && number(line, "payload") == payload
    });
    line.expect("a line")["summary"].clone()
}

#[test]
fn table1_reproduces_the_paper_and_keeps_a_wrong_start() {
    let report = table("table1", 20);
    assert!(report.met, "{}", report.text);
    let cases = report.json["cases"].as_array().expect("cases");
    for ((case, number_), std) in cases.iter().zip(1..).zip([3.36, 3.81, 4.01]) {
        assert_eq!(case["case"], number_);
        assert!(number(case, "mean").abs() < 0.5);
        assert!((number(case, "std") - std).abs() < 0.3);
        assert!(number(case, "max") < 14.0);
    }
    for mean in report.json["wrong_start"].as_array().expect("wrong starts") {
        assert!((mean.as_f64().expect("a number") + 20.1).abs() < 0.5);
    }
    assert_eq!(cases.len(), 3);
    assert!(report.text.contains("no estimator"));
}

#[test]
fn the_modes_keep_their_averages() {
    let report = table("modes", 8);
    for payload in [0.0, 288.0, 423.0] {
        let line = |mode| summary(&report.json, mode, "base", payload);
        // Averages over 300 seeds are 0.3 below each limit or better.
        for (mode, std, max) in [
            ("D_known", 0.9, 3.0),
            ("D_auto", 1.6, 6.0),
            ("BM_known", 1.6, 6.5),
        ] {
            let line = line(mode);
            assert!(
                number(&line, "std") < std && number(&line, "max") < max,
                "{mode}: {line}"
            );
            assert!(number(&line, "coverage") > 85.0, "{mode}: {line}");
            assert_eq!(number(&line, "trusted_wrong"), 0.0, "{mode}: {line}");
        }
        let posture = line("C");
        assert!(
            number(&posture, "mean").abs() < 5.0 && number(&posture, "std") < 1.8,
            "{posture}"
        );
        let velocity = line("A");
        assert!(number(&velocity, "coverage") > 95.0, "{velocity}");
        assert_eq!(number(&velocity, "trusted"), 0.0, "{velocity}");
    }
    let constant = summary(&report.json, "A_const", "constant", 150.0);
    assert!(
        number(&constant, "max") < 7.5 && number(&constant, "coverage") > 90.0,
        "{constant}"
    );
}

#[test]
fn a_payload_that_visibly_changes_is_never_called_valid_while_it_is_wrong() {
    let report = table("drop", 8);
    for event in report.json["events"].as_array().expect("events") {
        let name = event["event"].as_str().expect("a name");
        assert_eq!(number(&event["flag"], "missed"), 0.0, "{name}");
        if name.starts_with("still") || name.starts_with("pick") {
            assert!(number(&event["flag"], "median") < 0.45, "{name}: {event}");
        } else {
            assert_eq!(number(&event["valid_wrong"], "max"), 0.0, "{name}: {event}");
            assert!(
                number(&event["during"], "coverage") > 88.0,
                "{name}: {event}"
            );
        }
    }
}

/// Without torque a dump cannot be followed: the earlier value is retained, but is no longer trusted.
#[test]
fn without_torque_an_opening_bucket_ends_the_trust() {
    for scenario in [Scenario::Drop, Scenario::DropAccelerating] {
        let case = Case::new(scenario, None);
        for seed in 1..=10 {
            let rows = case.rows(seed, Sensors::default(), &[]).expect("rows");
            let points = Setup::posture().run(&rows).expect("estimates");
            let trusted_and_wrong = |p: &&evaluate::excavator::Point| {
                p.estimate.flags.trusted() && p.truth.velocity > 0.05 && p.error().abs() > 20.0
            };
            let wrong = points.iter().filter(trusted_and_wrong).count();
            assert_eq!(wrong, 0, "{scenario:?} seed {seed}");
        }
    }
}

/// With these seeds the last part of a slow dump leaves when the bucket seems to be finished. Without protection the
/// value was valid and wrong for 0.03 to 0.11 s.
#[test]
fn the_end_of_a_slow_dump_is_not_trusted_at_once() {
    let case = Case::new(Scenario::SlowDrop, None);
    for seed in [13, 86, 138, 145, 189, 239] {
        let rows = case.rows(seed, Sensors::default(), &[]).expect("rows");
        for point in Setup::auto().run(&rows).expect("estimates") {
            let moving = point.time > 6.3 && point.truth.velocity > 0.05;
            let wrong = moving && point.error().abs() > 10.6;
            assert!(
                !(wrong && point.estimate.flags.converged),
                "seed {seed} at {:.2} s: {:.1} %",
                point.time,
                point.error()
            );
        }
    }
}

#[test]
fn bounds_and_reached_errors_belong_together() {
    let report = table("identifiability", 20);
    assert!(
        report.met,
        "the paper's regression has a null direction: {}",
        report.text
    );
    let last = |mode: &str| {
        let modes = report.json["modes"].as_array().expect("modes");
        let points = modes.iter().find(|m| m["mode"] == mode).expect("a mode")["points"].clone();
        points[7].clone()
    };
    // At 9.0 s the data determine the result: the error is 0.8 to 3 times the bound.
    for mode in ["D_known", "D_auto"] {
        let ratio = number(&last(mode), "reached") / number(&last(mode), "bound");
        assert!((0.8..3.0).contains(&ratio), "{mode}: {ratio}");
    }
    // The velocity alone adds no information about the inertia.
    assert!(number(&last("A"), "bound") > 25.0);
}

#[test]
fn bad_input_does_not_earn_trust_and_attachments_have_their_ratios() {
    let report = table("bad-input", 2);
    let lines = report.json.as_array().expect("a list");
    assert!(lines.len() > 100, "{}", lines.len());
    assert!(
        lines
            .iter()
            .all(|line| number(&line["summary"], "max").is_finite())
    );
    let asked = |line: &&Value| line["targets"].as_array().is_some_and(|t| !t.is_empty());
    let asked: Vec<_> = lines.iter().filter(asked).collect();
    assert!(asked.len() > 80, "{}", asked.len());
    for line in asked {
        let wrong = number(&line["summary"], "trusted_wrong");
        assert!(
            wrong <= 0.5,
            "{} {}: {wrong} %",
            line["input"],
            line["mode"]
        );
    }
    assert!(table("attachments", 0).met);
}

#[test]
fn an_unknown_table_is_an_error_that_lists_the_tables() {
    let options = Options {
        table: Some("table2".into()),
        ..Options::default()
    };
    let error = evaluate::excavator::evaluate(&options).expect_err("no such table");
    assert!(matches!(error, Error::UnknownTable { .. }));
    assert!(
        error
            .to_string()
            .contains("table1, modes, drop, bad-input, identifiability, attachments")
    );
}

#[test]
fn what_is_trusted_is_right_whatever_the_machine_does_beside_its_description() {
    let report = table("honesty", 4);
    println!("{}", report.text);
    let lines = report.json["lines"].as_array().expect("lines");
    let of = |effect: &'static str| {
        let mut found = lines.iter().filter(move |line| line["effect"] == effect);
        found
            .find(|line| line["what"] == "posture-torque")
            .expect("a line")
    };
    // A torque error beyond the doubt in the machine file looks like another inertia. If the doubt is stated, the interval covers it.
    let unstated = |line: &Value| {
        let far = ["+10 %", "-10 %"].iter().any(|s| line["severity"] == *s);
        far && line["effect"] == "torque gain"
    };
    let stated = lines
        .iter()
        .filter(|line| line["effect"] == "torque gain, 5 % stated");
    assert!(stated.clone().count() >= 2);
    for line in stated {
        assert!(number(line, "wrong") <= 0.05, "{line}");
    }
    // Single lines of four seeds scatter; their mean does not.
    let default = (lines.iter()).filter(|line| line["what"] == "posture-torque" && !unstated(line));
    let wrong: Vec<f64> = default.map(|line| number(line, "wrong")).collect();
    assert!(wrong.iter().sum::<f64>() / (wrong.len() as f64) < 0.02);
    for (effect, trusted) in [("none", 0.70), ("good machine", 0.50)] {
        let line = of(effect);
        assert!(number(line, "wrong") <= 0.05, "{line}");
        assert!(number(line, "trusted") >= trusted, "{line}");
        assert!(number(line, "covered") >= 0.93, "{line}");
    }
    // A method that cannot determine the inertia of such a machine never claims to do so.
    for line in lines.iter().filter(|line| line["what"] != "posture-torque") {
        assert_eq!(number(line, "trusted"), 0.0, "{line}");
    }
}

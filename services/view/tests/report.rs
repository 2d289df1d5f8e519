//! Contents of the report.

mod common;

use view::{Run, compared, report};

/// Addresses in a page, which it could load; only names of XML vocabularies are permitted.
fn addresses(html: &str) -> Vec<&str> {
    html.match_indices("http")
        .map(|(at, _)| &html[at..(at + 30).min(html.len())])
        .filter(|a| a.starts_with("http:") || a.starts_with("https:"))
        .collect()
}

fn keep(name: &str, html: &str) {
    let dir = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(dir.join(name), html).expect("the test folder can be written");
}

#[test]
fn the_report_shows_inertia_uncertainty_reasons_and_truth() {
    let html = report(&common::excavator(20.0, 100.0, true));
    keep("excavator.html", &html);
    for part in [
        "The swing inertia is",
        "heft trusts it: the machine swings",
        "The truth was",
        "stands still",
        "normal fit: mean",
        "Forgetting factors",
        "Updating rules",
        "Autocorrelation",
        "whole way",
        "nominal_damping = 1500",
        "posture-torque",
    ] {
        assert!(html.contains(part), "{part}");
    }
    assert!(
        html.contains("two swings &lt;made up&gt;"),
        "text is escaped"
    );
}

/// The end of a swing cannot be determined from a part of the samples.
#[test]
fn swings_are_separated_only_if_all_samples_are_present() {
    let mut run = common::excavator(20.0, 100.0, true);
    assert!(report(&run).contains("<h2>Each swing"));
    run.thinned.push(view::Thinned {
        channel: "excavator/inertia_ukf".into(),
        stretch: 4,
        received: 80_000,
        lost: 0,
    });
    let html = report(&run);
    assert!(!html.contains("<h2>Each swing"));
    assert!(html.contains("each swing or drive by itself, are left out"));
}

#[test]
fn the_report_separates_position_and_height() {
    let html = report(&common::loader(60.0, 100.0, true));
    keep("loader.html", &html);
    for part in [
        "behind the front axle",
        "above the ground",
        "heft trusts it: the axle torques change",
        "heft does not trust it, because",
    ] {
        assert!(html.contains(part), "{part}");
    }
}

#[test]
fn a_loader_s_payload_is_drawn_and_listed_where_its_arm_weighs_it_and_never_summed_over_drives() {
    let without = common::loader(60.0, 100.0, true);
    let mut with = without.clone();
    for estimate in with
        .parts
        .loader
        .estimators
        .iter_mut()
        .flat_map(|e| &mut e.estimates)
    {
        (estimate.payload, estimate.payload_std) = (1234.0, 20.0);
        estimate.estimated |= messages::loader_bits::PAYLOAD;
        estimate.flags =
            messages::loader_bits::TRUSTED_RATIO | messages::loader_bits::TRUSTED_HEIGHT;
    }
    let page = report(&with);
    keep("loader_payload.html", &page);
    assert!(page.contains("Payload [kg], 95 %") && page.contains("1\u{a0}234 ± 39"));
    let said = "; payload 1\u{a0}234\u{a0}±\u{a0}20\u{a0}kg, not trusted)";
    assert!(page.contains(said) && !report(&without).contains("; payload"));
    assert!(!page.contains("Payload of the trusted ones, summed"));
    assert!(!report(&without).contains("Payload [kg]"));
}

#[test]
fn without_truth_there_is_no_error_but_a_verdict() {
    let html = report(&common::excavator(10.0, 100.0, false));
    keep("no_truth.html", &html);
    assert!(
        !html.contains("normal fit") && !html.contains("The truth was") && !html.contains("NaN")
    );
    assert!(html.contains("heft trusts it"));
}

#[test]
fn the_report_loads_nothing_and_runs_no_script_but_its_own() {
    let mut hostile = common::excavator(5.0, 100.0, true);
    let name = "</script><script>alert(1)</script>";
    hostile.metadata.push(("input".into(), name.into()));
    hostile.inputs.push(view::Input {
        name: "</script><script>alert(2)</script>",
        unit: "<script>",
        points: vec![(0.0, 1.0), (1.0, 2.0)],
    });
    for run in [hostile, common::loader(5.0, 100.0, true), Run::default()] {
        // The address in the licence line of uPlot is only a comment.
        let html = report(&run).replace("/*! https://github.com/leeoniya/uPlot", "");
        assert_eq!(addresses(&html), Vec::<&str>::new());
        for loader in [
            "<link",
            "@import",
            "url(",
            "src=",
            "fetch(",
            "alert(1)</script",
        ] {
            assert!(!html.contains(loader), "{loader}");
        }
        let drawn = html.contains("data-plot");
        // One element with the numbers, and the script whose hash is in the policy.
        assert_eq!(html.matches("<script").count(), if drawn { 2 } else { 0 });
        let policy = "content=\"default-src 'none'; style-src 'unsafe-inline'; script-src '";
        let allowed = if drawn { "sha256-" } else { "none'\"" };
        assert!(html.contains(&format!("{policy}{allowed}")));
    }
}

#[test]
fn two_recordings_are_compared_with_what_differs_in_how_they_were_made() {
    let (first, mut second) = (
        common::excavator(20.0, 100.0, true),
        common::excavator(20.0, 100.0, true),
    );
    second.metadata = vec![(
        "config".into(),
        "[machine]\nnominal_damping = 1400\n".into(),
    )];
    let runs = [("morning".into(), first), ("evening <1>".into(), second)];
    let html = compared(&runs);
    keep("compared.html", &html);
    for part in [
        "What they say",
        "none to be seen",
        "minus morning",
        "evening &lt;1&gt;",
        "20.0 s",
        "<td>config: machine.nominal_damping</td><td>1500</td><td>1400</td>",
    ] {
        assert!(html.contains(part), "{part}");
    }
    let other = compared(&[
        ("a".into(), common::excavator(5.0, 100.0, false)),
        ("b".into(), common::loader(5.0, 100.0, false)),
    ]);
    assert!(other.contains("No two of them"));
}

#[test]
fn ten_minutes_at_a_kilohertz_fit_in_three_megabytes() {
    let html = report(&common::excavator(600.0, 1000.0, true));
    println!("{} bytes", html.len());
    assert!(html.len() < 3_000_000, "{} bytes", html.len());
}

#[test]
fn the_page_of_an_empty_run_states_that_it_is_empty() {
    assert!(report(&Run::default()).contains("no estimate"));
}

#[test]
fn a_recording_makes_the_same_report_as_the_run_in_memory() {
    let run = common::excavator(5.0, 100.0, true);
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report.mcap");
    let mut metadata: recording::Metadata = run.metadata.iter().cloned().collect();
    metadata.insert("processes".into(), run.processes.join(","));
    common::record(&file, &metadata, &run);
    let read = Run::from_recording(&recording::Reader::open(&file).expect("opened")).expect("read");
    assert_eq!(read.processes, run.processes);
    assert_eq!(read.parts.excavator.truth, run.parts.excavator.truth);
    let sorted = Run {
        metadata: read.metadata.clone(),
        ..run
    };
    assert_eq!(report(&read), report(&sorted));
}

#[test]
fn step_times_have_a_column_only_where_processes_reported_them() {
    let run = common::excavator(5.0, 100.0, true);
    assert!(report(&run).contains("<th>step p50 / p99</th>"));
    // As from `heft estimate`: one process, no telemetry.
    let alone = Run {
        health: Vec::new(),
        ..run
    };
    assert!(!report(&alone).contains("step p50"));
}

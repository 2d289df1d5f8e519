//! The tables of the report.

use std::fmt::Write;

use messages::{Health, Machine, State, fault};
use steps::stages::Pipeline;

use super::html::{row, table, text};
use crate::estimate::{Estimate, Parameter};
use crate::number::{grouped, nanoseconds};
use crate::panels::latency::Hop;
use crate::run::{self, Estimator, MachineRun, Run};
use crate::score::Score;

/// Share in percent, a dash if absent.
pub(super) fn percent(share: f64) -> String {
    if share.is_finite() {
        format!("{} %", grouped(100.0 * share, 1))
    } else {
        "–".into()
    }
}

/// The estimators side by side.
pub(super) fn comparison<E: Estimate>(body: &mut String, run: &Run, part: &MachineRun<E>) {
    let mut rows = String::new();
    for parameter in E::headlines() {
        for estimator in &part.estimators {
            rows.push_str(&comparison_row(run, part, estimator, parameter));
        }
    }
    let mut head = vec![
        "quantity",
        "method",
        "error, mean ± std",
        "largest error",
        "truth inside 95 %",
        "largest, trusted",
        "inside 95 %, trusted",
        "trusted",
    ];
    if is_timed(run) {
        head.push("step p50 / p99");
    }
    let _ = write!(
        body,
        "<section><h2>The estimators compared</h2>{}<p class=\"note\">Relative errors of the samples with enough motion \
         (excited), and the share of them whose 95 % interval holds the truth. A dash: no truth, or no sample of that kind.</p></section>",
        table(2, &head, &rows)
    );
}

fn comparison_row<E: Estimate>(
    run: &Run,
    part: &MachineRun<E>,
    estimator: &Estimator<E>,
    parameter: &Parameter<E, E::Truth>,
) -> String {
    let score = Score::of(part, estimator, parameter);
    let largest = |errors: &[f64]| {
        let summary = statistics::Summary::of(errors);
        summary.map_or("–".into(), |s| format!("{} %", grouped(s.max_abs, 1)))
    };
    let mean = score.summary().map_or("–".into(), |s| {
        format!("{} ± {} %", grouped(s.mean, 1), grouped(s.std, 1))
    });
    let mut cells = vec![
        parameter.label.into(),
        estimator.method().into(),
        mean,
        largest(&score.errors),
        percent(score.coverage),
        largest(&score.trusted_errors),
        percent(score.trusted_coverage),
        percent(score.trusted_share),
    ];
    if is_timed(run) {
        cells.push(step_time(run, E::MACHINE, &estimator.channel));
    }
    row(&cells)
}

/// Whether processes reported their step times; `heft estimate` has no processes.
fn is_timed(run: &Run) -> bool {
    !run.health.is_empty()
}

/// Step time of the process that publishes `channel`.
fn step_time(run: &Run, machine: Machine, channel: &str) -> String {
    let channel = messages::channels::find(channel);
    let writer = channel.and_then(|channel| Pipeline::of(machine).writer(channel));
    let of_writer =
        |h: &&Health| writer.is_some_and(|writer| run.process_name(h.process) == writer.name);
    run.health.iter().find(of_writer).map_or("–".into(), |h| {
        format!(
            "{} / {}",
            nanoseconds(h.step_p50_ns as f64),
            nanoseconds(h.step_p99_ns as f64)
        )
    })
}

/// Adds a row for each hop of `channel`.
pub(super) fn hop_rows(rows: &mut String, channel: &str, hops: &[Hop]) {
    for hop in hops {
        let at = |q| nanoseconds(hop.quantile_ns(q));
        let cells = [
            text(channel),
            hop.name.into(),
            at(0.5),
            at(0.99),
            at(0.999),
            at(1.0),
        ];
        rows.push_str(&row(&cells));
    }
}

/// Latencies by hop, and losses.
pub(super) fn latency<E: Estimate>(
    body: &mut String,
    run: &Run,
    hop_rows: &str,
    part: &MachineRun<E>,
) {
    let head = ["channel", "hop", "p50", "p99", "p99.9", "max"];
    let mut losses = String::new();
    for estimator in &part.estimators {
        let thinned = run.thinned.iter().find(|t| t.channel == estimator.channel);
        let (lost, received) = match thinned {
            Some(all) => (all.lost, all.received as f64),
            None => (
                run::lost(&estimator.estimates),
                estimator.estimates.len() as f64,
            ),
        };
        let cells = [
            text(&estimator.channel),
            grouped(received, 0),
            grouped(lost as f64, 0),
            percent(lost as f64 / (received + lost as f64)),
        ];
        losses.push_str(&row(&cells));
    }
    let loss_head = [
        "channel",
        "samples recorded",
        "lost (gaps in the sequence)",
        "share",
    ];
    let _ = write!(
        body,
        "<section>{}{}</section>",
        table(2, &head, hop_rows),
        table(1, &loss_head, &losses)
    );
}

/// The last health reports of the processes.
pub(super) fn processes(body: &mut String, run: &Run) {
    if run.health.is_empty() {
        return;
    }
    let rows: String = run.health.iter().map(|h| process_row(run, h)).collect();
    let head = [
        "process",
        "state",
        "samples",
        "late",
        "lost",
        "restarts",
        "step p50 / p99 / max",
        "age p50 / p99 / p99.9 / max",
        "real time",
        "last fault",
    ];
    let _ = write!(
        body,
        "<section><h2>Processes</h2>{}</section>",
        table(2, &head, &rows)
    );
}

fn process_row(run: &Run, h: &Health) -> String {
    let times = |ns: &[u64]| {
        let parts: Vec<_> = ns.iter().map(|&n| nanoseconds(n as f64)).collect();
        // A process without steps or samples has no times to show.
        let is_known = ns.iter().any(|&n| n > 0);
        if is_known {
            parts.join(" / ")
        } else {
            "–".into()
        }
    };
    row(&[
        text(&run.process_name(h.process)),
        state_name(h.state).into(),
        grouped(h.steps as f64, 0),
        grouped(h.late as f64, 0),
        grouped(h.lost as f64, 0),
        grouped(f64::from(h.restarts), 0),
        times(&[h.step_p50_ns, h.step_p99_ns, h.step_max_ns]),
        times(&[h.age_p50_ns, h.age_p99_ns, h.age_p999_ns, h.age_max_ns]),
        if h.realtime == 1 { "yes" } else { "no" }.into(),
        fault::text(h.fault).into(),
    ])
}

/// State of a process in a word.
pub(crate) fn state_name(state: u32) -> &'static str {
    let is = |s: State| state == s as u32;
    match () {
        () if is(State::Starting) => "starting",
        () if is(State::Running) => "running",
        () if is(State::Waiting) => "waiting",
        () if is(State::Ended) => "ended",
        () if is(State::Hanging) => "hanging",
        () => "unknown",
    }
}

/// All other metadata of the recording.
pub(super) fn configuration(body: &mut String, run: &Run) {
    if run.metadata.is_empty() {
        return;
    }
    body.push_str("<section><details><summary>Configuration</summary><dl>");
    for (name, value) in &run.metadata {
        let value = if value.contains('\n') {
            format!("<pre>{}</pre>", text(value))
        } else {
            text(value)
        };
        let _ = write!(body, "<dt>{}</dt><dd>{value}</dd>", text(name));
    }
    body.push_str("</dl></details></section>");
}

//! The top of the report: result, uncertainty, and reasons.

use std::fmt::Write;

use super::html::text;
use super::loads;
use super::part::{self, Part};
use crate::number::grouped;
use crate::posture;
use crate::run::Run;

/// Text for a recording that is damaged or truncated.
pub const NOT_WHOLE: &str = "The recording is not whole";

/// Title of the page.
pub(super) fn title(run: &Run) -> String {
    let parts = part::all(run).into_iter().filter(|part| !part.is_empty());
    let machines: Vec<_> = parts.map(|part| part.machine().name()).collect();
    if machines.is_empty() {
        return "heft report: no estimates".into();
    }
    format!("heft report: {}", machines.join(" and "))
}

pub(super) fn write(body: &mut String, run: &Run) {
    let _ = write!(body, "<header><h1>{}</h1>", text(&title(run)));
    if is_simulated(run) {
        body.push_str(
            "<p class=\"other\"><b>Simulated</b>: nothing here was measured on a machine.</p>",
        );
    }
    let line = facts(run);
    if !line.is_empty() {
        let _ = write!(body, "<p class=\"facts\">{}</p>", line.join(" · "));
    }
    if part::all(run).iter().all(|part| part.is_empty()) {
        body.push_str("<p>This run holds no estimate of a machine.</p>");
    }
    for damage in &run.damage {
        let _ = write!(
            body,
            "<p class=\"other\"><b>{NOT_WHOLE}</b>: {}; the rest was read.</p>",
            text(damage)
        );
    }
    if let Some(thinned) = run.thinned.iter().max_by_key(|t| t.stretch) {
        let _ = write!(
            body,
            "<p class=\"other\"><b>A long run</b>: plots, errors and latencies are made from a part of its {} \
             samples, of each {} the first and those with the highest and the lowest estimate. Losses are \
             counted over all. Innovations, and each swing or drive by itself, are left out; <code>heft loads</code> counts \
             loads from all samples.</p>",
            grouped(thinned.received as f64, 0),
            grouped(thinned.stretch as f64, 0),
        );
    }
    for part in part::all(run) {
        part.verdicts(body);
    }
    // Before the picture, so that they come first on a printed page.
    if let Some(account) = &run.loads {
        loads::section(body, account);
    }
    for part in part::all(run) {
        posture(body, run, part);
    }
    body.push_str("</header>");
}

/// Posture of the machine at the time of the first verdict's value.
fn posture(body: &mut String, run: &Run, part: &dyn Part) {
    let posture = |time| Some((time, posture::at(&run.inputs, time)?));
    let Some((time, posture)) = part.reported_at().and_then(posture) else {
        return;
    };
    let _ = write!(
        body,
        "<figure class=\"machine\">{}<figcaption>How it stood then, at t\u{a0}=\u{a0}{}\u{a0}s; not to scale, dashed where no angle was measured.</figcaption></figure>",
        posture::svg(part.machine(), &posture),
        grouped(time, 1)
    );
}

/// Whether the samples are simulated: older recordings show it by their scenario only.
fn is_simulated(run: &Run) -> bool {
    run.metadata("scenario").is_some() || part::all(run).iter().any(|part| part.is_simulated())
}

/// Time, place and tools of the recording, and its length, as HTML.
pub(super) fn facts(run: &Run) -> Vec<String> {
    let facts = [
        ("scenario", "scenario "),
        ("input", "input "),
        ("payload_kg", "payload [kg] "),
        ("seed", "seed "),
        ("heft.version", "heft "),
        ("wall_clock.start", "begun "),
        ("wall_clock.jumps", "wall clock jumped by "),
        ("host", "host "),
    ];
    let known = facts.iter().filter_map(|(key, words)| {
        run.metadata(key)
            .map(|value| format!("{words}{}", text(value)))
    });
    let mut line: Vec<_> = known.collect();
    line.extend(duration(run));
    line
}

/// Time from the first estimate to the last.
fn duration(run: &Run) -> Option<String> {
    let seconds = part::all(run).iter().find_map(|part| part.seconds())?;
    Some(format!("{} s long", grouped(seconds, 1)))
}

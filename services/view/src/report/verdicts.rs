//! The verdicts of a machine as cards: value, reasons, and the truth beside it.

use std::fmt::Write;

use messages::Message;

use super::html::text;
use crate::estimate::{Estimate, Parameter};
use crate::judgement::Judgement;
use crate::number::{grouped, large, significant};
use crate::run::{Estimator, MachineRun};
use crate::words::{RunJudgement, run_judgements};

/// The verdict of the primary estimator as cards, those of the others as a list.
pub(super) fn verdicts<E: Estimate>(body: &mut String, part: &MachineRun<E>) {
    let Some(primary) = part.primary() else {
        return;
    };
    for (judgement, parameter) in run_judgements(&primary.estimates)
        .iter()
        .zip(E::headlines())
    {
        card(body, part, primary, judgement, parameter);
    }
    for other in part
        .estimators
        .iter()
        .filter(|e| e.channel != primary.channel)
    {
        let name = other.method();
        let (said, first) = (sentences(other), sentences(primary));
        let said = match said == first {
            true => "the same.".to_owned(),
            false => text(&said),
        };
        let _ = write!(
            body,
            "<p class=\"other\">Another method, <b>{name}</b>: {said}</p>"
        );
    }
}

/// All sentences of an estimator.
fn sentences<E: Estimate>(estimator: &Estimator<E>) -> String {
    let judgements = run_judgements(&estimator.estimates);
    let sentences: Vec<_> = judgements.iter().map(|j| j.reported.sentence()).collect();
    sentences.join(" ")
}

fn card<E: Estimate>(
    body: &mut String,
    part: &MachineRun<E>,
    estimator: &Estimator<E>,
    judgement: &RunJudgement,
    parameter: &Parameter<E, E::Truth>,
) {
    let class = if judgement.reported.trusted {
        "trusted"
    } else {
        "doubted"
    };
    let word = if judgement.reported.trusted {
        "trusted"
    } else {
        "not trusted"
    };
    let at = grouped(judgement.time, 1);
    let _ = write!(
        body,
        "<article class=\"verdict {class}\"><p class=\"title\">{}</p>{}<p class=\"value\">{}.</p>\
         <p><span class=\"badge\">{word}</span> {}</p><p class=\"when\">{}, method <b>{}</b>, at t\u{a0}=\u{a0}{at}\u{a0}s; trusted {}\u{a0}% of the run.",
        text(parameter.label),
        headline_number(estimator, judgement, parameter),
        text(&judgement.reported.value),
        text(&explained(&judgement.reported)),
        if judgement.reported.trusted {
            "Last trusted value"
        } else {
            "Last value"
        },
        estimator.method(),
        significant(100.0 * judgement.trusted_share, 3),
    );
    if let Some(end) = &judgement.end {
        let _ = write!(body, " At the end: {}", text(&explained(end)));
    }
    if let Some(sentence) = truth_sentence(part, estimator, judgement, parameter) {
        let _ = write!(body, " {sentence}");
    }
    body.push_str(" ± is one standard deviation.</p></article>");
}

/// The reasons, with the remedy if it is not trusted.
fn explained(judgement: &Judgement) -> String {
    let text = format!("{} {}", judgement.verdict(), judgement.what_to_do());
    text.trim_end().to_owned()
}

/// The number in large print; nothing if absent.
fn headline_number<E: Estimate>(
    estimator: &Estimator<E>,
    judgement: &RunJudgement,
    parameter: &Parameter<E, E::Truth>,
) -> String {
    let Some(estimate) = estimator.estimates.get(judgement.index) else {
        return String::new();
    };
    let (value, std) = (parameter.value(estimate), parameter.std(estimate));
    if !value.is_finite() || !std.is_finite() {
        return String::new();
    }
    let (number, interval) = large(value, std, parameter.unit);
    // Faint if it is not trusted.
    let class = if judgement.reported.trusted {
        "number"
    } else {
        "number none"
    };
    format!(
        "<p class=\"{class}\">{}</p><p>95\u{a0}%: {}</p>",
        text(&number),
        text(&interval)
    )
}

/// Distance of the stated value from the truth.
fn truth_sentence<E: Estimate>(
    part: &MachineRun<E>,
    estimator: &Estimator<E>,
    judgement: &RunJudgement,
    parameter: &Parameter<E, E::Truth>,
) -> Option<String> {
    let estimate = estimator.estimates.get(judgement.index)?;
    let sequence = estimate.stamp().sequence;
    let at = part
        .truth
        .binary_search_by_key(&sequence, |t| t.stamp().sequence)
        .ok()?;
    let truth = parameter.truth(&part.truth[at]);
    let (value, std) = (parameter.value(estimate), parameter.std(estimate));
    let error = 100.0 * (value / truth - 1.0);
    let inside = if (estimation::Quantity { value, std }).holds(truth) {
        "inside"
    } else {
        "outside"
    };
    // With the digits of the large number above it.
    let (shown, _) = large(truth, std, parameter.unit);
    error.is_finite().then(|| {
        format!(
            "The truth was {shown}: the error is {}\u{a0}%, {inside} the 95\u{a0}% interval.",
            grouped(error, 1),
        )
    })
}

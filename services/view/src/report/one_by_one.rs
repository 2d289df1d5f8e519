//! A row for each swing or drive, and their sum.

use std::fmt::Write;

use estimation::HALF_WIDTH_95;

use super::html::{row, table, text};
use crate::estimate::{Estimate, Parameter};
use crate::judgement::Judgement;
use crate::number::{decimals, grouped, unit};
use crate::run::MachineRun;
use crate::stretches::{Stretch, stretches};

/// A row for each stretch of motion of the headline estimator.
pub(super) fn write<E: Estimate>(body: &mut String, part: &MachineRun<E>) {
    let Some(primary) = part.primary() else {
        return;
    };
    let (name, least) = E::MOTION_NAME;
    let found = stretches(&primary.estimates, E::motion, least);
    if found.is_empty() {
        return;
    }
    let shown: Vec<_> = E::STRETCH
        .iter()
        .filter_map(|key| parameter::<E>(key))
        // Some methods do not estimate all of them.
        .filter(|p| {
            let mut reported = found.iter().map(|s| p.value(&primary.estimates[s.index]));
            reported.any(f64::is_finite)
        })
        .collect();
    let titles: Vec<String> = shown
        .iter()
        .map(|p| format!("{}, 95 %", p.title()))
        .collect();
    let mut head = vec![name, "start", "duration"];
    head.extend(titles.iter().map(String::as_str));
    head.push("verdict");
    let mut rows = String::new();
    for (i, stretch) in found.iter().enumerate() {
        let estimate = &primary.estimates[stretch.index];
        let mut cells = vec![
            (i + 1).to_string(),
            format!("{} s", grouped(stretch.start, 1)),
            format!("{} s", grouped(stretch.duration, 1)),
        ];
        cells.extend(shown.iter().map(|p| interval(p, estimate)));
        let several = stretch.reported.len() > 1;
        let verdicts = stretch.reported.iter().zip(E::headlines()).map(|(j, p)| {
            let of = if several {
                format!("{}: ", p.label)
            } else {
                String::new()
            };
            text(&(of + &brief(j)))
        });
        cells.push(verdicts.collect::<Vec<_>>().join("<br>"));
        rows.push_str(&row(&cells));
    }
    let _ = write!(
        body,
        "<section class=\"words\"><h2>Each {name}</h2>{}<p>{}</p><p class=\"note\">By {}: the last value that heft trusted within each {name}, \
         else the last one, ± half the 95 % interval. <code>heft loads</code> counts loads and leaves out each empty {name}.</p></section>",
        table(1, &head, &rows),
        together(&primary.estimates, &found),
        primary.method()
    );
}

fn parameter<E: Estimate>(key: &str) -> Option<&'static Parameter<E, E::Truth>> {
    E::PARAMETERS.iter().find(|p| p.key == key)
}

/// "3 trusted"; "front share trusted in 3, height in 0" where the machine has several quantities with a verdict.
fn trusted_counts<E: Estimate>(found: &[Stretch]) -> String {
    let headline: Vec<_> = E::headlines().collect();
    let count = |i: usize| {
        let reported = |s: &&Stretch| s.reported.get(i).is_some_and(|j| j.trusted);
        found.iter().filter(reported).count()
    };
    if headline.len() < 2 {
        return format!("{} trusted", count(0));
    }
    let each = headline.iter().enumerate();
    let each = each.map(|(i, p)| format!("{} in {}", p.label, count(i)));
    format!("trusted: {}", each.collect::<Vec<_>>().join(", "))
}

/// Number, duration, and sum of the summable quantities.
fn together<E: Estimate>(estimates: &[E], found: &[Stretch]) -> String {
    let (name, _) = E::MOTION_NAME;
    let trusted = |stretch: &&Stretch| stretch.reported.iter().all(|judgement| judgement.trusted);
    let duration: f64 = found.iter().map(|s| s.duration).sum();
    let good: Vec<&Stretch> = found.iter().filter(trusted).collect();
    let mut out = format!(
        "Together: {} {name}{}, {} s of motion, {}.",
        found.len(),
        if found.len() == 1 { "" } else { "s" },
        grouped(duration, 1),
        trusted_counts::<E>(found)
    );
    let loads = |p: &&Parameter<E, E::Truth>| p.is_load && E::LOAD_EACH;
    for parameter in E::PARAMETERS.iter().filter(loads) {
        let at = |s: &&Stretch| estimates.get(s.index);
        let values = good.iter().filter_map(at);
        let values = values.map(|e| (parameter.value(e), parameter.std(e)));
        let known: Vec<(f64, f64)> = values
            .filter(|(value, std)| value.is_finite() && std.is_finite())
            .collect();
        if known.len() > 1 {
            out += &sum(parameter.label, parameter.unit, name, &known);
        }
    }
    out
}

/// The sum with its two intervals. Noise averages out over the stretches, while an error of the description (a nominal damping, a
/// geometry) is common to all. A standard deviation does not state the two parts, so both extremes are reported.
fn sum(label: &str, of: &str, name: &str, known: &[(f64, f64)]) -> String {
    let value: f64 = known.iter().map(|k| k.0).sum();
    let apart = HALF_WIDTH_95 * known.iter().map(|k| k.1 * k.1).sum::<f64>().sqrt();
    let alike = HALF_WIDTH_95 * known.iter().map(|k| k.1).sum::<f64>();
    let places = decimals(apart);
    format!(
        " {label} of the trusted {name}s, summed: {}\u{a0}{}; 95\u{a0}% ± {} if the errors of the {name}s are random, \
         ± {} if all {name}s share them, as with a wrong machine file.",
        grouped(value, places),
        unit(of),
        grouped(apart, places),
        grouped(alike, places),
    )
}

/// Value ± half of the 95 % interval, a dash if absent.
pub(super) fn interval<E: Estimate>(parameter: &Parameter<E, E::Truth>, estimate: &E) -> String {
    let value = parameter.value(estimate);
    let half = HALF_WIDTH_95 * parameter.std(estimate);
    if value.is_finite() && half.is_finite() {
        let decimals = decimals(half);
        format!("{} ± {}", grouped(value, decimals), grouped(half, decimals))
    } else {
        "–".into()
    }
}

/// "trusted", or the reason against it.
pub(super) fn brief(judgement: &Judgement) -> String {
    if judgement.trusted {
        "trusted".into()
    } else {
        format!("not trusted: {}", judgement.reasons.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::GROUP;

    #[test]
    fn a_sum_distinguishes_independent_and_common_errors() {
        let text = sum("Payload", "kg", "swing", &[(300.0, 10.0), (400.0, 10.0)]);
        let text = text.replace(GROUP, " ");
        // 1.96 sqrt(2) 10 and 1.96 2 10.
        assert!(text.contains("700 kg; 95 % ± 28 if"), "{text}");
        assert!(text.contains("± 39 if all swings share them"), "{text}");
    }
}

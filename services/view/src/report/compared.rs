//! Recordings of the same machine side by side: their results, and the differences in their settings.

use std::collections::BTreeMap;
use std::fmt::Write;

use estimation::HALF_WIDTH_95;

use super::html::{self, row, table, text};
use super::one_by_one::interval;
use super::{Page, header, panels, tables};
use crate::estimate::{Estimate, Parameter};
use crate::number::{decimals, grouped, unit};
use crate::plot::{Plot, Style};
use crate::run::{self, Estimator, MachineRun, Run};
use crate::stretches::stretches;
use crate::words::run_judgements;

/// The page that compares `runs`, each with its name; a machine that only one of them has is left out.
pub fn compared(runs: &[(String, Run)]) -> String {
    let mut page = Page::default();
    let names: Vec<String> = runs.iter().map(|(name, _)| text(name)).collect();
    let title = format!("heft report: {}", together(runs));
    let _ = write!(page.body, "<header><h1>{}</h1>", text(&title));
    for (name, (_, run)) in names.iter().zip(runs) {
        let facts = header::facts(run).join(" · ");
        let _ = write!(page.body, "<p class=\"facts\"><b>{name}</b>: {facts}</p>");
    }
    sections(&mut page, runs);
    differences(&mut page.body, runs);
    html::page_of_plots(&title, &page.body, &page.plots)
}

macro_rules! sections {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// The rest of the header, and the sections of each machine.
        fn sections(page: &mut Page, runs: &[(String, Run)]) {
            $( let $module = parts(runs, |run| &run.parts.$module); )*
            if [$( $module.len() ),*].iter().all(|n| *n < 2) {
                page.body
                    .push_str("<p>No two of them hold estimates of the same machine.</p>");
            }
            page.body.push_str("</header>");
            $( machine(page, &$module); )*
        }
    };
}

messages::machines!(sections);

/// "a and b".
fn together(runs: &[(String, Run)]) -> String {
    let names: Vec<&str> = runs.iter().map(|(name, _)| name.as_str()).collect();
    names.join(" and ")
}

/// A recording's name, the machine's part of it, and the headline estimator.
type Part<'a, E> = (&'a str, &'a Run, &'a MachineRun<E>, &'a Estimator<E>);

fn parts<E: Estimate>(
    runs: &[(String, Run)],
    of: impl Fn(&Run) -> &MachineRun<E>,
) -> Vec<Part<'_, E>> {
    let part = |(name, run)| {
        let part = of(run);
        Some((String::as_str(name), run, part, part.primary()?))
    };
    runs.iter().map(|(n, r)| (n, r)).filter_map(part).collect()
}

fn machine<E: Estimate>(page: &mut Page, parts: &[Part<'_, E>]) {
    if parts.len() < 2 {
        return;
    }
    verdicts(&mut page.body, parts);
    let panels = E::PARAMETERS.iter().filter_map(|p| overlay(parts, p));
    page.section(
        &format!("The {}, from the first estimate of each", E::MACHINE),
        panels.collect(),
    );
    recordings(&mut page.body, parts);
}

/// The headline quantities and those of a single swing in each recording, and their differences.
fn verdicts<E: Estimate>(body: &mut String, parts: &[Part<'_, E>]) {
    let reported = |p: &&Parameter<E, E::Truth>| p.headline() || E::STRETCH.contains(&p.key);
    let mut rows = String::new();
    for parameter in E::PARAMETERS.iter().filter(reported) {
        let values: Vec<(String, f64, f64)> = parts
            .iter()
            .map(|(_, _, _, estimator)| value(estimator, parameter))
            .collect();
        if values.iter().all(|v| !v.1.is_finite()) {
            continue;
        }
        let mut cells = vec![text(&parameter.title())];
        cells.extend(values.iter().map(|v| v.0.clone()));
        let first = &values[0];
        let apart = values[1..]
            .iter()
            .map(|v| difference(first, v, parameter.unit));
        cells.push(apart.collect::<Vec<_>>().join("<br>"));
        rows.push_str(&row(&cells));
    }
    let mut head = vec!["quantity, 95 %".to_owned()];
    let name =
        |(name, _, _, estimator): &Part<'_, E>| format!("{}: {}", text(name), estimator.method());
    head.extend(parts.iter().map(name));
    head.push(format!("minus {}", text(parts[0].0)));
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    let _ = write!(
        body,
        "<section><h2>What they say</h2>{}<p class=\"note\">The last value that heft trusted, else the last one. The \
         difference has the interval of independent errors: one of a description that both share is in both, and \
         tells nothing of the difference.</p></section>",
        table(1, &head, &rows)
    );
}

/// The last trusted value, else the last, in words, with its standard deviation.
fn value<E: Estimate>(
    estimator: &Estimator<E>,
    parameter: &Parameter<E, E::Truth>,
) -> (String, f64, f64) {
    let judgements = run_judgements(&estimator.estimates);
    let own = E::headlines()
        .zip(&judgements)
        .find(|(p, _)| p.key == parameter.key);
    // A quantity without a verdict of its own is reported at the time of the first quantity that has one.
    let judgement = own.map(|(_, j)| j).or(judgements.first());
    let Some((judgement, estimate)) =
        judgement.and_then(|j| Some((j, estimator.estimates.get(j.index)?)))
    else {
        return ("–".into(), f64::NAN, f64::NAN);
    };
    let verdict = match (own.is_some(), judgement.reported.trusted) {
        (false, _) => "",
        (true, true) => "<br>trusted",
        (true, false) => "<br>not trusted",
    };
    let words = format!("{}{verdict}", interval(parameter, estimate));
    (words, parameter.value(estimate), parameter.std(estimate))
}

fn difference(a: &(String, f64, f64), b: &(String, f64, f64), of: &str) -> String {
    let (value, half) = (
        b.1 - a.1,
        HALF_WIDTH_95 * (a.2.powi(2) + b.2.powi(2)).sqrt(),
    );
    if !value.is_finite() || !half.is_finite() {
        return "–".into();
    }
    let places = decimals(half);
    let word = if value.abs() > half {
        "they differ"
    } else {
        "none to be seen"
    };
    format!(
        "{} ± {} {}<br>{word}",
        grouped(value, places),
        grouped(half, places),
        unit(of)
    )
}

/// The quantity in each recording, over the time since its first estimate.
fn overlay<E: Estimate>(
    parts: &[Part<'_, E>],
    parameter: &Parameter<E, E::Truth>,
) -> Option<panels::Panel> {
    let mut plot = Plot::new(parameter.title(), panels::TIME).y_possible(parameter.possible);
    let mut drawn = false;
    let mut label = "95 % interval";
    for (i, (name, _, _, estimator)) in parts.iter().enumerate() {
        let start = estimator.estimates.first().map_or(0.0, |e| e.stamp().time);
        let time = |e: &E| e.stamp().time - start;
        let value = |e: &E| (time(e), parameter.value(e));
        let line: Vec<_> = estimator.estimates.iter().map(value).collect();
        if !line.iter().any(|p| p.1.is_finite()) {
            continue;
        }
        let ends = |e: &E| {
            let (value, half) = (parameter.value(e), HALF_WIDTH_95 * parameter.std(e));
            (time(e), value - half, value + half)
        };
        let band: Vec<_> = estimator.estimates.iter().map(ends).collect();
        if band.iter().any(|p| p.1.is_finite() && p.2 > p.1) {
            plot.band(std::mem::take(&mut label), Style::Series(i), &band);
        }
        plot.line(*name, Style::Series(i), &line);
        drawn = true;
    }
    drawn.then(|| panels::Panel {
        plot,
        wide: parameter.headline(),
        note: String::new(),
    })
}

/// A row for each recording: its length, its trusted share, its losses.
fn recordings<E: Estimate>(body: &mut String, parts: &[Part<'_, E>]) {
    let (name, least) = E::MOTION_NAME;
    let mut rows = String::new();
    for (recording, run, _, estimator) in parts {
        let all = &estimator.estimates;
        let seconds = match (all.first(), all.last()) {
            (Some(first), Some(last)) => last.stamp().time - first.stamp().time,
            _ => f64::NAN,
        };
        let trusted = run_judgements(all);
        let trusted = trusted.iter().map(|j| tables::percent(j.trusted_share));
        let thinned = run.thinned.iter().find(|t| t.channel == estimator.channel);
        let (received, lost) = thinned.map_or_else(
            || (all.len() as u64, run::lost(all)),
            |t| (t.received, t.lost),
        );
        rows.push_str(&row(&[
            text(recording),
            estimator.method().into(),
            format!("{} s", grouped(seconds, 1)),
            thinned.map_or_else(
                || stretches(all, E::motion, least).len().to_string(),
                |_| "–".into(),
            ),
            trusted.collect::<Vec<_>>().join(" / "),
            grouped(received as f64, 0),
            grouped(lost as f64, 0),
        ]));
    }
    let motions = format!("{name}s");
    let head = [
        "recording",
        "method",
        "duration",
        &motions,
        "trusted",
        "estimates",
        "lost",
    ];
    let _ = write!(
        body,
        "<section><h2>The recordings</h2>{}</section>",
        table(2, &head, &rows)
    );
}

/// The differing settings and circumstances.
fn differences(body: &mut String, runs: &[(String, Run)]) {
    let all: Vec<BTreeMap<String, String>> = runs.iter().map(|(_, run)| settings(run)).collect();
    let keys: std::collections::BTreeSet<&String> = all.iter().flat_map(BTreeMap::keys).collect();
    let mut rows = String::new();
    for key in keys {
        let values: Vec<Option<&String>> = all.iter().map(|settings| settings.get(key)).collect();
        if values.windows(2).all(|pair| pair[0] == pair[1]) {
            continue;
        }
        let mut cells = vec![text(key)];
        cells.extend(values.iter().map(|v| v.map_or("–".into(), |v| text(v))));
        rows.push_str(&row(&cells));
    }
    let mut head = vec!["setting"];
    let names: Vec<String> = runs.iter().map(|(name, _)| text(name)).collect();
    head.extend(names.iter().map(String::as_str));
    let _ = if rows.is_empty() {
        write!(
            body,
            "<section><h2>What differs in how they were made</h2><p>Nothing that they say of themselves.</p></section>"
        )
    } else {
        write!(
            body,
            "<section><h2>What differs in how they were made</h2>{}</section>",
            table(1, &head, &rows)
        )
    };
}

/// The metadata of a recording, a description key by key. Left out: the wall clock, which is shown elsewhere, and the run, which
/// always differs.
fn settings(run: &Run) -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    for (name, value) in &run.metadata {
        if name.starts_with("wall_clock") || name == "run" {
            continue;
        }
        if !value.contains('\n') {
            all.insert(name.clone(), value.clone());
            continue;
        }
        let mut section = "";
        for line in value.lines().map(str::trim).filter(|l| !l.starts_with('#')) {
            if let Some(table) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
                section = table;
            } else if let Some((key, value)) = line.split_once('=') {
                let key = format!("{name}: {section}.{}", key.trim());
                all.insert(key, value.trim().to_owned());
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_reported_by_key() {
        let text = "# a remark\n[machine]\nmass = 3\n\n[sensors]\nrate = 100.0\n";
        let pairs = [
            ("description", text),
            ("run", "5"),
            ("seed", "7"),
            ("wall_clock.start", "x"),
        ];
        let run = Run {
            metadata: pairs.map(|(k, v)| (k.to_owned(), v.to_owned())).to_vec(),
            ..Default::default()
        };
        let all: Vec<_> = settings(&run).into_iter().collect();
        let expected = [
            ("description: machine.mass", "3"),
            ("description: sensors.rate", "100.0"),
            ("seed", "7"),
        ];
        assert_eq!(all, expected.map(|(k, v)| (k.to_owned(), v.to_owned())));
    }

    #[test]
    fn a_difference_is_one_beyond_both_intervals() {
        let value = |v, std| (String::new(), v, std);
        assert!(difference(&value(100.0, 3.0), &value(110.0, 4.0), "kg").contains("they differ"));
        assert!(difference(&value(100.0, 3.0), &value(109.0, 4.0), "kg").contains("none"));
        assert_eq!(
            difference(&value(f64::NAN, 1.0), &value(1.0, 1.0), "kg"),
            "–"
        );
    }
}

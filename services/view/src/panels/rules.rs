//! Forgetting factors, updating rules and the conditions of the verdict over time.

use messages::{ExcavatorEstimate, LoaderEstimate, excavator_bits as x, loader_bits as l};

use super::{Panel, TIME, spans};
use crate::estimate::Estimate;
use crate::plot::{Plot, Style};
use crate::run::{Estimator, MachineRun};

/// Conditions of the excavator's verdict, the verdict last.
const EXCAVATOR: &[(&str, u32)] = &[
    ("excited", x::EXCITED),
    ("consistent", x::CONSISTENT),
    ("fresh", x::FRESH),
    ("converged", x::CONVERGED),
    ("identifiable", x::IDENTIFIABLE),
    ("trusted", x::TRUSTED),
];

/// Conditions of the loader's verdicts.
const LOADER: &[(&str, u32)] = &[
    ("consistent", l::CONSISTENT),
    ("fresh", l::FRESH),
    ("ratio excited", l::EXCITED_RATIO),
    ("ratio converged", l::CONVERGED_RATIO),
    ("ratio trusted", l::TRUSTED_RATIO),
    ("height excited", l::EXCITED_HEIGHT),
    ("height converged", l::CONVERGED_HEIGHT),
    ("height trusted", l::TRUSTED_HEIGHT),
];

/// Conditions, forgetting factors and rules of an excavator run.
#[must_use]
pub fn excavator(run: &MachineRun<ExcavatorEstimate>) -> Vec<Panel> {
    let mut panels: Vec<_> = run
        .primary()
        .map(|e| conditions(e, EXCAVATOR))
        .into_iter()
        .collect();
    for estimator in &run.estimators {
        panels.extend(forgetting(estimator));
        panels.extend(activity(estimator));
    }
    panels
}

/// Conditions of a loader run.
#[must_use]
pub fn loader(run: &MachineRun<LoaderEstimate>) -> Vec<Panel> {
    run.primary()
        .map(|e| conditions(e, LOADER))
        .into_iter()
        .collect()
}

/// A row of shaded stretches for each condition.
fn conditions<E: Estimate>(estimator: &Estimator<E>, names: &[(&str, u32)]) -> Panel {
    let title = format!("Conditions of the verdict: {}", estimator.method());
    let rows = names.len() as f64;
    let place = |i: usize| rows - 1.0 - i as f64;
    let labels = names
        .iter()
        .enumerate()
        .map(|(i, n)| (place(i), n.0.to_owned()));
    let mut plot = Plot::new(title, TIME)
        .y_range(-0.6, rows - 0.4)
        .y_names(labels.collect());
    for (i, (name, bit)) in names.iter().enumerate() {
        let style = if name.ends_with("trusted") {
            Style::Trusted
        } else {
            Style::Holds
        };
        let band = spans(
            &estimator.estimates,
            |e| e.stamp().time,
            |e| e.flags() & bit != 0,
        );
        let points: Vec<_> = band
            .iter()
            .flat_map(|s| [(s.0, 0.32), (s.1, 0.32), (s.1, f64::NAN)])
            .map(|(t, half)| (t, place(i) - half, place(i) + half))
            .collect();
        plot.band("", style, &points);
    }
    if let (Some(first), Some(last)) = (estimator.estimates.first(), estimator.estimates.last()) {
        plot = plot.x_range(first.stamp().time, last.stamp().time);
    }
    Panel::wide(
        plot,
        "A bar where the condition holds. heft trusts an estimate while all of its conditions hold.",
    )
}

/// One of the three forgetting factors.
type Factor = fn(&ExcavatorEstimate) -> f64;

fn forgetting(estimator: &Estimator<ExcavatorEstimate>) -> Option<Panel> {
    let used = |e: &ExcavatorEstimate| e.forgetting_inertia > 0.0;
    estimator.estimates.iter().any(used).then(|| {
        let title = format!("Forgetting factors [–]: {}", estimator.method());
        let mut plot = Plot::new(title, TIME).y_range(0.0, 1.05);
        let lines: [(&str, Factor); 3] = [
            ("inertia", |e| e.forgetting_inertia),
            ("damping", |e| e.forgetting_damping),
            ("torque", |e| e.forgetting_torque),
        ];
        for (i, (label, value)) in lines.into_iter().enumerate() {
            let points: Vec<_> = estimator
                .estimates
                .iter()
                .map(|e| (e.stamp.time, value(e)))
                .collect();
            if points.iter().any(|p| p.1 > 0.0) {
                plot.line(label, Style::Series(i), &points);
            }
        }
        Panel::half(plot, "")
    })
}

fn activity(estimator: &Estimator<ExcavatorEstimate>) -> Option<Panel> {
    let acts = |e: &ExcavatorEstimate| e.flags & (x::NOMINAL | x::WINDOW) != 0;
    estimator.estimates.iter().any(acts).then(|| {
        let title = format!("Updating rules: {}", estimator.method());
        let mut plot = Plot::new(title, TIME)
            .y_range(-0.1, 1.1)
            .y_names(vec![(0.0, "rests".into()), (1.0, "acts".into())]);
        let rules = [
            ("nominal damping", x::NOMINAL),
            ("change window", x::WINDOW),
        ];
        for (i, (label, bit)) in rules.into_iter().enumerate() {
            let value = |e: &ExcavatorEstimate| f64::from(u8::from(e.flags & bit != 0));
            let points: Vec<_> = estimator
                .estimates
                .iter()
                .map(|e| (e.stamp.time, value(e)))
                .collect();
            plot.line(label, Style::Series(i), &points);
        }
        Panel::half(plot, "")
    })
}

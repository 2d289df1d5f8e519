//! The conditions of the verdict over time, and a machine's own panels.

use super::{Panel, TIME, spans};
use crate::estimate::Estimate;
use crate::plot::{Plot, Style};
use crate::run::{Estimator, MachineRun};

/// The conditions of the headline estimator, and each estimator's own panels.
pub fn panels<E: Estimate>(run: &MachineRun<E>) -> Vec<Panel> {
    let own = run
        .estimators
        .iter()
        .flat_map(|e| E::own_panels(&e.estimates));
    run.primary()
        .map(conditions)
        .into_iter()
        .chain(own)
        .collect()
}

/// A row of shaded stretches for each condition.
fn conditions<E: Estimate>(estimator: &Estimator<E>) -> Panel {
    let names = E::CONDITIONS;
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

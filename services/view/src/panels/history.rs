//! Estimates over time with their 95 % band, the truth, and the trusted stretches.

use estimation::HALF_WIDTH_95;
use messages::Message;

use super::{Panel, TIME, spans};
use crate::estimate::{Estimate, Parameter};
use crate::plot::{Plot, Style};
use crate::run::{Estimator, MachineRun};

/// A panel for each parameter that some estimator estimates.
pub fn panels<E: Estimate>(run: &MachineRun<E>) -> Vec<Panel> {
    let parameters = E::PARAMETERS.iter();
    parameters.filter_map(|p| panel(run, p)).collect()
}

fn panel<E: Estimate>(run: &MachineRun<E>, parameter: &Parameter<E, E::Truth>) -> Option<Panel> {
    let estimates = |e: &&Estimator<E>| e.estimates.iter().any(|e| parameter.value(e).is_finite());
    let estimators: Vec<_> = run.estimators.iter().filter(estimates).collect();
    if estimators.is_empty() {
        return None;
    }
    let mut plot = Plot::new(parameter.title(), TIME).y_possible(parameter.possible);
    if let Some(primary) = run.primary().filter(|_| parameter.headline()) {
        let trusted = |e: &E| e.flags() & parameter.trusted != 0;
        let spans = spans(&primary.estimates, |e| e.stamp().time, trusted);
        if !spans.is_empty() {
            let label = format!("{} trusted", primary.method());
            plot.shade(label, Style::Trusted, &spans);
        }
    }
    // One band only, with its colour in the legend: two of them are indistinguishable.
    let primary = run.primary().map(|p| &p.channel);
    let first = estimators.iter().find(|e| Some(&e.channel) == primary);
    if let Some(estimator) = first.or(estimators.first()) {
        let label = format!("95 % interval of {}", estimator.method());
        add_band(&mut plot, run, estimator, parameter, &label);
    }
    add_truth(&mut plot, run, parameter);
    for estimator in &estimators {
        add_line(&mut plot, run, estimator, parameter);
    }
    let make = if parameter.headline() {
        Panel::wide
    } else {
        Panel::half
    };
    Some(make(plot, ""))
}

/// The colour of an estimator is the same in every plot.
pub(crate) fn style<E: Estimate>(run: &MachineRun<E>, estimator: &Estimator<E>) -> Style {
    let place = run
        .estimators
        .iter()
        .position(|e| e.channel == estimator.channel);
    Style::Series(place.unwrap_or(0))
}

fn add_band<E: Estimate>(
    plot: &mut Plot,
    run: &MachineRun<E>,
    estimator: &Estimator<E>,
    parameter: &Parameter<E, E::Truth>,
    label: &str,
) {
    let point = |e: &E| {
        let (value, half) = (parameter.value(e), HALF_WIDTH_95 * parameter.std(e));
        (e.stamp().time, value - half, value + half)
    };
    let points: Vec<_> = estimator.estimates.iter().map(point).collect();
    let known = points.iter().any(|p| p.1.is_finite() && p.2 > p.1);
    if known {
        plot.band(label, style(run, estimator), &points);
    }
}

fn add_truth<E: Estimate>(
    plot: &mut Plot,
    run: &MachineRun<E>,
    parameter: &Parameter<E, E::Truth>,
) {
    let point = |t: &E::Truth| (t.stamp().time, parameter.truth(t));
    let points: Vec<_> = run.truth.iter().map(point).collect();
    if points.iter().any(|p| p.1.is_finite()) {
        plot.line("truth", Style::Truth, &points);
    }
}

fn add_line<E: Estimate>(
    plot: &mut Plot,
    run: &MachineRun<E>,
    estimator: &Estimator<E>,
    parameter: &Parameter<E, E::Truth>,
) {
    let point = |e: &E| (e.stamp().time, parameter.value(e));
    let points: Vec<_> = estimator.estimates.iter().map(point).collect();
    plot.line(estimator.method(), style(run, estimator), &points);
}

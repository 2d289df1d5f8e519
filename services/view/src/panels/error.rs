//! Histograms of the relative error with their normal fit, as the papers draw them.

use super::Panel;
use super::history::style;
use crate::estimate::Estimate;
use crate::number::grouped;
use crate::plot::{Plot, Style};
use crate::run::MachineRun;
use crate::score::Score;
use statistics::{Histogram, Summary, normal_density};

const BINS: usize = 32;

/// A histogram for each estimator and headline parameter whose truth is known.
pub fn panels<E: Estimate>(run: &MachineRun<E>) -> Vec<Panel> {
    let mut panels = Vec::new();
    for parameter in E::headlines() {
        for estimator in &run.estimators {
            let score = Score::of(run, estimator, parameter);
            let title = format!("Error of {}", parameter.label.to_lowercase());
            let (label, style) = (estimator.method(), style(run, estimator));
            let plot = histogram(&title, label, &score.errors, style);
            let note = "Samples with enough motion (excited), trusted or not; bars: share of samples per 1\u{a0}% of error.";
            panels.extend(plot.map(|plot| Panel::half(plot, note)));
        }
    }
    panels
}

/// Histogram of errors in percent with the normal density of the same mean and standard deviation.
pub fn histogram(title: &str, label: &str, errors: &[f64], style: Style) -> Option<Plot> {
    let (summary, bins) = (Summary::of(errors)?, Histogram::of(errors, BINS)?);
    let mut plot = Plot::new(title, "Relative error [%]");
    plot.bars(label, style, &bins.edges, &bins.density);
    if summary.std > 0.0 {
        let fit = format!(
            "normal fit: mean {} %, std {} %",
            grouped(summary.mean, 1),
            grouped(summary.std, 1)
        );
        plot.line(fit, Style::Truth, &normal_curve(&summary));
    }
    Some(plot)
}

fn normal_curve(summary: &Summary) -> Vec<(f64, f64)> {
    let at = |i: i32| summary.mean + summary.std * f64::from(i) / 20.0;
    (-80..=80)
        .map(|i| (at(i), normal_density(at(i), summary.mean, summary.std)))
        .collect()
}

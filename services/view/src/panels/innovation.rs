//! Size and whiteness of the innovations against the filters' expectation.

use estimation::HALF_WIDTH_95;
use estimation::consistency::MOST_NIS;
use messages::SwingMotion;

use super::history::style;
use super::{Panel, TIME};
use crate::estimate::Estimate;
use crate::plot::{Plot, Style};
use crate::run::{Estimator, MachineRun};
use statistics::{autocorrelation, mean_chi_square_95, moving_mean};

/// Lags of the autocorrelation.
const LAGS: usize = 50;

/// The moving mean of the normalised innovation squared, and its autocorrelation.
pub fn panels<E: Estimate>(run: &MachineRun<E>, motion: &[SwingMotion]) -> Vec<Panel> {
    let judged: Vec<_> = run
        .estimators
        .iter()
        .filter(|e| accepted(e).len() > LAGS)
        .collect();
    let mut whiteness = Whiteness::new();
    for estimator in &judged {
        let values: Vec<_> = accepted(estimator).iter().map(|a| a.1).collect();
        whiteness.add(estimator.method(), style(run, estimator), &values);
    }
    let normalised = normalised_innovations(motion);
    whiteness.add(
        "velocity filter",
        Style::Series(run.estimators.len()),
        &normalised,
    );
    let size = (!judged.is_empty()).then(|| size_panel(run, &judged));
    size.into_iter().chain(whiteness.panel()).collect()
}

/// Time and capped NIS of the samples with an accepted measurement.
fn accepted<E: Estimate>(estimator: &Estimator<E>) -> Vec<(f64, f64)> {
    let positive = estimator.estimates.iter().filter(|e| e.nis() > 0.0);
    positive
        .map(|e| (e.stamp().time, e.nis().min(MOST_NIS)))
        .collect()
}

fn size_panel<E: Estimate>(run: &MachineRun<E>, judged: &[&Estimator<E>]) -> Panel {
    let rule = E::INNOVATION;
    let title = format!(
        "Normalised innovation squared, mean of {} samples [–]",
        rule.window
    );
    let mut plot = Plot::new(title, TIME).y_possible((0.0, f64::INFINITY));
    let (low, high) = mean_chi_square_95(rule.window as f64 * rule.measurements);
    let mut ends = (f64::INFINITY, f64::NEG_INFINITY);
    for estimator in judged {
        let rows = accepted(estimator);
        let values: Vec<_> = rows.iter().map(|r| r.1).collect();
        let means = moving_mean(&values, rule.window);
        let points: Vec<_> = rows
            .iter()
            .zip(means)
            .skip(rule.window / 2)
            .map(|(r, m)| (r.0, m))
            .collect();
        for p in &points {
            ends = (ends.0.min(p.0), ends.1.max(p.0));
        }
        plot.line(estimator.method(), style(run, estimator), &points);
    }
    if ends.0 < ends.1 {
        let band = [(ends.0, low, high), (ends.1, low, high)];
        plot.band("expected, 95 %", Style::Limit, &band);
    }
    plot.level(
        format!("verdict limit {}", rule.limit),
        Style::Limit,
        rule.limit,
    );
    let note = "Above the limit the measurements disagree with the model and heft withdraws its trust; \
                below the band the filter is more cautious than it need be.";
    Panel::half(plot, note)
}

fn normalised_innovations(motion: &[SwingMotion]) -> Vec<f64> {
    let measured = motion
        .iter()
        .filter(|m| m.innovation != 0.0 && m.innovation_std > 0.0);
    measured
        .map(|m| (m.innovation / m.innovation_std).clamp(-4.0, 4.0))
        .collect()
}

/// The autocorrelation plot under construction.
struct Whiteness {
    plot: Plot,
    fewest: usize,
}

impl Whiteness {
    fn new() -> Self {
        let plot = Plot::new("Autocorrelation of the innovations [–]", "Lag [samples]")
            .y_possible((-1.0, 1.0));
        Self {
            plot,
            fewest: usize::MAX,
        }
    }

    fn add(&mut self, label: &str, style: Style, values: &[f64]) {
        // 20 000 samples determine the correlation to 0.01 and cost a millisecond.
        let part = &values[..values.len().min(20_000)];
        if part.len() <= LAGS {
            return;
        }
        let r = autocorrelation(part, LAGS);
        if r.is_empty() {
            return;
        }
        let points: Vec<_> = r
            .iter()
            .enumerate()
            .skip(1)
            .map(|(i, r)| (i as f64, *r))
            .collect();
        self.plot.line(label, style, &points);
        self.fewest = self.fewest.min(part.len());
    }

    fn panel(mut self) -> Option<Panel> {
        if self.fewest == usize::MAX {
            return None;
        }
        let bound = HALF_WIDTH_95 / (self.fewest as f64).sqrt();
        let band = [(1.0, -bound, bound), (LAGS as f64, -bound, bound)];
        self.plot.band("white noise, 95 %", Style::Limit, &band);
        let note = "White innovations carry nothing that the filter has not used. Estimators: of \
                    the normalised innovation squared; velocity filter: of the innovation.";
        Some(Panel::half(self.plot, note))
    }
}

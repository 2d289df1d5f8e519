//! Error statistics of one run, and of many.

use super::estimators::Point;
use serde_json::{Value, json};
use statistics::{deviation, largest, mean, mean_error, median, p95, p95_error, percentage};

/// The swing begins [s].
const SWING: f64 = 5.5;
/// Error below which an estimate counts as converged [%].
const ARRIVED: f64 = 5.0;
/// Time until which it must stay below [s].
const STAYS_UNTIL: f64 = 9.1;

/// Selection of the scored samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// From this time \[s\].
    pub from: f64,
    /// To this time, included \[s\].
    pub to: f64,
    /// Least true velocity [rad/s].
    pub velocity: f64,
}

impl Window {
    /// A window with the usual limit of 0.10 rad/s.
    pub fn new(from: f64, to: f64) -> Self {
        Self {
            from,
            to,
            velocity: 0.10,
        }
    }

    /// Whether a sample is scored.
    pub fn holds(&self, point: &Point) -> bool {
        let time = (self.from - 1e-9..=self.to + 1e-9).contains(&point.time);
        time && point.truth.velocity.abs() >= self.velocity
    }
}

/// The errors of one run, in percent of the true inertia.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// Mean error.
    pub mean: f64,
    /// Its standard deviation over time.
    pub std: f64,
    /// Largest absolute error.
    pub max: f64,
    /// Share of the samples whose 95 % interval holds the truth.
    pub coverage: f64,
    /// Share of the samples that are trusted.
    pub trusted: f64,
    /// Share of the samples that are trusted and far from the truth, see [`Point::is_far`].
    pub trusted_wrong: f64,
    /// Share of the identifiable samples.
    pub identifiable: f64,
    /// Share of the samples whose 95 % interval is wider than plus or minus 10 %.
    pub wide: f64,
    /// Time after the start of the swing from which the error stays below 5 % \[s\]; none if it does not.
    pub convergence: Option<f64>,
    /// Number of samples.
    pub samples: usize,
}

impl Score {
    /// Scores the samples of a window.
    pub fn of(points: &[Point], window: Window) -> Self {
        let scored: Vec<&Point> = points.iter().filter(|point| window.holds(point)).collect();
        let errors: Vec<f64> = scored.iter().map(|point| point.error()).collect();
        let share = |holds: &dyn Fn(&Point) -> bool| percentage(scored.iter().map(|p| holds(p)));
        Self {
            mean: mean(&errors),
            std: deviation(&errors),
            max: largest(&errors),
            coverage: share(&Point::covered),
            trusted: share(&|p| p.estimate.flags.trusted()),
            trusted_wrong: share(&|p| p.estimate.flags.trusted() && p.is_far()),
            identifiable: share(&|p| p.estimate.flags.identifiable),
            wide: share(&|p| {
                estimation::HALF_WIDTH_95 * p.estimate.inertia_std > 0.1 * p.estimate.inertia
            }),
            convergence: convergence(points),
            samples: errors.len(),
        }
    }
}

fn convergence(points: &[Point]) -> Option<f64> {
    let swing = points
        .iter()
        .filter(|p| p.time >= SWING - 1e-9 && p.time <= STAYS_UNTIL + 1e-9);
    let mut arrived = None;
    for point in swing {
        if point.error().abs() >= ARRIVED {
            arrived = None;
        } else if arrived.is_none() {
            arrived = Some(point.time - SWING);
        }
    }
    arrived
}

/// The scores of many seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Average of the mean error [%].
    pub mean: f64,
    /// 95th percentile of its size [%].
    pub mean_p95: f64,
    /// Average standard deviation over time [%].
    pub std: f64,
    /// Its 95th percentile [%].
    pub std_p95: f64,
    /// Average largest error [%].
    pub max: f64,
    /// Median of the largest error [%].
    pub max_median: f64,
    /// Its 95th percentile [%].
    pub max_p95: f64,
    /// Average coverage [%].
    pub coverage: f64,
    /// Average share of trusted samples [%].
    pub trusted: f64,
    /// Average share of samples trusted and wrong [%].
    pub trusted_wrong: f64,
    /// Average share of identifiable samples [%].
    pub identifiable: f64,
    /// Average share of samples with an interval wider than 10 % [%].
    pub wide: f64,
    /// Median time to 5 % \[s\]; infinite if most seeds do not converge.
    pub convergence: f64,
    /// Its 95th percentile \[s\].
    pub convergence_p95: f64,
    /// Number of seeds.
    pub seeds: usize,
    /// Their standard errors.
    pub error: StandardErrors,
}

/// Standard errors of the numbers of a [`Summary`], from the scatter of the seeds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StandardErrors {
    /// Of the average mean error [%].
    pub mean: f64,
    /// Of the 95th percentile of its size [%].
    pub mean_p95: f64,
    /// Of the average standard deviation [%].
    pub std: f64,
    /// Of its 95th percentile [%].
    pub std_p95: f64,
    /// Of the 95th percentile of the largest error [%].
    pub max_p95: f64,
    /// Of the coverage [%].
    pub coverage: f64,
    /// Of the share of samples trusted and wrong [%].
    pub trusted_wrong: f64,
}

impl Summary {
    /// Summarises the scores of many seeds.
    pub fn of(scores: &[Score]) -> Self {
        let all = |value: fn(&Score) -> f64| scores.iter().map(value).collect::<Vec<f64>>();
        let times = all(|s| s.convergence.unwrap_or(f64::INFINITY));
        let (means, stds, maxima) = (all(|s| s.mean.abs()), all(|s| s.std), all(|s| s.max));
        Self {
            mean: mean(&all(|s| s.mean)),
            mean_p95: p95(&means),
            std: mean(&stds),
            std_p95: p95(&stds),
            max: mean(&maxima),
            max_median: median(&maxima),
            max_p95: p95(&maxima),
            coverage: mean(&all(|s| s.coverage)),
            trusted: mean(&all(|s| s.trusted)),
            trusted_wrong: mean(&all(|s| s.trusted_wrong)),
            identifiable: mean(&all(|s| s.identifiable)),
            wide: mean(&all(|s| s.wide)),
            convergence: nearest(&times, 0.5),
            convergence_p95: nearest(&times, 0.95),
            seeds: scores.len(),
            error: StandardErrors {
                mean: mean_error(&all(|s| s.mean)),
                mean_p95: p95_error(&means),
                std: mean_error(&stds),
                std_p95: p95_error(&stds),
                max_p95: p95_error(&maxima),
                coverage: mean_error(&all(|s| s.coverage)),
                trusted_wrong: mean_error(&all(|s| s.trusted_wrong)),
            },
        }
    }

    /// All numbers by name; a time that is never reached is null.
    pub fn json(&self) -> Value {
        json!({
            "mean": self.mean, "mean_p95": self.mean_p95, "std": self.std, "std_p95": self.std_p95,
            "max": self.max, "max_median": self.max_median, "max_p95": self.max_p95,
            "coverage": self.coverage, "trusted": self.trusted, "trusted_wrong": self.trusted_wrong,
            "identifiable": self.identifiable, "wide": self.wide,
            "convergence": self.convergence, "convergence_p95": self.convergence_p95,
            "seeds": self.seeds,
        })
    }
}

/// The percentile without interpolation, because infinite times cannot be averaged.
fn nearest(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let index = (share * sorted.len().saturating_sub(1) as f64).round() as usize;
    sorted.get(index).copied().unwrap_or(f64::INFINITY)
}

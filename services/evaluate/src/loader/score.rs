//! Scores of one run and of many.
//!
//! Errors are relative to the truth of the same row, in percent. Per run: the largest and the rms error over
//! the window. Over the runs: median and 95th percentile of the largest errors, root mean square of the rms
//! errors, and the mean share of rows whose 95 % interval holds the truth.

use estimation::Quantity;
use estimation::loader::Estimate;
use sim::loader::Row;

use statistics::{mean, median, p95};

use crate::text::plain;

/// Half width of a 95 % interval in standard deviations.
const INTERVAL: f64 = estimation::HALF_WIDTH_95;

/// One parameter over one run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ParameterScore {
    rows: u64,
    covered: u64,
    largest: f64,
    squares: f64,
    finite: bool,
}

impl ParameterScore {
    fn take(&mut self, truth: f64, estimate: Quantity) {
        let error = estimate.value - truth;
        let percent = 100.0 * error / truth;
        self.finite =
            (self.rows == 0 || self.finite) && percent.is_finite() && estimate.std.is_finite();
        self.rows += 1;
        self.covered += u64::from(error.abs() < INTERVAL * estimate.std);
        self.largest = self.largest.max(percent.abs());
        self.squares += percent * percent;
    }

    fn rms(&self) -> f64 {
        (self.squares / self.rows.max(1) as f64).sqrt()
    }

    fn coverage(&self) -> f64 {
        self.covered as f64 / self.rows.max(1) as f64
    }
}

/// One run of one filter.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Score {
    /// Of the ratio.
    pub ratio: ParameterScore,
    /// Of the height.
    pub height: ParameterScore,
}

impl Score {
    /// Takes a row of the window.
    pub fn take(&mut self, row: &Row, estimate: &Estimate) {
        self.ratio.take(row.truth.cg_ratio, estimate.cg_ratio);
        self.height.take(row.truth.cg_height, estimate.cg_height);
    }

    /// Whether it is not finite, or wrong by more than 50 % in the ratio or 100 % in the height.
    pub fn diverged(&self) -> bool {
        !(self.ratio.finite
            && self.height.finite
            && self.ratio.largest <= 50.0
            && self.height.largest <= 100.0)
    }
}

/// One parameter over many runs; errors in percent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errors {
    /// Median of the largest errors.
    pub median: f64,
    /// 95th percentile of the largest errors.
    pub p95: f64,
    /// Root mean square error.
    pub rms: f64,
    /// Share of rows whose 95 % interval holds the truth.
    pub coverage: f64,
}

impl Errors {
    fn of(scores: &[ParameterScore]) -> Self {
        let of =
            |value: &dyn Fn(&ParameterScore) -> f64| scores.iter().map(value).collect::<Vec<_>>();
        let largest = of(&|s| s.largest);
        Self {
            median: median(&largest),
            p95: p95(&largest),
            rms: mean(&of(&|s| s.rms().powi(2))).sqrt(),
            coverage: mean(&of(&|s| s.coverage())),
        }
    }

    /// Median and 95th percentile, as `2.9 (5.8)`.
    pub fn largest(&self) -> String {
        format!("{:.1} ({:.1})", self.median, self.p95)
    }

    pub fn json(&self) -> serde_json::Value {
        serde_json::json!({
            "max_median": self.median, "max_p95": self.p95, "rms": self.rms, "coverage": self.coverage
        })
    }
}

/// One filter over many runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Summary {
    /// Of the ratio.
    pub ratio: Errors,
    /// Of the height.
    pub height: Errors,
    /// Runs that diverged.
    pub diverged: usize,
    /// All runs.
    pub runs: usize,
}

impl Summary {
    /// Summary of filter `k` over runs that each scored several filters.
    pub fn of(runs: &[Vec<Score>], k: usize) -> Self {
        let scores: Vec<Score> = runs.iter().filter_map(|run| run.get(k).copied()).collect();
        let pick =
            |part: &dyn Fn(&Score) -> ParameterScore| scores.iter().map(part).collect::<Vec<_>>();
        Self {
            ratio: Errors::of(&pick(&|s| s.ratio)),
            height: Errors::of(&pick(&|s| s.height)),
            diverged: scores.iter().filter(|s| s.diverged()).count(),
            runs: scores.len(),
        }
    }

    /// Cells of a table: runs; largest error, rms error and coverage [%] of ratio and height; diverged runs.
    pub fn cells(&self) -> Vec<String> {
        let runs = std::iter::once(self.runs.to_string());
        runs.chain(self.quantities())
            .chain([self.diverged.to_string()])
            .collect()
    }

    /// The cells of ratio and height alone.
    pub fn quantities(&self) -> impl Iterator<Item = String> {
        let errors = |e: &Errors| [e.largest(), plain(e.rms, 2), plain(100.0 * e.coverage, 1)];
        [&self.ratio, &self.height].into_iter().flat_map(errors)
    }

    pub fn json(&self) -> serde_json::Value {
        serde_json::json!({
            "ratio": self.ratio.json(), "height": self.height.json(), "diverged": self.diverged, "runs": self.runs
        })
    }
}

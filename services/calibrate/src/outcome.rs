//! Result of a calibration of any machine: the fit, its uncertainty, and a summary for display.

use std::fmt::Write;
use std::ops::Range;

use estimation::Quantity;

use crate::fit::{Fit, GOOD, Task};
use crate::honesty::{self, Agreement, Profile, Uncertainty};
use crate::model::Model;

/// One block in this number is held out of the fit that is judged on it.
const HELD_OUT: usize = 4;

/// Remark on a fit that was stopped.
pub const STOPPED: &str = "stopped before its end: the best so far";
/// Fault of a fit without any interval.
pub const NOTHING: &str = "the recordings determine nothing";

/// Error for a key that cannot be identified.
pub fn no_such_key(key: &str, known: &[&str]) -> String {
    format!(
        "{key} cannot be found from recordings; these can: {}",
        known.join(", ")
    )
}

/// A fit with its uncertainty.
#[derive(Debug, Clone)]
pub struct FitResult {
    /// The fit.
    pub fit: Fit,
    /// Its uncertainty.
    pub uncertainty: Uncertainty,
    /// Profiles of the two weakest parameters.
    pub profiles: Vec<Profile>,
    /// Agreement on the blocks held out of a second fit: with the description, and with that fit.
    pub unseen: [Agreement; 2],
}

impl FitResult {
    /// The result of a task. `held` is the tolerance of each parameter that was not free, in prior standard
    /// deviations; `minor` are those without a profile. `None` where the data determine nothing.
    pub fn of<M: Model>(
        task: &Task<'_, M>,
        mut fit: Fit,
        held: &[f64],
        minor: &[bool],
    ) -> Option<Self> {
        let none = vec![false; task.fixed.len()];
        let everything = Task {
            fixed: &none,
            ..*task
        };
        fit.information = everything.information(&fit.place);
        let parameters = task.model.parameters();
        let uncertainty = honesty::uncertainty(&fit, parameters, task.fixed, held)?;
        let unseen = judge(task, &fit);
        let profiles = weakest(task, &fit, &uncertainty, minor);
        Some(Self {
            fit,
            uncertainty,
            profiles,
            unseen,
        })
    }
}

impl FitResult {
    /// Replaces what is known of a parameter by another value and deviation, in prior standard deviations; the other parameters follow
    /// by their correlations with it.
    pub fn learn(&mut self, i: usize, place: f64, std: f64) {
        let covariance = &mut self.uncertainty.covariance;
        let own = covariance[(i, i)];
        if own <= 0.0 {
            return;
        }
        let follows: Vec<f64> = (0..covariance.nrows())
            .map(|j| covariance[(j, i)] / own)
            .collect();
        let moved = place - self.fit.place[i];
        let gained = std * std - own;
        for (j, of_j) in follows.iter().enumerate() {
            self.fit.place[j] += of_j * moved;
            for (k, of_k) in follows.iter().enumerate() {
                covariance[(j, k)] += of_j * of_k * gained;
            }
        }
    }
}

/// Fits without one block in four, and returns the agreement on those.
fn judge<M: Model>(task: &Task<'_, M>, whole: &Fit) -> [Agreement; 2] {
    let mut counted = vec![0; task.model.blocks()];
    let is_unseen = |block: usize, counted: &mut Vec<usize>| {
        let recording = task.model.recording(block);
        counted[recording] += 1;
        (counted[recording] - 1) % HELD_OUT == HELD_OUT / 2
    };
    let (unseen, seen): (Vec<usize>, Vec<usize>) = task
        .blocks
        .iter()
        .partition(|&&block| is_unseen(block, &mut counted));
    let fit = Task {
        blocks: &seen,
        least_gain: task.least_gain.max(GOOD),
        progress: &|_| {},
        ..*task
    }
    .run(&whole.place);
    let before = vec![0.0; task.fixed.len()];
    [&before, &fit.place].map(|place| honesty::agreement(task.model, &unseen, place))
}

/// Profiles of the two parameters that the data narrow least.
fn weakest<M: Model>(
    task: &Task<'_, M>,
    fit: &Fit,
    uncertainty: &Uncertainty,
    minor: &[bool],
) -> Vec<Profile> {
    let mut order: Vec<usize> = (0..task.fixed.len())
        .filter(|&i| !task.fixed[i] && !minor[i])
        .collect();
    order.sort_by(|a, b| uncertainty.std(*b).total_cmp(&uncertainty.std(*a)));
    order
        .into_iter()
        .take(2)
        .map(|i| honesty::profile(task, fit, uncertainty, i))
        .collect()
}

/// A calibration of any machine, for display.
#[derive(Clone)]
pub struct Summary<'a> {
    /// Name of the machine, for titles.
    pub machine: &'static str,
    /// Name of a block: "swing".
    pub block: &'static str,
    /// Parameters and blocks.
    pub model: &'a dyn Model,
    /// Names of the recordings.
    pub recordings: Vec<String>,
    /// Contents of each recording, as text.
    pub contents: Vec<String>,
    /// Flag of each parameter: it was held.
    pub fixed: &'a [bool],
    /// Flag of each parameter: it belongs to a recording and not to the machine.
    pub loads: Vec<bool>,
    /// The fit, if there is one.
    pub found: Option<&'a FitResult>,
    /// Why the result is not to be trusted.
    pub faults: &'a [String],
    /// Remarks for the reader.
    pub remarks: &'a [String],
}

impl Summary<'_> {
    /// Value and standard deviation of a parameter.
    pub fn quantity(&self, i: usize) -> Option<Quantity> {
        let found = self.found?;
        let parameter = &self.model.parameters()[i];
        Some(Quantity {
            value: parameter.value(found.fit.place[i]),
            std: parameter.value_std(found.fit.place[i], found.uncertainty.std(i)),
        })
    }

    /// Value and standard deviation of the sum of linear parameters.
    pub fn sum(&self, parameters: Range<usize>) -> Option<Quantity> {
        let found = self.found?;
        let all = self.model.parameters();
        let std = |i: usize| all[i].value_std(found.fit.place[i], 1.0);
        let covariance = |i: usize, j: usize| found.uncertainty.covariance[(i, j)];
        let each = parameters.clone();
        let row = |i| -> f64 {
            let row = parameters.clone().map(|j| std(j) * covariance(i, j));
            std(i) * row.sum::<f64>()
        };
        Some(Quantity {
            value: each.clone().map(|i| all[i].value(found.fit.place[i])).sum(),
            std: each.map(row).sum::<f64>().max(0.0).sqrt(),
        })
    }

    /// The blocks of a recording.
    pub fn blocks_of(&self, recording: usize) -> Vec<usize> {
        (0..self.model.blocks())
            .filter(|&block| self.model.recording(block) == recording)
            .collect()
    }

    /// The correlations as comments of a description, which has no keys for them.
    pub fn joint(&self) -> String {
        let Some(found) = self.found else {
            return String::new();
        };
        let free: Vec<usize> = (0..self.fixed.len()).filter(|&i| !self.fixed[i]).collect();
        let mut text = format!(
            "# Correlations of the errors (standard deviations widened {:.2} times by the scatter from {} to {}):\n",
            found.uncertainty.widened, self.block, self.block
        );
        for (row, &i) in free.iter().enumerate() {
            let cells: Vec<String> = free[..row]
                .iter()
                .map(|&j| format!("{:+.2}", found.uncertainty.correlation(i, j)))
                .collect();
            let key = &self.model.parameters()[i].key;
            let _ = writeln!(text, "#   {key:<32} {}", cells.join(" "));
        }
        text
    }
}

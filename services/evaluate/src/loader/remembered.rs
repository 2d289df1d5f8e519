//! Gain of a run from the parameters of an earlier one (`heft run --state`), and its loss if they have changed since.
//!
//! The earlier run is a work cycle of the same machine and sensors. The later one accelerates and brakes hard on another road
//! with other noise. It begins cold or with the remembered parameters as its prior, on the same tyres or on others.
//!
//! JSON: `[{"tyres", "prior", "ratio", "height", "diverged", "runs", "met"}]`; `met` is null without a target.

use estimation::Quantity;
use estimation::loader::{Estimate, Prior};
use serde_json::{Value, json};
use sim::loader::{Run, Scenario, Tier};

use super::candidate::Candidate;
use super::score::{Score, Summary};
use super::trial;
use crate::text::{Table, verdict};
use crate::{Error, Options, Report, seeds};

/// Length of the earlier run [s].
const SHIFT: f64 = 100.0;
/// The night between the runs [s].
const PAUSE: f64 = 12.0 * 3600.0;
/// Distance of the seeds of a machine's days.
const DAY: u64 = 1 << 32;

/// Upper limits of the ratio's largest error, median and 95th percentile [percent], and least coverage.
const LIMITS: (f64, f64) = (3.0, 6.0);
const COVERAGE: f64 = 0.93;

/// The lines: the later run's tyres, whether it begins with remembered parameters, and whether its errors have a target.
const LINES: [(&str, bool, bool); 4] = [
    ("the same", false, false),
    ("the same", true, true),
    ("others", false, false),
    ("others", true, false),
];

pub(super) fn evaluate(options: &Options) -> Result<Report, Error> {
    let runs = seeds(options, "remembered", one)?;
    let mut table =
        Table::headed("tyres; begins; runs; ratio; rms; covered; height; rms; covered; diverged; ");
    let (mut json, mut met) = (Vec::new(), true);
    for (k, (tyres, is_restored, has_target)) in LINES.into_iter().enumerate() {
        let summary = Summary::of(&runs, k);
        let Summary { ratio, height, .. } = &summary;
        let is_exact = !has_target || (ratio.median <= LIMITS.0 && ratio.p95 <= LIMITS.1);
        let is_covered = ratio.coverage.min(height.coverage) >= COVERAGE;
        let passed = is_restored.then_some(is_exact && is_covered);
        met &= passed != Some(false);
        let begins = if is_restored { "remembered" } else { "cold" };
        let mut row = vec![tyres.to_owned(), begins.to_owned()];
        row.extend(summary.cells());
        row.push(passed.map(verdict).unwrap_or_default());
        table.row(row);
        let mut record = summary.json();
        (record["tyres"], record["prior"]) = (json!(tyres), json!(begins));
        record["met"] = json!(passed);
        json.push(record);
    }
    let text = format!(
        "Acceleration and deceleration after an earlier shift: largest error [%] in the window, median (p95) over the machines; rms error [%]; 95 % interval coverage [%]\n{table}"
    );
    Ok(Report {
        text,
        json: Value::Array(json),
        met,
    })
}

/// Scores a machine: its earlier run, then every line.
fn one(seed: u64) -> Result<Vec<Score>, Error> {
    let day = |scenario, n| Run {
        seed: seed + n * DAY,
        machine_seed: Some(seed),
        tier: Tier::B,
        ..Run::new(scenario)
    };
    let earlier = Run {
        duration: Some(SHIFT),
        ..day(Scenario::WorkCycle, 1)
    };
    let mut learnt = Learnt::default();
    trial::each_row(&earlier, &[Candidate::COLD], |_, _, estimate| {
        learnt.see(estimate);
    })?;
    let mut scores = Vec::new();
    for (tyres, is_restored, _) in LINES {
        let later = Run {
            tyres_seed: (tyres == "others").then_some(seed + DAY / 2),
            ..day(Scenario::AccelDecel, 2)
        };
        scores.extend(trial::scores_adjusted(
            &later,
            &[Candidate::COLD],
            |settings| {
                if is_restored {
                    learnt.restore(&mut settings.prior, PAUSE);
                }
            },
        )?);
    }
    Ok(scores)
}

/// What `heft run --state` stores: the latest slip stiffness since it was first trusted, and the latest trusted height and ratio of the
/// empty machine.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Learnt {
    was_trusted: bool,
    slip_stiffness: Option<Quantity>,
    cg_height: Option<Quantity>,
    cg_ratio: Option<Quantity>,
}

impl Learnt {
    pub(super) fn see(&mut self, estimate: &Estimate) {
        self.was_trusted |= estimate.trusted_ratio;
        if self.was_trusted && estimate.consistent && estimate.fresh {
            self.slip_stiffness = Some(estimate.slip_stiffness);
        }
        if estimate.trusted_ratio && estimate.of_empty {
            self.cg_ratio = Some(estimate.cg_ratio);
        }
        if estimate.trusted_height && estimate.of_empty {
            self.cg_height = Some(estimate.cg_height);
        }
    }

    /// Restores the prior as `heft run --state` does, and returns how many parameters. The later run does not gain from rolling radii and
    /// slope bias, nor from a narrower floor, nor from the covariance between them (160 machines, floors of 0.4 to 0.2 of the prior: 2.3 to
    /// 2.4 % in the median). On other tyres, a smaller deviation of the radii increases the error.
    pub(super) fn restore(&self, prior: &mut Prior, pause: f64) -> usize {
        let restored = [
            (
                self.slip_stiffness,
                &mut prior.slip_stiffness,
                &mut prior.slip_stiffness_std,
            ),
            (
                self.cg_height,
                &mut prior.cg_height,
                &mut prior.cg_height_std,
            ),
            (self.cg_ratio, &mut prior.cg_ratio, &mut prior.cg_ratio_std),
        ];
        let mut count = 0;
        for (learnt, value, std) in restored {
            let Some(Quantity {
                value: own,
                std: of,
            }) = learnt
            else {
                continue;
            };
            if config::serves([own, of], [*value, *std]).is_ok() {
                [*value, *std] = config::recalled([own, of], [*value, *std], pause);
                count += 1;
            }
        }
        count
    }
}

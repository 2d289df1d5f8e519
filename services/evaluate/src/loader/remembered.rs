//! Gain of a run from the parameters of an earlier one (`heft run --state`), and its loss if they have changed since.
//!
//! The earlier run is a work cycle of the same machine and sensors. The later one accelerates and brakes hard on another road
//! with other noise. It begins cold or with the remembered parameters as its prior, on the same tyres or on others.
//!
//! JSON: `[{"tyres", "prior", "ratio", "height", "diverged", "runs", "met"}]`; `met` is null without a target.

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
    let mut learnt = (None, None);
    trial::each_row(&earlier, &[Candidate::COLD], |_, _, estimate| {
        if estimate.trusted_ratio {
            learnt.0 = Some(*estimate);
        }
        if estimate.trusted_height {
            learnt.1 = Some(*estimate);
        }
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
                    restore(&mut settings.prior, &learnt);
                }
            },
        )?);
    }
    Ok(scores)
}

/// The latest estimates with a trusted ratio, and with a trusted height.
type Learnt = (Option<Estimate>, Option<Estimate>);

/// Restores the prior as `heft run --state` does. The later run does not gain from rolling radii and slope bias, nor from a
/// narrower floor, nor from the covariance between them (160 machines, floors of 0.4 to 0.2 of the prior: 2.3 to 2.4 % in the
/// median). On other tyres, a smaller deviation of the radii increases the error.
fn restore(prior: &mut Prior, learnt: &Learnt) {
    let widened = |std, prior| config::widened(std, prior, PAUSE);
    if let Some(e) = learnt.0 {
        (prior.slip_stiffness, prior.cg_ratio) = (e.slip_stiffness.value, e.cg_ratio.value);
        prior.slip_stiffness_std = widened(e.slip_stiffness.std, prior.slip_stiffness_std);
        prior.cg_ratio_std = widened(e.cg_ratio.std, prior.cg_ratio_std);
    }
    if let Some(e) = learnt.1 {
        prior.cg_height = e.cg_height.value;
        prior.cg_height_std = widened(e.cg_height.std, prior.cg_height_std);
    }
}

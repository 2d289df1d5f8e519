//! The targets, on a known machine (tier A) and on a real one (tier B), resolver-grade wheel speeds.
//!
//! JSON: `[{"tier", "scenario", "filter", "ratio", "height", "diverged", "runs", "met"}]`; `met` is null without a target.

use serde_json::{Value, json};
use sim::loader::{Run, Scenario, Tier};

use super::candidate::Candidate;
use super::score::{Errors, Summary};
use super::trial;
use crate::text::{Table, verdict};
use crate::{Error, Options, Report, seeds};

/// Upper limits [percent]; an infinite one is no target.
#[derive(Clone, Copy, Debug)]
struct Limits {
    median: f64,
    p95: f64,
    rms: f64,
}

const NONE: Limits = Limits {
    median: f64::INFINITY,
    p95: f64::INFINITY,
    rms: f64::INFINITY,
};

impl Limits {
    fn hold(self, errors: &Errors) -> bool {
        errors.median <= self.median && errors.p95 <= self.p95 && errors.rms <= self.rms
    }

    fn text(self) -> String {
        let parts = [
            ("median", self.median),
            ("p95", self.p95),
            ("rms", self.rms),
        ];
        let parts = parts
            .iter()
            .filter(|p| p.1.is_finite())
            .map(|p| format!("{} {}", p.0, p.1));
        parts.collect::<Vec<_>>().join(", ")
    }
}

/// One line of the table.
#[derive(Clone, Copy, Debug)]
struct Case {
    tier: Tier,
    scenario: Scenario,
    filter: Candidate,
    ratio: Limits,
    height: Limits,
    /// Least share of rows whose interval holds the truth, for both parameters.
    coverage: f64,
}

impl Case {
    const fn new(tier: Tier, scenario: Scenario, filter: Candidate) -> Self {
        Self {
            tier,
            scenario,
            filter,
            ratio: NONE,
            height: NONE,
            coverage: 0.0,
        }
    }

    const fn ratio(mut self, median: f64, p95: f64, rms: f64) -> Self {
        self.ratio = Limits { median, p95, rms };
        self
    }

    const fn height(mut self, p95: f64, rms: f64) -> Self {
        self.height = Limits { p95, rms, ..NONE };
        self
    }

    const fn covered(mut self) -> Self {
        self.coverage = 0.93;
        self
    }

    fn has_target(&self) -> bool {
        self.coverage > 0.0
            || [self.ratio, self.height]
                .iter()
                .any(|l| !l.text().is_empty())
    }

    fn holds(&self, summary: &Summary) -> bool {
        let covered = summary.ratio.coverage.min(summary.height.coverage) >= self.coverage;
        self.ratio.hold(&summary.ratio) && self.height.hold(&summary.height) && covered
    }
}

const INF: f64 = f64::INFINITY;

/// The lines; consecutive ones of the same tier and scenario share their runs.
static CASES: [Case; 29] = {
    use Scenario::{AccelDecel, Bumpy, ConstantTorque, Digging, LoadCycle, Spading, WorkCycle};
    use Tier::{A, B};
    [
        Case::new(A, Bumpy, Candidate::PRINTED),
        Case::new(A, Bumpy, Candidate::TUNED),
        Case::new(A, Bumpy, Candidate::COLD),
        Case::new(A, AccelDecel, Candidate::PRINTED),
        Case::new(A, AccelDecel, Candidate::TUNED).ratio(1.5, 3.0, INF),
        Case::new(A, AccelDecel, Candidate::COLD),
        Case::new(A, WorkCycle, Candidate::TUNED)
            .ratio(INF, 0.5, INF)
            .height(4.5, INF),
        Case::new(A, WorkCycle, Candidate::COLD),
        Case::new(B, Bumpy, Candidate::PRINTED),
        Case::new(B, Bumpy, Candidate::EKF),
        Case::new(B, Bumpy, Candidate::COLD)
            .ratio(3.2, 9.2, INF)
            .covered(),
        Case::new(B, Bumpy, Candidate::TANGENT)
            .ratio(3.2, 9.2, INF)
            .covered(),
        Case::new(B, Bumpy, Candidate::CALIBRATED),
        Case::new(B, Spading, Candidate::COLD),
        Case::new(B, Digging, Candidate::COLD),
        Case::new(B, ConstantTorque, Candidate::COLD),
        Case::new(B, AccelDecel, Candidate::PRINTED),
        Case::new(B, AccelDecel, Candidate::EKF),
        // The sampling spread of the median is 0.3 points.
        Case::new(B, AccelDecel, Candidate::COLD)
            .ratio(3.3, 6.0, INF)
            .covered(),
        Case::new(B, AccelDecel, Candidate::TANGENT)
            .ratio(3.3, 6.0, INF)
            .covered(),
        Case::new(B, AccelDecel, Candidate::CALIBRATED),
        Case::new(B, AccelDecel, Candidate::WARM),
        Case::new(A, LoadCycle, Candidate::WEIGHED),
        Case::new(B, LoadCycle, Candidate::COLD),
        Case::new(B, LoadCycle, Candidate::WEIGHED)
            .ratio(2.8, 6.6, INF)
            .covered(),
        Case::new(B, WorkCycle, Candidate::TUNED),
        Case::new(B, WorkCycle, Candidate::COLD)
            .ratio(INF, 3.5, 1.8)
            .height(11.0, 4.0)
            .covered(),
        Case::new(B, WorkCycle, Candidate::TANGENT)
            .ratio(INF, 3.5, 1.8)
            .height(11.0, 4.0)
            .covered(),
        Case::new(B, WorkCycle, Candidate::WARM),
    ]
};

/// Divisor of the number of work cycles: they take ten times as long as the other scenarios.
const FEWER_WORK_CYCLES: usize = 2;

pub(super) fn evaluate(options: &Options) -> Result<Report, Error> {
    let mut table = Table::headed(
        "tier, scenario; filter; runs; ratio; rms; covered; height; rms; covered; diverged; target; ",
    );
    let (mut json, mut met) = (Vec::new(), true);
    for group in CASES.chunk_by(|a, b| (a.tier, a.scenario) == (b.tier, b.scenario)) {
        for (case, summary) in group.iter().zip(run(options, group)?) {
            let passed = case.has_target().then(|| case.holds(&summary));
            met &= passed != Some(false);
            table.row(line(case, &summary, passed));
            json.push(record(case, &summary, passed));
        }
    }
    let text = format!(
        "Targets: largest error [%] in the window, median (p95) over the runs; rms error [%]; 95 % interval coverage [%]\n{table}"
    );
    Ok(Report {
        text,
        json: Value::Array(json),
        met,
    })
}

fn run(options: &Options, group: &[Case]) -> Result<Vec<Summary>, Error> {
    let Case { tier, scenario, .. } = group[0];
    let filters: Vec<Candidate> = group.iter().map(|case| case.filter).collect();
    let long = scenario == Scenario::WorkCycle;
    let options = if long {
        options.one_of(FEWER_WORK_CYCLES)
    } else {
        options.clone()
    };
    let label = format!("tier {tier:?}, {}", scenario.name());
    let runs = seeds(&options, &label, |seed| {
        trial::scores(
            &Run {
                seed,
                tier,
                ..Run::new(scenario)
            },
            &filters,
        )
    })?;
    Ok((0..filters.len()).map(|k| Summary::of(&runs, k)).collect())
}

fn line(case: &Case, summary: &Summary, passed: Option<bool>) -> Vec<String> {
    let limits = [("ratio", case.ratio.text()), ("height", case.height.text())];
    let mut target: Vec<String> = limits
        .iter()
        .filter(|l| !l.1.is_empty())
        .map(|l| format!("{} {}", l.0, l.1))
        .collect();
    if case.coverage > 0.0 {
        target.push(format!("covered {:.0}", 100.0 * case.coverage));
    }
    let mut row = vec![
        format!("{:?} {}", case.tier, case.scenario.name()),
        case.filter.name.to_owned(),
    ];
    row.extend(summary.cells());
    row.push(target.join("; "));
    row.push(passed.map(verdict).unwrap_or_default());
    row
}

fn record(case: &Case, summary: &Summary, passed: Option<bool>) -> Value {
    let mut record = summary.json();
    record["tier"] = json!(format!("{:?}", case.tier));
    record["scenario"] = json!(case.scenario.name());
    record["filter"] = json!(case.filter.name);
    record["met"] = json!(passed);
    record
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_a_real_machine_the_full_filter_holds_where_the_paper_filters_diverge() {
        let options = Options {
            seeds: 6,
            ..Options::default()
        };
        let of = |filter| Case::new(Tier::B, Scenario::AccelDecel, filter);
        let group = [
            of(Candidate::PRINTED),
            of(Candidate::EKF),
            of(Candidate::COLD),
        ];
        let [printed, ekf, full] = run(&options, &group).unwrap().try_into().unwrap();
        assert!(
            printed.diverged >= 3 && ekf.diverged >= 3,
            "{printed:?} {ekf:?}"
        );
        // The target's median is 3 % over 200 runs; six machines spread by some 2 %.
        assert!(full.diverged == 0 && full.ratio.median < 5.0, "{full:?}");
    }

    #[test]
    fn a_weighed_payload_keeps_the_ratio() {
        let options = Options {
            seeds: 3,
            ..Options::default()
        };
        let group = [Case::new(Tier::A, Scenario::LoadCycle, Candidate::WEIGHED)];
        let full = run(&options, &group).unwrap()[0];
        // 0.92 (2.7) % in the reference; a payload 5 % too heavy alone is 1.4 %.
        assert!(full.diverged == 0 && full.ratio.p95 < 4.0, "{full:?}");
    }

    #[test]
    fn after_a_pick_up_on_a_real_machine_the_interval_of_the_height_holds() {
        let options = Options {
            seeds: 6,
            ..Options::default()
        };
        let group = [Case::new(Tier::B, Scenario::LoadCycle, Candidate::WEIGHED)];
        let full = run(&options, &group).unwrap()[0];
        // Radii held fixed while the load shifts: 29 % covered, 40 % rms. Otherwise 97 % and 8 % over 100 runs; one machine in
        // six may leave its interval.
        assert!(
            full.height.coverage > 0.8 && full.height.rms < 16.0,
            "{full:?}"
        );
    }
}

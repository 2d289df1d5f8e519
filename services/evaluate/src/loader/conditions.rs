//! The paper's conditions: ISR-UKF as printed and made consistent, and EKF, next to the published errors.
//!
//! JSON: `[{"grade", "scenario", "filters": {NAME: {"ratio", "height", "diverged", "runs"}}, "published"}]` with
//! `max_median`, `max_p95`, `rms` (percent) and `coverage` per parameter; `published` is the largest error
//! of ratio and height [percent] or null.

use std::fmt::Write;

use serde_json::{Value, json};
use sim::loader::{Grade, Run, Scenario};

use super::candidate::Candidate;
use super::score::Summary;
use super::trial;
use crate::text::Table;
use crate::{Error, Options, Report, seeds};

const FILTERS: [Candidate; 3] = [Candidate::PRINTED, Candidate::JOINT, Candidate::EKF];
const GRADES: [Grade; 3] = [Grade::Hall, Grade::Nominal, Grade::Resolver];
const SCENARIOS: [Scenario; 5] = [
    Scenario::Bumpy,
    Scenario::Spading,
    Scenario::Digging,
    Scenario::ConstantTorque,
    Scenario::AccelDecel,
];

/// EKF and consistent ISR-UKF count as indistinguishable within this many percent of error, or this share of it.
const SAME: (f64, f64) = (0.5, 0.15);
/// The published 10.2 % on a bumpy road are reproduced in size if the median lies in this range [percent].
const PUBLISHED_SIZE: std::ops::Range<f64> = 6.0..15.0;

const READING: &str = "\
  With Hall-grade wheel speeds the published size of the ratio's error comes out; where wheel speeds are
  better, so is a consistent filter, and the printed one gets worse: its gain leaves the process noise out.
  In runs of 10 to 30 s the height's error is the error of the initial guess (10 % here): an error of 4 %
  says how good the guess was. The consistent ISR-UKF and the EKF of the same model cannot be distinguished,
  and the EKF does not diverge over time on a known machine. On a real one (table tiers) both fail.
";

/// Largest errors in the stabilisation phase that the paper publishes, ratio and height [percent].
fn published(scenario: Scenario) -> Option<[f64; 2]> {
    match scenario {
        Scenario::Bumpy => Some([10.2, 4.2]),
        Scenario::ConstantTorque => Some([6.0, 4.6]),
        _ => None,
    }
}

pub(super) fn evaluate(options: &Options) -> Result<Report, Error> {
    let mut text = format!(
        "Conditions of the paper: largest error [%] in the stabilisation phase, median (p95) of {} runs, known machine\n",
        options.seeds
    );
    let (mut json, mut met) = (Vec::new(), true);
    for grade in GRADES {
        let [mut ratio, mut height] = ["ratio", "height"].map(|what| {
            let names = FILTERS.iter().map(|filter| filter.name);
            let header = [what, "published"].into_iter().chain(names);
            Table::new(&header.collect::<Vec<_>>())
        });
        for scenario in SCENARIOS {
            let summaries = run(options, grade, scenario)?;
            let figure =
                |k: usize| published(scenario).map_or("-".to_owned(), |p| format!("{:.1}", p[k]));
            let cells = |figure: String, of: &dyn Fn(&Summary) -> String| {
                [
                    vec![scenario.name().to_owned(), figure],
                    summaries.iter().map(of).collect(),
                ]
                .concat()
            };
            ratio.row(cells(figure(0), &|s| s.ratio.largest()));
            height.row(cells(figure(1), &|s| s.height.largest()));
            met &= holds(grade, scenario, &summaries);
            json.push(record(grade, scenario, &summaries));
        }
        let _ = write!(text, "\n{} sensors\n{ratio}\n{height}", grade.name());
    }
    text += READING;
    Ok(Report {
        text,
        json: Value::Array(json),
        met,
    })
}

fn run(options: &Options, grade: Grade, scenario: Scenario) -> Result<[Summary; 3], Error> {
    let label = format!("{} {}", grade.name(), scenario.name());
    let runs = seeds(options, &label, |seed| {
        trial::scores(
            &Run {
                seed,
                grade,
                ..Run::new(scenario)
            },
            &FILTERS,
        )
    })?;
    Ok(std::array::from_fn(|k| Summary::of(&runs, k)))
}

/// Whether the results support the claims of [`READING`].
fn holds(grade: Grade, scenario: Scenario, [printed, joint, ekf]: &[Summary; 3]) -> bool {
    let same = |a: f64, b: f64| (a - b).abs() <= SAME.0.max(SAME.1 * b);
    let reproduced = grade != Grade::Hall
        || scenario != Scenario::Bumpy
        || PUBLISHED_SIZE.contains(&printed.ratio.median);
    reproduced
        && same(joint.ratio.median, ekf.ratio.median)
        && same(joint.height.median, ekf.height.median)
}

fn record(grade: Grade, scenario: Scenario, summaries: &[Summary; 3]) -> Value {
    let filters: serde_json::Map<String, Value> = FILTERS
        .iter()
        .zip(summaries)
        .map(|(filter, s)| (filter.name.to_owned(), s.json()))
        .collect();
    json!({
        "grade": grade.name(), "scenario": scenario.name(), "filters": filters, "published": published(scenario)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_size_comes_out_with_hall_sensors_and_the_ekf_is_no_worse() {
        let options = Options {
            seeds: 6,
            ..Options::default()
        };
        let summaries = run(&options, Grade::Hall, Scenario::Bumpy).unwrap();
        assert!(
            holds(Grade::Hall, Scenario::Bumpy, &summaries),
            "{summaries:?}"
        );
    }

    #[test]
    fn with_good_wheel_speeds_the_consistent_form_beats_the_printed_one() {
        let options = Options {
            seeds: 4,
            ..Options::default()
        };
        let [printed, joint, ekf] = run(&options, Grade::Resolver, Scenario::AccelDecel).unwrap();
        // 7.4 and 1.7 % in the reference; four runs leave a spread of some 1 %.
        assert!(
            printed.ratio.median > 2.0 * joint.ratio.median,
            "{printed:?} {joint:?}"
        );
        assert!(
            joint.ratio.median < 3.5
                && holds(
                    Grade::Resolver,
                    Scenario::AccelDecel,
                    &[printed, joint, ekf]
                )
        );
        // The height is the initial guess: 0.10 m of 0.90 m, equally good in any consistent form.
        assert!(joint.height.rms > 3.0, "{joint:?}");
    }
}

//! Table 1 of the paper, reproduced.
//!
//! JSON, in percent of the true inertia, averaged over the seeds:
//! `{"cases":[{"case":1,"mean":..,"std":..,"max":..},..],"wrong_start":[..]}`; `wrong_start` is the mean error
//! per case when the initial inertia is 0.8 of the true one.

use super::case::{Case, three};
use super::estimators::{self, Point, Setup};
use super::score::{Score, Summary, Window};
use crate::text::{Table, plain, signed, verdict};
use crate::{Error, Options, Report, seeds};
use serde_json::json;
use sim::excavator::Scenario;
use statistics::{deviation, largest, mean};

/// Mean and standard deviation printed in the paper [%].
const PAPER: [(f64, f64); 3] = [(-1.70, 4.51), (0.13, 4.99), (-0.49, 4.00)];
/// Our standard deviations as specified [%], and the tolerances of standard deviation and mean.
const EXPECTED_STD: [f64; 3] = [3.36, 3.81, 4.01];
const STD_TOLERANCE: f64 = 0.3;
const MEAN_TOLERANCE: f64 = 0.5;
/// Error at the end for a start at 0.8 of the truth [%].
const WRONG_START: f64 = 0.8;
const WRONG_MEAN: f64 = -20.1;
/// The scored part of the swing: all of it, at any velocity.
const WINDOW: Window = Window {
    from: 5.5,
    to: 9.3,
    velocity: 0.0,
};

struct Row {
    ours: Summary,
    wrong: Summary,
    held: (f64, f64, f64),
    met: bool,
}

/// Evaluates the table.
pub fn evaluate(options: &Options) -> Result<Report, Error> {
    let cases = three(Scenario::Paper);
    let mut rows = Vec::new();
    for (number, case) in cases.iter().enumerate() {
        rows.push(row(options, number, case)?);
    }
    let json = json!({
        "cases": rows.iter().enumerate().map(|(i, row)| json!({
            "case": i + 1, "mean": row.ours.mean, "std": row.ours.std, "max": row.ours.max,
        })).collect::<Vec<_>>(),
        "wrong_start": rows.iter().map(|row| row.wrong.mean).collect::<Vec<_>>(),
    });
    Ok(Report {
        text: text(&rows),
        json,
        met: rows.iter().all(|row| row.met),
    })
}

fn row(options: &Options, number: usize, case: &Case) -> Result<Row, Error> {
    let start = case.truth(WINDOW.from).inertia;
    let score = |share: f64| {
        let setup = Setup::paper(share * start);
        let label = format!("table 1, case {}, start at {share} J", number + 1);
        let scores = seeds(options, &label, |seed| {
            Ok(Score::of(&estimators::series(case, &setup, seed)?, WINDOW))
        })?;
        Ok(Summary::of(&scores))
    };
    let (ours, wrong) = (score(1.0)?, score(WRONG_START)?);
    let met = ours.mean.abs() <= MEAN_TOLERANCE
        && (ours.std - EXPECTED_STD[number]).abs() <= STD_TOLERANCE
        && (wrong.mean - WRONG_MEAN).abs() <= MEAN_TOLERANCE;
    Ok(Row {
        ours,
        wrong,
        held: held(case, start),
        met,
    })
}

/// Mean, deviation and largest error of a constant estimate: the inertia at the start.
fn held(case: &Case, start: f64) -> (f64, f64, f64) {
    let swing = case
        .exact()
        .iter()
        .filter(|s| (WINDOW.from - 1e-9..=WINDOW.to + 1e-9).contains(&s.time));
    let errors: Vec<f64> = swing
        .map(|s| 100.0 * (start / s.truth.inertia - 1.0))
        .collect();
    (mean(&errors), deviation(&errors), largest(&errors))
}

fn text(rows: &[Row]) -> String {
    let mut table = Table::headed(
        "case; paper mean; std; ours mean; std; max; no estimator mean; std; max; ours, start -20 %: mean; std; target",
    );
    for (i, row) in rows.iter().enumerate() {
        let (ours, wrong, held) = (&row.ours, &row.wrong, row.held);
        table.row([
            (i + 1).to_string(),
            signed(PAPER[i].0, 2),
            plain(PAPER[i].1, 2),
            signed(ours.mean, 2),
            plain(ours.std, 2),
            plain(ours.max, 1),
            signed(held.0, 2),
            plain(held.1, 2),
            plain(held.2, 1),
            signed(wrong.mean, 2),
            plain(wrong.std, 2),
            verdict(row.met),
        ]);
    }
    let seeds = rows.first().map_or(0, |row| row.ours.seeds);
    format!(
        "Table 1 of Oh, Yi, Seo, Kim, Lee 2017: error of the swing inertia in percent, {seeds} seeds\n\
         (arm extended late, the paper's equation of motion, 5.5-9.3 s, start at the true inertia)\n\n\
         {table}\n{READING}"
    )
}

const READING: &str = "\
How to read it. The paper's figures come out, but only when the estimator starts at the true inertia, and on a
path on which the inertia changes by about 10 %. \"No estimator\" answers with the inertia at 5.5 s throughout: its
spread is as small as the paper's, its mean some 5-6 % off. The regression of the paper is homogeneous (its output
is zero): doubling all its parameters satisfies it as well, so velocity and acceleration determine only the ratios
of inertia, damping and torque. Pinning the damping to its nominal value hardly reaches the inertia, which is
practically held at its initial value: started 20 % too low it stays 20 % too low, and nothing in the data objects.
";

/// The estimates of the paper's configuration for one case and seed: Figs. 11-19.
pub fn series(payload: f64, seed: u64) -> Result<Vec<Point>, Error> {
    let case = Case::new(Scenario::Paper, Some(payload));
    estimators::series(&case, &Setup::paper(case.truth(WINDOW.from).inertia), seed)
}

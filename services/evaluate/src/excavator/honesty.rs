//! Share of wrong values among the trusted: machines of four sizes at work, with ordinary physical effects that no description
//! contains, one at a time and all together.
//!
//! JSON: [`crate::honesty::json`]. The machines are uncalibrated: the estimators receive the data sheet and the default of
//! everything else ([`estimation::excavator::Doubts`]). A machine file without further statements means the same.

use super::estimators::Setup;
use super::honesty_lines::{EFFECT, Requirement, USUAL, described, effects};
use crate::honesty::{JudgedRow, Line, Tally, json, text};
use crate::{Error, Options, Report, seeds};
use estimation::excavator::{Estimate, Method, Settings};
use sim::excavator::{Effects, Row, Size, Work};

/// Length of a record: 40 s at 100 Hz.
const ROWS: usize = 4000;
/// True velocity above which the machine moves [rad/s].
const MOVING: f64 = 0.05;

/// The judged methods, by their names in the tables.
const METHODS: [(&str, Method, bool); 6] = [
    ("posture-torque", Method::PostureTorque, false),
    ("torque", Method::Torque, false),
    ("posture", Method::Posture, false),
    ("velocity", Method::Velocity, false),
    ("svf-rls", Method::SvfRls, false),
    ("svf-rls joint", Method::SvfRls, true),
];

/// Standard deviation of the torque gain in the lines where the machine file states it.
const STATED_GAIN_STD: f64 = 0.05;
const STATED: [(&str, f64); 2] = [("+10 %", 1.10), ("-10 %", 0.90)];

/// A line: its effects, or random ones for each seed, and the stated deviation of the torque gain.
struct Case {
    effect: &'static str,
    severity: &'static str,
    effects: Option<Effects>,
    gain_std: Option<f64>,
    asked: Requirement,
}

fn cases() -> Vec<Case> {
    let case = |effect, severity, effects, asked| Case {
        effect,
        severity,
        effects,
        gain_std: None,
        asked,
    };
    let stated = STATED.map(|(severity, torque_gain)| Case {
        gain_std: Some(STATED_GAIN_STD),
        ..case(
            "torque gain, 5 % stated",
            severity,
            Some(Effects {
                torque_gain,
                ..Effects::default()
            }),
            EFFECT,
        )
    });
    let mut cases: Vec<Case> = effects()
        .map(|(effect, severity, effects, asked)| case(effect, severity, Some(effects), asked))
        .collect();
    let after = cases.iter().rposition(|case| case.effect == "torque gain");
    let at = after.map_or(cases.len(), |i| i + 1);
    cases.splice(at..at, stated);
    // Machines with random effects, unlike those of the list.
    cases.push(case("by chance", "", None, USUAL));
    cases
}

fn tally(
    work: &Work,
    rows: &[Row],
    method: (&'static str, Method, bool),
    gain_std: Option<f64>,
) -> Result<Tally, Error> {
    let (name, method, joint) = method;
    let mut settings = Settings::of(&described(work));
    if let (Some(std), Some(doubts)) = (gain_std, &mut settings.doubts) {
        doubts.gain_std = std;
        settings.sensors.swing_torque_gain_std = std;
    }
    settings.estimator.estimate_damping = joint;
    settings.estimator.estimate_friction = joint;
    let mut tally = Tally::default();
    for point in Setup::working(name, method, settings).run(rows)? {
        tally.push(&JudgedRow {
            truth: point.truth.inertia,
            estimate: point.estimate.inertia,
            std: point.estimate.inertia_std,
            trusted: point.estimate.flags.trusted(),
            moving: point.truth.velocity.abs() > MOVING,
            reason: reason(&point.estimate),
        });
    }
    Ok(tally)
}

fn reason(estimate: &Estimate) -> &'static str {
    estimate.reason.name()
}

/// Every effect at every severity, every method; the sizes alternate with the seeds.
pub(super) fn evaluate(options: &Options) -> Result<Report, Error> {
    let sizes = [Size::t13(), Size::t22(), Size::t36(), Size::reference()];
    let mut lines = Vec::new();
    for case in cases() {
        let (effect, severity, asked) = (case.effect, case.severity, case.asked);
        let found = seeds(options, &format!("{effect} {severity}"), |seed| {
            let size = sizes[(seed as usize - 1) % sizes.len()];
            let effects = case.effects.unwrap_or_else(|| Effects::by_chance(seed));
            let work = Work::new(size, effects, seed);
            let rows: Vec<Row> = work.clone().take(ROWS).collect();
            METHODS
                .iter()
                .map(|&method| tally(&work, &rows, method, case.gain_std))
                .collect::<Result<Vec<_>, _>>()
        })?;
        for (i, (name, method, _)) in METHODS.iter().enumerate() {
            let mut sum = Tally::default();
            found.iter().for_each(|seed| sum.add(&seed[i]));
            let mut line = Line::new(effect, severity, name, sum);
            line.allowed = asked.wrong;
            if *method == Method::PostureTorque {
                line.least_trusted = asked.trusted;
                line.least_covered = asked.covered;
            }
            lines.push(line);
        }
    }
    Ok(Report {
        text: format!(
            "Excavators at work that are not what their description says, {} seeds of 40 s\n{}",
            options.seeds,
            text(&lines)
        ),
        json: json(&lines),
        met: lines.iter().all(Line::met),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use statistics::judge::is_covered;

    /// Shares of rows whose intervals of damping and torque hold the truth.
    fn covered(case: &Case) -> [f64; 2] {
        let effects = case.effects.unwrap_or_else(|| Effects::by_chance(2));
        let work = Work::new(Size::t22(), effects, 2);
        let rows: Vec<Row> = work.clone().take(ROWS).collect();
        let (name, method, _) = METHODS[0];
        let setup = Setup::working(name, method, Settings::of(&described(&work)));
        let points = setup.run(&rows).unwrap();
        let mut counts = [[0; 2]; 2];
        for point in &points {
            let (e, truth) = (&point.estimate, &point.truth);
            let both = [(e.damping, truth.damping), (e.torque, truth.torque)];
            for (count, (quantity, truth)) in counts.iter_mut().zip(both) {
                if let Some(quantity) = quantity {
                    count[0] += 1;
                    count[1] += i32::from(is_covered(quantity.value, quantity.std, truth));
                }
            }
        }
        counts.map(|[rows, covered]| f64::from(covered) / f64::from(rows))
    }

    #[test]
    fn the_intervals_of_damping_and_torque_hold() {
        let cases = cases();
        let mut sum = [0.0; 2];
        for case in &cases {
            let line = covered(case);
            // Before it has turned, a machine with half as much damping again is one that nobody described.
            assert!(
                line[0] > 0.75 && line[1] > 0.85,
                "{} {}: {line:?}",
                case.effect,
                case.severity
            );
            sum = [sum[0] + line[0], sum[1] + line[1]];
        }
        let mean = sum.map(|share| share / cases.len() as f64);
        assert!(mean[0] > 0.97 && mean[1] > 0.98, "{mean:?}");
    }
}

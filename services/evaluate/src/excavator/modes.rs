//! All modes over the three loads, against their targets.
//!
//! JSON: a list of `{"mode":..,"scenario":..,"payload":..,"window":[from,to],"summary":{..},"targets":[..],"met":..}`
//! with [`Summary::json`] and [`Target::json`]; errors in percent, times in seconds.

use super::case::{Case, PAYLOADS};
use super::estimators::{Setup, series};
use super::score::{Score, Summary, Window};
use super::target::{Target, all_met, judgement, recorded};
use crate::text::{Table, plain, signed};
use crate::{Error, Options, Report, seeds};
use serde_json::{Value, json};
use sim::excavator::Scenario;

/// One line of the table: an estimator on a case.
struct Line {
    setup: Setup,
    case: Case,
    /// Name of the case if it is not that of its scenario.
    name: String,
    payload: f64,
    window: Window,
    targets: fn(&Summary) -> Vec<Target>,
}

/// Evaluates the table.
pub fn evaluate(options: &Options) -> Result<Report, Error> {
    let mut table = Table::headed(
        "mode; case; kg; mean; |mean| p95; std; p95; max; p95; coverage; to 5 % s; p95; trusted; wrong; target",
    );
    let (mut list, mut met) = (Vec::new(), true);
    for line in lines() {
        let summary = line.summary(options)?;
        let targets = (line.targets)(&summary);
        met &= all_met(&targets);
        table.row(line.cells(&summary, &targets));
        list.push(recorded(line.json(&summary), &targets));
    }
    Ok(Report {
        text: format!(
            "All modes, errors of the swing inertia in percent, {} seeds\n\n{table}{NOTE}",
            options.seeds
        ),
        json: Value::Array(list),
        met,
    })
}

const NOTE: &str = "\
  p95: over the seeds; the targets are set for 300 to 1000 of them, with fewer a p95 scatters. trusted: share of the
  time; wrong: trusted and off by more than 10 %. D: torque and posture; BM: torque; C: posture; A: velocity alone,
  which promises nothing but an honest interval; svf-rls on the paper's plant. BM_known, C and A_const are told that the
  damping is calibrated; BM_auto and C_auto, the defaults, allow for 15 %. Lines without a target are for comparison.
";

impl Line {
    fn summary(&self, options: &Options) -> Result<Summary, Error> {
        let label = format!("{} {} {} kg", self.setup.name, self.name, self.payload);
        let scores = seeds(options, &label, |seed| {
            Ok(Score::of(
                &series(&self.case, &self.setup, seed)?,
                self.window,
            ))
        })?;
        Ok(Summary::of(&scores))
    }

    fn cells(&self, s: &Summary, targets: &[Target]) -> Vec<String> {
        let time = |t: f64| {
            if t.is_finite() {
                plain(t, 2)
            } else {
                "-".into()
            }
        };
        vec![
            self.setup.name.into(),
            self.name.clone(),
            plain(self.payload, 0),
            signed(s.mean, 2),
            plain(s.mean_p95, 2),
            plain(s.std, 2),
            plain(s.std_p95, 2),
            plain(s.max, 1),
            plain(s.max_p95, 1),
            plain(s.coverage, 1),
            time(s.convergence),
            time(s.convergence_p95),
            plain(s.trusted, 0),
            plain(s.trusted_wrong, 1),
            judgement(targets),
        ]
    }

    fn json(&self, summary: &Summary) -> Value {
        json!({
            "mode": self.setup.name, "scenario": self.name, "payload": self.payload,
            "window": [self.window.from, self.window.to], "summary": summary.json(),
        })
    }
}

fn lines() -> Vec<Line> {
    let swing = Window::new(6.0, 9.3);
    let braking = Window::new(7.3, 9.1);
    let mut lines = Vec::new();
    let mut three = |setup: Setup, scenario: Scenario, window, targets| {
        lines.extend(PAYLOADS.map(|payload| line(setup, scenario, payload, window, targets)));
    };
    three(Setup::known(), Scenario::Base, swing, known);
    three(Setup::auto(), Scenario::Base, swing, tolerant);
    three(Setup::tolerant(), Scenario::Base, swing, tolerant);
    three(Setup::torque(), Scenario::Base, swing, torque);
    three(Setup::posture(), Scenario::Base, braking, posture);
    three(Setup::velocity(), Scenario::Base, swing, velocity);
    three(Setup::torque_auto(), Scenario::Base, swing, honest);
    three(Setup::torque_tolerant(), Scenario::Base, swing, none);
    three(Setup::posture_auto(), Scenario::Base, braking, honest);
    three(Setup::svf(), Scenario::Paper, swing, none);
    three(Setup::auto(), Scenario::Gentle, swing, none);
    three(Setup::torque(), Scenario::Gentle, swing, none);
    let plateau = Window::new(8.5, 12.4);
    lines.push(line(
        Setup::velocity_constant(),
        Scenario::Constant,
        150.0,
        plateau,
        constant,
    ));
    lines.push(line(
        Setup::auto(),
        Scenario::Constant,
        150.0,
        plateau,
        none,
    ));
    let back = Window::new(11.8, 14.8);
    for payload in [288.0, 423.0] {
        lines.push(line(
            Setup::auto(),
            Scenario::TwoSwings,
            payload,
            back,
            second_swing,
        ));
    }
    for (payload, share) in [0.0, 423.0]
        .into_iter()
        .flat_map(|p| [0.7, 0.5, 0.25].map(|s| (p, s)))
    {
        lines.push(soft_brake(payload, share, braking));
    }
    lines
}

fn line(
    setup: Setup,
    scenario: Scenario,
    payload: f64,
    window: Window,
    targets: fn(&Summary) -> Vec<Target>,
) -> Line {
    let case = Case::new(scenario, Some(payload));
    Line {
        setup,
        case,
        name: scenario.name().into(),
        payload,
        window,
        targets,
    }
}

/// C with a drive torque that is only reduced instead of reversed.
fn soft_brake(payload: f64, share: f64, window: Window) -> Line {
    let mut plant = Scenario::SoftBrake.plant(Some(payload));
    for swing in &mut plant.swings {
        swing.brake = -share * swing.accelerate;
    }
    let case = Case::of(Scenario::SoftBrake, plant, Scenario::SoftBrake.start());
    let name = format!("torque to {:.0} %", 100.0 * share);
    Line {
        setup: Setup::posture(),
        case,
        name,
        payload,
        window,
        targets: soft,
    }
}

fn none(_: &Summary) -> Vec<Target> {
    Vec::new()
}

/// Targets of a mode with unknown damping: no accuracy, but coverage.
fn honest(s: &Summary) -> Vec<Target> {
    vec![
        Target::least("coverage", s.coverage, 95.0).known_to(s.error.coverage),
        Target::most("wrong", s.trusted_wrong, 0.5).known_to(s.error.trusted_wrong),
    ]
}

fn known(s: &Summary) -> Vec<Target> {
    vec![
        Target::most("|mean|", s.mean_p95, 1.0).known_to(s.error.mean_p95),
        Target::most("std", s.std_p95, 0.9).known_to(s.error.std_p95),
        Target::most("max", s.max_p95, 3.0).known_to(s.error.max_p95),
        Target::between("coverage", s.coverage, 92.0, 98.0).known_to(s.error.coverage),
        Target::most("to 5 %", s.convergence_p95, 0.35),
    ]
}

/// The goal for the maximum is 6; 6.5 is accepted.
fn tolerant(s: &Summary) -> Vec<Target> {
    vec![
        Target::most("|mean|", s.mean_p95, 2.2).known_to(s.error.mean_p95),
        Target::most("std", s.std_p95, 1.9).known_to(s.error.std_p95),
        Target::most("max", s.max_p95, 6.5).known_to(s.error.max_p95),
        Target::between("coverage", s.coverage, 90.0, 98.0).known_to(s.error.coverage),
        Target::most("to 5 %", s.convergence, 0.3),
    ]
}

fn torque(s: &Summary) -> Vec<Target> {
    vec![
        Target::most("|mean|", s.mean_p95, 1.6).known_to(s.error.mean_p95),
        Target::most("std", s.std_p95, 1.8).known_to(s.error.std_p95),
        Target::most("max", s.max_p95, 7.0).known_to(s.error.max_p95),
        Target::between("coverage", s.coverage, 92.0, 98.0).known_to(s.error.coverage),
    ]
}

fn posture(s: &Summary) -> Vec<Target> {
    vec![
        Target::between("mean", s.mean, -3.0, 3.0).known_to(s.error.mean),
        Target::most("std", s.std, 1.3).known_to(s.error.std),
        Target::most("max", s.max_p95, 15.0).known_to(s.error.max_p95),
        Target::least("coverage", s.coverage, 90.0).known_to(s.error.coverage),
    ]
}

fn soft(s: &Summary) -> Vec<Target> {
    vec![
        Target::most("max", s.max_p95, 15.0).known_to(s.error.max_p95),
        Target::least("coverage", s.coverage, 90.0).known_to(s.error.coverage),
    ]
}

fn constant(s: &Summary) -> Vec<Target> {
    vec![
        Target::most("|mean|", s.mean_p95, 2.1).known_to(s.error.mean_p95),
        Target::most("std", s.std_p95, 1.3).known_to(s.error.std_p95),
        Target::most("max", s.max_p95, 7.5).known_to(s.error.max_p95),
        Target::least("coverage", s.coverage, 90.0).known_to(s.error.coverage),
    ]
}

fn velocity(s: &Summary) -> Vec<Target> {
    vec![
        Target::least("coverage", s.coverage, 95.0).known_to(s.error.coverage),
        Target::most("identifiable", s.identifiable, 0.0),
        Target::most("trusted", s.trusted, 0.0),
    ]
}

/// The swing back after a dump in the stop; specified as measured, 2.5 and 2.8 % maximum, coverage 90 %.
fn second_swing(s: &Summary) -> Vec<Target> {
    vec![
        Target::most("max", s.max_p95, 3.5).known_to(s.error.max_p95),
        Target::least("coverage", s.coverage, 88.0).known_to(s.error.coverage),
    ]
}

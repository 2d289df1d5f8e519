//! Faulty sensors and wrong parameters: the estimate stays usable, or says that it is not.
//!
//! JSON: a list of `{"input":..,"mode":..,"payload":..,"summary":{..},"targets":[..],"met":..}`, errors in percent.
//! A fault that can be noticed must not lead to values that are trusted and wrong by more than 10 %; where the
//! estimator has to deal with it, the accuracy is asked as well. A wrong parameter that the inputs of a mode cannot
//! tell from another inertia is only documented: "-".

use super::case::Case;
use super::estimators::Setup;
use super::score::{Score, Summary, Window};
use super::target::{Target, judgement};
use crate::text::{Table, plain, signed};
use crate::{Error, Options, Report, seeds};
use estimation::excavator::Settings;
use serde_json::{Value, json};
use sim::excavator::{Scenario, Sensors};
use sim::fault::{Fault, FaultKind, ROW};

/// The loads [kg].
const PAYLOADS: [f64; 2] = [0.0, 423.0];
/// Trusted and wrong: at most this share of the time [%].
const TRUSTED_WRONG: f64 = 0.5;

/// What is asked of a mode in trouble.
#[derive(Clone, Copy)]
enum Requirement {
    /// A largest error (p95) [%], and honesty.
    Accuracy(f64),
    /// Nothing trusted and wrong.
    Honesty,
    /// Nothing: the figures are for the record.
    Nothing,
}

use Requirement::{Accuracy, Honesty, Nothing};

/// What is wrong.
struct Trouble {
    name: &'static str,
    noise: Sensors,
    faults: Vec<Fault>,
    settings: fn(&mut Settings),
    /// The record begins here [s].
    start: f64,
    /// Damping and torque offset are what the estimators take them for: BM_known and C run, else the
    /// default variants, which do not rely on that.
    calibrated: bool,
    /// What is asked of D, BM and C.
    asked: [Requirement; 3],
}

/// Evaluates the table.
///
/// # Errors
/// As [`super::evaluate`].
pub fn evaluate(options: &Options) -> Result<Report, Error> {
    let mut table = Table::new(&[
        "input", "mode", "kg", "mean", "std", "max p95", "coverage", "trusted", "wrong", "target",
    ]);
    let (mut list, mut met) = (Vec::new(), true);
    let cases = PAYLOADS.map(|payload| (payload, Case::new(Scenario::Base, Some(payload))));
    for trouble in troubles() {
        for ((setup, window), most) in trouble.modes().into_iter().zip(trouble.asked) {
            for (payload, case) in &cases {
                let summary = trouble.summary(options, setup, case, window)?;
                let targets = targets(&summary, most);
                met &= targets.iter().all(Target::met);
                table.row(cells(
                    trouble.name,
                    setup.name,
                    *payload,
                    &summary,
                    &targets,
                ));
                list.push(entry(
                    trouble.name,
                    setup.name,
                    *payload,
                    &summary,
                    &targets,
                ));
            }
        }
    }
    let text = format!(
        "Bad input and wrong parameters, base path, errors in percent, {} seeds\n\n{table}",
        options.seeds
    );
    Ok(Report {
        text,
        json: Value::Array(list),
        met,
    })
}

fn targets(s: &Summary, asked: Requirement) -> Vec<Target> {
    let honest =
        Target::most("wrong", s.trusted_wrong, TRUSTED_WRONG).known_to(s.error.trusted_wrong);
    match asked {
        Accuracy(most) => vec![
            honest,
            Target::most("max", s.max_p95, most).known_to(s.error.max_p95),
        ],
        Honesty => vec![honest],
        Nothing => Vec::new(),
    }
}

impl Trouble {
    /// The modes and what is scored of them; a record that begins in the swing is scored half a second later.
    fn modes(&self) -> [(Setup, Window); 3] {
        let from = |time: f64| {
            let until = if time > 7.0 { 9.1 } else { 9.3 };
            Window::new(time.max(self.start + 0.5), until)
        };
        let (torque, posture) = if self.calibrated {
            (Setup::torque(), Setup::posture())
        } else {
            (Setup::torque_auto(), Setup::posture_auto())
        };
        [
            (Setup::auto(), from(6.0)),
            (torque, from(6.0)),
            (posture, from(7.3)),
        ]
    }

    fn summary(
        &self,
        options: &Options,
        mut setup: Setup,
        case: &Case,
        window: Window,
    ) -> Result<Summary, Error> {
        (self.settings)(&mut setup.settings);
        let case = case.clone().from(self.start);
        let scores = seeds(options, &format!("{}, {}", self.name, setup.name), |seed| {
            let rows = case.rows(seed, self.noise, &self.faults)?;
            Ok(Score::of(&setup.run(&rows)?, window))
        })?;
        Ok(Summary::of(&scores))
    }
}

fn cells(input: &str, mode: &str, payload: f64, s: &Summary, targets: &[Target]) -> Vec<String> {
    vec![
        input.into(),
        mode.into(),
        plain(payload, 0),
        signed(s.mean, 2),
        plain(s.std, 2),
        plain(s.max_p95, 1),
        plain(s.coverage, 0),
        plain(s.trusted, 0),
        plain(s.trusted_wrong, 2),
        judgement(targets),
    ]
}

fn entry(input: &str, mode: &str, payload: f64, summary: &Summary, targets: &[Target]) -> Value {
    json!({
        "input": input, "mode": mode, "payload": payload, "summary": summary.json(),
        "targets": targets.iter().map(Target::json).collect::<Vec<_>>(),
        "met": targets.iter().all(Target::met),
    })
}

/// As accurate as without the fault: a quarter above the figures of the undisturbed runs.
const AS_NONE: [Requirement; 3] = [Accuracy(8.0), Accuracy(9.0), Accuracy(18.0)];
/// The stated uncertainty covers it: D learns it on the way, the others must know their limits.
const STATED: [Requirement; 3] = [Accuracy(10.0), Honesty, Honesty];
/// Twice the stated uncertainty of a constant torque.
const FRICTION: [Requirement; 3] = [Nothing, Honesty, Honesty];
/// No mode can tell.
const RECORD: [Requirement; 3] = [Nothing; 3];

fn trouble(name: &'static str, asked: [Requirement; 3], faults: Vec<Fault>) -> Trouble {
    Trouble {
        name,
        noise: Sensors::default(),
        faults,
        settings: |_| {},
        start: 5.0,
        calibrated: true,
        asked,
    }
}

fn wrong(name: &'static str, asked: [Requirement; 3], settings: fn(&mut Settings)) -> Trouble {
    Trouble {
        settings,
        calibrated: false,
        ..trouble(name, asked, Vec::new())
    }
}

fn troubles() -> Vec<Trouble> {
    let mut all = lost_samples();
    all.extend(wrong_values());
    all.extend(more_noise());
    all.extend(parameter_troubles());
    all
}

const VELOCITY: &str = "swing_velocity";

fn lost_samples() -> Vec<Trouble> {
    vec![
        trouble("none", AS_NONE, vec![]),
        trouble(
            "10 % missing",
            AS_NONE,
            vec![Fault::random(VELOCITY, FaultKind::Missing, 0.1)],
        ),
        trouble(
            "50 % missing",
            [Accuracy(9.0), Accuracy(10.0), Honesty],
            vec![Fault::random(VELOCITY, FaultKind::Missing, 0.5)],
        ),
        trouble(
            "5 % not a number",
            AS_NONE,
            vec![Fault::random(VELOCITY, FaultKind::NotANumber, 0.05)],
        ),
        trouble(
            "0.3 s missing",
            [Accuracy(8.0), Accuracy(9.0), Accuracy(30.0)],
            vec![Fault::between(VELOCITY, FaultKind::Missing, 6.6, 6.9)],
        ),
        trouble(
            "torque 5 % missing",
            AS_NONE,
            vec![Fault::random("swing_torque", FaultKind::Missing, 0.05)],
        ),
    ]
}

fn wrong_values() -> Vec<Trouble> {
    vec![
        trouble(
            "2 % outliers 0.3",
            AS_NONE,
            vec![Fault::random(VELOCITY, FaultKind::Outlier(0.3), 0.02)],
        ),
        trouble(
            "5 % outliers 1.0",
            AS_NONE,
            vec![Fault::random(VELOCITY, FaultKind::Outlier(1.0), 0.05)],
        ),
        Trouble {
            settings: |s| s.sensors.swing_velocity_limit = 0.8,
            ..trouble(
                "limit 0.8",
                [Accuracy(8.0), Accuracy(9.0), Accuracy(35.0)],
                vec![Fault::always(VELOCITY, FaultKind::Saturation(0.8))],
            )
        },
        trouble(
            "bias 0.01",
            AS_NONE,
            vec![Fault::always(VELOCITY, FaultKind::Bias(0.01))],
        ),
        trouble(
            "scale +1 %",
            AS_NONE,
            vec![Fault::always(VELOCITY, FaultKind::Scale(1.01))],
        ),
        trouble(
            "torque gain +2 %",
            RECORD,
            vec![Fault::always("swing_torque", FaultKind::Scale(1.02))],
        ),
        Trouble {
            settings: |s| s.sensors.swing_torque_gain_std = 0.02,
            ..trouble(
                "the same, stated",
                [Honesty, Honesty, Honesty],
                vec![Fault::always("swing_torque", FaultKind::Scale(1.02))],
            )
        },
        Trouble {
            calibrated: false,
            ..trouble(
                "torque offset 100",
                STATED,
                vec![Fault::always("swing_torque", FaultKind::Bias(100.0))],
            )
        },
    ]
}

/// A gap of whole rows, noise beyond the usual, and a record that begins late.
fn more_noise() -> Vec<Trouble> {
    let noise = Sensors::default();
    vec![
        trouble(
            "60 ms gap",
            AS_NONE,
            vec![Fault::between(ROW, FaultKind::Missing, 6.995, 7.045)],
        ),
        Trouble {
            noise: Sensors {
                swing_velocity: 2.0 * noise.swing_velocity,
                ..noise
            },
            ..trouble("noise x 2", [Accuracy(9.0), Accuracy(9.0), Honesty], vec![])
        },
        Trouble {
            noise: Sensors {
                joint_angle: 0.3_f64.to_radians(),
                ..noise
            },
            ..trouble(
                "angle noise 0.3 deg",
                [Accuracy(9.0), Accuracy(9.0), Honesty],
                vec![],
            )
        },
        Trouble {
            start: 6.5,
            ..trouble(
                "start in mid-swing",
                [Accuracy(11.0), Honesty, Honesty],
                vec![],
            )
        },
    ]
}

fn parameter_troubles() -> Vec<Trouble> {
    vec![
        wrong("b_bar -20 %", STATED, |s| s.nominal_damping *= 0.8),
        wrong("b_bar +20 %", STATED, |s| s.nominal_damping *= 1.2),
        wrong("T_f -50 %", FRICTION, |s| s.coulomb_friction *= 0.5),
        wrong("T_f +50 %", FRICTION, |s| s.coulomb_friction *= 1.5),
        wrong("J_u -10 %", RECORD, |s| s.geometry.upper_inertia *= 0.9),
        wrong("J_u +10 %", RECORD, |s| s.geometry.upper_inertia *= 1.1),
        wrong("link masses +5 %", RECORD, |s| {
            s.geometry.masses = s.geometry.masses.map(|m| 1.05 * m)
        }),
        wrong("payload centre +20 %", RECORD, |s| {
            s.geometry.payload_centre *= 1.2
        }),
    ]
}

//! Which parameter is weak along a manoeuvre: singular values of what the data say about the parameters.
//!
//! The filter's model is linearised along the true motion of a known machine, and the covariance is carried from row to row
//! as a square root, by QR. Process noise acts on the speeds only, so what is measured is what the *motion* tells, not
//! the tuning. With the parameters in units of their prior, the singular values of their part of the root are the posterior
//! over the prior standard deviation along orthogonal directions: 1 is a direction that the data say nothing about.
//!
//! JSON: `[{"scenario", "time", "parameters": {NAME: std/prior}, "directions": [{"ratio", "along"}]}]`, weakest first.

use estimation::dual::Dual;
use estimation::loader::cg_model::{CgModel, Integration, Loading};
use estimation::loader::wheel_dynamics::{Inputs, Tyres, WheelDynamics};
use estimation::loader::{LoadTransfer, Prior, Settings};
use estimation::model::Model;
use faer::Mat;
use serde_json::{Value, json};
use sim::loader::{Nominal, Row, Run, Scenario, Simulation};
use std::fmt::Write;

use crate::text::{Table, plain};
use crate::{Error, Options, Report};

const STATES: usize = 10;
const MEASUREMENTS: usize = 4;
/// The parameters among the states: all but the three speeds.
const PARAMETERS: [&str; 7] = ["K", "h", "lambda", "F_x", "d_f", "d_r", "bias"];
/// Index of the slowly changing spade force; as an unknown input it must move, all others are constants.
const FORCE: usize = 6;

/// The manoeuvres and the times at which they are looked at [s].
const CASES: [(Scenario, &[f64]); 4] = [
    (Scenario::Cruise, &[10.0, 60.0]),
    (Scenario::Bumpy, &[10.0]),
    (Scenario::AccelDecel, &[10.0, 30.0]),
    (Scenario::WorkCycle, &[30.0, 100.0]),
];

pub(super) fn evaluate(_options: &Options) -> Result<Report, Error> {
    let mut table = Table::new(
        &[
            &["scenario", "t [s]"],
            &PARAMETERS[..],
            &["singular values, weakest first"],
            &["weakest along"],
        ]
        .concat(),
    );
    let mut json = Vec::new();
    for (scenario, times) in CASES {
        for (time, root) in roots(scenario, times)? {
            let knowledge = Knowledge::of(&root)?;
            table.row(knowledge.cells(scenario, time));
            json.push(knowledge.record(scenario, time));
        }
    }
    let met = json.iter().all(as_expected);
    let mut text =
        "Observability: standard deviation over its prior, per parameter and along the principal directions (1: nothing learnt)\n"
            .to_owned();
    let _ = write!(text, "{table}{READING}");
    Ok(Report {
        text,
        json: Value::Array(json),
        met,
    })
}

const READING: &str = "\
  The weak direction is the height, and on a cruise it is alone: no manoeuvre without changes of acceleration
  tells it. Slip stiffness and ratio come from traction; the rolling radii must be learnt with them.
";

/// On a cruise the height must be the weak one.
fn as_expected(record: &Value) -> bool {
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    record["scenario"] != Scenario::Cruise.name() || number(&record["parameters"]["h"]) > 0.85
}

/// What is known of the parameters, in units of the prior.
struct Knowledge {
    /// Standard deviation over its prior, per parameter.
    parameters: [f64; PARAMETERS.len()],
    /// Singular values, weakest first, each with its direction.
    directions: Vec<(f64, [f64; PARAMETERS.len()])>,
}

impl Knowledge {
    fn of(root: &Mat<f64>) -> Result<Self, Error> {
        let prior = prior_std();
        let part = Mat::from_fn(PARAMETERS.len(), STATES, |i, j| {
            root[(i + 3, j)] / prior[i + 3]
        });
        let svd = part
            .thin_svd()
            .map_err(|_| Error::refused("the singular values did not converge"))?;
        let (u, s) = (svd.U(), svd.S().column_vector());
        let parameters = std::array::from_fn(|i| {
            (0..STATES)
                .map(|j| part[(i, j)].powi(2))
                .sum::<f64>()
                .sqrt()
        });
        let directions = (0..PARAMETERS.len())
            .map(|k| (s[k], std::array::from_fn(|i| u[(i, k)])))
            .collect();
        Ok(Self {
            parameters,
            directions,
        })
    }

    /// A direction as the parameters that make it up.
    fn along(direction: &[f64; PARAMETERS.len()]) -> String {
        let mut parts: Vec<(f64, &str)> = direction.iter().copied().zip(PARAMETERS).collect();
        parts.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
        let main = parts
            .iter()
            .filter(|p| p.0.abs() > 0.3)
            .map(|p| format!("{:+.2} {}", p.0, p.1));
        main.collect::<Vec<_>>().join(" ")
    }

    fn cells(&self, scenario: Scenario, time: f64) -> Vec<String> {
        let values = self
            .directions
            .iter()
            .map(|d| plain(d.0, 3))
            .collect::<Vec<_>>()
            .join(" ");
        let weakest = self
            .directions
            .first()
            .map(|d| Self::along(&d.1))
            .unwrap_or_default();
        let mut cells = vec![scenario.name().to_owned(), plain(time, 0)];
        cells.extend(self.parameters.iter().map(|p| plain(*p, 3)));
        cells.extend([values, weakest]);
        cells
    }

    fn record(&self, scenario: Scenario, time: f64) -> Value {
        let parameters: serde_json::Map<String, Value> = PARAMETERS
            .iter()
            .zip(self.parameters)
            .map(|(name, p)| ((*name).to_owned(), json!(p)))
            .collect();
        let directions: Vec<Value> = self
            .directions
            .iter()
            .map(|d| json!({"ratio": d.0, "along": Self::along(&d.1)}))
            .collect();
        json!({"scenario": scenario.name(), "time": time, "parameters": parameters, "directions": directions})
    }
}

fn prior_std() -> [f64; STATES] {
    let prior = Prior::default();
    let speed = prior.speed_std;
    [
        speed,
        speed,
        speed,
        prior.slip_stiffness_std,
        prior.cg_height_std,
        prior.cg_ratio_std,
        prior.spade_force_std,
        prior.radius_std,
        prior.radius_std,
        prior.slope_bias_std,
    ]
}

/// The covariance root of the states at the given times of a run.
fn roots(scenario: Scenario, times: &[f64]) -> Result<Vec<(f64, Mat<f64>)>, Error> {
    let end = times.last().copied();
    let simulation = Simulation::new(&Run {
        duration: end,
        ..Run::new(scenario)
    })
    .map_err(Error::refused)?;
    let nominal = *simulation.nominal();
    let mut root = Mat::from_fn(
        STATES,
        STATES,
        |i, j| if i == j { prior_std()[i] } else { 0.0 },
    );
    let (mut previous, mut found) = (None, Vec::new());
    for row in simulation {
        if let Some(before) = previous.replace(row) {
            root = step(&root, &nominal, &before, &row);
        }
        if times
            .get(found.len())
            .is_some_and(|time| row.time >= time - 1e-6)
        {
            found.push((times[found.len()], root.clone()));
        }
    }
    Ok(found)
}

/// The root after a prediction along the truth and an update with all measurements.
fn step(root: &Mat<f64>, nominal: &Nominal, before: &Row, row: &Row) -> Mat<f64> {
    let (states, measurements) = jacobian(nominal, before, row);
    let keys = Settings::SPECIFIED.estimator;
    let process = [keys.q_speed, keys.q_wheel_speed, keys.q_wheel_speed];
    let grade = nominal.grade;
    let sensor = [
        grade.speed_std(),
        grade.wheel_speed_std(),
        grade.wheel_speed_std(),
        grade.acceleration_std(),
    ];
    let images = Mat::from_fn(STATES, STATES, |i, j| states[i][j]) * root;
    let measured = Mat::from_fn(MEASUREMENTS, STATES, |i, j| measurements[i][j]) * root;
    let process_std = |i: usize| {
        if i < 3 {
            process[i]
        } else if i == FORCE {
            keys.q_spade_force
        } else {
            0.0
        }
    };
    // Rows: measurements, then states. Columns: the old root, process noise, measurement noise.
    let dt = row.time - before.time;
    let array = Mat::from_fn(MEASUREMENTS + STATES, 2 * STATES + MEASUREMENTS, |i, j| {
        let state = i.checked_sub(MEASUREMENTS);
        match (state, j) {
            (None, j) if j < STATES => measured[(i, j)],
            (None, j) if j < 2 * STATES => match i {
                // The specific force sees the speed noise of its step as an acceleration.
                3 => {
                    if j == STATES {
                        process[0] / dt
                    } else {
                        0.0
                    }
                }
                _ => {
                    if j - STATES == i {
                        process_std(i)
                    } else {
                        0.0
                    }
                }
            },
            (None, j) if j - 2 * STATES == i => sensor[i],
            (None, _) => 0.0,
            (Some(k), j) if j < STATES => images[(k, j)],
            (Some(k), j) if j - STATES == k => process_std(k),
            _ => 0.0,
        }
    });
    let upper = array.transpose().qr().thin_R().to_owned();
    Mat::from_fn(STATES, STATES, |i, j| {
        upper[(j + MEASUREMENTS, i + MEASUREMENTS)]
    })
}

type Jacobian = ([[f64; STATES]; STATES], [[f64; STATES]; MEASUREMENTS]);

/// Derivatives of the next state and of the measurements with respect to the state, along the truth.
fn jacobian(nominal: &Nominal, before: &Row, row: &Row) -> Jacobian {
    let t = &before.truth;
    let values = [
        t.speed,
        t.front_wheel_speed,
        t.rear_wheel_speed,
        t.slip_stiffness,
        t.cg_height,
        t.cg_ratio,
        0.0,
        0.0,
        0.0,
        0.0,
    ];
    let state: [Dual<STATES>; STATES] = std::array::from_fn(|i| {
        Dual::new(
            values[i],
            std::array::from_fn(|j| f64::from(u8::from(i == j))),
        )
    });
    let model = model(nominal, before, row);
    let (next, measured) = Model::<STATES, MEASUREMENTS>::predict(&model, &state);
    (
        next.map(|x| x.derivative),
        std::array::from_fn(|j| {
            if j < 3 {
                next[j].derivative
            } else {
                measured[j].derivative
            }
        }),
    )
}

fn model(nominal: &Nominal, before: &Row, row: &Row) -> CgModel {
    let middle = |value: fn(&Row) -> f64| 0.5 * (value(before) + value(row));
    CgModel {
        dynamics: WheelDynamics {
            mass: row.mass.unwrap_or(nominal.mass),
            wheel_radius: nominal.wheel_radius,
            axle_inertia: nominal.axle_inertia,
            wheelbase: nominal.wheelbase,
            bucket_reach: nominal.bucket_reach,
            rolling_resistance: nominal.rolling_resistance,
            friction: nominal.friction,
            radius_load_sensitivity: nominal.radius_load_sensitivity,
            minimum_speed: Settings::SPECIFIED.estimator.v_min,
            load_transfer: LoadTransfer::Physical,
            tyres: Tyres::ALIKE,
        },
        inputs: Inputs {
            front_torque: middle(|row| row.front_torque),
            rear_torque: middle(|row| row.rear_torque),
            spade_force_x: middle(|row| row.spade_force_x.unwrap_or(0.0)),
            spade_force_z: middle(|row| row.spade_force_z.unwrap_or(0.0)),
            slope: middle(|row| row.truth.slope),
        },
        dt: row.time - before.time,
        integration: Integration::Implicit,
        substeps: 1,
        loading: Loading::NONE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knowledge(scenario: Scenario, time: f64) -> Knowledge {
        let found = roots(scenario, &[time]).unwrap();
        Knowledge::of(&found[0].1).unwrap()
    }

    #[test]
    fn on_a_cruise_the_height_alone_is_unobservable() {
        let cruise = knowledge(Scenario::Cruise, 12.0);
        let (weakest, direction) = cruise.directions[0];
        assert!(
            weakest > 0.95 && direction[1].abs() > 0.95,
            "{weakest} {direction:?}"
        );
        assert!(cruise.parameters[2] < 0.3, "{:?}", cruise.parameters);
    }

    #[test]
    fn changing_acceleration_makes_the_height_observable() {
        let driven = knowledge(Scenario::AccelDecel, 30.0);
        assert!(driven.parameters[1] < 0.6, "{:?}", driven.parameters);
    }
}

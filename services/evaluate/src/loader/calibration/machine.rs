//! The machines that are calibrated, their recordings, and the statements about them.

use calibrate::loader::{Input, StatedLoad};
use estimation::loader::weigh::{Reading, Weighing};
use sim::loader::{Effects, Machine, Row, Run, Scenario, Simulation, Tier};
use sim::noise::Noise;

use crate::Error;
use crate::loader::candidate::sample;

/// Zero of an accelerometer [m/s^2]: that of the sensor, and that of a mounting error of a quarter of a degree.
const ZERO_STD: f64 = 0.04;
/// Accuracy of axle scales, relative, and slope of the machine on them [rad].
const SCALE_STD: f64 = 0.005;
const TILTS: [f64; 4] = [0.0, 0.0, 0.12, -0.12];

/// A machine that differs from its description.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    seed: u64,
    /// Effects that the reference plant does not contain.
    pub effects: Effects,
    torque_delay: f64,
}

impl Truth {
    /// The machine of a seed.
    pub fn new(seed: u64) -> Self {
        let mut noise = Noise::channel(seed, 100);
        let mut truth = Self {
            seed,
            effects: Effects {
                speed_delay: noise.uniform(0.0, 0.08),
                stiffness_difference: noise.uniform(-0.08, 0.08),
                stiffness_exponent: noise.uniform(0.0, 0.15),
                radius_sensitivity: (0.002 * noise.normal()).max(-0.008),
                ..Effects::default()
            },
            torque_delay: noise.uniform(0.0, 0.02),
        };
        let sensor = (noise.uniform(0.0, 0.5), noise.uniform(0.0, 0.4));
        if truth.slope_lags() {
            (truth.effects.slope_lag, truth.effects.slope_follows) = sensor;
        }
        truth.effects.acceleration_offset = ZERO_STD * noise.normal();
        truth
    }

    /// Whether its slope sensor has errors beyond its zero.
    pub fn slope_lags(&self) -> bool {
        self.seed.is_multiple_of(2)
    }

    /// A run of this machine, with the number of its course.
    pub fn run(&self, scenario: Scenario, course: u64, payload: Option<f64>, duration: f64) -> Run {
        Run {
            seed: 100 * self.seed + course,
            machine_seed: Some(self.seed),
            tier: Tier::B,
            effects: self.effects,
            payload,
            duration: Some(duration),
            ..Run::new(scenario)
        }
    }

    /// The measurements of its sensors in a run.
    pub fn rows(&self, run: &Run) -> Result<Vec<Row>, Error> {
        let rows: Vec<Row> = Simulation::new(run).map_err(Error::refused)?.collect();
        let late = self.torque_delay * run.rate;
        let (whole, part) = (late.floor() as usize, late.fract());
        let earlier = |k: usize, by: usize| &rows[k.saturating_sub(by)];
        let mixed = |k: usize, of: fn(&Row) -> f64| {
            (1.0 - part) * of(earlier(k, whole)) + part * of(earlier(k, whole + 1))
        };
        let delayed = (0..rows.len()).map(|k| Row {
            front_torque: mixed(k, |row| row.front_torque),
            rear_torque: mixed(k, |row| row.rear_torque),
            ..rows[k]
        });
        Ok(delayed.collect())
    }
}

/// Distance travelled at each row [m].
pub fn way(rows: &[Row]) -> impl Iterator<Item = f64> {
    let pairs = rows.windows(2);
    pairs.scan(0.0, |way, pair| {
        *way += (pair[1].time - pair[0].time) * pair[1].truth.speed;
        Some(*way)
    })
}

/// A recording for `heft calibrate`.
pub fn input(name: &str, rows: &[Row], stated: StatedLoad) -> Input {
    Input {
        name: name.into(),
        samples: rows.iter().map(sample).collect(),
        stated,
        payload: None,
    }
}

/// The empty machine on axle scales.
pub fn weighed(machine: &Machine, noise: &mut Noise) -> Result<StatedLoad, Error> {
    let mut weighing = Weighing::new(machine.wheelbase, SCALE_STD).map_err(Error::refused)?;
    for pitch in TILTS {
        let share = machine.cg_ratio - machine.cg_height / machine.wheelbase * pitch.tan();
        let mut shown = |part: f64| part * machine.mass * (1.0 + SCALE_STD * noise.normal());
        let reading = Reading {
            pitch,
            front_load: shown(share),
            rear_load: shown(1.0 - share),
        };
        weighing.add(&reading).map_err(Error::refused)?;
    }
    let reference = weighing.reference().map_err(Error::refused)?;
    Ok(StatedLoad::weighed(&reference, SCALE_STD))
}

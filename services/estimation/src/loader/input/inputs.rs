//! Inputs and the specific force between two rows: held where missing, averaged over the step.

use crate::loader::physics::wheel_dynamics::Inputs;
use crate::loader::sample::Sample;
use crate::math::sin_cos;

/// Time for which a stated mass is valid after its last row: then a bucket may have been filled or emptied \[s\].
const HOLDS: f64 = 10.0;

/// Speed below which a yaw rate does not determine the angle between the bodies [m/s].
const SLOWEST: f64 = 0.5;

/// The last finite input of each kind, the mass, and the last specific force.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct InputHold {
    held: [f64; 5],
    /// Which of them were missing in the last row.
    missing: [bool; 5],
    acceleration: Option<f64>,
    /// Mass with its load [kg].
    pub mass: f64,
    /// Time of the last row that stated it \[s\].
    weighed: f64,
}

/// Inputs of the step that ends at a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepInputs {
    pub inputs: Inputs,
    /// Sine of the measured slope.
    pub sine: f64,
    /// Mean specific force over the step; missing when either end is.
    pub acceleration: Option<f64>,
    /// Friction brakes act.
    pub brake: bool,
    /// The mass with its load is stated.
    pub states_mass: bool,
    /// Angle between front and rear body, where it is measured [rad].
    pub articulation: Option<f64>,
    /// Yaw rate, where it is measured [rad/s].
    pub yaw_rate: Option<f64>,
}

impl StepInputs {
    /// Angle between front and rear body: measured, or from the yaw rate, or 0 [rad].
    pub fn turning(&self, speed: f64, wheelbase: f64) -> f64 {
        let by_yaw = |rate: f64| rate * wheelbase / speed.abs().max(SLOWEST);
        self.articulation
            .or(self.yaw_rate.map(by_yaw))
            .unwrap_or(0.0)
    }
}

impl InputHold {
    pub fn new(mass: f64) -> Self {
        Self {
            held: [0.0; 5],
            missing: [false; 5],
            acceleration: None,
            mass,
            weighed: f64::NEG_INFINITY,
        }
    }

    /// Takes a plausible row, and returns the inputs of the step that ends at it.
    ///
    /// A missing input keeps its last finite value; before any it is 0. Mid-point inputs are the mean of the held value and the new
    /// one. Otherwise the older one is held over the step, as in the paper. With `restart`, a value that follows missing ones
    /// stands alone, because the held one is of another time.
    pub fn advance(&mut self, sample: &Sample, midpoint: bool, restart: bool) -> StepInputs {
        let row = [
            sample.front_torque,
            sample.rear_torque,
            sample.spade_force_x,
            sample.spade_force_z,
            sample.slope,
        ];
        let mut used = self.held;
        let memory = self.held.iter_mut().zip(&mut self.missing);
        for ((used, (held, missing)), new) in used.iter_mut().zip(memory).zip(row) {
            if let Some(new) = new {
                *used = match midpoint {
                    true if restart && *missing => new,
                    true => 0.5 * (*held + new),
                    false => *used,
                };
                *held = new;
                *missing = false;
            } else {
                *missing = true;
            }
        }
        let acceleration = sample.acceleration;
        let mean = self
            .acceleration
            .zip(acceleration)
            .map(|(a, b)| 0.5 * (a + b));
        self.acceleration = acceleration;
        if let Some(mass) = sample.mass {
            self.mass = mass;
            self.weighed = sample.time;
        }
        let inputs = Inputs::of(used);
        StepInputs {
            inputs,
            sine: sin_cos(inputs.slope).0,
            acceleration: mean,
            brake: sample.brake,
            // A clock that was set back makes an age negative.
            states_mass: (0.0..HOLDS).contains(&(sample.time - self.weighed)),
            articulation: sample.articulation,
            yaw_rate: sample.yaw_rate,
        }
    }
}

//! Removal of torques and slopes that leap further than a loader and its road allow.

use crate::GRAVITY;
use crate::leap::{Leap, SteadyTorque};
use crate::loader::sample::Sample;

/// Least full-scale pull of an axle, as a share of the weight.
const LEAST_PULL: f64 = 0.02;
/// Largest rate at which road and sensor lag can tilt the machine [rad/s].
const TILTING: f64 = 2.0;
/// Roughness of a road and noise of the sensor, from row to row [rad].
const ROUGHNESS: f64 = 0.15;

/// Torques and slope without their leaps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::loader) struct Steady {
    torques: [SteadyTorque; 2],
    slope: Leap,
}

impl Steady {
    /// Removes leaping values from a row `dt` after the one before, of a machine of this mass [kg] and wheel radius [m].
    pub(in crate::loader) fn watch(
        &mut self,
        sample: &mut Sample,
        mass: f64,
        radius: f64,
        dt: f64,
    ) {
        let least = LEAST_PULL * mass * GRAVITY * radius;
        let torques = [&mut sample.front_torque, &mut sample.rear_torque];
        for (torque, steady) in torques.into_iter().zip(&mut self.torques) {
            *torque = steady.pass(*torque, [least, 0.0], dt);
        }
        sample.slope = self.slope.pass(sample.slope, TILTING, ROUGHNESS, dt);
    }
}

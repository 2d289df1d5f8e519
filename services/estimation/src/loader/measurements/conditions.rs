//! Conditions in which the parameters are held: low speed and digging.

use crate::loader::settings::{Estimator, Settings};

/// Conditions of one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Conditions {
    /// Slow or digging: no process noise of the parameters, and the wheels carry little information.
    pub frozen: bool,
    /// Digging ended with this row: the bucket may be full.
    pub reopen: bool,
}

/// Hold time of digging.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Digging {
    /// Time for which the machine still counts as digging [s].
    hold: f64,
}

impl Digging {
    /// Returns the conditions of a step with this predicted speed and total spade force.
    pub fn conditions(
        &mut self,
        settings: &Settings,
        speed: f64,
        spade_force: f64,
        dt: f64,
    ) -> Conditions {
        let slow = speed.abs() < settings.estimator.v_freeze;
        let (digging, reopen) = if settings.protected() {
            self.digging(&settings.estimator, spade_force, dt)
        } else {
            (false, false)
        };
        Conditions {
            frozen: slow || digging,
            reopen,
        }
    }

    /// Whether the machine digs or did so within the hold time, and whether the hold ends with this row.
    fn digging(&mut self, keys: &Estimator, spade_force: f64, dt: f64) -> (bool, bool) {
        if spade_force.abs() > keys.dig_force {
            self.hold = keys.dig_hold;
            return (true, false);
        }
        if self.hold <= 0.0 {
            return (false, false);
        }
        self.hold -= dt;
        // Tolerance of half a row, because times are rounded.
        let over = self.hold < 0.5 * dt;
        if over {
            self.hold = 0.0;
        }
        (true, over)
    }
}

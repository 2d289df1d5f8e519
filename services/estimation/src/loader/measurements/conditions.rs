//! When the parameters are held: low speed, digging.

use crate::loader::settings::{Estimator, Settings};

/// What holds during one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Conditions {
    /// Slow or digging: no parameter noise, and the wheels tell little.
    pub frozen: bool,
    /// Digging just ended: the bucket may be full.
    pub reopen: bool,
}

/// Memory of digging.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Digging {
    /// For how long it still counts as digging [s].
    hold: f64,
}

impl Digging {
    /// Conditions of a step with this predicted speed and total spade force.
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
        // Half a row of slack: times are rounded.
        let over = self.hold < 0.5 * dt;
        if over {
            self.hold = 0.0;
        }
        (true, over)
    }
}

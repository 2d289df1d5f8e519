//! Gain kappa of the drive, force on the body over force of the reported torques, from all driving in which the ground does not resist.
//!
//! ```text
//! a = kappa u - c sgn(v) + z,   u = (T_f + T_r)/(r m)
//! ```
//! A bucket in a pile, or a blade, resists with a force that no sensor reports. There the machine hardly accelerates, whatever its torques
//! are: as with a small kappa. That force acts against forward motion, at the speed of work, and grows over a second. So the rows of a
//! fifth of a second are averaged and wait for a second. They count if none of them, and none after them, lags behind the torques.
//! Where the ground does not resist, such a row shows another mass, a load that nobody reports: kappa opens.

use core::array;

use crate::Quantity;
use crate::loader::load::inertia::{Force, Push};
use crate::loader::measurements::blocks::Blocks;
use crate::math::sqrt;

/// Range of kappa by tolerances of mass and torque.
const RANGE: (f64, f64) = (0.75, 1.33);
/// Largest force per mass of a drive [m/s^2].
pub const LARGEST: f64 = 5.0;
/// Random walk of kappa [1/sqrt(s)], of the resistance and of the accelerometer's zero [m/s^2/sqrt(s)]: kappa, a property of gears, motors
/// and the empty machine, walks 3 % in a quarter of an hour.
const WALK: [f64; 3] = [0.001, 0.01, 0.01];
/// Length of a block [s], and the number of them that wait.
const BLOCK: f64 = 0.2;
const WAIT: usize = 5;
/// Speed below which a loader fills its bucket or grades [m/s].
const WORKS_BELOW: f64 = 3.0;
/// Force per mass beyond which a block is unexplained: absolute [m/s^2], and in standard deviations.
const SURPRISES: f64 = 0.15;
const SURPRISES_STDS: f64 = 2.0;

/// Estimate of kappa, c and z.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gain {
    force: Force,
    /// Of acceleration, force over mass and direction.
    blocks: Blocks<3>,
    /// Means of the blocks that wait, oldest first.
    waiting: [Option<[f64; 3]>; WAIT],
}

impl Default for Gain {
    fn default() -> Self {
        let mut force = Force::default();
        force.open_zero();
        Self {
            force,
            blocks: Blocks::default(),
            waiting: [None; WAIT],
        }
    }
}

impl Gain {
    /// Updates with a row; it `counts` where the torques drive and nothing known resists.
    pub fn see(&mut self, row: &Push, counts: bool, dt: f64) {
        if !counts {
            self.blocks = Blocks::default();
            return;
        }
        let direction = if row.speed >= 0.0 { 1.0 } else { -1.0 };
        let signals = [row.acceleration, row.pull, direction];
        let Some(block) = self.blocks.add(signals, dt, BLOCK) else {
            return;
        };
        let surprise = self.surprise(&block);
        if surprise < 0.0 && (0.0..WORKS_BELOW).contains(&row.speed) {
            self.waiting = [None; WAIT];
            return;
        }
        if surprise != 0.0 {
            self.force.reopen_gain();
        }
        if let Some(block) = self.waiting[0] {
            self.force.walk(&WALK, BLOCK);
            self.force.see(block, BLOCK);
        }
        self.waiting = array::from_fn(|i| self.waiting.get(i + 1).copied().unwrap_or(Some(block)));
    }

    /// Acceleration of a block beyond what is explained, 0 within [m/s^2]: negative where the machine lags behind its torques.
    fn surprise(&self, block: &[f64; 3]) -> f64 {
        let [innovation, variance] = self.force.expects(block, BLOCK);
        let explained = SURPRISES + SURPRISES_STDS * sqrt(variance);
        (innovation.abs() - explained).max(0.0).copysign(innovation)
    }

    /// Kappa.
    pub fn found(&self) -> Quantity {
        Quantity {
            value: self.force.state[0],
            std: sqrt(self.force.covariance[0][0].max(0.0)),
        }
    }

    /// Kappa, limited to what tolerances explain.
    pub fn value(&self) -> f64 {
        self.force.state[0].clamp(RANGE.0, RANGE.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pull and speed at a time of shuttling between 2 m/s forward and back [m/s^2, m/s].
    fn shuttle(t: f64) -> (f64, f64) {
        let rate = 0.5;
        (2.0 * rate * f64::cos(rate * t), 2.0 * f64::sin(rate * t))
    }

    /// Adds a row of this true kappa; the bucket resists by `ground` [m/s^2].
    fn add(gain: &mut Gain, kappa: f64, (pull, speed): (f64, f64), ground: f64) {
        let row = Push {
            acceleration: kappa * pull - 0.2 * speed.signum() - ground,
            pull,
            speed,
        };
        gain.see(&row, pull * speed > 0.0 && speed.abs() > 0.5, 0.01);
    }

    /// After a minute of shuttling.
    fn shuttled(kappa: f64) -> Gain {
        let mut gain = Gain::default();
        for k in 0..6000 {
            add(&mut gain, kappa, shuttle(0.01 * f64::from(k)), 0.0);
        }
        gain
    }

    #[test]
    fn driving_identifies_kappa_and_an_unreported_load_opens_it() {
        for kappa in [0.7, 0.9, 1.1] {
            let mut gain = shuttled(kappa);
            let Quantity { value, std } = gain.found();
            assert!((value - kappa).abs() < 0.02, "{value} {kappa}");
            assert!((value - kappa).abs() < 3.0 * std && std < 0.03, "{std}");
            // A quarter more mass on the way back.
            let way_back = |t: f64| (-1.5 - f64::sin(2.0 * t), -1.5);
            (0..400).for_each(|k| add(&mut gain, 0.8 * kappa, way_back(0.01 * f64::from(k)), 0.0));
            let loaded = gain.found();
            assert!(
                (loaded.value - 0.8 * kappa).abs() < 0.08,
                "{loaded:?} {kappa}"
            );
        }
        assert_eq!(shuttled(0.7).value(), RANGE.0, "beyond tolerances");
    }

    #[test]
    fn a_bucket_that_is_pushed_into_a_pile_is_no_smaller_kappa() {
        for before in [Gain::default(), shuttled(1.0)] {
            let mut gain = before;
            // A pull of 3 m/s^2, against a resistance that grows over a second and stops the machine.
            for k in 0..400 {
                let t = 0.01 * f64::from(k);
                let ground = 3.0 * t.min(1.0);
                add(&mut gain, 1.0, (3.0, 2.0 - 0.3 * t), ground);
            }
            let Quantity { value, std } = gain.found();
            assert!((value - 1.0).abs() < 2.0 * std, "{value} +- {std}");
            assert!((value - 1.0).abs() < 0.05, "{value} +- {std}");
        }
    }

    #[test]
    fn rows_that_do_not_count_change_nothing() {
        let mut gain = shuttled(1.0);
        let before = gain.found();
        for _ in 0..1000 {
            let row = Push {
                acceleration: 0.0,
                pull: 3.0,
                speed: -2.0,
            };
            gain.see(&row, false, 0.01);
        }
        assert_eq!(gain.found(), before);
    }
}

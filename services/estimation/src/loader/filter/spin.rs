//! Wheels that spin: tyres on soil have passed their proportional range, and the force that they transmit says nothing of slip
//! stiffness and load (Wong, Theory of Ground Vehicles, 2.4).

use super::{Belief, CgFilter};
use crate::loader::layout::{FRONT_WHEEL, REAR_WHEEL, SPEED};
use crate::loader::sample::Sample;

/// A wheel that slips by more than this share spins.
const SLIP: f64 = 0.15;
/// Slip speeds below this are no spin [m/s].
const SLIP_SPEED: f64 = 0.3;
/// A wheel that seems to spin for longer, or for a third of its way, has another radius or unit than is described [s].
const LONGEST: f64 = 5.0;

/// Memory of the wheels that spun.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Spin {
    /// How long a wheel has spun, less half of the time in which all rolled [s].
    time: f64,
}

impl Spin {
    /// Whether wheels that `slip` far in a row of `dt` spin, and are not described wrongly.
    fn is_one(&mut self, slip: bool, speed: f64, dt: f64) -> bool {
        self.time += match (slip, speed.abs() > SLIP_SPEED) {
            (true, _) => dt,
            (false, true) => -0.5 * dt,
            (false, false) => 0.0,
        };
        self.time = self.time.clamp(0.0, LONGEST);
        slip && self.time < LONGEST
    }
}

/// Whether a wheel slips by more than a tyre that rolls; speeds of rim and body [m/s].
fn slips_far(rim: f64, speed: f64) -> bool {
    let (slip, fastest) = ((rim - speed).abs(), rim.abs().max(speed.abs()));
    slip > SLIP_SPEED && slip > SLIP * fastest
}

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// Whether a row's wheels say nothing of the tyre: they spin, or roll again while the filter's own still spin, which were taken
    /// from a row that spun or from an outlier.
    pub(super) fn spins(&mut self, sample: &Sample, dt: f64) -> bool {
        let state = self.belief.state();
        let (speed, radius) = (state[SPEED], self.dynamics.wheel_radius);
        let slips = |wheel: f64| slips_far(radius * wheel, speed);
        let own = slips(state[FRONT_WHEEL]) || slips(state[REAR_WHEEL]);
        let wheels = [sample.front_wheel_speed, sample.rear_wheel_speed];
        let seen = wheels.into_iter().flatten().any(slips);
        self.spin.is_one(seen, speed, dt) || own && !seen
    }
}

//! Wheels that spin: a tyre on soil has passed its proportional range, and its force carries no information about slip stiffness
//! and load (Wong, Theory of Ground Vehicles, 2.4).

use super::{Belief, CgFilter};
use crate::loader::layout::{FRONT_WHEEL, REAR_WHEEL, SPEED};
use crate::loader::sample::Sample;

/// Slip beyond which a wheel spins.
const SLIP: f64 = 0.15;
/// Slip speed below which a wheel does not spin [m/s].
const SLIP_SPEED: f64 = 0.3;
/// Longest spin [s]. A wheel that seems to spin for longer, or for a third of the driving time, has another radius or unit than
/// stated.
const LONGEST: f64 = 5.0;

/// Timer of spinning wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Spin {
    /// Time for which a wheel has spun, less half of the time in which all rolled [s].
    time: f64,
}

impl Spin {
    /// Whether wheels with a large `slip` in a row of `dt` spin, rather than being described wrongly.
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

/// Whether a wheel spins: it slips by more than a rolling tyre. Speeds of rim and body [m/s].
#[must_use]
pub fn wheel_spins(rim: f64, speed: f64) -> bool {
    let (slip, fastest) = ((rim - speed).abs(), rim.abs().max(speed.abs()));
    slip > SLIP_SPEED && slip > SLIP * fastest
}

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// Whether a row's wheels carry no information about the tyres. They spin, or they roll again while the filter's own wheel
    /// speeds still spin, which came from a spinning row or from an outlier.
    pub(super) fn spins(&mut self, sample: &Sample, dt: f64) -> bool {
        let state = self.belief.state();
        let (speed, radius) = (state[SPEED], self.dynamics.wheel_radius);
        let slips = |wheel: f64| wheel_spins(radius * wheel, speed);
        let own = slips(state[FRONT_WHEEL]) || slips(state[REAR_WHEEL]);
        let wheels = [sample.front_wheel_speed, sample.rear_wheel_speed];
        let seen = wheels.into_iter().flatten().any(slips);
        self.spin.is_one(seen, speed, dt) || own && !seen
    }
}

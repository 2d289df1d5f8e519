//! Estimates the lag of the torque behind the velocity from both signals.
//!
//! At any mass of the machine, the torque is a sum of inertial torque, damping, friction and slope. At the true lag l the least squares of
//! ```text
//! T(t + l) = c1 L'(t) + c2 w(t) + c3 sgn w(t) + c4 sin psi(t) + c5 cos psi(t) + c6 |L'(t)| sgn w(t),  L = J_e(q) w
//! ```
//! leave the smallest residual; the last summand is the loss of the gear. The prior of the lag is the stated value with its standard
//! deviation, and with a small probability any other lag. It is part of the odds. The estimators tolerate a few hundredths of a second, and
//! estimate them more accurately themselves. This estimates larger lags.

use crate::excavator::grid::{PERIOD, Tick};
use crate::math::{exp, ln, round, sin_cos, sqrt};
use core::f64::consts::TAU;
use nalgebra::{SMatrix, SVector};

/// Ticks on either side over which the velocity is differenced and the torque is averaged.
const HALF: usize = 3;
/// Range of the lag: the torque comes at most this number of ticks earlier or later.
const EARLIEST: usize = 16;
const LATEST: usize = 20;
const LAGS: usize = EARLIEST + LATEST + 1;
const RING: usize = EARLIEST + LATEST + 2 * HALF + 2;
/// Velocity below which the machine may stand [rad/s].
const MOVING: f64 = 0.06;
/// Weight of one tick in the sums: a memory of 20 s of motion.
const MEMORY: f64 = 0.0005;
/// Ticks of motion needed for a result: 2.5 s.
const ENOUGH: f64 = 250.0;
/// Number of neighbouring ticks whose errors are equal. With 10, a wrong lag was found on a quarter of 32 simulated machines with
/// jittering stamps.
const CORRELATED: f64 = 30.0;
/// Logarithm of the odds at which a lag replaces the present one.
const BETTER: f64 = 5.0;
/// Probability that the lag is not as stated; all lags are then equally probable.
const UNSTATED: f64 = 0.01;
/// Least standard deviation of a stated lag [ticks].
const CLOSELY: f64 = 0.5;
/// Least difference from the present lag [ticks]: the estimators tolerate smaller ones.
const BORNE: i32 = 3;

/// Number of regressors.
const SUMMANDS: usize = 6;
type Regressors = SVector<f64, SUMMANDS>;

/// Sums of the least squares for each lag.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Lag {
    /// Velocity, torque averaged up to this tick, inertia, swing angle.
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    ring: [(f64, f64, f64, f64); RING],
    recent: [f64; 2 * HALF + 1],
    count: usize,
    turn: f64,
    seen: f64,
    normal: SMatrix<f64, SUMMANDS, SUMMANDS>,
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    products: [Regressors; LAGS],
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    squares: [f64; LAGS],
    /// Residual at each lag, and the lag that is computed next.
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    left: [f64; LAGS],
    next: usize,
    /// Number of residuals that are older than the present sums.
    old: usize,
    /// Stated lag, and its standard deviation [ticks].
    stated: [f64; 2],
}

impl Lag {
    /// From a stated lag and its standard deviation [s].
    pub(in crate::excavator) fn new([value, std]: [f64; 2]) -> Self {
        Self {
            stated: [value / PERIOD, (std / PERIOD).max(CLOSELY)],
            ring: [(0.0, 0.0, 0.0, 0.0); RING],
            recent: [0.0; 2 * HALF + 1],
            count: 0,
            turn: 0.0,
            seen: 0.0,
            normal: SMatrix::zeros(),
            products: [Regressors::zeros(); LAGS],
            squares: [0.0; LAGS],
            left: [f64::INFINITY; LAGS],
            next: 0,
            old: 0,
        }
    }

    /// Takes a tick with the inertia of the empty machine. Returns a lag [ticks], positive where the torque is later than the velocity, if
    /// it is clearly better than the `present` one [s].
    pub(in crate::excavator) fn push(
        &mut self,
        tick: &Tick,
        inertia: f64,
        present: f64,
    ) -> Option<i32> {
        let steady = (tick.period - PERIOD).abs() < 0.5 * PERIOD;
        let there = tick.has_torque() && tick.has_posture();
        // The swing angle is integrated also where other signals are missing.
        self.turn += tick.velocity.unwrap_or(0.0) * tick.period;
        let Some(velocity) = tick.velocity.filter(|_| steady && there) else {
            self.count = 0;
            return None;
        };
        self.recent[self.count % self.recent.len()] = tick.torque;
        let mean = self.recent.iter().sum::<f64>() / self.recent.len() as f64;
        self.ring[self.count % RING] = (velocity, mean, inertia, self.turn);
        self.count += 1;
        if self.count < RING {
            return None;
        }
        self.sum();
        self.look();
        if self.next == 0 && self.seen > ENOUGH {
            self.better(present)
        } else {
            None
        }
    }

    /// Adds the tick in the middle of the ring.
    fn sum(&mut self) {
        let newest = self.count - 1;
        let middle = newest - LATEST - HALF;
        let at = |k: usize| self.ring[k % RING];
        let (ahead, behind) = (at(middle + HALF), at(middle - HALF));
        let velocity = 0.5 * (ahead.0 + behind.0);
        if velocity.abs() < MOVING || ahead.0 * behind.0 <= 0.0 {
            return;
        }
        let momentum = |(velocity, _, inertia, _): (f64, f64, f64, f64)| inertia * velocity;
        let inertial = (momentum(ahead) - momentum(behind)) / (2.0 * HALF as f64 * PERIOD);
        let (direction, (sin, cos)) = (velocity.signum(), sin_cos(at(middle).3));
        let lost = inertial.abs() * direction;
        let x = Regressors::new(inertial, velocity, direction, sin, cos, lost);
        let mut k = (middle + HALF - EARLIEST) % RING;
        let forgetting = 1.0 - MEMORY;
        self.seen = self.seen * forgetting + 1.0;
        self.old = LAGS;
        self.normal = self.normal * forgetting + x * x.transpose();
        for (product, square) in self.products.iter_mut().zip(&mut self.squares) {
            let torque = self.ring[k].1;
            k = if k + 1 < RING { k + 1 } else { 0 };
            *product = *product * forgetting + x * torque;
            *square = *square * forgetting + torque * torque;
        }
    }

    /// Updates the residual at one lag, another one in each tick.
    fn look(&mut self) {
        let i = self.next;
        self.next = (i + 1) % LAGS;
        if self.old == 0 {
            return;
        }
        self.old -= 1;
        // With N = L L', c' N^-1 c is the square of L^-1 c.
        let explained = self.normal.cholesky().and_then(|factor| {
            let lower = factor.l_dirty();
            lower.solve_lower_triangular(&self.products[i])
        });
        self.left[i] = explained.map_or(f64::INFINITY, |explained| {
            self.squares[i] - explained.norm_squared()
        });
    }

    fn better(&self, present: f64) -> Option<i32> {
        let present = round(present / PERIOD) as i32;
        let all = self.left.iter().enumerate();
        let (best, least) = all.min_by(|a, b| a.1.total_cmp(b.1))?;
        let inside = (1..LAGS - 1).contains(&best);
        let at = |lag: i32| usize::try_from(lag + EARLIEST as i32).ok();
        let now = at(present).and_then(|i| self.left.get(i)).copied()?;
        let lag = best as i32 - EARLIEST as i32;
        let known = self.left.iter().all(|left| left.is_finite());
        let evidence = self.seen / CORRELATED * ln(now / least.max(f64::MIN_POSITIVE));
        let odds = evidence + self.beforehand(lag) - self.beforehand(present);
        (known && inside && (lag - present).abs() >= BORNE && odds > BETTER).then_some(lag)
    }

    /// Logarithm of the prior probability of a lag.
    fn beforehand(&self, lag: i32) -> f64 {
        let [value, std] = self.stated;
        let away = (f64::from(lag) - value) / std;
        let as_stated = exp(-0.5 * away * away) / (std * sqrt(TAU));
        ln((1.0 - UNSTATED) * as_stated + UNSTATED / LAGS as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::tanh;

    /// Lag found in a swing whose torque is `late` ticks late; `share` scales the true inertia.
    fn found(late: i32, share: f64) -> Option<i32> {
        let mut lag = Lag::new([0.0, 0.02]);
        // Swings with plateaus: in a sine, a lag is equivalent to another inertia and damping.
        let velocity =
            |k: f64| 0.8 * tanh(3.0 * sin_cos(0.015 * k).0) * (1.0 + 0.3 * sin_cos(0.0031 * k).0);
        let torque = |k: f64| {
            let w = velocity(k);
            let acceleration = (velocity(k + 0.5) - velocity(k - 0.5)) / PERIOD;
            6000.0 * share * acceleration + 1500.0 * w + 250.0 * w.signum()
        };
        (0..3000).find_map(|k| {
            let noise = f64::from(k * 7919 % 1013) / 1013.0 - 0.5;
            let tick = Tick {
                period: PERIOD,
                velocity: Some(velocity(f64::from(k)) + 0.01 * noise),
                torque: torque(f64::from(k - late)) + 200.0 * noise,
                ..Tick::default()
            };
            lag.push(&tick, 5000.0, 0.0)
        })
    }

    #[test]
    fn the_lag_of_torque_or_velocity_is_found_whatever_the_machine_weighs() {
        for share in [0.7, 1.0, 1.5] {
            for late in [-10, -5, 5, 12, 17] {
                let lag = found(late, share);
                assert!(
                    lag.is_some_and(|lag| (lag - late).abs() <= 1),
                    "{late}: {lag:?}"
                );
            }
            for late in [-2, 0, 2] {
                assert_eq!(found(late, share), None, "{late}");
            }
        }
    }
}

//! Detection of a load that hangs.
//!
//! A load on a hook, or one that sloshes, is a pendulum: it follows the upper body late, and pulls it back and forth. A rigid load
//! explains nothing of that. Means over a fifth of a second since the content changed are fitted by least squares:
//!
//! ```text
//! tau - J_e alpha = b1 g alpha + b2 sign(w) + b3 w + b4 g a_L
//! ```
//!
//! J_e and g are the inertia without payload and per kilogram. The acceleration of the upper body is alpha; that of a load on a rope of
//! length L, still at first, is a_L. The first three terms describe any rigid load and any friction. The squared partial correlation with
//! the last one is the share of their residual that a load on this rope explains.

use nalgebra::{Matrix3, Vector3};

use super::super::geometry::Inertia;
use crate::excavator::measurements::boom_moment::GRAVITY;

/// Lengths of the rope \[m\]: half periods of .8, 1.2 and 1.9 s. Neighbouring lengths respond similarly within a swing.
const ROPES: [f64; 3] = [0.6, 1.5, 3.5];
/// Share of its velocity that a hanging load retains over a block: 3 to 5 % of the critical damping.
const RETAINED: f64 = 0.95;
/// Ticks of a block.
const BLOCK: u32 = 20;
/// Longest duration of a block \[s\]: the shortest pendulum advances by at most 1 rad.
const LONGEST: f64 = 0.25;
/// Number of blocks that identify four coefficients.
const ENOUGH: u32 = 10;
/// Number of blocks between two evaluations.
const AGAIN: u32 = 5;
/// Explained share above which a load hangs. It is at most .41 in 19 of 20 carries of a rigid load with one effect of real machines (late
/// torque, losses, friction, a boom that bends). It is at least .54 with a load on ropes of .8 and 1.5 m.
const MOST: f64 = 0.5;
/// Share by which the diagonal is raised, so that nearly collinear regressors have a pivot.
const RIDGE: f64 = 1e-9;
/// Number of coefficients of a rigid load and of friction.
const RIGID: usize = 3;

/// Load that hangs on one rope.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Pendulum {
    /// Angle about the swing axis by which the load leads the upper body \[rad\], and its rate [rad/s].
    ahead: f64,
    rate: f64,
    /// Sums of products of its regressor: with those of a rigid load, with itself, and with the torque.
    with_rigid: [f64; RIGID],
    squares: f64,
    with_torque: f64,
}

impl Pendulum {
    /// Advances by a block in which the upper body gains this velocity; returns the load's acceleration [rad/s^2].
    fn step(&mut self, rope: f64, gained: f64, period: f64) -> f64 {
        self.ahead += 0.5 * period * self.rate;
        let acceleration = -GRAVITY / rope * self.ahead;
        self.rate = RETAINED * self.rate + period * acceleration - gained;
        self.ahead += 0.5 * period * self.rate;
        acceleration
    }
}

/// Regression over the swings since the content changed.
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Sway {
    /// Velocity at the start of the block [rad/s], ticks so far, and sum of their torques [N m].
    before: f64,
    ticks: u32,
    torque: f64,
    pendulums: [Pendulum; ROPES.len()],
    /// Sums of products of the rigid load's regressors, with each other and with the torque beyond the empty machine's; sum of its
    /// squares.
    rigid: [[f64; RIGID]; RIGID],
    with_torque: [f64; RIGID],
    squares: f64,
    blocks: u32,
    hangs: bool,
}

impl Sway {
    /// Adds torque and velocity of a tick in which the machine swings freely.
    pub(super) fn push(&mut self, torque: f64, velocity: f64, now: &Inertia, period: f64) {
        if self.ticks == 0 {
            (self.before, self.torque) = (velocity, 0.0);
        } else {
            self.torque += torque;
        }
        self.ticks += 1;
        if self.ticks <= BLOCK {
            return;
        }
        let time = f64::from(BLOCK) * period;
        if time < LONGEST {
            self.block(self.torque / f64::from(BLOCK), velocity, now, time);
            (self.before, self.torque, self.ticks) = (velocity, 0.0, 1);
        } else {
            self.rest();
        }
    }

    fn block(&mut self, torque: f64, velocity: f64, now: &Inertia, time: f64) {
        let gained = velocity - self.before;
        let acceleration = gained / time;
        let torque = torque - now.empty * acceleration;
        let terms = [now.per_payload * acceleration, velocity.signum(), velocity];
        for (row, x) in self.rigid.iter_mut().zip(terms) {
            add(row, x, &terms);
        }
        add(&mut self.with_torque, torque, &terms);
        self.squares += torque * torque;
        for (pendulum, rope) in self.pendulums.iter_mut().zip(ROPES) {
            let term = now.per_payload * pendulum.step(rope, gained, time);
            add(&mut pendulum.with_rigid, term, &terms);
            pendulum.squares += term * term;
            pendulum.with_torque += term * torque;
        }
        self.blocks += 1;
        if self.blocks >= ENOUGH && self.blocks.is_multiple_of(AGAIN) {
            self.hangs = self.explained() > MOST;
        }
    }

    /// Largest share of the torque, beyond the rigid load's fit, that a hanging load explains.
    fn explained(&self) -> f64 {
        let mut rigid = Matrix3::from(self.rigid);
        (0..RIGID).for_each(|k| rigid[(k, k)] *= 1.0 + RIDGE);
        let Some(root) = rigid.cholesky() else {
            return 0.0;
        };
        let whiten = |products: [f64; RIGID]| {
            root.l_dirty()
                .solve_lower_triangular_unchecked(&Vector3::from(products))
        };
        let torque = whiten(self.with_torque);
        let left = self.squares - torque.norm_squared();
        let share = |pendulum: &Pendulum| {
            let term = whiten(pendulum.with_rigid);
            let covariance = pendulum.with_torque - term.dot(&torque);
            let whole = left * (pendulum.squares - term.norm_squared());
            // A hanging load pulls back: a coefficient of the other sign does not count.
            if covariance > 0.0 && whole > 0.0 {
                covariance * covariance / whole
            } else {
                0.0
            }
        };
        self.pendulums.iter().map(share).fold(0.0, f64::max)
    }

    /// Ends a block at standstill; the load counts as still when the next swing begins.
    pub(super) fn rest(&mut self) {
        if core::mem::take(&mut self.ticks) == 0 {
            return;
        }
        for pendulum in &mut self.pendulums {
            (pendulum.ahead, pendulum.rate) = (0.0, 0.0);
        }
    }

    /// Resets for another content: a load that hung may be gone.
    pub(super) fn forget(&mut self) {
        if self.blocks > 0 || self.ticks > 0 {
            *self = Self::default();
        }
    }

    /// Returns whether a hanging load explains more than half of what a rigid load leaves.
    pub(super) fn hangs(&self) -> bool {
        self.hangs
    }
}

/// Adds the products of `x` with the terms.
fn add(sums: &mut [f64; RIGID], x: f64, terms: &[f64; RIGID]) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum += x * term;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sin_cos;

    /// Inertia without payload [kg m^2], and per kilogram of it [m^2].
    const EMPTY: f64 = 60e3;
    const PER_PAYLOAD: f64 = 50.0;

    /// Whether a load [kg] counts as hanging after two swings back and forth. It hangs on this rope \[m\], or is rigid where there is
    /// none. The torque arrives `late` [s].
    fn swings(payload: f64, rope: Option<f64>, late: f64) -> bool {
        let (mut sway, mut pendulum, mut velocity) =
            (Sway::default(), Pendulum::default(), 0.0_f64);
        let now = Inertia {
            empty: EMPTY,
            per_payload: PER_PAYLOAD,
            ..Inertia::default()
        };
        let period = 0.01;
        let drive = |t: f64| 30e3 * sin_cos(1.3 * t).0;
        let mut random = 0.3;
        for tick in 0..1000 {
            let time = f64::from(tick) * period;
            let friction = 3e3 * velocity.signum() + 5e3 * velocity;
            let inertia = EMPTY
                + if rope.is_some() {
                    0.0
                } else {
                    payload * PER_PAYLOAD
                };
            let pull = rope.map_or(0.0, |rope| {
                GRAVITY / rope * pendulum.ahead * payload * PER_PAYLOAD
            });
            let gained = (drive(time) - friction + pull) / inertia * period;
            velocity += gained;
            // The load retains 99.75 % of its rate over a tick, 95 % over a block.
            pendulum.ahead += period * pendulum.rate;
            let acceleration = -GRAVITY / rope.unwrap_or(1.0) * pendulum.ahead;
            pendulum.rate = 0.9975 * pendulum.rate + period * acceleration - gained;
            random = 3.99 * random * (1.0 - random);
            let torque = drive(time - late) + 2e3 * (random - 0.5);
            sway.push(torque, velocity, &now, period);
        }
        sway.hangs()
    }

    #[test]
    fn a_hanging_load_is_distinguished_from_a_rigid_one() {
        for rope in [0.7, 1.1, 2.0, 4.0] {
            assert!(swings(900.0, Some(rope), 0.0), "{rope} m");
        }
        for late in [0.0, 0.05] {
            assert!(!swings(900.0, None, late), "rigid, torque {late} s late");
        }
        assert!(!swings(0.0, Some(1.0), 0.0), "nothing on the hook");
    }

    #[test]
    fn what_was_learnt_goes_with_the_content() {
        let mut sway = Sway {
            hangs: true,
            blocks: 1,
            ..Sway::default()
        };
        sway.rest();
        assert!(sway.hangs());
        sway.forget();
        assert!(!sway.hangs());
    }
}

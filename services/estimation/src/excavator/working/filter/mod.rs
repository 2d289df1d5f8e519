//! Extended Kalman filter of the swing. Its states include every constant in which a described machine may differ.
//!
//! ```text
//! J w' = (1 + k) [T - l |T| th - T_f th + d - b w] - Jd w + g0 M (p cos psi - q sin psi)
//! J = J_e(q) + dJ_u + dm_b g_b(q) + e J_l(q) + (1 + k) m g(q),  th = tanh(w / width),  M = S + sum m_i r_i + (1 + k) m r_p + ...
//! measured velocity: y(t) = w(t - tau) = w - tau w'
//! ```
//!
//! | symbol | index | meaning | unit |
//! |---|---|---|---|
//! | w | [`W`] | swing velocity | rad/s |
//! | m | [`M`] | payload beyond what sticks in the bucket, over 1 + k | kg |
//! | d | [`OFFSET`] | offset of the measured torque | N m |
//! | b | [`DAMPING`] | viscous damping | N m s/rad |
//! | k | [`GAIN`] | true torque over the measured one, minus 1 | - |
//! | l | [`LOSS`] | share of the torque lost while driving, gained while braking | - |
//! | T_f | [`FRICTION`] | Coulomb friction | N m |
//! | p, q | [`SLOPE`], [`SLOPE`] + 1 | slope of the ground, sin(beta) times sine and cosine of its direction | - |
//! | S | [`MOMENT`] | first moment of the upper body | kg m |
//! | tau | [`DELAY`] | delay of the velocity behind the torque | s |
//! | dJ_u | [`UPPER`] | inertia of the upper body beyond the described one | kg m^2 |
//! | dm_b | [`BUCKET`] | mass of the bucket, with what sticks in it, beyond the described one | kg |
//! | e | [`LINKS`] | masses of boom and arm over the described ones, minus 1 | - |
//! | s, z, f, h | [`SPAN`], [`ZERO`], [`REST`], [`HELD`] | of the boom's moment: [`super::super::measurements::boom_moment`] | -, N, N, N |
//!
//! No motion identifies the common scale of torque and masses. Payload, friction, damping and offset are therefore over 1 + k: in units
//! of the measured torque. The unobservable direction of the states then does not depend on their values, so that linearisation adds no
//! information along it. In coordinates where that direction turns, it does (Huang, Mourikis, Roumeliotis 2010).
//!
//! All states but w and m are constants of the machine and its place. Only row W of the transition differs from the identity, in the
//! states before [`ACTING`]. A step therefore costs two passes over the covariance. It is stored by columns: the sums along its rows run
//! side by side, each in a fixed order. Covariances of the states from [`SEEN`] on with those before are stored in the columns of the
//! former only.
//!
//! [`prediction`], [`update`] and [`load`] hold what is done with them; this file holds state and covariance.

mod load;
mod prediction;
mod update;

pub(super) use self::prediction::Input;
pub(super) use super::states::*;
use super::trail::Trail;
use crate::mixture::mix;

/// State and covariance.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Filter {
    pub(super) x: Vector,
    /// Covariance by columns, symmetric to rounding. `p[i][j]` with i < [`SEEN`] <= j is not stored.
    pub(super) p: [Vector; N],
    /// Acceleration over the last step [rad/s^2].
    pub(super) acceleration: f64,
}

impl Filter {
    /// Starts with independent states.
    pub(super) fn new(x: Vector, std: &Vector) -> Self {
        let mut p = [[0.0; N]; N];
        for (i, std) in std.iter().enumerate() {
            p[i][i] = std * std;
        }
        Self {
            x,
            p,
            acceleration: 0.0,
        }
    }

    /// Covariances of all states with a linear combination of some.
    #[inline(always)]
    pub(super) fn along(&self, entries: impl Iterator<Item = (usize, f64)>) -> Vector {
        let mut sums = [0.0; N];
        for (j, entry) in entries {
            let covariances = self.with(j);
            for (sum, covariance) in sums.iter_mut().zip(covariances) {
                *sum += covariance * entry;
            }
        }
        sums
    }

    /// Whether the states from [`SEEN`] on are uncertain: they are where pressures weigh. Without a variance they have no covariances.
    #[inline(always)]
    fn weighs(&self) -> bool {
        (SEEN..N).any(|i| self.p[i][i] != 0.0)
    }

    /// Value and variance of a linear combination of few states.
    #[inline(always)]
    pub(super) fn combination<const K: usize>(&self, row: &[(usize, f64); K]) -> (f64, f64) {
        let (mut value, mut variance) = (0.0, 0.0);
        for (k, &(i, a)) in row.iter().enumerate() {
            value += a * self.x[i];
            let of = |j: usize| self.p[i.max(j)][i.min(j)];
            let beside: f64 = row[k + 1..].iter().map(|&(j, b)| b * of(j)).sum();
            variance += a * (a * self.p[i][i] + 2.0 * beside);
        }
        (value, variance.max(0.0))
    }

    /// Covariances of all states with state `i`.
    #[inline(always)]
    fn with(&self, i: usize) -> Vector {
        let mut covariances = self.p[i];
        if i < SEEN {
            for (covariance, column) in covariances[SEEN..].iter_mut().zip(&self.p[SEEN..]) {
                *covariance = column[i];
            }
        }
        covariances
    }

    /// Sets state `i` to a value with a variance, independent of all other states.
    pub(super) fn set(&mut self, i: usize, value: f64, variance: f64, trail: &mut Option<Trail>) {
        if let Some(trail) = trail {
            trail.set(i);
        }
        self.x[i] = value;
        for j in 0..N {
            self.p[i][j] = 0.0;
            self.p[j][i] = 0.0;
        }
        self.p[i][i] = variance;
    }

    /// Returns mean and covariance of the mixture with another filter of this probability.
    pub(super) fn mixed(mut self, other: &Self, probability: f64) -> Self {
        mix(&mut self.x, &mut self.p, (&other.x, &other.p), probability);
        self
    }

    /// Returns whether all states and variances are finite.
    pub(super) fn is_finite(&self) -> bool {
        // A covariance that is not finite reaches the states with the next motion; one of the pressures with their next moment.
        let variances: f64 = (0..N).map(|i| self.p[i][i]).sum();
        (self.sum() + variances).is_finite()
    }

    /// Returns whether the same holds, and no variance is negative.
    pub(super) fn is_sound(&self) -> bool {
        let (mut variances, mut least) = (0.0, 0.0);
        for i in 0..N {
            let variance = self.p[i][i];
            variances += variance;
            // One instruction; NaN shows in the sum.
            least = if least < variance { least } else { variance };
        }
        least == 0.0 && (self.sum() + variances).is_finite()
    }

    /// Sum of all states, two at a time.
    fn sum(&self) -> f64 {
        let pairs = self.x.as_chunks::<2>();
        let add = |[a, b]: [f64; 2], pair: &[f64; 2]| [a + pair[0], b + pair[1]];
        let [a, b] = pairs.0.iter().fold([0.0; 2], add);
        a + b + pairs.1.iter().sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::prediction::tests::swing;
    use super::*;

    #[test]
    fn covariances_that_are_not_stored_are_not_read() {
        let all: [(usize, f64); N] = core::array::from_fn(|i| (i, 1.0 - 0.1 * i as f64));
        let done = |not_kept: f64| {
            let mut filter = Filter::new([0.5; N], &[1.0; N]);
            for column in &mut filter.p[..SEEN] {
                column[SEEN..].fill(not_kept);
            }
            let other = Filter::new([0.4; N], &[0.9; N]);
            let input = Input {
                leaving: 0.1,
                ..swing()
            };
            filter.measure(all, 1.0, 2.0, 1e9, &mut None);
            filter.predict(&input, 0.01, 1000.0, &mut None);
            filter.correct(0.4, 0.1, 4.0, &mut None);
            filter.lag(0.1, &mut None);
            filter.weighs_true_mass(0.3, &mut None);
            filter.hold((1.0, 9.0), true, &mut None);
            filter.measure([(M, 1.0), (ZERO, 1.0)], 0.1, 1.0, 1e9, &mut None);
            filter.take_back((1.0, 9.0), true, &mut None);
            filter.fade(&other, 0.9, &[GAIN, ZERO]);
            filter.set(REST, 0.0, 1.0, &mut None);
            filter = filter.mixed(&other, 0.3);
            let along = filter.along(all.into_iter());
            let (value, variance) = filter.combination(&all);
            let own: f64 = all.iter().map(|(i, entry)| entry * along[*i]).sum();
            assert!((variance / own - 1.0).abs() < 1e-12);
            (filter.x, along, value)
        };
        assert_eq!(done(0.0), done(f64::NAN));
    }

    #[test]
    fn a_covariance_that_is_no_number_anywhere_shows_with_the_next_motion_and_moment_or_is_gone() {
        let input = swing();
        let moved = |i: usize, j: usize, covariance: f64| {
            let mut filter = Filter::new([1.0; N], &[1.0; N]);
            filter.p[i][j] = covariance;
            filter.predict(&input, 0.01, 1000.0, &mut None);
            filter.correct(1.0, 1.0, 1e3, &mut None);
            let pressures = [SPAN, ZERO, REST, HELD].map(|i| (i, 1.0));
            filter.measure(pressures, 0.0, 1.0, 1e3, &mut None);
            filter
        };
        for i in 0..N {
            let mut filter = Filter::new([1.0; N], &[1.0; N]);
            filter.p[i][i] = -1e-9;
            assert!(!filter.is_sound(), "a negative variance at {i}");
            for j in (0..N).filter(|j| *j != i && (i >= SEEN || *j < SEEN)) {
                assert!(moved(i, j, 0.1).is_sound());
                for none in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    let filter = moved(i, j, none);
                    let gone = filter.p.iter().flatten().all(|p| p.is_finite());
                    assert!(gone || !filter.is_sound(), "{none} at {i}, {j}");
                }
            }
        }
    }
}

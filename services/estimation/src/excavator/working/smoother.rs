//! Fixed-interval smoother of the default estimator (off line): adds the information of all later rows to an earlier estimate.
//!
//! Adjoint form of the Rauch-Tung-Striebel smoother (Bryson, Frazier 1963; Bierman 1977). The filter records its operations on state and
//! covariance in a trail. The smoother runs backwards along it, with `lambda` and `Lambda` zero at the end:
//! ```text
//! measurement h of innovation nu, variance S, gain K:   lambda <- (I - K h)' lambda - h' nu/S
//!                                                       Lambda <- (I - K h)' Lambda (I - K h) + h' h/S
//! transition F:                                         lambda <- F' lambda,  Lambda <- F' Lambda F
//! state of a tick:   x_s = x - P lambda,   P_s = P - P Lambda P
//! ```
//! Nothing is inverted, so states that are known exactly do no harm. A state that is reset is a transition with a row of zeros: later
//! rows carry no information about it before. The model is the filter's, linearised along the filter's path.

use super::super::geometry::Inertia;
use super::super::size::Sticking;
use super::filter::{Filter, N, Vector};
use super::trail::{Act, Trail};
use crate::excavator::state::State;
use crate::linear::dot;
use crate::math::sqrt;
use crate::{HALF_WIDTH_95, Quantity};

impl Trail {
    /// Records the estimate after the tick.
    pub(super) fn finish(&mut self, filter: &Filter, sticks: &Sticking, now: &Inertia) {
        self.payload = filter.payload(sticks);
        self.inertia = filter.inertia(now, filter.load());
        [self.own, self.variance] = filter.variances(now, sticks);
        self.covariance = filter.along(filter.payload_row(sticks).into_iter());
        self.along = filter.along(filter.inertia_row(now).into_iter());
    }

    /// Records the variance of the estimate beyond that of the filter with its disagreement, of all loads, and of the drawing.
    pub(super) fn doubts(&mut self, state: &State) {
        let left = |(value, std): (f64, f64), own: f64, variance: f64| {
            let apart = value - own;
            (std * std + apart * apart - variance).max(0.0)
        };
        let payload = state.payload.unwrap_or_default();
        let weighed = self.own * self.disagreement + self.loads.variance(payload.0);
        let drawn = self.variance * self.disagreement + self.form * self.form;
        self.beside = [
            left(payload, self.payload, weighed),
            left((state.inertia, state.inertia_std), self.inertia, drawn),
        ];
        self.unsettled = state.unsettled;
    }
}

/// Smoothed estimate of an earlier time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Smoothed {
    /// Payload and standard deviation \[kg\].
    pub payload: Quantity,
    /// Inertia and standard deviation [kg m^2].
    pub inertia: Quantity,
    /// The estimate is not trusted, whatever its interval.
    pub unsettled: bool,
}

impl Smoothed {
    /// Returns whether the inertia is trusted where motion and inputs permit: half of its 95 % interval is narrower than this share of
    /// it.
    pub fn converged(&self, share: f64) -> bool {
        let Quantity { value, std } = self.inertia;
        !self.unsettled && HALF_WIDTH_95 * std < share * value
    }
}

/// Smoother that runs backwards along a trail.
#[derive(Debug, Clone)]
pub struct Smoother {
    lambda: Vector,
    curvature: [Vector; N],
    disagreement: f64,
}

impl Default for Smoother {
    fn default() -> Self {
        Self {
            lambda: [0.0; N],
            curvature: [[0.0; N]; N],
            disagreement: 1.0,
        }
    }
}

impl Smoother {
    /// Processes the tick before those already processed, and returns its estimate by all rows.
    pub fn back(&mut self, trail: &Trail) -> Smoothed {
        let smoothed = self.state(trail);
        for act in trail.acts[..trail.count].iter().rev().flatten() {
            match act {
                Act::Row(i, row) => self.transition(*i, row),
                Act::Faded(states, remaining) => self.fade(states, *remaining),
                Act::Measured {
                    row,
                    gain,
                    value,
                    variance,
                } => self.measurement(row, gain, *value, *variance),
            }
        }
        if trail.anew || trail.contradicted {
            // A contradiction carries no information about earlier rows, except that the filter was too certain.
            let disagreement = if trail.anew { 1.0 } else { self.disagreement };
            *self = Self {
                disagreement,
                ..Self::default()
            };
        }
        smoothed
    }

    fn state(&mut self, trail: &Trail) -> Smoothed {
        let (shift, known) = self.information(&trail.covariance);
        let [least, most] = trail.range;
        let payload = (trail.payload - shift).clamp(least, most);
        self.disagreement = self.disagreement.max(trail.disagreement);
        let left = |own: f64, known: f64| (own - known).clamp(0.0, own.max(0.0));
        let (moved, identified) = self.information(&trail.along);
        let variance = left(trail.variance, identified) * self.disagreement;
        Smoothed {
            payload: Quantity {
                value: payload,
                std: sqrt(
                    left(trail.own, known) * self.disagreement
                        + trail.loads.variance(payload)
                        + trail.beside[0],
                ),
            },
            inertia: Quantity {
                value: trail.inertia - moved,
                std: sqrt(variance + trail.form * trail.form + trail.beside[1]),
            },
            unsettled: trail.unsettled,
        }
    }

    /// Information of later rows about a quantity with this covariance: its shift, and the variance that they remove.
    fn information(&self, c: &Vector) -> (f64, f64) {
        let mut taken = 0.0;
        for (ci, line) in c.iter().zip(&self.curvature) {
            taken += ci * dot(line, c);
        }
        (dot(c, &self.lambda), taken)
    }

    /// Reverses a transition x_i = row x.
    fn transition(&mut self, i: usize, row: &Vector) {
        let own = self.lambda[i];
        self.lambda[i] = 0.0;
        for (l, r) in self.lambda.iter_mut().zip(row) {
            *l += r * own;
        }
        // F' Lambda F, where F is the identity except in row i.
        let line = self.curvature[i];
        let corner = line[i];
        for j in 0..N {
            self.curvature[i][j] = 0.0;
            self.curvature[j][i] = 0.0;
        }
        let mut others = line;
        others[i] = 0.0;
        for j in 0..N {
            for k in 0..N {
                self.curvature[j][k] +=
                    row[j] * others[k] + others[j] * row[k] + row[j] * corner * row[k];
            }
        }
    }

    /// Reverses the fading of these states.
    fn fade(&mut self, states: &[usize], remaining: f64) {
        for &i in states {
            self.lambda[i] *= remaining;
            for j in 0..N {
                self.curvature[i][j] *= remaining;
                self.curvature[j][i] *= remaining;
            }
        }
    }

    /// Reverses a measurement.
    fn measurement(&mut self, row: &Vector, gain: &Vector, value: f64, variance: f64) {
        let share = dot(gain, &self.lambda) + value / variance;
        let mut across = [0.0; N];
        for (a, line) in across.iter_mut().zip(&self.curvature) {
            *a = dot(line, gain);
        }
        let square = dot(&across, gain) + 1.0 / variance;
        for j in 0..N {
            self.lambda[j] -= row[j] * share;
            for k in 0..N {
                self.curvature[j][k] +=
                    row[j] * square * row[k] - across[j] * row[k] - row[j] * across[k];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excavator::working::filter::{M, OFFSET, W};

    #[test]
    fn a_constant_that_was_measured_twice_is_the_same_at_both_times() {
        let mut std = [0.0; N];
        std[M] = 100.0;
        let mut filter = Filter::new([0.0; N], &std);
        let trails = [50.0, 80.0].map(|value| {
            let mut trail = Some(Trail {
                range: [-1e9, 1e9],
                ..Trail::NOTHING
            });
            let innovation = value - filter.x[M];
            filter.measure([(M, 1.0)], innovation, 100.0, 1e9, &mut trail);
            let mut trail = trail.expect("a trail");
            trail.finish(&filter, &Sticking::default(), &Inertia::default());
            trail
        });
        let mut smoother = Smoother::default();
        let last = smoother.back(&trails[1]).payload;
        let first = smoother.back(&trails[0]).payload;
        assert!((first.value - filter.x[M]).abs() < 1e-9);
        assert!((last.value - first.value).abs() < 1e-9 && (last.std - first.std).abs() < 1e-9);
        assert!((first.std * first.std - filter.p[M][M]).abs() < 1e-9);
    }

    #[test]
    fn rows_after_a_new_load_do_not_inform_the_old_one() {
        let mut std = [0.0; N];
        (std[M], std[OFFSET], std[W]) = (100.0, 10.0, 1.0);
        let mut filter = Filter::new([0.0; N], &std);
        let mut before = Trail::NOTHING;
        before.range = [-1e9, 1e9];
        before.finish(&filter, &Sticking::default(), &Inertia::default());
        let mut after = Some(before);
        filter.set(M, 0.0, 1e4, &mut after);
        filter.measure([(M, 1.0)], 300.0, 1.0, 1e9, &mut after);
        let mut after = after.expect("a trail");
        after.finish(&filter, &Sticking::default(), &Inertia::default());
        let mut smoother = Smoother::default();
        assert!(smoother.back(&after).payload.value > 290.0);
        let old = smoother.back(&before).payload;
        assert!(old.value.abs() < 1e-9 && (old.std - 100.0).abs() < 1e-9);
    }
}

//! Belief as a covariance, propagated by the model's tangent.

#![allow(clippy::needless_range_loop)] // indices as in the formulas

use super::Belief;
use crate::ekf::{Ekf, Expected, carry, combine};
use crate::loader::layout::{Layout, SPEED};
use crate::loader::physics::cg_model::CgModel;
use crate::loader::physics::tangent::Tangent;
use crate::loader::physics::wheel_dynamics::Road;
use crate::sigma_points::Spread;
use crate::srukf::SquareRootUkf;

/// A measurement as a function of the speed after the step and of two states before it, to first order.
struct Made {
    /// Gain of the new speed's noise in it, as in [`CgModel`]. A late speed contains the noise of an earlier step, of equal size,
    /// and not 1 - tau/dt times that of this one.
    noise: f64,
    new_speed: f64,
    old: [(usize, f64); 2],
}

impl Made {
    /// Measurement j: the late speed v+ - tau (v+ - v)/dt, or the specific force (v+ - v)/dt + g sin th; the others are states.
    #[inline(always)]
    fn of<const N: usize>(
        j: usize,
        dt: f64,
        rate: f64,
        delay: f64,
        (road, gravity): (&Road<f64>, f64),
    ) -> Option<Self> {
        match (j, const { Layout::of(N) }.speed_delay) {
            (SPEED, Some(late)) => Some(Self {
                noise: 1.0,
                new_speed: 1.0 - delay / dt,
                old: [(SPEED, delay / dt), (late, -rate)],
            }),
            (3, _) => Some(Self {
                noise: 1.0 / dt,
                new_speed: 1.0 / dt,
                old: [
                    (SPEED, -1.0 / dt),
                    Layout::of(N)
                        .slope_bias
                        .map_or((SPEED, 0.0), |bias| (bias, -gravity * road.cosine)),
                ],
            }),
            _ => None,
        }
    }

    /// Its covariance with another quantity, from those of the new speed and of the old states.
    #[inline(always)]
    fn of_columns(&self, new_speed: f64, old: impl Fn(usize) -> f64) -> f64 {
        let [(first, by_first), (second, by_second)] = self.old;
        self.new_speed * new_speed + by_first * old(first) + by_second * old(second)
    }
}

/// The model's step at the state.
pub(in crate::loader) struct Step<const N: usize> {
    state: [f64; N],
    tangent: Tangent<N>,
    road: Road<f64>,
}

impl<const N: usize, const M: usize> Belief<N, M> for Ekf<N, M> {
    type Ahead = Step<N>;
    type Expected = Expected<N, M>;

    fn new(state: [f64; N], std: &[f64; N], _: Spread) -> Self {
        Self::new(state, std)
    }

    fn state(&self) -> &[f64; N] {
        &self.state
    }

    fn state_mut(&mut self) -> &mut [f64; N] {
        &mut self.state
    }

    fn variance(&self, i: usize) -> f64 {
        self.covariance[i][i]
    }

    fn is_sound(&self) -> bool {
        // An entry beside the diagonal that is not finite reaches the state with the next row.
        let (mut sum, mut positive) = (0.0, true);
        for i in 0..N {
            sum += self.state[i] + self.covariance[i][i];
            positive &= self.covariance[i][i] > 0.0;
        }
        positive && sum.is_finite()
    }

    fn separate(&mut self, states: &[(usize, f64)], process_std: &[f64; N]) {
        for i in 0..N {
            self.covariance[i][i] += process_std[i] * process_std[i];
        }
        for &(i, std) in states {
            self.covariance[i] = [0.0; N];
            for row in &mut self.covariance {
                row[i] = 0.0;
            }
            self.covariance[i][i] = std * std;
        }
    }

    #[inline(always)]
    fn ahead(&self, model: &CgModel) -> Self::Ahead {
        let (tangent, road) = model.tangent(&self.state);
        let mut state = self.state;
        tangent.motion.put(&mut state);
        Step {
            state,
            tangent,
            road,
        }
    }

    fn state_ahead(ahead: &Self::Ahead) -> &[f64; N] {
        &ahead.state
    }

    /// As [`Ekf::predict`], with the block structure of the loader: three states that move, and measurements that follow from them.
    #[inline(always)]
    fn predict(
        &mut self,
        ahead: &mut Self::Ahead,
        model: &CgModel,
        process_std: &[f64; N],
    ) -> Self::Expected {
        let by = &ahead.tangent.by;
        let p = &mut self.covariance;
        let moved = [combine(&by[0], p), combine(&by[1], p), combine(&by[2], p)];
        let rate = (ahead.state[SPEED] - self.state[SPEED]) / model.dt;
        let delay = const { Layout::of(N) }
            .speed_delay
            .map_or(0.0, |i| self.state[i]);
        let ground = (&ahead.road, model.dynamics.gravity);
        let made = |j: usize| Made::of::<N>(j, model.dt, rate, delay, ground);
        let mut expected = Expected {
            measurement: [0.0; M],
            cross: [[0.0; N]; M],
            own: [[0.0; M]; M],
        };
        for j in 0..M {
            let Some(made) = made(j) else { continue };
            for c in 0..N {
                expected.cross[j][c] = made.of_columns(moved[SPEED][c], |i| p[i][c]);
            }
            expected.measurement[j] = match j {
                SPEED => ahead.state[SPEED] - rate * delay,
                _ => rate + ahead.road.sine * model.dynamics.gravity,
            };
        }
        carry(p, &moved, by);
        for j in 0..M {
            let Some(first) = made(j) else { continue };
            let before = expected.cross[j];
            for k in 0..3 {
                expected.cross[j][k] = first.of_columns(p[SPEED][k], |i| moved[k][i]);
            }
            for l in 0..=j {
                let Some(second) = made(l) else { continue };
                let own = second.of_columns(expected.cross[j][SPEED], |i| before[i]);
                expected.own[j][l] = own;
                expected.own[l][j] = own;
            }
        }
        let noise = process_std[SPEED] * process_std[SPEED];
        for j in 0..M {
            let Some(first) = made(j) else { continue };
            expected.cross[j][SPEED] += first.noise * noise;
            for l in 0..M {
                let Some(second) = made(l) else { continue };
                expected.own[j][l] += first.noise * second.noise * noise;
            }
        }
        self.state = ahead.state;
        self.complete(&mut expected, process_std, Layout::of(N).direct());
        expected
    }

    fn measurement(expected: &Self::Expected) -> &[f64; M] {
        &expected.measurement
    }

    fn measurement_std(expected: &Self::Expected, j: usize) -> f64 {
        expected.measurement_std(j)
    }

    fn difference_variance(expected: &Self::Expected, [a, b]: [usize; 2]) -> f64 {
        expected.own[a][a] + expected.own[b][b] - 2.0 * expected.own[a][b]
    }

    #[inline(always)]
    fn update(
        &mut self,
        expected: &mut Self::Expected,
        innovation: &[f64; M],
        std: &[f64; M],
        accepted: &[bool; M],
    ) -> f64 {
        Ekf::update(
            self,
            expected,
            innovation,
            std,
            accepted,
            Layout::of(N).direct(),
        )
    }

    fn sigma_points(&mut self) -> Option<&mut SquareRootUkf<N, M>> {
        None
    }
}

//! The estimator's model of the loader: states, measurements, and the known payload.
//!
//! | states | x | filter |
//! |---|---|---|
//! | 6 | v, w_f, w_r, K, h, lam | the paper, (15)-(17) |
//! | 8 | .., d_f, d_r | no accelerometer |
//! | 10 | .., F_x, d_f, d_r, b | a calibrated machine |
//! | 9 | those of 8, tau | no accelerometer; the speed is late |
//! | 12 | those of 10, e, tau | recommended: the load sensitivity of the radii differs from the stated one |
//!
//! Measurements are v, w_f, w_r and, with four, the specific force a_x = (v+ - v)/dt + g sin th along the body axis. A late speed
//! is measured as v - tau dv/dt: satellite receivers and radars filter, and at 1 m/s^2 a delay of 30 ms is twice the slip speed.
//!
//! The load that an acceleration moves changes the radii in proportion to the acceleration, as it does the slips that determine the
//! ratio. Driving forward, e and lam are not distinguishable. Driving backward, the slips change their sign relative to the
//! acceleration and the radii do not: then both are observable. With e as a state, the covariance of both is right.
//!
//! Parameters are random walks. (15) names L the measurement matrix (it is the noise input) and v_k process noise (it is the
//! measurement noise); (17) rewrites (15), not (12).

use core::ops::Range;

use super::tangent::Tangent;
use super::wheel_dynamics::{Inputs, Motion, Parameters, Road, WheelDynamics};
use crate::loader::layout::{CG_HEIGHT, CG_RATIO, Layout, REAR_WHEEL, SPEED};
use crate::math::sin_cos;
use crate::model::Model;
use crate::scalar::Scalar;

/// Loaded centre of gravity as a function of the empty machine's: h = share h_0 + `height`, lam = share lam_0 + `ratio`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Loading {
    /// Empty mass over total mass.
    pub share: f64,
    /// The payload's part of the height \[m\].
    pub height: f64,
    /// The payload's part of the ratio.
    pub ratio: f64,
}

impl Loading {
    /// No known payload: the states are the loaded machine's.
    pub const NONE: Self = Self {
        share: 1.0,
        height: 0.0,
        ratio: 0.0,
    };
}

/// One step of the loader under given inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CgModel {
    /// The machine, its mass that of this step.
    pub dynamics: WheelDynamics,
    /// Inputs of the step.
    pub inputs: Inputs,
    /// Length of the step \[s\].
    pub dt: f64,
    /// Number of substeps.
    pub substeps: u32,
    /// Known payload.
    pub loading: Loading,
}

impl CgModel {
    /// Parameters of a state, the payload included.
    #[inline(always)]
    fn parameters<T: Scalar, const N: usize>(&self, state: &[T; N]) -> Parameters<T> {
        let Loading {
            share,
            height,
            ratio,
        } = self.loading;
        let parameters = Parameters::of(state);
        Parameters {
            cg_height: parameters.cg_height * share + height,
            cg_ratio: parameters.cg_ratio * share + ratio,
            ..parameters
        }
    }

    /// Motion one step later, and the road.
    #[inline(always)]
    fn advance<T: Scalar, const N: usize>(&self, state: &[T; N]) -> (Motion<T>, Road<T>) {
        let (old, parameters) = (Motion::of(state), self.parameters(state));
        let road = Road::of(-parameters.slope_bias + self.inputs.slope);
        let new = self.dynamics.substeps(
            &old,
            &parameters,
            &self.inputs,
            &road,
            self.dt,
            self.substeps,
        );
        (new, road)
    }

    /// The same, with its derivatives by the state.
    pub(in crate::loader) fn tangent<const N: usize>(
        &self,
        state: &[f64; N],
    ) -> (Tangent<N>, Road<f64>) {
        let parameters = self.parameters(state);
        let (sine, cosine) = sin_cos(self.inputs.slope - parameters.slope_bias);
        let road = Road { sine, cosine };
        let part = self.dt / f64::from(self.substeps);
        let step = |motion| {
            self.dynamics
                .step_tangent(&motion, &parameters, &self.inputs, &road, part)
        };
        let mut tangent: Tangent<N> = step(Motion::of(state));
        for _ in 1..self.substeps {
            tangent = tangent.then(&step(tangent.motion));
        }
        for row in &mut tangent.by {
            row[CG_HEIGHT] *= self.loading.share;
            row[CG_RATIO] *= self.loading.share;
        }
        (tangent, road)
    }
}

impl<const N: usize, const M: usize> Model<N, M> for CgModel {
    const DYNAMIC: usize = 3;
    const DIRECT: Range<usize> = Layout::of(N).direct();
    const PASSIVE: usize = match Layout::of(N).speed_delay {
        Some(delay) => delay,
        None => N,
    };

    // Inlined: values common to all sigma points are computed once.
    #[inline(always)]
    fn predict<T: Scalar>(&self, state: &[T; N]) -> ([T; N], [T; M]) {
        let (old, (new, road)) = (Motion::of(state), self.advance(state));
        let mut next = *state;
        new.put(&mut next);
        let rate = (new.speed - old.speed) / self.dt;
        let measurement =
            core::array::from_fn(|j| match (j, const { Layout::of(N) }.speed_delay) {
                (SPEED, Some(delay)) => next[SPEED] - rate * state[delay],
                (SPEED..=REAR_WHEEL, _) => next[j],
                _ => rate + road.sine * self.dynamics.gravity,
            });
        (next, measurement)
    }

    /// The delay of the speed does not affect the motion.
    fn measure<T: Scalar>(
        &self,
        state: &[T; N],
        center: &([f64; N], [f64; M]),
    ) -> ([T; N], [T; M]) {
        let (next, mut measurement) = (center.0.map(T::constant), center.1.map(T::constant));
        if let Some(delay) = const { Layout::of(N) }.speed_delay {
            let rate = (next[SPEED] - state[SPEED]) / self.dt;
            measurement[SPEED] = next[SPEED] - rate * state[delay];
        }
        (next, measurement)
    }

    /// The speed noise of the step acts on the specific force as q_v/dt. A measurement of a state contains the noise of that state,
    /// and so does that of a late speed. Its noise is some steps old, and the rate v' of its tau v' is that of the machine, not of
    /// one step's noise.
    fn noise_coupling(&self) -> [[f64; N]; M] {
        let mut coupling = [[0.0; N]; M];
        for (j, row) in coupling.iter_mut().enumerate().take(3) {
            row[j] = 1.0;
        }
        for row in coupling.iter_mut().skip(3) {
            row[SPEED] = 1.0 / self.dt;
        }
        coupling
    }
}

//! Consider covariance (Schmidt 1966): the error of an estimate due to parameters that the filter holds fixed.
//!
//! An error of a fixed parameter causes an error of the estimate that the filter's covariance does not contain. The error e due to a
//! parameter error of one standard deviation follows the filter's own equations,
//!
//! ```text
//! prediction: e = F e + G,   correction: e = (I - K H) e
//! ```
//!
//! and its square is added to the reported variance. The estimate itself is unchanged.

use super::settings::{Settings, Variant};
use nalgebra::{SMatrix, SVector};

/// Standard deviations of the parameters that are held fixed; 0 for a calibrated or estimated one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Doubt {
    /// Viscous damping [N m s/rad].
    pub(super) damping: f64,
    /// Constant torque, beyond the part that the filter itself allows for [N m].
    pub(super) offset: f64,
    /// Gain of the torque measurement.
    pub(super) gain: f64,
}

impl Doubt {
    /// For the modes that hold damping and offset fixed.
    pub(super) fn new(settings: &Settings) -> Self {
        let p = &settings.prior;
        let gain = settings.sensors.swing_torque_gain_std;
        if settings.estimator.variant == Variant::Known {
            return Self {
                damping: 0.0,
                offset: 0.0,
                gain,
            };
        }
        let (all, allowed) = (p.torque_offset_std, p.known_torque_offset_std);
        Self {
            damping: p.damping_std,
            offset: crate::math::sqrt((all * all - allowed * allowed).max(0.0)),
            gain,
        }
    }
}

/// Errors of a state of `N` due to one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Consider<const N: usize> {
    error: SVector<f64, N>,
    active: bool,
}

impl<const N: usize> Consider<N> {
    /// An error of `std` in the constant state `i`.
    pub(super) fn state(i: usize, std: f64) -> Self {
        let mut error = SVector::zeros();
        error[i] = std;
        Self {
            error,
            active: std > 0.0,
        }
    }

    /// An error that enters through [`Self::predict`], due to a parameter with this standard deviation.
    pub(super) fn input(std: f64) -> Self {
        Self {
            error: SVector::zeros(),
            active: std > 0.0,
        }
    }

    /// Propagates the error over one step; `input` (G) enters state 0.
    #[expect(non_snake_case, reason = "the symbol of the model")]
    pub(super) fn predict(&mut self, F: &SMatrix<f64, N, N>, input: f64) {
        if self.active {
            self.error = F * self.error;
            self.error[0] += input;
        }
    }

    /// Corrects the error with the filter's gain; `row` is the measurement row H.
    pub(super) fn correct(&mut self, gain: &SVector<f64, N>, row: &SVector<f64, N>) {
        if self.active {
            self.error -= gain * row.dot(&self.error);
        }
    }

    /// Replaces the error of state `i`, which has become known or unknown for other reasons.
    pub(super) fn set(&mut self, i: usize, error: f64) {
        self.error[i] = error;
    }

    /// Error of state `i`, with its sign.
    pub(super) fn of(&self, i: usize) -> f64 {
        self.error[i]
    }
}

//! Operations of the filter in each tick, recorded for the smoother.

use super::states::{N, Vector};
use crate::CommonError;

/// Largest number of operations in a tick. The longest stand is that in which boom pressures begin: content over and unknown; span, zero,
/// rest, held and gain reset; two inclinations; standing. The longest motion: the step, what leaves the bucket, velocity, tare, an
/// attachment, rest and moment of the boom, constants that fade.
const MOST: usize = 12;

/// Operation of the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Act {
    /// State `i` became `row x`.
    Row(usize, Vector),
    /// These states faded; this share of their deviation remained.
    Faded(&'static [usize], f64),
    /// A measurement of `row x` with gain, innovation and variance.
    Measured {
        row: Vector,
        gain: Vector,
        value: f64,
        variance: f64,
    },
}

/// Operations of the filter in one tick, and its estimate after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trail {
    pub(super) acts: [Option<Act>; MOST],
    pub(super) count: usize,
    /// Payload [kg], its variance, and its covariance with the states.
    pub(super) payload: f64,
    pub(super) own: f64,
    pub(super) covariance: Vector,
    /// Inertia [kg m^2], its covariance with the states, and its variance.
    pub(super) inertia: f64,
    pub(super) along: Vector,
    pub(super) variance: f64,
    /// The filter has restarted: it holds no information from before.
    pub(super) anew: bool,
    /// Swings or constants contradict the description.
    pub(super) contradicted: bool,
    /// The estimate is not trusted, whatever its interval.
    pub(super) unsettled: bool,
    /// Variances of the estimate beside those of the filter, about the filter's payload and inertia [kg^2], [kg^2 m^4].
    pub(super) beside: [f64; 2],
    /// Smallest and largest payload [kg].
    pub(super) range: [f64; 2],
    /// Standard deviation of the inertia by errors of the drawing [kg m^2].
    pub(super) form: f64,
    /// Errors common to all loads.
    pub(super) loads: CommonError,
    /// Factor of the variances: disagreement of the swings' stretches, times the doubt of the description.
    pub(super) disagreement: f64,
}

impl Trail {
    /// Without any operation.
    pub(super) const NOTHING: Self = Self {
        acts: [None; MOST],
        count: 0,
        payload: 0.0,
        own: 0.0,
        covariance: [0.0; N],
        inertia: 0.0,
        along: [0.0; N],
        variance: 0.0,
        anew: false,
        contradicted: false,
        unsettled: false,
        beside: [0.0; 2],
        range: [0.0; 2],
        form: 0.0,
        loads: CommonError {
            scale_std: 0.0,
            zero_std: 0.0,
        },
        disagreement: 1.0,
    };

    fn push(&mut self, act: Act) {
        debug_assert!(
            self.count < MOST,
            "a tick that does more than a trail holds"
        );
        if let Some(free) = self.acts.get_mut(self.count) {
            *free = Some(act);
            self.count += 1;
        }
    }

    /// Records that these states fade.
    pub(super) fn fade(&mut self, states: &'static [usize], remaining: f64) {
        self.push(Act::Faded(states, remaining));
    }

    /// Records that state `i` is reset, independent of all.
    pub(super) fn set(&mut self, i: usize) {
        self.push(Act::Row(i, [0.0; N]));
    }

    /// Records that state `i` becomes `row x`.
    pub(super) fn row(&mut self, i: usize, row: &Vector) {
        self.push(Act::Row(i, *row));
    }

    /// Records a measurement.
    pub(super) fn measured(&mut self, row: &Vector, gain: &Vector, value: f64, variance: f64) {
        self.push(Act::Measured {
            row: *row,
            gain: *gain,
            value,
            variance,
        });
    }
}

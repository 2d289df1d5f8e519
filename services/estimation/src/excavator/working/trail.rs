//! What the filter did in each tick, left for the smoother.

use super::states::{N, Vector};
use crate::CommonError;

/// Most that a tick does. The longest stand in which boom pressures begin: content over and unknown, span, zero, rest, held and gain anew,
/// two inclinations, standing. One in motion: the step, what leaves the bucket, velocity, tare, an attachment, rest and moment of the boom,
/// constants that fade.
const MOST: usize = 12;

/// One thing that the filter did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Act {
    /// State `i` became `row x`.
    Row(usize, Vector),
    /// This share of what was told of these states is kept.
    Faded(&'static [usize], f64),
    /// A measurement of `row x` with its gain, innovation and variance.
    Measured {
        row: Vector,
        gain: Vector,
        value: f64,
        variance: f64,
    },
}

/// What the filter did in one tick, and what it knew of the payload after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trail {
    pub(super) acts: [Option<Act>; MOST],
    pub(super) count: usize,
    /// Payload, its variance, and its covariance with the states.
    pub(super) payload: f64,
    pub(super) own: f64,
    pub(super) covariance: Vector,
    /// Inertia, its covariance with the states, and its variance.
    pub(super) inertia: f64,
    pub(super) along: Vector,
    pub(super) variance: f64,
    /// The filter is a new one: of what was before it knows nothing.
    pub(super) anew: bool,
    /// Swings or constants contradict the description.
    pub(super) contradicted: bool,
    /// The estimate may not be believed, whatever its interval.
    pub(super) unsettled: bool,
    /// Variance of the estimate beside the filter's, about the filter's payload and inertia [kg^2], [kg^2 m^4].
    pub(super) beside: [f64; 2],
    /// Smallest and largest payload.
    pub(super) range: [f64; 2],
    /// Standard deviation of what the drawing misses of the inertia [kg m^2].
    pub(super) form: f64,
    /// What all loads are off together.
    pub(super) loads: CommonError,
    /// Factor of the variance by which stretches of the swings disagree.
    pub(super) disagreement: f64,
}

impl Trail {
    /// Nothing done.
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

    /// What was told of these states fades.
    pub(super) fn fade(&mut self, states: &'static [usize], kept: f64) {
        self.push(Act::Faded(states, kept));
    }

    /// State `i` is a new one, independent of all.
    pub(super) fn set(&mut self, i: usize) {
        self.push(Act::Row(i, [0.0; N]));
    }

    /// State `i` becomes this product.
    pub(super) fn row(&mut self, i: usize, row: &Vector) {
        self.push(Act::Row(i, *row));
    }

    /// A measurement.
    pub(super) fn measured(&mut self, row: &Vector, gain: &Vector, value: f64, variance: f64) {
        self.push(Act::Measured {
            row: *row,
            gain: *gain,
            value,
            variance,
        });
    }
}

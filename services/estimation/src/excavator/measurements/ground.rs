//! May the ground carry part of the bucket?
//!
//! Nobody measures the ground. But a bucket gets there only by going down, by the arm that pulls it in or by closing, while the
//! upper body stands; and it is free again when it has risen from its lowest place, or when the machine swings.

use crate::math::sin_cos;

/// Time constant of the smoothed angles from which rates are taken [s].
const SMOOTHING: f64 = 0.1;
/// Rates from which on a bucket goes down [lengths of boom and arm/s], and arm and bucket dig [rad/s].
const DOWN: f64 = 0.006;
const DIGGING: [f64; 2] = [0.08, 0.12];
/// An arm that digs pulls the bucket in so many times as fast as it rises.
const PULLING: f64 = 2.0;
/// So far above its lowest place the bucket is free [lengths of boom and arm].
const RAISED: f64 = 0.035;
/// Swinging so fast for so long frees it too [rad/s, s].
const SWINGING: f64 = 0.08;
const SWUNG: f64 = 0.15;

/// Follows the bucket.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Ground {
    touches: bool,
    digs: bool,
    smoothed: Option<[f64; 3]>,
    height: f64,
    lowest: f64,
    swung: f64,
}

impl Ground {
    /// At the start it may lie anywhere.
    pub(in crate::excavator) fn new() -> Self {
        Self {
            touches: true,
            digs: true,
            smoothed: None,
            height: 0.0,
            lowest: f64::INFINITY,
            swung: 0.0,
        }
    }

    /// One tick: joint angles [rad], lengths of boom and arm [m], swing velocity [rad/s].
    pub(in crate::excavator) fn step(
        &mut self,
        posture: [f64; 3],
        lengths: [f64; 2],
        velocity: f64,
        period: f64,
    ) {
        let before = self.smoothed.unwrap_or(posture);
        let share = period / (SMOOTHING + period);
        let now: [f64; 3] = core::array::from_fn(|i| before[i] + share * (posture[i] - before[i]));
        self.smoothed = Some(now);
        let reach = lengths[0] + lengths[1];
        let height = lengths[0] * sin_cos(now[0]).0 + lengths[1] * sin_cos(now[0] + now[1]).0;
        let rise = (height - self.height) / period;
        self.height = height;
        self.swung = if velocity.abs() > SWINGING {
            self.swung + period
        } else {
            0.0
        };
        if self.swung > SWUNG {
            self.free();
            return;
        }
        let rates = [1, 2].map(|i| (posture[i] - now[i]) / SMOOTHING);
        // Who lifts pulls the arm in as well, but not so fast.
        let pulls = -rates[0] > DIGGING[0] && -rates[0] * lengths[1] > PULLING * rise;
        let digs = pulls || rates[1] < -DIGGING[1];
        if self.swung == 0.0 && (rise < -DOWN * reach || digs) {
            self.touches = true;
        }
        self.digs |= digs && self.touches;
        self.lowest = self.lowest.min(height);
        if !self.touches || height > self.lowest + RAISED * reach {
            self.free();
        }
    }

    fn free(&mut self) {
        self.touches = false;
        self.digs = false;
        self.lowest = f64::INFINITY;
    }

    /// The bucket has opened: what it did before fills it no more.
    pub(in crate::excavator) fn opens(&mut self) {
        self.digs = false;
    }

    /// The bucket may be filling.
    pub(in crate::excavator) fn digs(&self) -> bool {
        self.digs
    }

    /// It may.
    pub(in crate::excavator) fn may_touch(&self) -> bool {
        self.touches
    }
}

//! Delay line between change detector and estimator (modes C and A).
//!
//! The detector finds a change of torque 0.1 to 0.15 s late. The estimator therefore runs 15 ticks late, and the
//! flag of a change covers the ticks from 15 before its detection to 25 after.

use crate::excavator::drive::Drive;
use crate::excavator::standstill::Phase;

/// Ticks by which the estimator is late (0.15 s).
pub(in crate::excavator) const LATE: usize = 15;
/// Ticks that stay flagged after a detection (0.25 s).
const AFTER: u32 = 25;

/// Entry of the line: the part of a drive that is delayed with the velocity and independent of the torque.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Entry {
    pub(in crate::excavator) period: f64,
    /// Gated velocity and its variance.
    pub(in crate::excavator) velocity: Option<f64>,
    pub(in crate::excavator) variance: f64,
    /// Mean inertia over the step and its rate, each without payload and per kilogram of it.
    pub(in crate::excavator) mean: [f64; 2],
    pub(in crate::excavator) rate: [f64; 2],
    pub(in crate::excavator) phase: Phase,
    pub(in crate::excavator) reopen: bool,
    pub(in crate::excavator) flagged: bool,
}

impl Entry {
    pub(in crate::excavator) fn new(drive: &Drive, phase: Phase, reopen: bool) -> Self {
        Self {
            period: drive.period,
            velocity: drive.velocity,
            variance: drive.variance,
            mean: [drive.mean.empty, drive.mean.per_payload],
            rate: [drive.rate.empty, drive.rate.per_payload],
            phase,
            reopen,
            flagged: false,
        }
    }
}

/// The delay line.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct DelayLine {
    ring: [Entry; LATE + 1],
    count: usize,
    flag_left: u32,
}

impl DelayLine {
    pub(in crate::excavator) fn new() -> Self {
        Self {
            ring: [Entry::default(); LATE + 1],
            count: 0,
            flag_left: 0,
        }
    }

    /// Stores a tick. Returns the oldest one, once the line is full.
    pub(in crate::excavator) fn push(&mut self, mut entry: Entry, event: bool) -> Option<Entry> {
        if event {
            self.ring.iter_mut().for_each(|e| e.flagged = true);
            self.flag_left = AFTER + 1;
        }
        entry.flagged = self.flag_left > 0;
        self.flag_left = self.flag_left.saturating_sub(1);
        let n = self.ring.len();
        self.ring[self.count % n] = entry;
        self.count += 1;
        (self.count >= n).then(|| self.ring[self.count % n])
    }
}

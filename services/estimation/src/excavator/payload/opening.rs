//! Detects an opening bucket by its angle relative to the arm, before the material moves.

use crate::excavator::drive::Drive;

/// Number of ticks over which the bucket's rate is taken, and for which an opening lasts (0.10 s).
const OPENING: usize = 10;

/// Detector of an opening bucket.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Opening {
    ring: [(f64, f64); OPENING],
    count: usize,
    threshold: f64,
    left: u32,
}

impl Opening {
    /// From the least rate of an opening [rad/s].
    pub(in crate::excavator) fn new(threshold: f64) -> Self {
        Self {
            ring: [(0.0, 0.0); OPENING],
            count: 0,
            threshold,
            left: 0,
        }
    }

    /// Least rate of an opening [rad/s].
    pub(in crate::excavator) fn threshold(&self) -> f64 {
        self.threshold
    }

    /// Whether the bucket opens, or has just done so.
    pub(in crate::excavator) fn is_open(&self) -> bool {
        self.left > 0
    }

    /// Takes one tick. Returns the rate of opening, 0 while the bucket does not open (rho) [rad/s].
    pub(in crate::excavator) fn step(&mut self, drive: &Drive) -> f64 {
        let slot = self.count % OPENING;
        let (then, angle) = self.ring[slot];
        let rate = if self.count >= OPENING {
            (drive.posture[2] - angle) / (drive.time - then)
        } else {
            0.0
        };
        self.ring[slot] = (drive.time, drive.posture[2]);
        self.count += 1;
        self.left = if rate > self.threshold {
            OPENING as u32
        } else {
            self.left.saturating_sub(1)
        };
        if self.left > 0 { rate.max(0.0) } else { 0.0 }
    }
}

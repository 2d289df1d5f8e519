//! Detects a row that repeats the last one, signal by signal and bit by bit.
//!
//! A logger that misses its bus may write its last row again, with a new time. Such a row is no measurement. Noise shows it: no two rows
//! of noisy signals ([`Repetition::is_noisy`](super::frozen::Repetition::is_noisy)) are equal. Where a source repeats rows often, because
//! it is slow, its stamps jitter or its steps are coarse, equal rows count.

use crate::excavator::estimate::Sample;

/// Signals of a row.
const SIGNALS: usize = 12;
/// Weight of one new row in the share of new rows after a repetition: 1000 rows, 10 s at 100 Hz.
const MEMORY: f64 = 0.001;
/// Share of new rows after a repetition from which repetitions are usual: eight in 10 s. A plant whose stamps jitter by 8 ms has .02, a
/// logger that holds each 15 s has .001.
const USUAL: f64 = 0.008;

/// The last row.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Repeated {
    last: [Option<f64>; SIGNALS],
    repeats: bool,
    /// Share of new rows after a repetition.
    share: f64,
}

impl Repeated {
    /// Whether a row has exactly the values of the last one, and the source seldom repeats one.
    pub(in crate::excavator) fn again(&mut self, row: &Sample) -> bool {
        let [boom, arm, bucket] = row.posture;
        let [pitch, roll] = row.inclination;
        let now = [
            row.velocity,
            row.angle,
            row.torque,
            boom,
            arm,
            bucket,
            pitch,
            roll,
            row.boom_head_pressure,
            row.boom_rod_pressure,
            row.arm_head_pressure,
            row.arm_rod_pressure,
        ]
        .map(|value| value.filter(|v| v.is_finite()));
        let repeated = core::mem::replace(&mut self.last, now) == now;
        let before = core::mem::replace(&mut self.repeats, repeated);
        if !repeated {
            self.share += MEMORY * (f64::from(u8::from(before)) - self.share);
        }
        repeated && self.share < USUAL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_repeated_if_no_signal_differs() {
        let mut repeated = Repeated::default();
        let row = Sample {
            velocity: Some(0.3),
            boom_head_pressure: Some(f64::NAN),
            posture: [Some(0.5), None, Some(-1.0)],
            ..Sample::default()
        };
        assert!(!repeated.again(&row), "the first");
        let later = Sample { time: 0.01, ..row };
        assert!(repeated.again(&later));
        let rolls = Sample {
            inclination: [None, Some(0.0)],
            ..row
        };
        assert!(!repeated.again(&rolls));
    }
}

//! Detects a head-pressure sensor at the end of its range: its value is then a lower bound, and no weight.
//!
//! The end is not stated. It is detected where the highest value so far repeats to the bit while arm or machine moves, since motion shakes
//! every pressure.

/// Time for which the highest value repeats until it counts as the end [s].
const STAYS: f64 = 0.5;
/// Time after the end for which rows are not used [s]: the lower half of a pressure that swings about the end.
const SWINGS: f64 = 0.5;

/// State of the detector.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Saturation {
    /// Highest value [Pa], time for which it has repeated [s], and whether it is the end.
    highest: f64,
    stayed: f64,
    is_end: bool,
    /// Time until rows are used again [s].
    left: f64,
}

impl Saturation {
    /// Before the first row.
    pub const NEW: Self = Self {
        highest: 0.0,
        stayed: 0.0,
        is_end: false,
        left: 0.0,
    };

    /// Updates with a pressure [Pa]; `moves` while arm or machine does. Returns whether the sensor may be at its end.
    pub fn see(&mut self, pressure: f64, moves: bool, dt: f64) -> bool {
        if pressure > self.highest {
            *self = Self {
                highest: pressure,
                ..Self::NEW
            };
        } else if pressure < self.highest {
            self.stayed = 0.0;
        } else if moves {
            self.stayed += dt;
            self.is_end |= self.stayed > STAYS;
        }
        self.left = if self.is_end && pressure == self.highest {
            SWINGS
        } else {
            (self.left - dt).max(0.0)
        };
        self.left > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_value_that_stays_while_the_arm_moves_is_the_end_of_the_sensor() {
        let mut sensor = Saturation::NEW;
        let mut ends = |pressure: f64, moves, rows: u32| {
            let seen = (0..rows).map(|_| sensor.see(pressure, moves, 0.01));
            seen.last().expect("rows")
        };
        assert!(!ends(12e6, true, 5));
        assert!(
            !ends(18e6, false, 100),
            "at rest any sensor may show the same"
        );
        assert!(!ends(18e6, true, 45) && ends(18e6, true, 10));
        assert!(ends(17.9e6, true, 40), "the lower part of a swing");
        assert!(!ends(17.9e6, true, 20));
        assert!(ends(18e6, false, 1), "it is known now");
        assert!(!ends(19e6, true, 1), "and it was none");
    }
}

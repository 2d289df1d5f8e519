//! A pressure sensor at its end: what it shows is a least value, and no weight.
//!
//! Nobody states where it ends. It shows where the highest value of all comes again to the bit while arm or machine moves, which shakes every
//! pressure.

/// The highest value that stays so long is the end [s].
const STAYS: f64 = 0.5;
/// So long after it rows are the lower ones of a pressure that swings about the end [s].
const SWINGS: f64 = 0.5;

/// Memory of the pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Saturation {
    /// Highest value [Pa], how long it has stayed [s], and whether it is the end.
    highest: f64,
    stayed: f64,
    is_end: bool,
    /// Time until rows tell again [s].
    left: f64,
}

impl Saturation {
    /// Nothing has been seen.
    pub const NEW: Self = Self {
        highest: 0.0,
        stayed: 0.0,
        is_end: false,
        left: 0.0,
    };

    /// Takes a pressure [Pa]; `moves` while arm or machine does. Whether it may be at its end.
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

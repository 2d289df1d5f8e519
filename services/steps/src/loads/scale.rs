//! A machine whose mass is measured: its payload is what it has more than empty.

use estimation::Quantity;
use estimation::math::norm;

/// The machine's mass is measured: its payload is what it has more than empty.
///
/// Nobody states what such a scale is worth: half a percent of the machine, two percent of the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    /// Described mass of the empty machine [kg].
    described: f64,
    /// Least mass that has held [kg].
    empty: Option<f64>,
    /// Mass that holds, and since when [kg], [s].
    anchor: Option<(f64, f64)>,
}

/// Standard deviation of a mass, in masses, and of a load, in loads.
const SCALE_STD: [f64; 2] = [0.005, 0.02];
/// A mass holds that has stayed within this share for this long [s].
const HOLDS: (f64, f64) = (0.01, 1.0);
/// A mass further below the described one is not that of this machine, in masses.
const BELOW: f64 = 0.2;
/// The empty machine weighs at most so much more than described, in masses.
const EMPTY: f64 = 0.05;

impl Scale {
    pub(super) fn new(described: f64) -> Self {
        Self {
            described,
            empty: None,
            anchor: None,
        }
    }

    /// Payload of this mass, and the standard deviation of what all loads share.
    pub(super) fn step(&mut self, mass: f64, time: f64) -> Option<(Quantity, f64)> {
        if !(mass.is_finite() && mass > (1.0 - BELOW) * self.described) {
            return None;
        }
        match self.anchor {
            Some((anchor, since)) if (mass - anchor).abs() < HOLDS.0 * anchor => {
                if time - since >= HOLDS.1 {
                    self.empty = Some(self.empty.map_or(anchor, |e| e.min(anchor)));
                }
            }
            _ => self.anchor = Some((mass, time)),
        }
        // Until it has been about as light as described, the machine that began may have been loaded already.
        let learnt = self.empty.filter(|e| *e < (1.0 + EMPTY) * self.described);
        let zero = if learnt.is_some() {
            0.0
        } else {
            EMPTY * self.described
        };
        let value = mass - learnt.unwrap_or(self.described);
        let common = norm(&[SCALE_STD[1] * value, zero]);
        let std = norm(&[SCALE_STD[0] * mass, common]);
        Some((Quantity { value, std }, common))
    }
}

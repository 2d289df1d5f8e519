//! The material in the bucket.

use crate::blend::transition;

/// Times before the filling at which the bucket begins to touch the ground, and is in it [s].
const TOUCH: (f64, f64) = (0.7, 0.4);
/// Times before and after the end of the filling at which the bucket begins to leave the ground, and has left it [s].
const BREAK_OUT: (f64, f64) = (0.2, 0.15);

/// A portion of material: picked up in one smooth transition, dumped in another. A portion that stays has infinite dump times;
/// one that is always present has infinitely early fill times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Mass of the portion \[kg\].
    pub mass: f64,
    /// Beginning and end of its filling \[s\].
    pub fill: (f64, f64),
    /// Beginning and end of its dumping \[s\].
    pub dump: (f64, f64),
}

impl Load {
    /// A portion that is always present.
    pub fn kept(mass: f64) -> Self {
        Self {
            mass,
            fill: (f64::NEG_INFINITY, f64::NEG_INFINITY),
            dump: (f64::INFINITY, f64::INFINITY),
        }
    }

    /// Mass in the bucket at a time \[kg\]: fill s (1 - dump s), both quintic.
    pub fn at(&self, time: f64) -> f64 {
        let filled = transition(time, self.fill.0, self.fill.1);
        self.mass * filled * (1.0 - transition(time, self.dump.0, self.dump.1))
    }

    /// Share of the bucket in the ground around its filling, 0 to 1: it enters before, and breaks out at the end.
    pub fn contact(&self, time: f64) -> f64 {
        let (from, to) = self.fill;
        if !from.is_finite() {
            return 0.0;
        }
        let entered = transition(time, from - TOUCH.0, from - TOUCH.1);
        entered * (1.0 - transition(time, to - BREAK_OUT.0, to + BREAK_OUT.1))
    }
}

/// The mass of all portions at a time \[kg\].
pub fn payload(loads: &[Load], time: f64) -> f64 {
    loads.iter().map(|load| load.at(time)).sum()
}

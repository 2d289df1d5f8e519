//! The material in the bucket.

use crate::blend::transition;

/// A portion of material: taken up in one smooth transition, lost in another. What stays has infinite
/// dump times; what was always there has infinitely early fill times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Mass of the portion [kg].
    pub mass: f64,
    /// Beginning and end of its filling [s].
    pub fill: (f64, f64),
    /// Beginning and end of its dumping [s].
    pub dump: (f64, f64),
}

impl Load {
    /// A portion that was there before and stays.
    pub fn kept(mass: f64) -> Self {
        Self {
            mass,
            fill: (f64::NEG_INFINITY, f64::NEG_INFINITY),
            dump: (f64::INFINITY, f64::INFINITY),
        }
    }

    /// Mass in the bucket at a time [kg]: fill s (1 - dump s), both quintic.
    pub fn at(&self, time: f64) -> f64 {
        let filled = transition(time, self.fill.0, self.fill.1);
        self.mass * filled * (1.0 - transition(time, self.dump.0, self.dump.1))
    }
}

/// The mass of all portions at a time [kg].
pub fn payload(loads: &[Load], time: f64) -> f64 {
    loads.iter().map(|load| load.at(time)).sum()
}

//! Sample-and-hold of the arm's signals: a bus sends each at its own time, so a row may hold one of them without the others.

use crate::loader::sample::Sample;

/// Last value of a signal, and its time [s].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Held {
    value: f64,
    time: f64,
}

impl Held {
    /// Before the first value.
    const NEVER: Self = Self {
        value: 0.0,
        time: f64::NEG_INFINITY,
    };

    /// Updates with a row's value. Returns the last one, while it is no older than `fresh` [s].
    fn take(&mut self, value: Option<f64>, time: f64, fresh: f64) -> Option<f64> {
        if let Some(value) = value {
            *self = Self { value, time };
            return Some(value);
        }
        (0.0..=fresh)
            .contains(&(time - self.time))
            .then_some(self.value)
    }
}

/// Angles of arm and bucket, rod-side pressure, and specific force.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Signals {
    lift: Held,
    tilt: Held,
    rod: Held,
    acceleration: Held,
}

/// Their values in a row; none where missing or too old.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Now {
    /// Angle of the arm [rad].
    pub lift: Option<f64>,
    /// Angle of the bucket to the arm [rad].
    pub tilt: Option<f64>,
    /// Pressure on the rod side [Pa].
    pub rod: Option<f64>,
    /// Value of the accelerometer [m/s^2].
    pub acceleration: Option<f64>,
}

impl Signals {
    /// Before the first row.
    pub const NONE: Self = Self {
        lift: Held::NEVER,
        tilt: Held::NEVER,
        rod: Held::NEVER,
        acceleration: Held::NEVER,
    };

    /// Updates with a plausible row; a value counts until it is older than `fresh` [s].
    pub fn take(&mut self, sample: &Sample, fresh: f64) -> Now {
        let hold = |held: &mut Held, value| held.take(value, sample.time, fresh);
        Now {
            lift: hold(&mut self.lift, sample.lift_angle),
            tilt: hold(&mut self.tilt, sample.tilt_angle),
            rod: hold(&mut self.rod, sample.lift_rod_pressure),
            acceleration: hold(&mut self.acceleration, sample.acceleration),
        }
    }

    /// The bucket's angle has been measured.
    pub fn measure_tilt(&self) -> bool {
        self.tilt != Held::NEVER
    }
}

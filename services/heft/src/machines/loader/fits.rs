//! Are the data in the units and signs that are meant?

use config::Description;
use estimation::loader::{Carriage, largest};
use messages::LoaderSensors;

use crate::commands::estimate::look::Look;

/// No loader drives on a steeper ground \[rad\]: 35 degrees.
const STEEPEST: f64 = 0.61;
/// Nor does a sensor show one for more than this share of the rows.
const OFTEN: f64 = 0.1;

/// Looks at the slope, and at how the bucket is carried.
#[derive(Default)]
pub(in crate::machines) struct Fits {
    rows: u64,
    steep: u64,
    carriage: Carriage,
    last: Option<f64>,
}

impl Fits {
    fn see(&mut self, slope: Option<f64>) {
        if let Some(slope) = slope.filter(|slope| slope.is_finite()) {
            self.rows += 1;
            self.steep += u64::from(slope.abs() > STEEPEST);
        }
    }

    fn is_in_degrees(&self) -> bool {
        self.steep as f64 > OFTEN * self.rows as f64
    }
}

impl Look for Fits {
    type Sensors = LoaderSensors;

    fn of(_: &Description) -> Self {
        Self::default()
    }

    fn largest(description: &Description, signal: &str) -> Option<f64> {
        match description {
            Description::Loader(described) => largest(signal, described),
            _ => None,
        }
    }

    fn add(&mut self, s: &LoaderSensors) {
        let sample = steps::loader::sample(s);
        self.see(sample.slope);
        let last = self.last.replace(sample.time);
        if let (Some(last), Some(speed), Some(lift), Some(tilt)) =
            (last, sample.speed, sample.lift_angle, sample.tilt_angle)
        {
            self.carriage.see(speed, [lift, tilt], sample.time - last);
        }
    }

    fn fault(&self) -> Option<String> {
        let said = if self.is_in_degrees() {
            "slope seems to be in degrees: no loader drives on such hills\n  \
             what to do: write `unit = \"deg\"` for slope in a signal map"
        } else if self.carriage.is_odd() {
            "lift_angle or tilt_angle seems to have the other sign, or another zero: no loader drives with its bucket like that\n  \
             what to do: in the signal map `sign = -1`, or `offset`; the angles are drawn in docs/signs-loader.svg"
        } else {
            return None;
        };
        Some(said.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hills_in_degrees_are_told_from_hills_in_radians() {
        let seen = |unit: f64| {
            let mut fits = Fits::default();
            for k in 0..1000 {
                let hill = 0.05 * (f64::from(k) / 100.0).sin();
                fits.see(Some(unit * hill));
                fits.see(None);
            }
            fits.is_in_degrees()
        };
        assert!(seen(57.3));
        assert!(!seen(1.0));
        assert!(!Fits::default().is_in_degrees());
    }
}

//! Are the data in the units that are meant?

use config::Description;
use messages::LoaderSensors;

use crate::commands::estimate::look::Look;

/// No loader drives on a steeper ground \[rad\]: 35 degrees.
const STEEPEST: f64 = 0.61;
/// Nor does a sensor show one for more than this share of the rows.
const OFTEN: f64 = 0.1;

/// Looks at the slope.
#[derive(Default)]
pub(in crate::machines) struct Fits {
    rows: u64,
    steep: u64,
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

    fn add(&mut self, s: &LoaderSensors) {
        self.see(steps::loader::sample(s).slope);
    }

    fn fault(&self) -> Option<String> {
        self.is_in_degrees().then(|| {
            "slope seems to be in degrees: no loader drives on such hills\n  \
             what to do: write `unit = \"deg\"` for slope in a signal map"
                .into()
        })
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

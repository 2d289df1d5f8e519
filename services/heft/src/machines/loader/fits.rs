//! Are the data in the units and signs that are meant?

use config::Description;
use estimation::loader::{Carriage, Mismatch, Plausible, largest};
use messages::LoaderSensors;

use crate::commands::estimate::look::Look;

/// No loader drives on a steeper ground \[rad\]: 35 degrees.
const STEEPEST: f64 = 0.61;
/// Nor does a sensor show one for more than this share of the rows.
const OFTEN: f64 = 0.1;

/// From motor to wheel a gear has at least four turns to one.
const AT_MOTOR: f64 = 0.25;

/// Looks at the slope, at how the bucket is carried, and at wheels and torques.
#[derive(Default)]
pub(in crate::machines) struct Fits {
    rows: u64,
    steep: u64,
    carriage: Carriage,
    last: Option<f64>,
    plausible: Option<Plausible>,
    /// Described \[kg\].
    mass: f64,
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

    fn of(description: &Description) -> Self {
        let machine = match description {
            Description::Loader(described) => Some(&described.machine),
            _ => None,
        };
        Self {
            plausible: machine.map(|m| Plausible::new(m.mass, m.wheel_radius)),
            mass: machine.map_or(0.0, |m| m.mass),
            ..Self::default()
        }
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
        if let Some(plausible) = &mut self.plausible {
            plausible.push(&sample);
        }
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
             what to do: write `unit = \"deg\"` for slope in a signal map, or `unit = \"%\", scale = 1.0` for a grade"
        } else if self.carriage.is_odd() {
            "lift_angle or tilt_angle seems to have the other sign, or another zero: no loader drives with its bucket like that\n  \
             what to do: in the signal map `sign = -1`, or `offset`; the angles are drawn in docs/signs-loader.svg"
        } else {
            let mismatch = self.plausible.as_ref()?.mismatch()?;
            let remedy = remedy(mismatch, self.mass);
            return Some(format!("{mismatch}\n  what to do: {remedy}"));
        };
        Some(said.into())
    }
}

/// What to do about it.
fn remedy(mismatch: Mismatch, mass: f64) -> String {
    let map = |column: &str, line: &str| format!("write {line} for {column} in a signal map");
    match mismatch {
        Mismatch::SpeedSign => map("speed", "`sign = -1`"),
        Mismatch::WheelSign(axle) => map(&format!("{axle}_wheel_speed"), "`sign = -1`"),
        Mismatch::KilometresPerHour => map("speed", "`unit = \"km/h\"`"),
        Mismatch::Revolutions => map("front_wheel_speed and rear_wheel_speed", "`unit = \"rpm\"`"),
        Mismatch::Tread => {
            "divide them by the wheel radius: in the signal map `scale`, which is 1 / radius; or state machine.wheel_radius, if it is 1 m".into()
        }
        Mismatch::Radius(_) => {
            "check the units of speed and wheel speeds, gear ratios, and machine.wheel_radius"
                .into()
        }
        Mismatch::Kilonewtons => map("front_torque and rear_torque", "`unit = \"kNm\"`"),
        Mismatch::TorqueSign => map("front_torque and rear_torque", "`sign = -1`"),
        Mismatch::Mass(ratio) => {
            let tonnes = mass * ratio.abs() / 1000.0;
            let motor = match ratio.abs() < AT_MOTOR {
                true => format!("; or the torques are those at the motor: in the signal map `scale`, the gear ratio (about {:.0})", 1.0 / ratio.abs()),
                false => String::new(),
            };
            format!("state the mass: a loader of about {tonnes:.1} t would fit (machine.mass, or --class){motor}")
        }
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

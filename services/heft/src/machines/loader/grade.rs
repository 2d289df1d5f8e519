//! What accelerometer and torques say of the slope.
//!
//! Over blocks, with s = g times the slope that is sent:
//!
//! | what | model | sound |
//! |---|---|---|
//! | accelerometer | c0 + c1 dv/dt + c2 s | c2 = 1 |
//! | torque of both axles | c0 sgn v + c1 dv/dt + c2 s | c2 = c1 |
//!
//! A hill sensor that follows the acceleration leaves less of c1 and all of c2. Level ground tells nothing.

use estimation::GRAVITY;

use super::pair::about;
use super::regression::Regression;

/// Blocks that tell.
const ENOUGH: f64 = 50.0;
/// The accelerometer and a slope that is meant: .93 to 1.02 was recorded with correlations of .45 to .95. On level ground 5 and
/// more, with .34 at most.
const ALIKE: f64 = 1.15;
const TOGETHER: f64 = 0.4;
/// The torques and a slope that is meant: .83 to 1.33 with correlations above this one; with -.29 at the least.
const ABOUT: f64 = 1.4;
const SURELY: f64 = 0.6;
/// Per cent in a radian of a small slope.
const PERCENT: f64 = 100.0;

/// Looks at blocks of rows.
#[derive(Default)]
pub(super) struct Grade {
    acceleration: Regression,
    torque: Regression,
}

impl Grade {
    /// A block that drives: speed, dv/dt, slope, acceleration, torque of both axles.
    pub(super) fn see(
        &mut self,
        speed: f64,
        gain: f64,
        slope: f64,
        acceleration: f64,
        torque: f64,
    ) {
        let fall = GRAVITY * slope;
        self.acceleration.see([1.0, gain, fall, acceleration]);
        self.torque.see([speed.signum(), gain, fall, torque]);
    }

    /// How much of the slope that is sent the others show, and what may be its unit; none where they do not tell.
    fn share(&self) -> Option<(f64, &'static [Unit])> {
        let belongs = |r: &Regression, least: f64| r.correlation().abs() > least;
        if self.acceleration.rows >= ENOUGH && belongs(&self.acceleration, TOGETHER) {
            let [gain, share] = self.acceleration.coefficients();
            return Some((share * gain.signum(), &UNITS));
        }
        let tells = self.torque.rows >= ENOUGH && belongs(&self.torque, SURELY);
        let [gain, share] = self.torque.coefficients();
        tells.then_some((share / gain, &UNITS[..BY_TORQUE]))
    }

    /// What the slope is, and what to do.
    pub(super) fn fault(&self) -> Option<String> {
        let (share, units) = self.share()?;
        let factor = if units.len() == UNITS.len() {
            ALIKE
        } else {
            ABOUT
        };
        let (.., what, remedy) = units
            .iter()
            .find(|(unit, ..)| about(share * unit, factor))?;
        Some(format!(
            "slope {what}: acceleration and torques show {share:.2} of it\n  what to do: {remedy}"
        ))
    }
}

/// A slope that is so many times the one that is meant, what it seems, and what to do.
type Unit = (f64, &'static str, &'static str);

/// Those that the torques tell come first: of a load on the machine they know nothing.
const BY_TORQUE: usize = 3;
const UNITS: [Unit; 5] = [
    (
        -1.0,
        "seems to have the other sign",
        "in the signal map `sign = -1` for slope; nose up is positive",
    ),
    (
        PERCENT,
        "seems to be a grade in percent",
        "in the signal map `unit = \"%\", scale = 1.0` for slope",
    ),
    (
        180.0 / core::f64::consts::PI,
        "seems to be in degrees",
        "in the signal map `unit = \"deg\"` for slope",
    ),
    (
        PERCENT * core::f64::consts::PI / 180.0,
        "seems to be a grade in percent that is read as degrees",
        "in the signal map `unit = \"%\", scale = 1.0` for slope",
    ),
    (
        180.0 / core::f64::consts::PI / PERCENT,
        "seems to be in degrees that are read as percent",
        "in the signal map `unit = \"deg\"` for slope",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// A machine of 10 t on wheels of .7 m on hills, with a slope that is so many times the true one.
    fn said(by: f64, has_accelerometer: bool, hills: f64) -> String {
        let mut grade = Grade::default();
        for k in 0..400 {
            let time = 0.2 * f64::from(k);
            let (speed, gain) = (3.0 + time.sin(), time.cos());
            let slope = hills * (0.21 * time).sin();
            let force = gain + GRAVITY * slope;
            let acceleration = if has_accelerometer { force } else { f64::NAN };
            let sent = by * slope + 0.002 * (7.0 * time).sin();
            grade.see(speed, gain, sent, acceleration, 7e3 * (force + 0.2));
        }
        grade.fault().unwrap_or_default()
    }

    #[test]
    fn sign_and_unit_of_a_slope_are_told_by_accelerometer_and_torques() {
        for has_accelerometer in [true, false] {
            let said = |by| said(by, has_accelerometer, 0.08);
            assert_eq!(said(1.0), "");
            assert!(said(-1.0).starts_with("slope seems to have the other sign"));
            assert!(said(57.3).starts_with("slope seems to be in degrees:"));
            assert!(said(100.0).starts_with("slope seems to be a grade in percent:"));
        }
        assert!(said(1.745, true, 0.08).contains("percent that is read as degrees"));
        assert!(said(0.573, true, 0.08).contains("degrees that are read as percent"));
        // A load of half the machine is no other unit, and level ground tells nothing.
        assert_eq!(said(0.67, false, 0.08), "");
        assert_eq!(said(-1.0, true, 1e-5), "");
    }
}

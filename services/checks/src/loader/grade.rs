//! Checks the slope sensor against accelerometer and torques.
//!
//! Regressions over blocks, with s = g times the measured slope:
//!
//! | what | model | sound |
//! |---|---|---|
//! | accelerometer | c0 + c1 dv/dt + c2 s | c2 = 1 |
//! | torque of both axles | c0 sgn v + c1 dv/dt + c2 s | c2 = c1 |
//!
//! A slope sensor that follows the acceleration lowers c1 and leaves c2. Level ground carries no information.

use estimation::GRAVITY;
use recording::Finding;

use super::pair::about;
use super::regression::Regression;

/// Fewest blocks for a verdict.
const ENOUGH: f64 = 50.0;
/// Accelerometer: factor within which the share identifies a unit, and least correlation. A correct slope gave .93 to 1.02, with
/// correlations of .45 to .95. Level ground gave 5 and more, with .34 at most.
const ALIKE: f64 = 1.15;
const TOGETHER: f64 = 0.4;
/// Torques: the same. A correct slope gave .83 to 1.33 with correlations above this one; -.29 was the least correlation.
const ABOUT: f64 = 1.4;
const SURELY: f64 = 0.6;
/// Factor of the accelerometer's c1 where the sensor does not follow the acceleration: another unit of the slope leaves c1 unchanged.
/// On nearly level ground a sensor that follows it leaves .25 to .80, and a c2 of 1.8 to 7.
const UNMOVED: f64 = 1.1;
/// Slope from which on a ratio of two units is one \[rad\]: the body's pitch with the acceleration is below .015 rad, and late or filtered.
const HILLS: f64 = 0.02;
/// Per cent in a radian of a small slope.
const PERCENT: f64 = 100.0;

/// Accumulates blocks of rows.
#[derive(Default)]
pub(super) struct Grade {
    acceleration: Regression<4>,
    torque: Regression<4>,
}

impl Grade {
    /// Takes a driving block: speed, dv/dt, slope, acceleration, torque of both axles.
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

    /// Share of the measured slope that accelerometer or torques show, its tolerance factor, and the candidate units; none if undecided.
    fn share(&self) -> Option<(f64, f64, &'static [Unit])> {
        let belongs = |r: &Regression<4>, least: f64| r.correlation().abs() > least;
        if self.acceleration.rows >= ENOUGH && belongs(&self.acceleration, TOGETHER) {
            let [gain, share] = self.acceleration.coefficients();
            let share = share * gain.signum();
            let has_hills = self.acceleration.left() > GRAVITY * HILLS;
            let units = match has_hills && about(gain.abs(), UNMOVED) {
                true => &UNITS[..],
                false => &UNITS[..FAR],
            };
            return Some((share, ALIKE, units));
        }
        let is_determined = self.torque.rows >= ENOUGH && belongs(&self.torque, SURELY);
        let [gain, share] = self.torque.coefficients();
        is_determined.then_some((share / gain, ABOUT, &UNITS[..FAR]))
    }

    /// The fault of the slope and its remedy.
    pub(super) fn fault(&self) -> Option<Finding> {
        let (share, factor, units) = self.share()?;
        let (.., what, remedy) = units
            .iter()
            .find(|(unit, ..)| about(share * unit, factor))?;
        Some(Finding::new(
            format!("slope {what}: acceleration and torques show {share:.2} of it"),
            *remedy,
        ))
    }
}

/// A candidate: measured over true slope, its name, and the remedy.
type Unit = (f64, &'static str, &'static str);

/// Number of candidates that are far from a correct slope; they come first. Torques distinguish no others, because they depend on the
/// unknown load. Nor does a sensor that follows the acceleration, which on level ground shows little else.
const FAR: usize = 3;
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
    use crate::text;

    /// The fault of a machine of 10 t on wheels of .7 m on hills; `by`: measured over true slope.
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
        text(grade.fault())
    }

    #[test]
    fn sign_and_unit_of_a_slope_are_determined_by_accelerometer_and_torques() {
        for has_accelerometer in [true, false] {
            let said = |by| said(by, has_accelerometer, 0.08);
            assert_eq!(said(1.0), "");
            assert!(said(-1.0).starts_with("slope seems to have the other sign"));
            assert!(said(57.3).starts_with("slope seems to be in degrees:"));
            assert!(said(100.0).starts_with("slope seems to be a grade in percent:"));
        }
        assert!(said(1.745, true, 0.08).contains("percent that is read as degrees"));
        assert!(said(0.573, true, 0.08).contains("degrees that are read as percent"));
        // A load of half the machine is no other unit, and level ground carries no information.
        assert_eq!(said(0.67, false, 0.08), "");
        assert_eq!(said(-1.0, true, 1e-5), "");
        assert_eq!(said(0.573, true, 0.02), "", "hardly a hill");
    }

    #[test]
    fn a_sensor_that_follows_the_acceleration_on_level_ground_is_in_no_other_unit() {
        // Level ground, and a sensor that shows the acceleration of a moment ago.
        let said = |follows: f64| {
            let mut grade = Grade::default();
            for k in 0..400 {
                let time = 0.2 * f64::from(k);
                let (speed, gain) = (3.0 + time.sin(), time.cos());
                let slope = 0.02 * (0.05 * time).sin();
                let sent = slope + follows / GRAVITY * (time - 0.6).cos();
                let force = gain + GRAVITY * slope;
                grade.see(speed, gain, sent, force, 7e3 * (force + 0.2));
            }
            let [gain, share] = grade.acceleration.coefficients();
            (gain, share, grade.fault())
        };
        for follows in [0.1, 0.2, 0.3, 0.4] {
            let (gain, share, said) = said(follows);
            assert_eq!(said, None, "{follows}: {gain} {share}");
        }
    }
}

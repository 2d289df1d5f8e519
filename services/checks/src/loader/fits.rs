//! Checks the units and signs of a loader's data.

use estimation::loader::{Carriage, Mismatch, Plausible, largest};
use messages::LoaderSensors;
use recording::{Finding, STEEPEST};

use super::axles::Axles;
use super::turning::Turning;
use crate::advice::{write_sign, write_unit};
use crate::look::Look;
use crate::still::Still;
use crate::units::{Angles, Cylinder, TURNING};

/// Least share of rows with a slope that is too steep, for a verdict.
const OFTEN: f64 = 0.1;

/// Ratio of wheel to motor speed: the gear has at least four turns to one.
const AT_MOTOR: f64 = 0.25;

/// Speed above which the machine drives, and the lift cylinders carry arm and bucket [m/s].
const DRIVES: f64 = 1.0;
/// Pounds in a kilogram, and largest mass with load over the empty machine's: a load of half the mass exceeds any rated payload.
const POUNDS: f64 = 2.204_62;
const LADEN: f64 = 1.6;
/// Largest difference of the measured empty machine from its stated mass, as a share.
const EMPTY: f64 = 0.2;
/// Largest angle of a lift arm, up or down \[rad\]: -.7 to .8 was recorded.
const LIFTS: f64 = 1.0;

/// All checks: single columns, slope, carriage of the bucket, wheels and torques.
pub struct Fits {
    angles: Angles<3>,
    cylinder: Cylinder,
    torques: Still<2>,
    speed: Still<1>,
    wheels: Still<2>,
    /// Driving rows, and rows among them in which the lift angle, the tilt angle, exceeds the range of a lift arm.
    driving: u32,
    beyond: [u32; 2],
    axles: Axles,
    turning: Turning,
    /// Rows with a mass, and rows in which it is that of the described machine in tonnes, in pounds.
    massive: u32,
    tonnes: u32,
    pounds: u32,
    /// Sum of the masses \[kg\].
    mass_sum: f64,
    /// Mass times wheel radius [kg m].
    moment: f64,
    rows: u64,
    /// Rows with a slope too steep for radians, and too steep for degrees.
    steep: [u64; 2],
    carriage: Carriage,
    last: Option<f64>,
    plausible: Plausible,
    /// Mass by the machine file \[kg\].
    mass: f64,
}

impl Fits {
    fn see(&mut self, slope: Option<f64>) {
        if let Some(slope) = slope.filter(|slope| slope.is_finite()) {
            self.rows += 1;
            for (count, limit) in self.steep.iter_mut().zip([STEEPEST, STEEPEST.to_degrees()]) {
                *count += u64::from(slope.abs() > limit);
            }
        }
    }

    /// Whether the lift angle is often in the range of buckets only, and the tilt angle hardly ever.
    fn is_exchanged(&self) -> bool {
        let [lift, tilt] = self.beyond;
        10 * lift > self.driving && 100 * tilt < self.driving
    }

    /// The fault of a mass larger than the described machine with any load: it is in pounds, or the machine is larger.
    fn too_massive(&self) -> Finding {
        let mean = self.mass_sum / f64::from(self.massive);
        let [shown, described] = [mean, self.mass].map(|kg| kg / 1000.0);
        let size = format!("say how large yours is (--class {shown:.1}t, or machine.mass)");
        let unit = write_unit("lb", "mass");
        // The size of the reference machine is not stated by the user.
        if self.mass == config::Loader::REFERENCE_MASS {
            return Finding::new(
                format!(
                    "mass is {shown:.1} t, more than the reference machine of {described:.1} t has with any load"
                ),
                format!("{size}; or, if it is in pounds, {unit}"),
            );
        }
        Finding::new(
            format!(
                "mass seems to be in pounds: it is {shown:.1} t, more than the {described:.1} t of the machine file with any load"
            ),
            format!("{unit}; or {size}"),
        )
    }

    /// The fault of the slope's unit and its remedy, in the words of accelerometer and torques if they show it.
    fn slope_fault(&self) -> Option<Finding> {
        let unit = self.slope_unit()?;
        Some(self.axles.slope().unwrap_or(unit))
    }

    fn slope_unit(&self) -> Option<Finding> {
        let is_too_steep = self
            .steep
            .map(|count| count as f64 > OFTEN * self.rows as f64);
        match is_too_steep {
            [_, true] => Some(Finding::new(
                "slope seems to be a grade in percent: even in degrees no loader drives on such hills",
                "write `unit = \"%\", scale = 1.0` for slope in a signal map",
            )),
            [true, false] => Some(Finding::new(
                "slope seems to be in degrees or in percent: no loader drives on such hills",
                "in a signal map write `unit = \"deg\"` for slope, or `unit = \"%\", scale = 1.0` for a grade",
            )),
            [false, false] => None,
        }
    }

    /// A mass in another unit, or of another machine.
    fn mass_fault(&self) -> Option<Finding> {
        if 2 * self.tonnes > self.massive {
            return Some(Finding::new(
                "mass seems to be in t: the machine has about a thousand times as many kg",
                write_unit("t", "mass"),
            ));
        }
        (2 * self.pounds > self.massive).then(|| self.too_massive())
    }

    /// Lift and tilt angle that are exchanged, or of which one has another sign or zero.
    fn angle_fault(&self) -> Option<Finding> {
        if self.is_exchanged() {
            return Some(Finding::new(
                "lift_angle and tilt_angle seem to be exchanged: no loader drives with its arm upright",
                "exchange the two in the signal map",
            ));
        }
        self.carriage.is_odd().then(|| Finding::new(
                "lift_angle or tilt_angle seems to have the other sign, or another zero: no loader drives with its bucket like that",
                "in the signal map `sign = -1`, or `offset`; the angles are drawn in docs/lift-arm.svg",
            ),
        )
    }

    /// Wheels, torques and mass that cannot be of the described machine.
    fn machine_fault(&self) -> Option<Finding> {
        // One axle that contradicts the other makes the sum of both that of another machine.
        let axles = self.axles.fault(self.moment);
        // A bucket that pushes into a pile hides from the speed what the accelerometer shows.
        let at_motor = || self.axles.at_motor(self.moment).map(Mismatch::Mass);
        match self.plausible.mismatch().or_else(at_motor) {
            Some(mismatch) if axles.is_none() || is_of_wheels(mismatch) => {
                let remedy = remedy(mismatch, self.mass);
                Some(Finding::new(mismatch.to_string(), remedy))
            }
            _ => axles,
        }
    }
}

impl Look for Fits {
    type Described = config::Loader;
    type Sensors = LoaderSensors;

    fn of(described: &config::Loader) -> Self {
        let machine = &described.machine;
        Self {
            angles: Angles::new(["lift_angle", "tilt_angle", "articulation"]),
            cylinder: Cylinder::new("lift"),
            torques: Still::new(["front_torque", "rear_torque"], "N m"),
            speed: Still::new(["speed"], "m/s"),
            wheels: Still::new(["front_wheel_speed", "rear_wheel_speed"], "rad/s"),
            driving: 0,
            beyond: [0; 2],
            axles: Axles::default(),
            turning: Turning::default(),
            massive: 0,
            tonnes: 0,
            pounds: 0,
            mass_sum: 0.0,
            moment: machine.mass * machine.wheel_radius,
            rows: 0,
            steep: [0; 2],
            carriage: Carriage::default(),
            last: None,
            plausible: Plausible::new(machine.mass, machine.wheel_radius),
            mass: machine.mass,
        }
    }

    fn largest(described: &config::Loader, signal: &str) -> Option<f64> {
        largest(signal, described)
    }

    fn add(&mut self, s: &LoaderSensors) {
        let sample = steps::loader::sample(s);
        self.see(sample.slope);
        self.plausible.push(&sample);
        self.axles.see(&sample);
        self.turning.see(&sample);
        let angles = [sample.lift_angle, sample.tilt_angle];
        self.angles
            .see([sample.lift_angle, sample.tilt_angle, sample.articulation]);
        self.massive += u32::from(sample.mass.is_some());
        self.mass_sum += sample.mass.unwrap_or(0.0);
        let tonnes = |mass: f64| (self.mass / 2.0..2.0 * self.mass).contains(&(1e3 * mass));
        self.tonnes += u32::from(sample.mass.is_some_and(tonnes));
        let pounds = |mass: f64| (LADEN..LADEN * POUNDS).contains(&(mass / self.mass));
        self.pounds += u32::from(sample.mass.is_some_and(pounds));
        let drives = sample.speed.is_some_and(|v| v.abs() > DRIVES);
        let wheels = [sample.front_wheel_speed, sample.rear_wheel_speed];
        self.cylinder
            .see(sample.lift_head_pressure, sample.lift_rod_pressure, drives);
        if drives {
            self.torques.see([sample.front_torque, sample.rear_torque]);
            self.wheels.see(wheels);
        }
        let turns = |w: f64| (w * self.moment / self.mass).abs() > DRIVES;
        if wheels.into_iter().all(|wheel| wheel.is_some_and(turns)) {
            self.speed.see([sample.speed]);
        }
        if let ([Some(lift), Some(tilt)], true) = (angles, drives) {
            self.driving += 1;
            for (count, angle) in self.beyond.iter_mut().zip([lift, tilt]) {
                *count += u32::from(angle.abs() > LIFTS);
            }
        }
        let last = self.last.replace(sample.time);
        if let (Some(last), Some(speed), Some(lift), Some(tilt)) =
            (last, sample.speed, sample.lift_angle, sample.tilt_angle)
        {
            self.carriage.see(speed, [lift, tilt], sample.time - last);
        }
    }

    fn is_measurement(&self, signal: &str, value: f64) -> bool {
        signal == "mass" && (value - self.mass).abs() < EMPTY * self.mass
    }

    fn fault(&self) -> Option<Finding> {
        let columns = self.angles.fault().or_else(|| self.cylinder.fault());
        let columns = columns.or_else(|| self.torques.fault());
        let columns = columns.or_else(|| self.speed.fault().or_else(|| self.wheels.fault()));
        let columns = columns.or_else(|| self.slope_fault());
        let columns = columns.or_else(|| self.mass_fault());
        let columns = columns.or_else(|| self.turning.fault());
        columns
            .or_else(|| self.axles.speed())
            .or_else(|| self.angle_fault())
            .or_else(|| self.machine_fault())
    }
}

/// Whether speed and wheel speeds alone show this mismatch.
fn is_of_wheels(mismatch: Mismatch) -> bool {
    !matches!(
        mismatch,
        Mismatch::Kilonewtons | Mismatch::TorqueSign | Mismatch::Mass(_)
    )
}

/// Unit of the wheel speeds by the ratio of machine speed to wheel speed; none for other ratios.
fn unit_of(ratio: f64) -> Option<&'static str> {
    let [_, degrees, turns, thousandths] = TURNING;
    let is_about = |unit: f64| (0.8..1.25).contains(&(ratio / (1.0 / unit)));
    let mut units = [turns, degrees, thousandths].into_iter();
    units
        .find(|(_, unit)| is_about(*unit))
        .map(|(name, _)| name)
}

const WHEELS: &str = "front_wheel_speed and rear_wheel_speed";

/// What the user can do about a mismatch.
fn remedy(mismatch: Mismatch, mass: f64) -> String {
    match mismatch {
        Mismatch::SpeedSign => write_sign("speed"),
        Mismatch::WheelSign(axle) => write_sign(&format!("{axle}_wheel_speed")),
        Mismatch::Speed("ft/s") => format!(
            "{}, or \"km/h\" if the wheels are a tenth smaller than machine.wheel_radius",
            write_unit("ft/s", "speed")
        ),
        Mismatch::Speed(name) => write_unit(name, "speed"),
        Mismatch::Revolutions => write_unit("rpm", WHEELS),
        Mismatch::Tread => {
            "divide them by the wheel radius: in the signal map `scale`, which is 1 / radius; or state machine.wheel_radius, if it is 1 m".into()
        }
        Mismatch::Radius(ratio) => match unit_of(ratio) {
            Some(name) => write_unit(name, WHEELS),
            None => "check the units of speed and wheel speeds, gear ratios, and machine.wheel_radius".into(),
        },
        Mismatch::Kilonewtons => write_unit("kNm", "front_torque and rear_torque"),
        Mismatch::TorqueSign => write_sign("front_torque and rear_torque"),
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
    fn hills_in_degrees_or_percent_are_distinguished_from_hills_in_radians() {
        let said = |unit: f64| {
            let mut fits = Fits::of(&config::Loader::default());
            for k in 0..1000 {
                let hill = 0.05 * (f64::from(k) / 100.0).sin();
                fits.see(Some(unit * hill));
                fits.see(None);
            }
            fits.slope_unit().map(|fault| fault.what)
        };
        assert_eq!(said(1.0), None);
        for (unit, words) in [
            (57.3, "in degrees or in percent"),
            (100.0, "in degrees or in percent"),
            (1000.0, "a grade in percent: even"),
        ] {
            assert!(
                said(unit).is_some_and(|said| said.contains(words)),
                "{unit}"
            );
        }
        assert_eq!(Fits::of(&config::Loader::default()).slope_unit(), None);
    }
}

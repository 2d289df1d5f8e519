//! Checks whether data and machine file belong to the same machine.

use estimation::excavator::{Geometry, Mismatch, Plausible, joint, largest};
use messages::ExcavatorSensors;
use recording::Finding;

use super::boom::Boom;
use super::carries::Carries;
use super::ground::Ground;
use super::postures::Postures;
use super::signless::Signless;
use super::speed::Speed;
use super::turned::Turned;
use super::unmoved::Unmoved;
use crate::advice::{write_sign, write_unit};
use crate::look::Look;
use crate::still::Still;
use crate::units::{Angles, Cylinder};

/// Operating mass of the reference machine \[kg\], assumed for a machine file without one.
const REFERENCE: f64 = 5500.0;

/// Swing velocity above which the boom's cylinders carry boom, arm and bucket [rad/s].
const SWINGS: f64 = 0.1;

/// All checks: single columns, postures, then torque against the machine file.
pub struct Fits {
    angles: Angles<3>,
    speed: Speed,
    cylinders: [Cylinder; 2],
    carries: Carries,
    postures: Postures,
    boom: Boom,
    ground: Ground,
    turned: Turned,
    signless: Signless,
    unmoved: Unmoved,
    torque: Still<1>,
    plausible: Plausible,
    mass: f64,
}

impl Look for Fits {
    type Described = config::Excavator;
    type Sensors = ExcavatorSensors;

    fn of(described: &config::Excavator) -> Self {
        let geometry = Geometry::of(described);
        Self {
            angles: Angles::new(["boom_angle", "arm_angle", "bucket_angle"]),
            speed: Speed::new(geometry),
            cylinders: ["boom", "arm"].map(Cylinder::new),
            carries: Carries::default(),
            postures: Postures::default(),
            boom: Boom::default(),
            ground: Ground::default(),
            turned: Turned::new(geometry),
            signless: Signless::default(),
            unmoved: Unmoved::new(geometry),
            torque: Still::new(["swing_torque"], "N m"),
            plausible: Plausible::new(geometry),
            mass: described.machine.operating_mass.unwrap_or(REFERENCE),
        }
    }

    fn largest(described: &config::Excavator, signal: &str) -> Option<f64> {
        largest(signal, described)
    }

    fn add(&mut self, s: &ExcavatorSensors) {
        let sample = steps::excavator::sample(s);
        self.boom.add(s);
        self.carries.see(&sample);
        self.plausible.push(&sample);
        self.speed.see(&sample);
        self.ground.see(&sample);
        self.turned.see(&sample);
        self.signless.see(&sample);
        self.unmoved.see(&sample);
        self.angles.see(sample.posture);
        if let [Some(boom), Some(arm), Some(bucket)] = sample.posture {
            self.postures.see([boom, arm, bucket].map(joint));
        }
        let swings = sample.velocity.is_some_and(|v| v.abs() > SWINGS);
        if swings {
            self.torque.see([sample.torque]);
        }
        let [boom, arm] = &mut self.cylinders;
        boom.see(sample.boom_head_pressure, sample.boom_rod_pressure, swings);
        // The head side of the arm's cylinder curls the arm: it need not carry a load while the machine swings.
        arm.see(sample.arm_head_pressure, sample.arm_rod_pressure, false);
    }

    fn fault(&self) -> Option<Finding> {
        let columns = self.angles.fault().or_else(|| self.speed.fault());
        let columns = columns.or_else(|| self.cylinders.iter().find_map(Cylinder::fault));
        let columns = columns.or_else(|| self.postures.fault());
        if let Some(said) = columns.or_else(|| self.torque.fault()) {
            return Some(said);
        }
        let of_swing = self.unmoved.fault().or_else(|| self.signless.fault());
        if let Some(said) = of_swing.or_else(|| self.turned.fault()) {
            return Some(said);
        }
        let Some(mismatch) = self.plausible.mismatch() else {
            let of_signs = self.boom.fault().or_else(|| self.ground.fault());
            return of_signs.or_else(|| self.carries.fault());
        };
        let remedy = remedy(mismatch, self.mass);
        Some(Finding::new(mismatch.to_string(), remedy))
    }
}

/// What the user can do about a mismatch.
fn remedy(mismatch: Mismatch, mass: f64) -> String {
    match mismatch {
        Mismatch::Degrees => write_unit("deg/s", "swing_velocity"),
        Mismatch::Revolutions => write_unit("rpm", "swing_velocity"),
        Mismatch::SlopeDegrees => write_unit("deg", "pitch and roll"),
        Mismatch::AngleDegrees => write_unit("deg", "boom_angle, arm_angle and bucket_angle"),
        Mismatch::Kilonewtons(ratio) => {
            let unit = write_unit("kNm", "swing_torque");
            match tonnes(mass, ratio) {
                Some(tonnes) => format!("{unit}; or the machine is wrong: one of about {tonnes:.0} t would fit as well (--class {tonnes:.0}t)"),
                None => unit,
            }
        }
        Mismatch::Meganewtons => write_unit("MNm", "swing_torque"),
        Mismatch::Sign => write_sign("swing_torque"),
        Mismatch::Beyond { .. } => "in the signal map: `sign = -1`, or `offset`; the angles are drawn in docs/signs-excavator.svg".into(),
        Mismatch::Exchanged => "exchange the two in the signal map".into(),
        Mismatch::Absolute { arm, .. } => {
            let line = |joint: &str, before: &str| format!("{joint}_angle = {{ terms = [{{ column = \"{joint}_angle\" }}, {{ column = \"{before}_angle\", sign = -1 }}] }}");
            let (first, other) = match arm {
                true => (line("arm", "boom"), line("bucket", "arm")),
                false => (line("bucket", "arm"), line("arm", "boom")),
            };
            format!("subtract the angle of the link before, in the signal map under [columns]: {first}\n  if the other is one against the horizontal too: {other}")
        }
        Mismatch::Size(ratio) => size(mass, ratio),
    }
}

/// Mass of a machine with this many times the inertia \[t\], if such machines exist. Machines are geometrically similar: inertia grows
/// with the mass to the power of 5/3.
fn tonnes(mass: f64, ratio: f64) -> Option<f64> {
    let tonnes = mass * ratio.abs().powf(0.6) / 1000.0;
    (0.75..300.0).contains(&tonnes).then_some(tonnes)
}

/// Range of masses that are reported to fit, as shares of the mass by inertia: machines of one mass differ, and a load adds to the
/// inertia. The mass by inertia was 1.2 to 1.35 times too large on loaded machines of 13 to 36 t.
const SIZES: [f64; 2] = [0.65, 1.15];

fn size(mass: f64, ratio: f64) -> String {
    match tonnes(mass, ratio) {
        Some(tonnes) => {
            let [least, most] = SIZES.map(|share| share * tonnes);
            format!(
                "describe your machine: an excavator of {least:.0} to {most:.0} t would fit; give the operating mass of its data sheet (--class, or machine.operating_mass in the machine file)"
            )
        }
        None => "check the unit of swing_torque, and whether it is the torque at the swing bearing and not at the motor".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_of_fourteen_times_the_inertia_is_about_five_times_as_heavy() {
        let words = size(REFERENCE, 14.0);
        assert!(words.contains("of 17 to 31 t would fit"), "{words}");
        assert!(size(REFERENCE, 1e-6).contains("bearing"));
    }

    #[test]
    fn a_thousandth_is_a_unit_or_another_machine() {
        let words = |mass| remedy(Mismatch::Kilonewtons(1.7e-3), mass);
        assert!(words(1e6).contains("--class 22t"), "{}", words(1e6));
        assert!(!words(22e3).contains("--class"), "{}", words(22e3));
    }
}

//! The calibrated description of an excavator.

use config::{Excavator as Description, Tables as _};
use estimation::Quantity;

use super::{Outcome, Role, cylinder};
use crate::output::Pen;

/// Masses and inertias that share one scale factor.
const LINKS: [&str; 6] = [
    "machine.geometry.boom_mass",
    "machine.geometry.arm_mass",
    "machine.geometry.boom_inertia",
    "machine.geometry.arm_inertia",
    "machine.geometry.boom_axial_inertia",
    "machine.geometry.arm_axial_inertia",
];

/// Mass and inertias of the bucket.
const BUCKET: [&str; 3] = [
    "machine.geometry.bucket_mass",
    "machine.geometry.bucket_inertia",
    "machine.geometry.bucket_axial_inertia",
];

impl Outcome {
    /// The description with the identified values, and its text with `origin` as comments above; `None`
    /// without a fit.
    #[must_use]
    pub fn description(
        &self,
        before: &Description,
        origin: &[String],
    ) -> Option<(Description, String)> {
        self.found.as_ref()?;
        let mut pen = Pen::new(before.clone());
        for (i, role) in self.swings.roles.iter().enumerate() {
            if !self.fixed[i] {
                self.write(&mut pen, *role);
            }
        }
        if self.swings.has_posture() {
            self.together(&mut pen);
        }
        if let Some(learnt) = &self.cylinder {
            cylinder::write(learnt, &mut pen);
        }
        let text = pen.text(&self.summary(), origin);
        Some((pen.description, text))
    }

    fn write(&self, pen: &mut Pen<Description>, role: Role) {
        let Some(q) = self.quantity(role) else {
            return;
        };
        match role {
            Role::Damping => {
                pen.value("machine.nominal_damping", q);
                pen.std("prior.damping_std", q.std);
            }
            Role::Friction => {
                pen.value("machine.coulomb_friction", q);
                pen.std("machine.coulomb_friction_std", q.std);
                pen.std("prior.friction_std", q.std);
            }
            Role::Efficiency => {
                pen.value("machine.drive_efficiency", q);
                pen.std("machine.drive_efficiency_std", q.std);
            }
            Role::Offset => {
                pen.value("sensors.swing_torque_offset", q);
                pen.std("prior.torque_offset_std", q.std);
                pen.std("prior.known_torque_offset_std", q.std);
            }
            Role::Gain => {
                pen.value("sensors.swing_torque_gain", q);
                pen.std("sensors.swing_torque_gain_std", q.std);
            }
            Role::Inertia if self.swings.has_posture() => pen.value("machine.upper_inertia", q),
            Role::Inertia => {
                // The whole inertia: no posture is measured.
                pen.value("machine.upper_inertia", q);
                pen.value("prior.inertia", q);
                pen.std("prior.inertia_std", q.std);
            }
            Role::Links => scale(pen, &LINKS, q),
            Role::Bucket => {
                scale(pen, &BUCKET, q);
                pen.std("machine.bucket_tolerance", q.std / q.value);
            }
            Role::Delay => {
                let late = ["sensors.swing_velocity_delay", "sensors.swing_torque_delay"];
                let [late, prompt] = if q.value >= 0.0 {
                    late
                } else {
                    [late[1], late[0]]
                };
                let size = Quantity {
                    value: q.value.abs(),
                    std: q.std,
                };
                let none = Quantity {
                    value: 0.0,
                    std: q.std,
                };
                pen.value(late, size);
                pen.std(&format!("{late}_std"), q.std);
                pen.value(prompt, none);
                pen.std(&format!("{prompt}_std"), 0.0);
            }
            Role::MotionNoise | Role::TorqueNoise | Role::AngleOffset(_) | Role::Centre(_) => {
                if let Some(i) = self.swings.index(role) {
                    let key = self.swings.parameters[i].key.clone();
                    pen.value(&key, q);
                }
            }
            Role::Payload(_) | Role::Lever => {}
            Role::Swinging(_) => {}
            Role::UpperMoment | Role::Across(_) | Role::Along(_) => {}
        }
    }

    /// Writes the tolerances of masses and gain, and their correlations.
    fn together(&self, pen: &mut Pen<Description>) {
        let share = |role| {
            let i = self.swings.index(role).filter(|&i| !self.fixed[i])?;
            let q = self.quantity(role)?;
            Some((i, q.std / q.value))
        };
        let (Some((links, links_share)), Some((upper, upper_share))) =
            (share(Role::Links), share(Role::Inertia))
        else {
            return;
        };
        pen.std("machine.mass_tolerance", links_share);
        pen.std("machine.upper_tolerance", upper_share);
        let (Some((gain, _)), Some(found)) = (share(Role::Gain), &self.found) else {
            return;
        };
        for (key, i, j) in [
            ("machine.links_gain_correlation", links, gain),
            ("machine.upper_gain_correlation", upper, gain),
            ("machine.upper_links_correlation", upper, links),
        ] {
            pen.correlation(key, found.uncertainty.correlation(i, j));
        }
        let Some((bucket, _)) = share(Role::Bucket) else {
            return;
        };
        for (key, i) in [
            ("machine.bucket_gain_correlation", gain),
            ("machine.upper_bucket_correlation", upper),
            ("machine.links_bucket_correlation", links),
        ] {
            pen.correlation(key, found.uncertainty.correlation(i, bucket));
        }
    }
}

/// A description with the masses and inertias of another, and their tolerances.
pub fn with_masses(d: &Description, other: &Description) -> Description {
    let mut mixed = d.clone();
    for key in LINKS.iter().chain(&BUCKET) {
        if let Some(value) = other.number(key) {
            mixed.set_number(key, value);
        }
    }
    let (to, from) = (&mut mixed.machine, &other.machine);
    to.mass_tolerance = from.mass_tolerance;
    to.bucket_tolerance = from.bucket_tolerance;
    to.links_gain_correlation = from.links_gain_correlation;
    mixed
}

/// Multiplies described masses and inertias by an identified factor.
fn scale(pen: &mut Pen<Description>, keys: &[&str], factor: Quantity) {
    for key in keys {
        let part = pen.description.number(key).unwrap_or(0.0);
        let scaled = Quantity {
            value: part * factor.value,
            std: part * factor.std,
        };
        pen.value(key, scaled);
    }
}

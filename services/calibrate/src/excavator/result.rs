//! The calibrated description of an excavator.

use std::collections::BTreeMap;
use std::fmt::Write;

use config::{Excavator as Description, Tables};
use estimation::Quantity;

use super::series::percentile;
use super::{Outcome, Role};
use crate::description::{number, set};
use crate::model::Model;
use crate::output;

/// Masses and inertias that share one scale.
const LINKS: [&str; 9] = [
    "machine.geometry.boom_mass",
    "machine.geometry.arm_mass",
    "machine.geometry.bucket_mass",
    "machine.geometry.boom_inertia",
    "machine.geometry.arm_inertia",
    "machine.geometry.bucket_inertia",
    "machine.geometry.boom_axial_inertia",
    "machine.geometry.arm_axial_inertia",
    "machine.geometry.bucket_axial_inertia",
];

/// Writes the keys of a calibrated description, and remembers what to say of them.
struct Pen {
    description: Description,
    notes: BTreeMap<String, String>,
}

impl Pen {
    fn value(&mut self, key: &str, q: Quantity) {
        let was = number(&self.description, key);
        if set(&mut self.description, key, output::rounded(q.value, q.std)) {
            let was = was.map_or(String::new(), |w| {
                format!(", described {}", output::rounded(w, 0.0))
            });
            let note = format!("calibrated, ± {:.2e}{was}", q.std);
            self.notes.insert(key.into(), note);
        }
    }

    fn std(&mut self, key: &str, std: f64) {
        if set(&mut self.description, key, output::rounded(std, std)) {
            self.notes.insert(key.into(), "calibrated".into());
        }
    }
}

impl Outcome {
    /// The description with what was found, and its text with `origin` as comments above; none where
    /// nothing was.
    #[must_use]
    pub fn description(
        &self,
        before: &Description,
        origin: &[String],
    ) -> Option<(Description, String)> {
        let found = self.found.as_ref()?;
        let mut pen = Pen {
            description: before.clone(),
            notes: BTreeMap::new(),
        };
        for (i, role) in self.swings.roles.iter().enumerate() {
            if !self.fixed[i] {
                self.write(&mut pen, *role);
            }
        }
        if self.swings.has_posture()
            && let Some(tolerance) = self.inertia_tolerance()
        {
            pen.std("machine.mass_tolerance", tolerance);
        }
        let mut text = String::new();
        for line in origin.iter().chain(&self.remarks) {
            let _ = writeln!(text, "# {line}");
        }
        for fault in &self.faults {
            let _ = writeln!(text, "# NOT TO BE TRUSTED: {fault}");
        }
        let printed = output::keys(
            &pen.description.to_toml(),
            &Description::default().to_toml(),
            &pen.notes,
        );
        let _ = write!(
            text,
            "\n{printed}\n{}",
            self.joint(found.uncertainty.widened)
        );
        Some((pen.description, text))
    }

    fn write(&self, pen: &mut Pen, role: Role) {
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
                // All of it: nothing is known of a posture.
                pen.value("machine.upper_inertia", q);
                pen.value("prior.inertia", q);
                pen.std("prior.inertia_std", q.std);
            }
            Role::Links => {
                for key in LINKS {
                    let part = number(&pen.description, key).unwrap_or(0.0);
                    let scaled = Quantity {
                        value: part * q.value,
                        std: part * q.std,
                    };
                    pen.value(key, scaled);
                }
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
            Role::MotionNoise | Role::TorqueNoise => {
                if let Some(i) = self.swings.index(role) {
                    let key = self.swings.parameters[i].key.clone();
                    pen.value(&key, q);
                }
            }
            Role::Payload(_) => {}
        }
    }

    /// Relative standard deviation of the empty machine's inertia, with upper body and attachment
    /// correlated as found.
    fn inertia_tolerance(&self) -> Option<f64> {
        let found = self.found.as_ref()?;
        let (upper, links) = (
            self.swings.index(Role::Inertia)?,
            self.swings.index(Role::Links)?,
        );
        let mut attachment = Vec::new();
        for block in 0..self.swings.blocks() {
            let (series, swing) = self.swings.swing(block);
            attachment.extend(&series.links[swing.rows.clone()]);
        }
        let worst = [0.05, 0.5, 0.95].map(|share| {
            let part = percentile(attachment.clone(), share);
            let slope = [
                self.swings.parameters[upper].std,
                part * self.swings.parameters[links].std,
            ];
            let c = &found.uncertainty.covariance;
            let variance = slope[0] * slope[0] * c[(upper, upper)]
                + 2.0 * slope[0] * slope[1] * c[(upper, links)]
                + slope[1] * slope[1] * c[(links, links)];
            let value = |i: usize| self.swings.parameters[i].value(found.fit.place[i]);
            variance.max(0.0).sqrt() / (value(upper) + part * value(links))
        });
        worst.into_iter().reduce(f64::max)
    }

    /// The joint uncertainty, as comments: descriptions have no place for correlations.
    fn joint(&self, widened: f64) -> String {
        let Some(found) = &self.found else {
            return String::new();
        };
        let free: Vec<usize> = (0..self.fixed.len()).filter(|&i| !self.fixed[i]).collect();
        let mut text = format!(
            "# Correlations of the errors (standard deviations widened {widened:.2} times by the scatter between swings):\n"
        );
        for (row, &i) in free.iter().enumerate() {
            let cells: Vec<String> = free[..row]
                .iter()
                .map(|&j| format!("{:+.2}", found.uncertainty.correlation(i, j)))
                .collect();
            let _ = writeln!(
                text,
                "#   {:<32} {}",
                self.swings.parameters[i].key,
                cells.join(" ")
            );
        }
        text
    }
}

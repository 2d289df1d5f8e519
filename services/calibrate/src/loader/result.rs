//! The calibrated description of a loader.

use config::{Loader as Description, Tables};
use estimation::Quantity;

use super::{Outcome, Role, lift};
use crate::output::Pen;
use crate::parameter::Source;

/// Least written standard deviations, because these values drift: tyres wear and lose pressure, sensors warm up.
const RADIUS_STD: f64 = 5e-4;
const SLOPE_BIAS_STD: f64 = 2e-3;
const OFFSET_STD: f64 = 0.01;
const DELAY_STD: f64 = 2e-3;
/// The same of the slope's sensitivity: an error of the accelerometer's gain is indistinguishable from it.
const FOLLOWS_STD: f64 = 0.01;
/// Relative variation of the slip stiffness between grounds.
const GROUND: f64 = 0.05;
/// Ratio to the prior standard deviation above which a parameter stays as described.
pub const NARROWED: f64 = 0.7;
/// Least written share of the described standard deviation of the ratio.
const LOADED: f64 = 0.5;

/// Writes what axle scales found of the empty machine to the lift arm, where it is stated: there it has precedence over the prior.
fn write_empty(pen: &mut Pen<Description>, name: &str, q: Quantity) {
    let key = format!("machine.lift_arm.{name}");
    if pen.description.number(&key).is_some_and(|of| of > 0.0) {
        pen.value(&key, q);
        pen.std(&format!("{key}_std"), q.std);
    }
}

impl Outcome {
    /// The description with the identified values, and its text with `origin` as comments above; `None` without a fit.
    pub fn description(
        &self,
        before: &Description,
        origin: &[String],
    ) -> Option<(Description, String)> {
        if self.found.is_none() && self.lift.is_none() {
            return None;
        }
        let mut pen = Pen::new(before.clone());
        for (i, role) in self.drives.roles.iter().enumerate() {
            if let Some(q) = self.quantity(*role).filter(|_| self.is_found(i)) {
                self.write(&mut pen, *role, q);
            }
        }
        for &(key, noise) in &self.noises {
            pen.value(key, noise);
        }
        if let Some(learnt) = &self.lift {
            if let Some(turn) = self.turn {
                lift::write_turn(turn, &mut pen);
            }
            lift::write(learnt, &mut pen);
        }
        let text = pen.text(&self.summary(), origin);
        Some((pen.description, text))
    }

    /// Whether the recordings determine a parameter better than the description does.
    fn is_found(&self, i: usize) -> bool {
        let measured = self.drives.parameters[i].source == Source::Measured;
        let std = self.found.as_ref().map(|f| f.uncertainty.std(i));
        !self.fixed[i] && (measured || std.is_some_and(|s| s < NARROWED))
    }

    fn write(&self, pen: &mut Pen<Description>, role: Role, q: Quantity) {
        let Some(i) = self.drives.index(role) else {
            return;
        };
        let wider = |roles: [Role; 2]| self.std(roles[0]).max(self.std(roles[1]));
        let std = match role {
            Role::Mass(load) | Role::Ratio(load) | Role::Height(load) if load > 0 => return,
            Role::Height(_) => {
                if self.drives.loads[0].height.is_some() {
                    write_empty(pen, "empty_height", q);
                }
                None
            }
            Role::Mass(_) | Role::Rolling => None,
            Role::Stiffness => Some(("prior.slip_stiffness_std", q.std.max(GROUND * q.value))),
            // Loads in the bucket and on the machine change: only the spread between machines is removed from the prior.
            Role::Ratio(_) => {
                self.write_empty_ratio(pen, q);
                let left = LOADED * pen.description.prior.cg_ratio_std;
                Some(("prior.cg_ratio_std", q.std.max(left)))
            }
            Role::FrontRadius | Role::RearRadius => {
                let both = wider([Role::FrontRadius, Role::RearRadius]);
                Some(("prior.radius_std", both.max(RADIUS_STD)))
            }
            Role::LoadSensitivity => {
                pen.std("estimator.load_sensitivity_floor", 0.0);
                Some(("machine.radius_load_sensitivity_std", q.std))
            }
            Role::FrontGain | Role::RearGain => {
                let both = wider([Role::FrontGain, Role::RearGain]);
                Some(("sensors.torque_gain_std", both))
            }
            Role::StiffnessRatio => {
                // The ratio depends on the slip per measured torque, front against rear.
                let slip = [
                    (Role::StiffnessRatio, 1.0),
                    (Role::FrontGain, 1.0),
                    (Role::RearGain, -1.0),
                ];
                Some(("machine.stiffness_ratio_std", self.mixed(&slip)))
            }
            Role::LoadExponent => Some(("machine.stiffness_load_exponent_std", q.std)),
            Role::SlopeBias => Some(("prior.slope_bias_std", q.std.max(SLOPE_BIAS_STD))),
            Role::AccelerationOffset => {
                Some(("sensors.acceleration_offset_std", q.std.max(OFFSET_STD)))
            }
            Role::SlopeDelay => Some(("sensors.slope_delay_std", q.std.max(DELAY_STD))),
            Role::SlopeFollows => {
                let key = "sensors.slope_acceleration_sensitivity_std";
                Some((key, q.std.max(FOLLOWS_STD)))
            }
            Role::SpeedDelay => Some(("sensors.speed_delay_std", q.std.max(DELAY_STD))),
            // Belongs to a recording, or to the fit only.
            Role::Friction
            | Role::Brush
            | Role::LoadVariance
            | Role::TorqueDelay
            | Role::Relaxation
            | Role::Squat
            | Role::Settling
            | Role::WheelScatter
            | Role::SpeedScatter
            | Role::ForceScatter
            | Role::MotionScatter
            | Role::PathScatter
            | Role::Mark(_)
            | Role::Reach(_)
            | Role::Lift(_) => return,
        };
        pen.value(&self.drives.parameters[i].key, q);
        if let Some((key, std)) = std {
            pen.std(key, std);
        }
    }

    /// Writes a weighed load fraction to the lift arm, with no smaller deviation than stated: fuel and driver move it from day to day.
    fn write_empty_ratio(&self, pen: &mut Pen<Description>, q: Quantity) {
        if self.drives.loads[0].ratio.is_none() {
            return;
        }
        let stated = match pen.description.lift_arm.empty_ratio_std {
            0.0 => pen.description.prior.cg_ratio_std,
            std => std,
        };
        let std = q.std.max(stated);
        write_empty(pen, "empty_ratio", Quantity { std, ..q });
    }

    fn std(&self, role: Role) -> f64 {
        self.quantity(role).map_or(0.0, |q| q.std)
    }

    /// Standard deviation of a weighted sum of parameters, with their correlations.
    fn mixed(&self, parts: &[(Role, f64)]) -> f64 {
        let Some(found) = &self.found else {
            return 0.0;
        };
        let mut variance = 0.0;
        for (a, share_a) in parts {
            for (b, share_b) in parts {
                if let (Some(i), Some(j)) = (self.drives.index(*a), self.drives.index(*b)) {
                    let scale = self.drives.parameters[i].std * self.drives.parameters[j].std;
                    variance += share_a * share_b * scale * found.uncertainty.covariance[(i, j)];
                }
            }
        }
        variance.max(0.0).sqrt()
    }
}

//! Settings of every excavator estimator; `Settings::of(&Description::default())` is the reference machine.

pub(in crate::excavator) mod cylinder;
pub(in crate::excavator) mod described;
pub(in crate::excavator) mod doubts;
pub(in crate::excavator) mod geometry;
pub(in crate::excavator) mod settings_error;

use crate::math::sqrt;

use super::cylinder::Cylinder;
use super::doubts::Doubts;
use super::geometry::Geometry;
use super::keys::Description;
pub use super::keys::{Estimator, Paper, Prior, Variant};

/// Sensors.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sensors {
    /// Samples per second; only the first sample needs it, later ones bring their time \[Hz\].
    pub rate: f64,
    /// Noise of a velocity sample (sigma_w) [rad/s].
    pub swing_velocity_std: f64,
    /// Noise of a swing angle sample \[rad\].
    pub swing_angle_std: f64,
    /// Noise of a torque sample (sigma_T) [N m].
    pub swing_torque_std: f64,
    /// Standard deviation of the torque's gain about 1. No estimator can notice it; it widens the
    /// interval.
    pub swing_torque_gain_std: f64,
    /// Noise of a joint angle \[rad\].
    pub angle_std: f64,
    /// A velocity of this size or more is missing [rad/s].
    pub swing_velocity_limit: f64,
    /// A joint angle of this size or more is missing \[rad\].
    pub angle_limit: f64,
    /// Measured over true torque, as calibrated.
    pub swing_torque_gain: f64,
    /// Torque that is measured where there is none, as calibrated [N m].
    pub swing_torque_offset: f64,
    /// How late velocity and torque come, as stated \[s\].
    pub delays: [f64; 2],
}

/// Everything an excavator estimator needs to know beforehand.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Lengths and masses.
    pub geometry: Geometry,
    /// Viscous damping of the swing (b-bar) [N m s/rad].
    pub nominal_damping: f64,
    /// Coulomb friction torque (T_f) [N m].
    pub coulomb_friction: f64,
    /// Smallest inertia that an estimate may take [kg m^2].
    pub inertia_min: f64,
    /// Largest inertia that an estimate may take [kg m^2].
    pub inertia_max: f64,
    /// Sensors.
    pub sensors: Sensors,
    /// Prior.
    pub prior: Prior,
    /// Constants.
    pub estimator: Estimator,
    /// The paper's regression.
    pub paper: Paper,
    /// The cylinders that carry the boom, where they are described.
    pub boom: Option<Cylinder>,
    /// What a working machine may differ by; `None` for a calibrated one.
    pub doubts: Option<Doubts>,
}

impl Settings {
    /// The configuration that reproduces Table 1 of the paper on its own cycle, starting at
    /// `inertia`: the figures are reached only by starting at the true one.
    pub fn paper(inertia: f64) -> Self {
        Self::of(&Description::paper_preset(inertia))
    }

    /// Whether torque alone, or posture alone, can tell the inertia: on a machine that is calibrated, at an inertia
    /// that is declared constant, or on an axis that is no excavator's (lighter than its geometry).
    pub(super) fn is_partly_identifiable(&self) -> bool {
        let lighter = self.inertia_max < self.geometry.folded_inertia();
        self.doubts.is_none() || self.estimator.constant_inertia || lighter
    }

    /// The inertias that a machine can have of which torque or posture tells only a half: anywhere between folded
    /// and empty and stretched and full; with the `posture` known the content is left, and the damping, which is
    /// the scale.
    pub(super) fn partial_range(&self, posture: Option<[f64; 3]>) -> PartialRange {
        let Some(posture) = posture else {
            let stretched = self.geometry.inertia([0.0; 3]);
            return PartialRange {
                least: self.geometry.folded_inertia(),
                most: stretched.with_payload(self.prior.full_load()),
                scale: 0.0,
            };
        };
        let here = self.geometry.inertia(posture);
        PartialRange {
            least: here.empty,
            most: here.with_payload(self.prior.full_load()),
            scale: (self.prior.damping_std / self.nominal_damping.max(f64::MIN_POSITIVE)).min(1.0),
        }
    }

    /// Smallest and largest payload that an estimate may take: as set, but never less than what the
    /// prior holds possible [kg].
    pub(super) fn payload_range(&self) -> [f64; 2] {
        let prior = self.prior.payload + 4.0 * self.prior.payload_std;
        let e = &self.estimator;
        [e.payload_min, e.payload_max.max(prior)]
    }
}

/// What an inertia can be of which only one half is identified.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct PartialRange {
    least: f64,
    most: f64,
    scale: f64,
}

impl PartialRange {
    /// The standard deviation that covers the present inertia, `std` being that of the `inertia` which the method
    /// found [kg m^2]. That belongs to another posture or content than the present: the difference of two values
    /// that lie anywhere in a range has a sixth of its square as the variance. What lies outside the range is wrong
    /// by as much at least.
    pub(super) fn widened(&self, inertia: f64, std: f64) -> f64 {
        let range = (self.most - self.least).max(0.0);
        let outside = (inertia - self.most).max(self.least - inertia).max(0.0);
        let scale = self.scale * inertia;
        sqrt(std * std + range * range / 6.0 + outside * outside + scale * scale)
    }
}

impl Paper {
    /// Whether there is no regression at standstill. Where the user says when to begin, it runs from
    /// then on, as the paper's did.
    pub(super) fn hold_at_standstill(&self) -> bool {
        self.start_time.is_none()
    }
}

impl Settings {
    /// The reference machine, calibrated: it is exactly what its description says, and nothing is left open. Another
    /// filter with narrower intervals runs then; the settings of a real machine are [`Settings::of`] its description.
    #[must_use]
    pub fn calibrated() -> Self {
        let mut settings = Self::of(&Description::default());
        settings.sensors.swing_torque_gain_std = 0.0;
        settings.doubts = None;
        settings
    }
}

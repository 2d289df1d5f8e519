//! Settings of all excavator estimators; `Settings::of(&Description::default())` is the reference machine.

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
    /// Sampling rate; only the first sample needs it, later ones have their time \[Hz\].
    pub rate: f64,
    /// Noise of a velocity sample (sigma_w) [rad/s].
    pub swing_velocity_std: f64,
    /// Noise of a swing angle sample \[rad\].
    pub swing_angle_std: f64,
    /// Noise of a torque sample (sigma_T) [N m].
    pub swing_torque_std: f64,
    /// Standard deviation of the torque's gain about 1. Motion does not observe it, so it widens the interval.
    pub swing_torque_gain_std: f64,
    /// Noise of a joint angle \[rad\].
    pub angle_std: f64,
    /// Least absolute velocity that counts as missing [rad/s].
    pub swing_velocity_limit: f64,
    /// Least absolute joint angle that counts as missing \[rad\].
    pub angle_limit: f64,
    /// Gain of the torque sensor, measured over true, as calibrated.
    pub swing_torque_gain: f64,
    /// Offset of the torque sensor, its value at zero torque, as calibrated [N m].
    pub swing_torque_offset: f64,
    /// Offsets of the angles of boom, arm and bucket, measured less true, as calibrated \[rad\].
    pub angle_offsets: [f64; 3],
    /// Stated delays of velocity and torque \[s\].
    pub delays: [f64; 2],
}

/// Prior knowledge of an excavator estimator.
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
    /// Uncertainty of the description of a working machine; `None` for a calibrated one.
    pub doubts: Option<Doubts>,
}

impl Settings {
    /// The configuration that reproduces Table 1 of the paper on its own cycle, starting at `inertia`. The
    /// figures are reached only from the true inertia.
    pub fn paper(inertia: f64) -> Self {
        Self::of(&Description::paper_preset(inertia))
    }

    /// Whether torque alone or posture alone identifies the inertia: on a calibrated machine, with an inertia declared
    /// constant, or on an axis lighter than the described geometry (no excavator).
    pub(super) fn is_partly_identifiable(&self) -> bool {
        let lighter = self.inertia_max < self.geometry.folded_inertia();
        self.doubts.is_none() || self.estimator.constant_inertia || lighter
    }

    /// Range of the inertia where torque or posture is missing. Without posture it extends from folded and empty to
    /// stretched and full. With `posture` the payload is unknown, and the damping, which sets the scale.
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

    /// Smallest and largest payload that an estimate may take: as set, and at least four standard deviations above the
    /// mean of the prior [kg].
    pub(super) fn payload_range(&self) -> [f64; 2] {
        let prior = self.prior.payload + 4.0 * self.prior.payload_std;
        let e = &self.estimator;
        [e.payload_min, e.payload_max.max(prior)]
    }
}

/// Range of an inertia that is only partly identified.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct PartialRange {
    least: f64,
    most: f64,
    scale: f64,
}

impl PartialRange {
    /// Standard deviation that covers the present inertia; `inertia` and `std` are the method's estimate [kg m^2]. The
    /// estimate belongs to another posture or payload than the present one. The difference of two values anywhere in a
    /// range has a sixth of the squared range as its variance. An estimate outside the range errs at least by its
    /// distance.
    pub(super) fn widened(&self, inertia: f64, std: f64) -> f64 {
        let range = (self.most - self.least).max(0.0);
        let outside = (inertia - self.most).max(self.least - inertia).max(0.0);
        let scale = self.scale * inertia;
        sqrt(std * std + range * range / 6.0 + outside * outside + scale * scale)
    }
}

impl Paper {
    /// Whether the regression pauses at standstill. With a stated start time it does not, as in the paper.
    pub(super) fn hold_at_standstill(&self) -> bool {
        self.start_time.is_none()
    }
}

impl Settings {
    /// The reference machine, calibrated: its description is exact. Another filter with narrower intervals runs then.
    /// The settings of a real machine are [`Settings::of`] its description.
    #[must_use]
    pub fn calibrated() -> Self {
        let mut settings = Self::of(&Description::default());
        settings.sensors.swing_torque_gain_std = 0.0;
        settings.doubts = None;
        settings
    }
}

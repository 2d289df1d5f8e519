//! Detector of weak torque changes (modes C, and A with constant inertia).
//!
//! A single filter of velocity and unknown torque uses the posture, at the middle of the payload's prior. A
//! cumulative sum of its innovations detects the change. Only with the posture can its threshold be so low.

use crate::consistency::Cusum;
use crate::excavator::drive::Drive;
use crate::excavator::settings::Settings;
use crate::excavator::standstill::Phase;
use crate::excavator::unknown_torque::{Physics, UnknownTorque};

/// Inertia of the machine to which the drifts refer [kg m^2].
const REFERENCE_INERTIA: f64 = 6500.0;

/// Random walk of the torque on the reference machine, with known posture and with constant inertia [N m/sqrt(s)].
const POSTURE_DRIFT: f64 = 400.0;
const CONSTANT_DRIFT: f64 = 100.0;
/// Drift and threshold of the cumulative sum [standard deviations].
const SUM_DRIFT: f64 = 0.7;
const SUM_LIMIT: f64 = 6.0;
/// Least inertia, as a share of the machine's least one.
const LEAST_INERTIA: f64 = 0.1;

/// Detector of weak changes.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct WeakOnset {
    filter: UnknownTorque,
    cusum: Cusum,
    posture: bool,
    /// Torques of the machine over those of the reference machine.
    scale: f64,
}

impl WeakOnset {
    /// `posture`: the posture is known; otherwise the inertia is constant.
    pub(in crate::excavator) fn new(settings: &Settings, posture: bool) -> Self {
        let scale = if posture {
            settings.geometry.scale()
        } else {
            settings.prior.inertia / REFERENCE_INERTIA
        };
        Self {
            scale,
            filter: UnknownTorque::start(scale),
            cusum: Cusum::new(SUM_DRIFT, SUM_LIMIT),
            posture,
        }
    }

    /// Takes one tick. Returns whether a change is detected.
    pub(in crate::excavator) fn step(
        &mut self,
        settings: &Settings,
        drive: &Drive,
        phase: Phase,
    ) -> bool {
        let z = if phase == Phase::Moving {
            let physics = self.physics(settings, drive);
            self.filter
                .step(&physics, drive.period, drive.velocity, drive.variance)
                .normalised()
        } else {
            self.filter.rest(drive.variance, phase, self.scale);
            0.0
        };
        self.cusum.push(z)
    }

    fn physics(&self, s: &Settings, drive: &Drive) -> Physics {
        let (inertia, rate, torque_drift) = if self.posture {
            let payload = s.prior.payload;
            let inertia = drive.mean.with_payload(payload);
            (inertia, drive.rate.with_payload(payload), POSTURE_DRIFT)
        } else {
            (s.prior.inertia, 0.0, CONSTANT_DRIFT)
        };
        Physics {
            inertia: inertia.max(LEAST_INERTIA * s.inertia_min),
            rate,
            damping: s.nominal_damping,
            damping_std: 0.0,
            torque_noise: 0.0,
            torque_drift: self.scale * torque_drift,
        }
    }
}

//! Innovation gate and detection of torque changes from the velocity alone.
//!
//! A Kalman filter of velocity and acceleration predicts each sample. Outliers are dropped, but at most three in a row: a
//! fourth shows that the machine has moved. A lasting shift of the innovations, or a start from rest, is a change of
//! torque.

use crate::consistency::Cusum;
use crate::kalman::{Innovation, VelocityFilter};

/// Random walk of the acceleration, variance per second, for q_c = 4.7e-3 [rad^2/s^5].
const Q_PER_SECOND: f64 = 5e-2;
const REST_VELOCITY: f64 = 0.012;

/// Velocity after the gate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::excavator) struct Gated {
    /// `None` where the velocity is missing or dropped.
    pub(in crate::excavator) velocity: Option<f64>,
    /// A change of torque was detected at this sample.
    pub(in crate::excavator) event: bool,
}

/// Innovation gate: a fast Kalman filter that drops outliers.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Gate {
    filter: Option<VelocityFilter>,
    gate: f64,
    process_per_second: f64,
    rejections: u32,
}

impl Gate {
    pub(in crate::excavator) fn new(gate: f64, q_c: f64) -> Self {
        Self {
            filter: None,
            gate,
            process_per_second: Q_PER_SECOND * q_c / 4.7e-3,
            rejections: 0,
        }
    }

    /// Returns the velocity, `None` where it is missing or dropped, and its innovation.
    pub(in crate::excavator) fn step(
        &mut self,
        velocity: Option<f64>,
        variance: f64,
        period: f64,
    ) -> (Option<f64>, Innovation) {
        let filter = match (&mut self.filter, velocity) {
            (Some(filter), _) => {
                filter.predict(period, self.process_per_second * period);
                filter
            }
            (none, Some(velocity)) => none.insert(VelocityFilter::new(velocity, variance)),
            (None, None) => return (None, Innovation::default()),
        };
        let expected = filter.innovation(velocity, variance);
        let far = expected.nis() > self.gate * self.gate && self.rejections < 3;
        let velocity = velocity.filter(|_| !far);
        if far {
            self.rejections += 1;
        } else if velocity.is_some() {
            self.rejections = 0;
        }
        (velocity, filter.correct(velocity, variance))
    }
}

/// Gate, and detector of torque changes.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct ChangeDetector {
    gate: Gate,
    cusum: Cusum,
    rest: Rest,
    rest_velocity: f64,
}

/// Counts consecutive samples of rest and of motion.
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Rest {
    moving: bool,
    small: u32,
    large: u32,
}

impl ChangeDetector {
    pub(in crate::excavator) fn new(gate: f64, q_c: f64, velocity_std: f64) -> Self {
        Self {
            gate: Gate::new(gate, q_c),
            cusum: Cusum::new(1.0, 4.0),
            rest: Rest::default(),
            rest_velocity: REST_VELOCITY * velocity_std / 0.005,
        }
    }

    /// Takes one sample.
    pub(in crate::excavator) fn step(
        &mut self,
        velocity: Option<f64>,
        variance: f64,
        period: f64,
    ) -> Gated {
        let (velocity, innovation) = self.gate.step(velocity, variance, period);
        let shifted = self.cusum.push(innovation.normalised());
        let set_off = self.rest.step(velocity, self.rest_velocity);
        Gated {
            velocity,
            event: shifted || set_off,
        }
    }
}

impl Rest {
    fn step(&mut self, velocity: Option<f64>, threshold: f64) -> bool {
        let Some(y) = velocity else { return false };
        if y.abs() < threshold {
            self.small = self.small.saturating_add(1);
            self.large = 0;
        } else {
            self.large = self.large.saturating_add(1);
            self.small = 0;
        }
        if self.moving {
            self.moving = self.small < 12;
            return false;
        }
        self.moving = self.large >= 3;
        self.moving
    }
}

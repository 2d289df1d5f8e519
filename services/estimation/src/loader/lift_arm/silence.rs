//! Prediction of payload and centre of gravity while signals of the arm are missing.
//!
//! The load may have changed since the last weight, so the payload is a mixture of that weight and of the prior. T is that of
//! [`crate::loader::load::unreported_load`]; all time counts as idle:
//! ```text
//! q = 1 - exp(-age/T),   m_p = m_last + q d,   sigma^2 = (1 - q) sigma_last^2 + q sigma_any^2 + q (1 - q) d^2,   d = m_any - m_last
//! ```
//! An arm or a bucket whose angle is missing may be anywhere in its travel.

use super::geometry::UNKNOWN_BUCKET;
use super::signals::Now;
use super::{LiftWitness, Weighed};
use crate::Quantity;
use crate::loader::load::unreported_load::BETWEEN;
use crate::loader::sample::Sample;
use crate::math::{exp, sqrt};

/// Standard deviation of a missing angle of arm (about level) or bucket [rad]: arms go from -.7 to .75.
const TRAVEL: f64 = 0.5;

impl LiftWitness {
    /// Returns the prediction for this row; none before the first weight.
    pub(super) fn silent(&self, now: &Now, sample: &Sample) -> Option<Weighed> {
        self.answer?;
        let age = sample.time - self.last_time;
        let other = if age >= 0.0 {
            1.0 - exp(-age / BETWEEN)
        } else {
            1.0
        };
        let payload = mixed(self.scale.payload(), self.unknown(), other);
        let (arm, lifts) = now.lift.map_or((0.0, TRAVEL), |lift| (lift, 0.0));
        let measured = now.lift.zip(now.tilt);
        let (bucket, turns) =
            measured.map_or((UNKNOWN_BUCKET, TRAVEL), |(lift, tilt)| (lift + tilt, 0.0));
        let machine = |angles| {
            let posture = self.posture(angles, [0.0; 2], sample);
            let (drawing, values) = (&self.drawing, &self.drawing.values);
            drawing.empty_at(values, &drawing.stance(values, &posture))
        };
        let (here, there) = (
            machine([arm, bucket]),
            machine([arm + lifts, bucket + turns]),
        );
        Some(Weighed {
            silent: true,
            ..self.answer(&here, &there, payload, true)
        })
    }
}

/// Mean and standard deviation of the mixture of two estimates, the second with this probability.
fn mixed(last: Quantity, any: Quantity, likely: f64) -> Quantity {
    let away = any.value - last.value;
    let same = 1.0 - likely;
    let variance =
        same * last.std * last.std + likely * any.std * any.std + likely * same * away * away;
    Quantity {
        value: last.value + likely * away,
        std: sqrt(variance),
    }
}

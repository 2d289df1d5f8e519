//! Signals of the arm that do not come: nobody sees what the bucket holds, nor where it is.
//!
//! A load may have come or gone since the last weight, so what the bucket holds is a mixture of that one and of whatever it may hold
//! (as in [`crate::loader::load::unreported_load`], whose T it shares: nobody sees whether the machine is idle, so all time counts as that):
//! ```text
//! q = 1 - exp(-age/T),   m_p = m_last + q d,   sigma^2 = (1 - q) sigma_last^2 + q sigma_any^2 + q (1 - q) d^2,   d = m_any - m_last
//! ```
//! An arm or a bucket whose angle does not come is anywhere in its travel.

use super::geometry::UNKNOWN_BUCKET;
use super::signals::Now;
use super::{LiftWitness, Weighed};
use crate::Quantity;
use crate::loader::load::unreported_load::BETWEEN;
use crate::loader::sample::Sample;
use crate::math::{exp, sqrt};

/// Standard deviation of the angle of an arm about level, and of a bucket, that nobody measures: arms go from -.7 to .75 [rad].
const TRAVEL: f64 = 0.5;

impl LiftWitness {
    /// What may be by now; none where nothing has been weighed.
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

/// One of two, the second this likely.
fn mixed(last: Quantity, any: Quantity, likely: f64) -> Quantity {
    let away = any.value - last.value;
    let kept = 1.0 - likely;
    let variance =
        kept * last.std * last.std + likely * any.std * any.std + likely * kept * away * away;
    Quantity {
        value: last.value + likely * away,
        std: sqrt(variance),
    }
}

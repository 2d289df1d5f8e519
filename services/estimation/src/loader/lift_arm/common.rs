//! Errors of the drawing that are common to all loads, as a zero and a scale.
//!
//! With a level arm, an error e_i of a number shifts the weight of a load m_p by e_i(m_p) = z_i + s_i m_p.
//! ```text
//! zero^2 = sum w_i z_i^2,   scale^2 = sum w_i s_i^2 + s_g^2        w_i: stated variance to the assumed one (`doubt`)
//! ```
//! s_g is the gain of the pressures at a load, which an emptied bucket does not identify. Friction is no common error: its direction changes.

use super::doubt::weight;
use super::drawing::Drawing;
use super::geometry::{Posture, UNKNOWN_BUCKET, USUAL_ROD_PRESSURE};
use super::numbers::{FRICTION, HEAD_AREA, NUMBERS};
use super::turn::Turn;
use crate::CommonError;
use crate::GRAVITY;
use crate::loader::Method;
use crate::loader::keys::Description;
use crate::loader::settings::Settings;
use crate::math::{norm, sqrt};

impl Description {
    /// Errors common to all loads that the lift arm weighs; `None` where it is not described.
    pub(in crate::loader) fn loads_common(&self) -> Option<CommonError> {
        Drawing::of(&Settings::of(self, Method::FullEkf)).map(common)
    }
}

/// Errors of a drawing common to all loads.
fn common(mut drawing: Drawing) -> CommonError {
    let capacity = drawing.capacity;
    let [mut zero, mut scale] = [0.0; 2];
    for number in (0..NUMBERS).filter(|number| *number != FRICTION) {
        if !drawing.weighs_by(number) {
            continue;
        }
        drawing.put_off(number);
        let shift = |payload: f64| {
            let posture = level(&drawing, payload);
            let moved = &drawing.moved;
            let stance = drawing.stance(moved, &posture);
            drawing.shown(moved, &stance, &posture).payload() - payload
        };
        let [empty, full] = [0.0, capacity].map(shift);
        let by_load = (full - empty) / capacity;
        zero += weight(number) * empty * empty;
        scale += weight(number) * by_load * by_load;
    }
    CommonError {
        scale_std: norm(&[sqrt(scale), drawing.gain_left_std]),
        zero_std: sqrt(zero),
    }
}

/// A level arm that holds this payload, by the numbers as drawn.
fn level(drawing: &Drawing, payload: f64) -> Posture {
    let mut posture = Posture {
        arm: Turn::of(0.0),
        bucket: Turn::of(UNKNOWN_BUCKET),
        head: 0.0,
        rod: USUAL_ROD_PRESSURE,
        gravity: GRAVITY,
        acceleration: 0.0,
        seals: 0.0,
        rest: 0.0,
    };
    let values = &drawing.values;
    let shown = drawing.shown(values, &drawing.stance(values, &posture), &posture);
    let missing = (shown.empty + payload * shown.per_load - shown.lifting) / shown.lever;
    posture.head = missing / (drawing.count * values[HEAD_AREA]);
    posture
}

#[cfg(test)]
mod tests {
    use super::super::numbers::{BUCKET, SPAN};
    use super::super::tests::settings;
    use super::*;

    /// Common errors of an arm of which only this number is uncertain.
    fn of(number: usize, std: f64) -> CommonError {
        let mut drawing = Drawing::of(&settings()).expect("an arm");
        drawing.gain_left_std = 0.0;
        for other in (0..NUMBERS).filter(|other| *other != number) {
            let value = drawing.values[other];
            drawing.set(other, crate::Quantity { value, std: 0.0 });
        }
        let value = drawing.values[number];
        drawing.set(number, crate::Quantity { value, std });
        common(drawing)
    }

    #[test]
    fn a_heavier_bucket_is_a_zero_and_a_gain_a_scale_with_the_arm_s_share_as_zero() {
        let bucket = of(BUCKET, 50.0);
        let assumed = sqrt(weight(BUCKET));
        assert!((bucket.zero_std - 50.0 * assumed).abs() < 1.0, "{bucket:?}");
        assert!(bucket.scale_std < 1e-6, "{bucket:?}");
        let gain = of(SPAN, 0.02);
        assert!((gain.scale_std - 0.02 * assumed).abs() < 0.002, "{gain:?}");
        assert!(gain.zero_std > 0.02 * 560.0, "{gain:?}");
    }

    #[test]
    fn the_gain_that_an_emptied_bucket_does_not_show_is_a_scale() {
        let mut settings = settings();
        let scale = |settings: &Settings| common(Drawing::of(settings).expect("an arm")).scale_std;
        settings.sensors.pressure_gain_std = 0.0;
        let exact = scale(&settings);
        settings.sensors.pressure_gain_std = 0.03;
        assert!(scale(&settings) > norm(&[exact, 0.06]));
    }
}

//! Range of an excavator's joint angles.

use core::f64::consts::{PI, TAU};

/// Largest angle of boom, arm and bucket upwards beyond the line of the link before [rad]; a boom may point anywhere. In recordings no
/// arm reaches the line, and buckets turn 0.3 beyond it.
const BEYOND: [f64; 3] = [TAU, 0.35, 1.2];

/// Whether boom, arm and bucket can have these angles.
pub(in crate::excavator) fn possible(posture: [f64; 3]) -> [bool; 3] {
    core::array::from_fn(|i| turned(posture[i]) <= BEYOND[i])
}

/// Angle of a joint within half a turn \[rad\]. Sensors that count within a turn of their own, and differences of such sensors, may
/// be off by a whole turn. An angle beyond a turn has another unit, and stays unchanged.
#[must_use]
pub fn joint(angle: f64) -> f64 {
    if angle.abs() <= TAU {
        turned(angle)
    } else {
        angle
    }
}

/// True joint angles within half a turn, from the measured ones and their offsets, measured less true \[rad\].
#[must_use]
pub fn true_posture(measured: [Option<f64>; 3], offsets: [f64; 3]) -> [Option<f64>; 3] {
    core::array::from_fn(|i| Some(joint(measured[i]? - offsets[i])))
}

/// The equal angle within half a turn.
pub(in crate::excavator) fn turned(angle: f64) -> f64 {
    if angle.abs() <= PI {
        return angle;
    }
    let angle = angle % TAU;
    if angle > PI {
        angle - TAU
    } else if angle < -PI {
        angle + TAU
    } else {
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_is_where_it_is_whichever_turn_a_sensor_counts() {
        assert!((joint(-1.4 + TAU) + 1.4).abs() < 1e-12);
        assert!((joint(1.4 - TAU) - 1.4).abs() < 1e-12);
        assert_eq!(joint(-1.4), -1.4);
        assert_eq!(joint(-80.0), -80.0, "degrees stay, to be named");
        assert!(joint(f64::NAN).is_nan());
    }

    #[test]
    fn a_true_angle_is_the_measured_one_without_its_offset() {
        let measured = [Some(0.63), None, Some(-1.4 + TAU)];
        let [boom, arm, bucket] = true_posture(measured, [0.03, 0.1, -0.1]);
        assert!((boom.expect("measured") - 0.6).abs() < 1e-12);
        assert!((bucket.expect("measured") + 1.3).abs() < 1e-12);
        assert_eq!(arm, None);
        assert_eq!(true_posture(measured, [0.0; 3])[0], measured[0]);
    }
}

//! The course for a calibration: the swings of the working cycle, then slow full lifts while the upper body stands.

use super::cycle;
use super::path::Move;
use super::payload::Load;
use super::plant::Plant;

/// Moves of boom, arm and bucket after the swings: from, to [s], by [deg]. The bucket is filled and leaves the ground. The boom
/// goes up and down with the arm in and with the arm out. The bucket is emptied.
const BOOM: &[(f64, f64, f64)] = &[
    (3.6, 4.6, 6.0),
    (5.0, 13.0, 28.0),
    (13.5, 21.5, -28.0),
    (25.0, 33.0, 28.0),
    (33.5, 41.5, -28.0),
    (43.6, 45.0, -6.0),
];
const ARM: &[(f64, f64, f64)] = &[(0.8, 3.2, -30.0), (22.0, 24.5, 45.0), (43.6, 45.0, -15.0)];
const BUCKET: &[(f64, f64, f64)] = &[(1.4, 3.4, -50.0), (42.0, 43.5, 50.0)];
/// Times of filling and emptying the bucket [s].
const FILL: (f64, f64) = (1.5, 3.4);
const DUMP: (f64, f64) = (42.2, 43.3);
/// Length of the lifts [s].
const LENGTH: f64 = 46.0;
/// Default payload [kg].
const PAYLOAD: f64 = 423.0;

/// The plant; with `payload` \[kg\], every bucket carries it.
pub(super) fn plant(payload: Option<f64>) -> Plant {
    let mass = payload.unwrap_or(PAYLOAD);
    let mut plant = cycle::plant(Some(mass));
    let begin = plant.period;
    let later = |(from, to): (f64, f64)| (begin + from, begin + to);
    for (joint, moves) in plant.path.joints.iter_mut().zip([BOOM, ARM, BUCKET]) {
        joint.moves.extend(moves.iter().map(|&(from, to, degrees)| {
            let (from, to) = later((from, to));
            Move { from, to, degrees }
        }));
    }
    plant.loads.push(Load {
        mass,
        fill: later(FILL),
        dump: later(DUMP),
    });
    plant.period += LENGTH;
    plant
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_ends_as_it_begins_and_lifts_slowly_while_the_upper_body_stands() {
        let plant = plant(None);
        let begin = plant.period - LENGTH;
        let [first, last] = [0.0, plant.period - 1e-9].map(|time| plant.path.posture(time));
        for (a, b) in first.iter().zip(last) {
            // Sums of thirty moves of tens of degrees: rounding.
            assert!((a - b).abs() < 1e-12);
        }
        for k in 0..4600 {
            let time = begin + 0.01 * f64::from(k);
            assert_eq!(plant.torque(time), 0.0);
            let is_lifting = (5.0..41.5).contains(&(time - begin));
            if is_lifting {
                assert!(plant.path.rate(time)[0].abs() < 0.12, "{time}");
                assert_eq!(plant.payload(time), PAYLOAD);
            }
        }
    }
}

//! Detects a low bucket that ground or heap carries, by its payload: a bucket that drags over the ground, grades, or drives into a heap.
//!
//! A bucket that does not turn loses nothing, and only ground or heap fill a low one. So a low bucket that shows less than it held in the
//! air lies on the ground, and one that shows more is in a heap, which loads its edge before anything is in it. Neither needs a torque.
//!
//! Driving alone ends neither, since a bucket drags and a heap is driven into. The bucket is free once
//! - the arm lifts it out of reach,
//! - it is turned up and carries its load: its edge is out of the ground, or
//! - the arm has risen and the machine has backed away from the foremost place.

use crate::Quantity;
use crate::math::norm;

/// Standard deviations by which a low bucket must show less than it held in the air, to lie on the ground. Errors of drawing and seals are
/// common to both weights, so by chance they differ by less. With two thirds of it, a loader with a locked drive loses .08 of its trusted
/// rows; with 2, a bucket that drags while the machine backs is found later.
const LESS: f64 = 1.5;
/// The same for more, to be in a heap, which at once loads the edge by several times the empty bucket's weight. With two thirds of it empty
/// buckets lose .02 more of their trusted rows.
const MORE: f64 = 3.0;
/// Least excess in a heap, as a share of the capacity: an arm that has just been lowered shows a tenth less than one that stands low.
const HEAPED: f64 = 0.2;
/// Standard deviation of the moment by a change of posture, as a share.
const POSTURE: f64 = 0.015;
/// Angle beyond its least one at which a bucket is turned up [rad]: setting a blade takes less, filling a bucket more.
const TURNED_UP: f64 = 0.3;
/// Rise of the arm above its least angle [rad], and distance behind the foremost place [m], beyond which a low bucket is free.
const RISEN: f64 = 0.05;
const BEHIND: f64 = 0.3;

/// Payload last known in the air, and state of the low bucket.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Grading {
    /// Payload last known in the air [kg].
    in_the_air: Option<Quantity>,
    /// Least angles of the arm and of the bucket to the horizontal since the bucket is low [rad].
    least: [f64; 2],
    /// Distance from the foremost place since then [m].
    behind: f64,
    /// Ground or heap may carry it.
    rests: bool,
}

impl Default for Grading {
    /// At the start the payload is unknown.
    fn default() -> Self {
        Self {
            in_the_air: None,
            least: [f64::INFINITY; 2],
            behind: 0.0,
            rests: false,
        }
    }
}

impl Grading {
    /// Updates with the payload, none where it is unknown [kg], the angles of arm and bucket to the horizontal where the bucket is `low`
    /// [rad], the whole moment as a weight in the bucket and the capacity [kg], and the distance driven `forward` since the last row [m].
    /// Returns whether ground or heap may carry the bucket.
    pub fn see(
        &mut self,
        payload: Option<Quantity>,
        low: Option<[f64; 2]>,
        [moment, capacity]: [f64; 2],
        forward: f64,
    ) -> bool {
        let Some([lift, bucket]) = low else {
            *self = Self {
                in_the_air: payload.or(self.in_the_air),
                ..Self::default()
            };
            return false;
        };
        self.least = [self.least[0].min(lift), self.least[1].min(bucket)];
        self.behind = (self.behind - forward).max(0.0);
        if lift > self.least[0] + RISEN && self.behind > BEHIND {
            self.in_the_air = payload.or(self.in_the_air);
            self.rests = false;
        } else if bucket > self.least[1] + TURNED_UP {
            self.rests = false;
        } else if let (Some(payload), Some(held)) = (payload, self.in_the_air) {
            let std = norm(&[payload.std, held.std, POSTURE * moment]);
            let more = payload.value - held.value;
            self.rests |= more < -LESS * std || more > (MORE * std).max(HEAPED * capacity);
        }
        self.rests
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Angles of arm and bucket of a flat bucket near the ground [rad].
    const FLAT: Option<[f64; 2]> = Some([-0.5, 0.1]);
    /// Whole moment as a weight in the bucket, and capacity [kg].
    const MOMENT: [f64; 2] = [900.0, 4000.0];

    fn kg(value: f64) -> Option<Quantity> {
        Some(Quantity { value, std: 50.0 })
    }

    /// Lowered flat with the payload that it held in the air; none where that is unknown.
    fn let_down(held: Option<f64>) -> Grading {
        let mut grading = Grading::default();
        assert!(!grading.see(held.and_then(kg), None, MOMENT, 0.0));
        grading
    }

    #[test]
    fn a_low_bucket_is_free_while_it_shows_what_it_held_in_the_air() {
        for held in [0.0, 3000.0] {
            for more in [-50.0, 150.0] {
                assert!(!let_down(Some(held)).see(kg(held + more), FLAT, MOMENT, 0.0));
            }
            assert!(!let_down(Some(held)).see(None, FLAT, MOMENT, 0.0));
        }
        assert!(!let_down(None).see(kg(-400.0), FLAT, MOMENT, 0.0));
    }

    #[test]
    fn one_that_ground_or_heap_carry_is_free_when_it_is_lifted_or_turned_up() {
        for shown in [-400.0, 2000.0] {
            let rests = || {
                let mut grading = let_down(Some(0.0));
                assert!(grading.see(kg(shown), FLAT, MOMENT, 0.0));
                let turned = Some([-0.5, 0.2]);
                assert!(grading.see(kg(0.0), turned, MOMENT, 0.0), "still");
                grading
            };
            assert!(!rests().see(kg(900.0), Some([-0.5, 0.6]), MOMENT, 0.0));
            let mut lifted = rests();
            assert!(!lifted.see(kg(80.0), None, MOMENT, 0.0));
            assert!(!lifted.see(kg(80.0), FLAT, MOMENT, 0.0));
        }
    }

    #[test]
    fn it_is_free_when_the_arm_has_risen_and_the_machine_has_backed_and_not_by_one_of_them() {
        let risen = Some([-0.4, 0.1]);
        for (low, forward, rests) in [
            (FLAT, -1.0, true),
            (risen, 1.0, true),
            (risen, -0.2, true),
            (risen, -1.0, false),
        ] {
            let mut grading = let_down(Some(0.0));
            assert!(grading.see(kg(-400.0), FLAT, MOMENT, 0.0));
            assert_eq!(grading.see(None, low, MOMENT, forward), rests);
        }
        // What it holds then is known in the air.
        let mut grading = let_down(Some(0.0));
        assert!(!grading.see(None, FLAT, MOMENT, -1.0));
        assert!(!grading.see(kg(1500.0), risen, MOMENT, 0.0));
        assert!(!grading.see(kg(1500.0), risen, MOMENT, 1.0));
    }
}

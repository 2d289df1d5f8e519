//! Detects a low bucket that the ground carries, where no torque is measured: grading and stripping drive on with the bucket in the ground.
//!
//! A bucket that does not turn loses nothing. A low one that shows less than it held in the air therefore lies on the ground. The ground may
//! carry it until the arm lifts it. A bucket turned up carries its load: its edge is out of the ground.

use crate::Quantity;
use crate::math::norm;

/// Standard deviations by which a low bucket must show less than it held in the air. Errors of drawing and seals are common to both weights,
/// so by chance they differ by less. With half of it V cycles without torque lose .06 of their trusted share; with twice of it grading is
/// as often wrong.
const LESS: f64 = 1.0;
/// Standard deviation of the moment by a change of posture, as a share.
const POSTURE: f64 = 0.015;
/// Angle beyond its least one at which a bucket is turned up [rad]: setting a blade takes less, filling a bucket more.
const TURNED_UP: f64 = 0.3;

/// Payload last known in the air, and state of the low bucket.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Grading {
    /// Payload last known in the air [kg].
    in_the_air: Option<Quantity>,
    /// Least angle of the bucket to the horizontal since it is low [rad].
    flattest: f64,
    /// The ground may carry it.
    grades: bool,
}

impl Default for Grading {
    /// At the start the payload is unknown.
    fn default() -> Self {
        Self {
            in_the_air: None,
            flattest: f64::INFINITY,
            grades: false,
        }
    }
}

impl Grading {
    /// Updates with the payload, none where it is unknown [kg], the bucket's angle where it is `low` [rad], and the whole moment as a weight
    /// in the bucket [kg]. Returns whether the ground may carry the bucket.
    pub fn see(&mut self, payload: Option<Quantity>, low: Option<f64>, moment: f64) -> bool {
        let Some(bucket) = low else {
            (self.flattest, self.grades) = (f64::INFINITY, false);
            self.in_the_air = payload.or(self.in_the_air);
            return false;
        };
        self.flattest = self.flattest.min(bucket);
        if bucket > self.flattest + TURNED_UP {
            self.grades = false;
        } else if let (Some(payload), Some(held)) = (payload, self.in_the_air) {
            let std = norm(&[payload.std, held.std, POSTURE * moment]);
            self.grades |= payload.value < held.value - LESS * std;
        }
        self.grades
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAT: Option<f64> = Some(0.1);
    const MOMENT: f64 = 900.0;

    fn kg(value: f64) -> Option<Quantity> {
        Some(Quantity { value, std: 50.0 })
    }

    /// Lowered flat with the payload that it held in the air; none where that is unknown.
    fn let_down(held: Option<f64>) -> Grading {
        let mut grading = Grading::default();
        assert!(!grading.see(held.and_then(kg), None, MOMENT));
        grading
    }

    #[test]
    fn a_low_bucket_is_free_while_it_shows_what_it_held_in_the_air_or_more() {
        for held in [0.0, 3000.0] {
            for more in [-50.0, 400.0] {
                assert!(!let_down(Some(held)).see(kg(held + more), FLAT, MOMENT));
            }
            assert!(!let_down(Some(held)).see(None, FLAT, MOMENT));
        }
        assert!(!let_down(None).see(kg(-400.0), FLAT, MOMENT));
    }

    #[test]
    fn one_that_the_ground_carries_is_free_when_it_is_lifted_or_turned_up() {
        let grades = || {
            let mut grading = let_down(Some(0.0));
            assert!(grading.see(kg(-400.0), FLAT, MOMENT));
            assert!(grading.see(kg(0.0), Some(0.2), MOMENT), "it still lies");
            grading
        };
        assert!(!grades().see(kg(900.0), Some(0.6), MOMENT), "it was filled");
        let mut lifted = grades();
        assert!(!lifted.see(kg(80.0), None, MOMENT));
        assert!(!lifted.see(kg(80.0), FLAT, MOMENT));
    }
}

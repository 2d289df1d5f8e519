//! Whether the ground carries a low bucket though nobody tells a torque: who grades or strips drives on with it in the ground.
//!
//! A bucket that does not turn loses nothing. So one that shows less, low, than it held in the air lies on the ground, and the ground may
//! carry it until the arm lifts it. A bucket that turns up carries its load: its edge is out of the ground.

use crate::Quantity;
use crate::math::norm;

/// Standard deviations by which a low bucket shows less than it held in the air: of the drawing and of the seals both have the same errors,
/// so by chance they differ by less. With a half of it V cycles without torque lose .06 of their trust, with two of it grading is as
/// often wrong.
const LESS: f64 = 1.0;
/// What another posture of the arm leaves of the moment, as a share.
const POSTURE: f64 = 0.015;
/// So far beyond its flattest a bucket is turned up [rad]: a blade is set by less, a bucket is filled by more.
const TURNED_UP: f64 = 0.3;

/// What the bucket held, and how it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Grading {
    /// What it held when it was last known in the air [kg].
    in_the_air: Option<Quantity>,
    /// Its least angle to the horizontal since it is low [rad].
    flattest: f64,
    grades: bool,
}

impl Default for Grading {
    /// At the start nobody knows what it held.
    fn default() -> Self {
        Self {
            in_the_air: None,
            flattest: f64::INFINITY,
            grades: false,
        }
    }
}

impl Grading {
    /// Takes what the bucket seems to hold, none where that is not known [kg], its angle where it is `low` [rad], and the weight in it that
    /// has the arm's whole moment [kg]; whether the ground may carry it.
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

    /// Let down flat with what it held in the air, none where nobody saw it.
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

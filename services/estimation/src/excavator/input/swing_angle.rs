//! Checks that a swing angle can follow from the one before.
//!
//! The angle of an encoder has no range of its own: it counts turns. So an angle is valid if the machine can have turned there since the
//! last one. A value that stays elsewhere has another zero: everything that stores angles restarts.

use core::f64::consts::TAU;

/// Range of an encoder [rad]: beyond, the machine would have turned for days, and differences would lose their last digits.
const RANGE: f64 = 1e6;
/// Largest velocity of any machine, whatever is described [rad/s].
const FASTEST: f64 = 100.0;
/// Time after which an angle that does not follow has another zero [s].
const ELSEWHERE: f64 = 1.0;

/// Result of the check.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::excavator) enum Followed {
    /// The angle is valid, or missing.
    Yes(Option<f64>),
    /// The angle counts from another zero.
    Elsewhere(f64),
}

/// The last valid angle.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct SwingAngle {
    last: Option<f64>,
    /// Time since then [s].
    gap: f64,
}

impl SwingAngle {
    /// Checks the angle of a row. `period`: of the row [s]; `fastest`: greatest velocity of the machine [rad/s].
    pub(in crate::excavator) fn pass(
        &mut self,
        value: Option<f64>,
        period: f64,
        fastest: f64,
    ) -> Followed {
        self.gap += period;
        let Some(value) = value.filter(|v| v.abs() <= RANGE) else {
            return Followed::Yes(None);
        };
        let Some(last) = self.last else {
            (self.last, self.gap) = (Some(value), 0.0);
            return Followed::Yes(Some(value));
        };
        // An encoder that does not count turns jumps by one turn.
        let possible = TAU + fastest.min(FASTEST) * self.gap;
        let follows = (value - last).abs() <= possible;
        if !follows && self.gap < ELSEWHERE {
            return Followed::Yes(None);
        }
        (self.last, self.gap) = (Some(value), 0.0);
        if follows {
            Followed::Yes(Some(value))
        } else {
            Followed::Elsewhere(value)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_of_any_size_is_left_out_and_another_zero_restarts() {
        for wrong in [1e1, 1e3, 1e6, 1e20, 1e160, 1e308, f64::NAN, f64::INFINITY] {
            let mut angle = SwingAngle::default();
            for k in 0..100 {
                assert_eq!(
                    angle.pass(Some(0.01 * k as f64), 0.01, 5.0),
                    Followed::Yes(Some(0.01 * k as f64))
                );
            }
            for sign in [1.0, -1.0] {
                assert_eq!(
                    angle.pass(Some(sign * wrong), 0.01, 5.0),
                    Followed::Yes(None),
                    "{wrong}"
                );
            }
            assert_eq!(angle.pass(Some(1.0), 0.01, 5.0), Followed::Yes(Some(1.0)));
        }
        let mut angle = SwingAngle::default();
        angle.pass(Some(0.0), 0.01, 5.0);
        let taken = [(); 200].map(|()| angle.pass(Some(40.0), 0.01, 5.0));
        let elsewhere = taken.iter().filter(|f| **f == Followed::Elsewhere(40.0));
        assert_eq!(elsewhere.count(), 1);
        assert_eq!(taken[199], Followed::Yes(Some(40.0)));
        // An encoder of one turn.
        assert_eq!(
            angle.pass(Some(40.0 - TAU), 0.01, 5.0),
            Followed::Yes(Some(40.0 - TAU))
        );
    }
}

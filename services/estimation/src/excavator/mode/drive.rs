//! Inputs of the models between two ticks: means and rates of torque and posture.

use crate::excavator::geometry::{Geometry, Inertia, Turns, turns};
use crate::excavator::grid::Tick;

/// Inputs of one step from tick k-1 to tick k.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Drive {
    pub(in crate::excavator) time: f64,
    pub(in crate::excavator) period: f64,
    /// Gated velocity and its variance.
    pub(in crate::excavator) velocity: Option<f64>,
    pub(in crate::excavator) variance: f64,
    /// Mean of the two torques [N m].
    pub(in crate::excavator) torque: f64,
    /// Inertia at the tick, its mean and its rate over the step.
    pub(in crate::excavator) now: Inertia,
    pub(in crate::excavator) mean: Inertia,
    pub(in crate::excavator) rate: Inertia,
    /// Joint angles [rad], and sines and cosines of the angles of boom, arm and bucket to the horizontal.
    pub(in crate::excavator) posture: [f64; 3],
    pub(in crate::excavator) turns: Turns,
    /// Variance of a joint angle by sensor noise [rad^2].
    pub(in crate::excavator) posture_variance: f64,
    /// Pitch and roll of the upper body [rad].
    pub(in crate::excavator) inclination: Option<[f64; 2]>,
    /// Head and rod pressure of the boom's cylinders [Pa].
    pub(in crate::excavator) boom_pressure: Option<[f64; 2]>,
    /// Share of a row's noise variance that remains after averaging.
    pub(in crate::excavator) share: f64,
    /// Torque and posture are known.
    pub(in crate::excavator) driven: bool,
    /// The posture is known.
    pub(in crate::excavator) seen: bool,
    /// Additional variance of a torque that has been missing for long [(N m)^2].
    pub(in crate::excavator) stale_torque: f64,
    /// Variance of the mean torque of the step by its change T in it [(N m)^2]. The rows do not show when in the step it changed, T^2/12.
    /// The frames of torque and velocity are each up to a row old, T^2/6.
    pub(in crate::excavator) changing_torque: f64,
}

/// Age beyond which a missing torque is unknown, and no longer held [s].
const TORQUE_HOLD: f64 = 0.10;
/// Standard deviation, per tick, of an unknown torque [sigma_T]. The torque of a swing changes by
/// thousands of newton metres in a quarter of a second. A lasting error has more effect than
/// noise of its size.
const UNKNOWN_TORQUE: f64 = 300.0;

/// Stores torque and inertia of the last tick.
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Driver {
    torque: Option<f64>,
    inertia: Option<Inertia>,
    /// The last computed posture.
    asked: Option<Asked>,
}

/// A posture with its sines, cosines and inertia.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Asked {
    posture: [f64; 3],
    turns: Turns,
    inertia: Inertia,
}

impl Driver {
    /// Inertia at a posture; computed once per tick, also for two calls.
    pub(in crate::excavator) fn inertia(
        &mut self,
        geometry: &Geometry,
        posture: [f64; 3],
    ) -> &Inertia {
        &self.ask(geometry, posture).inertia
    }

    fn ask(&mut self, geometry: &Geometry, posture: [f64; 3]) -> &Asked {
        if self.asked.is_some_and(|asked| asked.posture != posture) {
            self.asked = None;
        }
        self.asked.get_or_insert_with(|| {
            let turns = turns(posture);
            Asked {
                posture,
                turns,
                inertia: geometry.inertia_turned(&turns),
            }
        })
    }

    /// The step that leads to `tick`; the first step has constant torque and posture.
    pub(in crate::excavator) fn step(
        &mut self,
        tick: &Tick,
        geometry: Option<&Geometry>,
        torque_std: f64,
    ) -> Drive {
        let (now, turns) = geometry.map_or_else(Default::default, |geometry| {
            let asked = self.ask(geometry, tick.posture);
            (asked.inertia, asked.turns)
        });
        let (driven, seen) = (tick.has_torque(), tick.has_posture());
        // A change across a pause is not a change within the step.
        let torque = self.torque.unwrap_or(tick.torque);
        self.torque = driven.then_some(tick.torque);
        let before = self.inertia.unwrap_or(now);
        self.inertia = seen.then_some(now);
        let h = tick.period;
        let change = tick.torque - torque;
        Drive {
            time: tick.time,
            period: h,
            velocity: tick.velocity,
            variance: tick.velocity_variance,
            torque: 0.5 * (tick.torque + torque),
            now,
            mean: now.with(&before, |a, b| 0.5 * (a + b)),
            rate: now.with(&before, |a, b| (a - b) / h),
            posture: tick.posture,
            turns,
            posture_variance: tick.posture_variance,
            inclination: tick.inclination,
            boom_pressure: tick.boom_pressure,
            share: tick.share,
            driven: driven && seen,
            seen,
            changing_torque: change * change / 4.0,
            stale_torque: if tick.torque_age > TORQUE_HOLD {
                (UNKNOWN_TORQUE * torque_std) * (UNKNOWN_TORQUE * torque_std)
            } else {
                0.0
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_torque_that_changes_is_known_to_half_its_change_and_the_first_one_does_not_change() {
        let tick = |torque| Tick {
            period: 0.01,
            torque,
            ..Tick::default()
        };
        let mut driver = Driver::default();
        let mut uncertain = |torque| driver.step(&tick(torque), None, 500.0).changing_torque;
        assert_eq!(uncertain(60e3), 0.0);
        assert_eq!(uncertain(60e3), 0.0);
        assert_eq!(uncertain(52e3), 4e3 * 4e3);
    }
}

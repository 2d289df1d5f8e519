//! The random work cycle: legs of acceleration and braking, some of them followed by rolling.
//!
//! For its first 300 s the driver plans in advance, as the reference does: each leg starts from the speed planned for the end of
//! the leg before. Later, and after the end of any other scenario, each leg starts from the true speed, so that the cycle can
//! continue for days.

use super::scenario::Scenario;
use crate::noise::Noise;

/// End of the pre-planned part [s].
const PLANNED_UNTIL: f64 = 300.0;

/// The driver's next decisions.
#[derive(Clone, Debug)]
pub(super) struct WorkCycle {
    noise: Noise,
    /// Begin of the next leg [s].
    next: f64,
    /// Speed at the end of the present leg, as planned [m/s].
    speed: f64,
    planned: bool,
    faster: Option<bool>,
    /// Whether every other run is driven backwards, and whether this one is.
    reverses: bool,
    backwards: bool,
    /// Time at which rolling begins, before the next leg.
    roll_from: Option<f64>,
}

impl WorkCycle {
    /// Duration of every change of torque [s].
    pub const RAMP: f64 = 0.25;

    /// The cycle of a work-cycle scenario, or the continuation of another. A cruise never ends.
    pub fn new(scenario: Scenario, noise: Noise) -> Self {
        let planned = matches!(scenario, Scenario::WorkCycle | Scenario::Dither);
        let next = match scenario {
            Scenario::Cruise | Scenario::Loading | Scenario::Lifts => f64::INFINITY,
            _ if planned => 0.5,
            _ => scenario.duration(),
        };
        Self {
            noise,
            next,
            speed: 0.0,
            planned,
            faster: planned.then_some(true),
            reverses: false,
            backwards: false,
            roll_from: None,
        }
    }

    /// Sets whether every other run is driven backwards.
    pub fn reversing(self, reverses: bool) -> Self {
        Self { reverses, ..self }
    }

    /// Whether the present run is driven backwards.
    pub fn backwards(&self) -> bool {
        self.backwards
    }

    /// The time of a change that is due at `t`, and the acceleration after it [m/s^2]; `speed` is the true one.
    pub fn next_leg(&mut self, t: f64, speed: f64) -> Option<(f64, f64)> {
        if let Some(from) = self.roll_from.take_if(|from| *from <= t) {
            return Some((from, 0.0));
        }
        (self.next <= t).then(|| self.decide(speed))
    }

    fn decide(&mut self, actual: f64) -> (f64, f64) {
        let from = self.next;
        let start = if self.planned && from < PLANNED_UNTIL {
            self.speed
        } else {
            actual
        };
        let faster = self.faster.unwrap_or(actual < 3.0);
        let noise = &mut self.noise;
        let a = noise.uniform(0.5, 1.1) * if faster { 1.0 } else { -1.0 };
        let target = match (faster, self.reverses) {
            (true, false) => noise.uniform(3.5, 5.5),
            (false, false) => noise.uniform(0.8, 1.5),
            (true, true) => noise.uniform(2.0, 4.5),
            (false, true) => 0.0,
        };
        if self.reverses && faster {
            self.backwards = !self.backwards;
        }
        let duration = ((target - start) / a).max(0.8);
        self.next += duration;
        self.speed = start + a * duration;
        if noise.uniform(0.0, 1.0) < 0.4 {
            self.roll_from = Some(self.next);
            self.next += noise.uniform(0.5, 2.0);
        }
        self.faster = Some(!faster);
        (from, a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times and accelerations of the changes in the first `until` seconds, on a machine that follows the plan.
    fn changes(until: f64) -> Vec<(f64, f64)> {
        let mut cycle = WorkCycle::new(Scenario::WorkCycle, Noise::new(5));
        let mut all = Vec::new();
        let mut speed = 0.0;
        for k in 0..(until * 1000.0) as u32 {
            all.extend(cycle.next_leg(f64::from(k) * 1e-3, speed));
            speed += 1e-3 * all.last().map_or(0.0, |c: &(f64, f64)| c.1);
        }
        all
    }

    #[test]
    fn legs_alternate_and_keep_the_speed_in_its_range() {
        let all = changes(1000.0);
        let (mut speed, mut up) = (0.0, true);
        for pair in all.windows(2) {
            if pair[0].1 != 0.0 {
                assert_eq!(pair[0].1 > 0.0, up);
                up = !up;
            }
            speed += pair[0].1 * (pair[1].0 - pair[0].0);
            // A leg lasts at least 0.8 s, so it may exceed its target slightly.
            assert!((0.0..6.5).contains(&speed), "{speed}");
        }
        assert!(all.len() > 200);
    }

    #[test]
    fn a_longer_run_begins_like_a_shorter_one() {
        let (short, long) = (changes(50.0), changes(80.0));
        assert_eq!(short[..], long[..short.len()]);
    }
}

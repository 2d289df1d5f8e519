//! The standing upper body: its velocity and slope are known, the swing is over, and the machine may travel. Tracks may turn it too.

use super::filter::{SLOPE, W};
use super::trail::Trail;
use super::{CREPT, Working};
use crate::excavator::drive::Drive;
use crate::excavator::settings::Settings;
use crate::excavator::standstill::released_variance;
use crate::kalman::Innovation;

/// Standard deviation of an inclinometer sample [rad].
const INCLINOMETER: f64 = 0.03;
/// Mounting error of the inclinometer [rad].
const MOUNTING: f64 = 0.004;
/// Probability of such travel per further second [1/s].
const TRAVELS: f64 = 0.02;
/// Time of standing after which the machine may have travelled to other ground on its tracks [s].
const TRAVEL: f64 = 2.0;
/// Time within which the slope's variance returns to the stated one, while tracks turn the upper body [s]: the machine is travelling.
const UNDER_WAY: f64 = 2.0;
/// Torque beyond friction that may still be none [standard deviations of its noise].
const NONE: f64 = 3.0;

impl Working {
    /// Processes a tick at standstill. After a while the machine may have travelled, or another bucket may be attached.
    pub(super) fn stand(&mut self, period: f64, trail: &mut Option<Trail>) -> Innovation {
        self.rides = false;
        if self.slow_for > TRAVEL {
            self.attachment.stands(self.slow_for);
            self.travels(period);
        }
        self.rest(0.0, 1e-6, trail)
    }

    /// Holds the velocity at standstill, or restarts it, and ends the swing.
    pub(super) fn rest(
        &mut self,
        velocity: f64,
        variance: f64,
        trail: &mut Option<Trail>,
    ) -> Innovation {
        self.filter.set(W, velocity, variance, trail);
        self.parallel.filter.set(W, velocity, variance, &mut None);
        self.filter.acceleration = 0.0;
        self.noise.rest();
        self.sway.rest();
        self.change.clear();
        self.changed = false;
        let pushed = core::mem::take(&mut self.pushed);
        if self.parallel.is_over() {
            self.contradiction.swung(self.agreement.factor());
            if !pushed && self.noise.is_unexplained() {
                self.contradiction.is_left_unexplained();
            }
        }
        self.agreement.interrupt();
        self.weighed_something = 0.0;
        Innovation::default()
    }

    /// Starts a motion with a measured velocity, which lags by the delay times the acceleration.
    pub(super) fn set_off(
        &mut self,
        velocity: f64,
        drive: &Drive,
        settings: &Settings,
        trail: &mut Option<Trail>,
    ) -> Innovation {
        self.joined &= self.slow_for <= CREPT;
        self.rides = self.joined || is_quiet(settings, drive.torque);
        if self.rides {
            self.torque = drive.torque;
        }
        let innovation = self.rest(velocity, released_variance(drive.variance), trail);
        let inertia = drive
            .now
            .with_payload(self.filter.load())
            .max(settings.inertia_min);
        let acceleration = drive.torque / inertia;
        self.filter.lag(acceleration, trail);
        self.parallel.filter.lag(acceleration, &mut None);
        innovation
    }

    /// Returns whether tracks still turn the upper body: as long as no torque acts. A motion whose start was not seen counts as such.
    pub(super) fn is_riding(&mut self, s: &Settings, drive: &Drive, share: f64) -> bool {
        if self.rides && !self.joined {
            self.torque += share * (drive.torque - self.torque);
            self.rides = is_quiet(s, self.torque);
            self.travel(drive.period / UNDER_WAY);
        }
        self.rides
    }

    /// Adds the variance of another slope, as the machine may have travelled in this time \[s\].
    pub(super) fn travels(&mut self, time: f64) {
        self.travel((TRAVELS * time).min(1.0));
    }

    /// Adds the variance of another slope, as the machine may have travelled with this probability.
    fn travel(&mut self, probability: f64) {
        for i in [SLOPE, SLOPE + 1] {
            let anywhere = self.stated[i] * self.stated[i];
            let more = probability * anywhere;
            let parallel = &mut self.parallel.filter;
            for filter in [&mut self.filter, parallel, &mut self.scale.filter] {
                if filter.p[i][i] < anywhere {
                    filter.p[i][i] += more;
                }
            }
        }
    }

    /// Measures the slope along the axes of the start, from pitch and roll of the standing upper body. During a swing, accelerations
    /// would appear as inclination.
    pub(super) fn incline(&mut self, [pitch, roll]: [f64; 2], trail: &mut Option<Trail>) {
        let (sin, cos) = self.turn;
        let slopes = [roll * cos - pitch * sin, -roll * sin - pitch * cos];
        self.scale
            .incline(slopes, MOUNTING * MOUNTING, INCLINOMETER * INCLINOMETER);
        for (i, slope) in (SLOPE..).zip(slopes) {
            self.described[i] = slope;
            if self.filter.p[i][i] > MOUNTING * MOUNTING {
                let value = slope - self.filter.x[i];
                let variance = INCLINOMETER * INCLINOMETER;
                self.filter.measure([(i, 1.0)], value, variance, 1e3, trail);
                let parallel = &mut self.parallel.filter;
                let value = slope - parallel.x[i];
                parallel.measure([(i, 1.0)], value, variance, 1e3, &mut None);
            }
        }
    }
}

/// Returns whether a torque counts as none: within friction and the noise of its sensor.
pub(super) fn is_quiet(s: &Settings, torque: f64) -> bool {
    torque.abs() < s.coulomb_friction + NONE * s.sensors.swing_torque_std
}

#[cfg(test)]
mod tests {
    use super::super::filter::FRICTION;
    use super::*;
    use crate::excavator::Reason;
    use crate::excavator::keys::Description;
    use crate::excavator::standstill::Phase;
    use crate::math::sin_cos;

    #[test]
    fn a_slope_that_the_inclinometer_shows_is_no_reason() {
        let settings = Settings::of(&Description::default());
        let doubts = settings.doubts.expect("doubts");
        let mut working = Working::new(&settings, &doubts);
        for _ in 0..200 {
            working.incline([0.06, 0.0], &mut None);
        }
        assert!((working.filter.x[SLOPE + 1] + 0.06).abs() < 0.01);
        assert_eq!(working.reason(false, (false, false)), Reason::None);
        // The motion contradicts the inclinometer.
        working.filter.x[SLOPE + 1] = 0.06;
        assert_eq!(working.reason(false, (false, false)), Reason::Slope);
    }

    #[test]
    fn tracks_that_turn_the_machine_while_no_torque_acts_inform_no_state() {
        let settings = Settings::of(&Description::default());
        let mut working = Working::new(&settings, &settings.doubts.expect("doubts"));
        let now = settings.geometry.inertia([0.6, -1.8, -1.5]);
        let mut turn = |velocity: f64, torque: f64, phase: Phase| {
            let drive = Drive {
                period: 0.01,
                velocity: Some(velocity),
                variance: 2.5e-5,
                torque,
                now,
                mean: now,
                posture: [0.6, -1.8, -1.5],
                driven: true,
                seen: true,
                ..Drive::default()
            };
            working.step(&settings, &drive, phase, &mut None);
            let change = working.described[FRICTION] - working.filter.x[FRICTION];
            (
                change == 0.0,
                working.contradiction.is_open(),
                working.rides,
            )
        };
        turn(0.0, 0.0, Phase::Held);
        turn(0.02, 0.0, Phase::Released(0.02));
        for k in 0..400 {
            let velocity = 0.3 * sin_cos(0.015 * f64::from(k)).0;
            assert_eq!(turn(velocity, 0.0, Phase::Moving), (true, false, true));
        }
        // A torque drives the swing again.
        (0..30).for_each(|_| {
            turn(0.2, 4000.0, Phase::Moving);
        });
        assert!(!turn(0.2, 4000.0, Phase::Moving).2);
    }
}

//! Correction of a row's signals before use: stated gains and offsets, values that leap or are stuck, the slope of the road.

use super::{Belief, CgFilter};
use crate::loader::input::stuck::Witness;
use crate::loader::layout::{Layout, SPEED};
use crate::loader::sample::Sample;
use crate::loader::settings::{Machine, Settings};

/// Acceleration beyond which the torques do not explain the motion [m/s^2].
const UNEXPLAINED: f64 = 0.15;

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// Corrects torques and specific force by the stated gains and offset. Corrects the slope by its stated bias where the filter
    /// does not estimate it.
    pub(super) fn correct(settings: &Settings, sample: &mut Sample) {
        let sensors = &settings.sensors;
        sample.front_torque = sample.front_torque.map(|t| t / sensors.front_torque_gain);
        sample.rear_torque = sample.rear_torque.map(|t| t / sensors.rear_torque_gain);
        let offset = sensors.acceleration_offset;
        sample.acceleration = sample.acceleration.map(|a| a - offset);
        if const { Layout::of(N) }.slope_bias.is_none() {
            sample.slope = sample.slope.map(|s| s - settings.prior.slope_bias);
        }
    }

    /// Replaces the slope by that of the road; a bias that the filter estimates is left in it.
    pub(super) fn level(&mut self, settings: &Settings, sample: &mut Sample, dt: f64) {
        let bias = const { Layout::of(N) }
            .slope_bias
            .map_or(0.0, |_| settings.prior.slope_bias);
        sample.slope = self.inclinometer.road(&settings.sensors, bias, sample, dt);
    }

    /// Removes values that leap from a row.
    pub(super) fn drop_leaps(&mut self, machine: &Machine, sample: &mut Sample, dt: f64) {
        let (mass, radius) = (machine.mass, machine.wheel_radius);
        self.steady.watch(sample, mass, radius, dt);
    }

    /// Removes values that are stuck from a row.
    pub(super) fn drop_stuck(&mut self, settings: &Settings, sample: &mut Sample, dt: f64) {
        let witness = self.witness(settings, sample);
        self.stuck.watch(sample, &witness, dt);
    }

    /// Returns what the motion shows, to check the signals of a row.
    fn witness(&self, settings: &Settings, sample: &Sample) -> Witness {
        let (state, sensors) = (self.belief.state(), &settings.sensors);
        let radius = self.dynamics.wheel_radius;
        let speed = sample.speed.unwrap_or(state[SPEED]);
        let front = sample.front_wheel_speed.unwrap_or(speed / radius);
        let rear = sample.rear_wheel_speed.unwrap_or(speed / radius);
        let fastest = speed.abs().max(radius * front.abs().max(rear.abs()));
        Witness {
            moving: fastest > settings.estimator.v_freeze,
            speeds: [0.5 * radius * (front + rear), rear, front],
            unexplained: self.disturbance.unexplained.abs() > UNEXPLAINED,
            std: [
                sensors.speed_std,
                sensors.wheel_speed_std,
                sensors.wheel_speed_std,
                0.0,
                0.0,
                sensors.slope_std,
                sensors.acceleration_std,
            ],
            patience: settings.estimator.fresh,
        }
    }

    /// Updates the error of the slope sensor with wheels, specific force and slope of a row.
    pub(super) fn watch_slope(&mut self, sample: &Sample, dt: f64) {
        let wheels = sample.front_wheel_speed.zip(sample.rear_wheel_speed);
        let road = sample.acceleration.zip(sample.slope);
        if let (Some((front, rear)), Some((acceleration, slope))) = (wheels, road) {
            let rim_speed = 0.5 * self.dynamics.wheel_radius * (front + rear);
            self.slope_error.see(rim_speed, acceleration, slope, dt);
        }
    }
}

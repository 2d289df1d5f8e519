//! Bias and noise of the velocity, measured over the first half second if the machine stands then.

use super::grid::Tick;
use super::settings::Settings;
use crate::math::{exp, ln, sqrt};

/// Length of the measurement [s].
const WINDOW: f64 = 0.5;
/// Ticks that fit into it, with some to spare.
const CAPACITY: usize = 128;
/// A larger mean is motion, not bias [rad/s].
const BIAS_MAX: f64 = 0.03;
/// Motion may have begun this many ticks before it is noticed.
const ONSET: usize = 8;
/// Fewest ticks that give a bias when the machine sets off early.
const FEWEST: usize = 12;

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Calibrated {
    /// To be subtracted from every velocity [rad/s].
    pub(super) bias: f64,
    /// Measured over described noise, at least 1.
    pub(super) noise: f64,
    /// The machine was seen to stand.
    pub(super) stood: bool,
}

impl Calibrated {
    /// Nothing measured.
    pub(super) const NONE: Self = Self {
        bias: 0.0,
        noise: 1.0,
        stood: false,
    };
}

/// Collects the first half second.
#[derive(Debug, Clone)]
pub(super) struct Calibration {
    velocities: [f64; CAPACITY],
    valid: usize,
    ticks: usize,
    torque_sum: f64,
    torque: f64,
    elapsed: f64,
    variance: f64,
    friction: f64,
    measure_noise: bool,
}

impl Calibration {
    pub(super) fn new(settings: &Settings) -> Self {
        Self {
            velocities: [0.0; CAPACITY],
            valid: 0,
            ticks: 0,
            torque_sum: 0.0,
            torque: 0.0,
            elapsed: 0.0,
            variance: 0.0,
            friction: settings.coulomb_friction,
            measure_noise: settings.estimator.measure_noise_at_rest,
        }
    }

    /// Takes in one tick; the answer comes once, with the first tick that is no longer part of it.
    pub(super) fn step(&mut self, tick: &Tick) -> Option<Calibrated> {
        if self.elapsed >= WINDOW - 1e-6 || self.ticks >= CAPACITY {
            return Some(self.finish());
        }
        self.elapsed += tick.period;
        self.ticks += 1;
        self.torque_sum += tick.torque;
        self.torque += (1.0 - exp(ln(0.65) * tick.period / 0.01)) * (tick.torque - self.torque);
        if let Some(y) = tick.velocity {
            self.velocities[self.valid] = y;
            self.valid += 1;
            self.variance = tick.velocity_variance;
        }
        self.moves().then(|| self.early())
    }

    fn moves(&self) -> bool {
        let n = self.valid;
        let mean = if n >= 4 {
            mean(&self.velocities[n - 4..n])
        } else {
            0.0
        };
        let limit = BIAS_MAX + 1.5 * sqrt(self.variance);
        mean.abs() > limit || self.torque.abs() > self.friction
    }

    /// The machine set off before the time was over: what came before may still tell the bias.
    fn early(&self) -> Calibrated {
        let n = self.valid.saturating_sub(ONSET);
        let before = &self.velocities[..n];
        if n < FEWEST || !plausible(before, self.variance) {
            return Calibrated::NONE;
        }
        Calibrated {
            bias: mean(before),
            noise: 1.0,
            stood: true,
        }
    }

    fn finish(&self) -> Calibrated {
        let all = &self.velocities[..self.valid];
        let complete = self.valid * 10 >= self.ticks * 8 && self.valid >= FEWEST;
        let torque = self.torque_sum / self.ticks.max(1) as f64;
        if !complete || torque.abs() >= self.friction || !plausible(all, self.variance) {
            return Calibrated::NONE;
        }
        // Measured noise only ever widens: a quiet half second may be a quantised sensor. The
        // margin is the error of a standard deviation from fifty samples.
        let ratio = deviation(all) / sqrt(self.variance);
        let noise = if self.measure_noise && ratio > 1.3 {
            ratio.min(4.0)
        } else {
            1.0
        };
        Calibrated {
            bias: mean(all),
            noise,
            stood: true,
        }
    }
}

/// A steady small mean with the described noise.
fn plausible(values: &[f64], variance: f64) -> bool {
    let std = sqrt(variance);
    let (first, second) = values.split_at(values.len() / 2);
    let half = first.len().max(1) as f64;
    let drift = mean(second) - mean(first);
    mean(values).abs() < BIAS_MAX
        && deviation(values) < 3.0 * std
        && drift.abs() < 4.0 * std * sqrt(2.0 / half)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn deviation(values: &[f64]) -> f64 {
    let m = mean(values);
    let square: f64 = values.iter().map(|v| (v - m) * (v - m)).sum();
    sqrt(square / values.len().saturating_sub(1).max(1) as f64)
}

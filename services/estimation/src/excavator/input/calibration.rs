//! Measures bias and noise of the velocity over the first half second, if the machine stands. Single outliers are left out, since one
//! of them would hide the standstill.

use super::standstill::torque_share;
use crate::excavator::grid::Tick;
use crate::excavator::settings::Settings;
use crate::math::sqrt;

/// Duration of the measurement [s].
const WINDOW: f64 = 0.5;
/// Ticks of the measurement, with a margin.
const CAPACITY: usize = 128;
/// Mean velocity above which it is motion, not bias [rad/s].
const BIAS_MAX: f64 = 0.03;
/// Ticks before its detection in which motion may have begun.
const ONSET: usize = 8;
/// Number of velocities whose median detects motion.
const RECENT: usize = 5;
/// Least number of ticks for a bias when the machine sets off early.
const FEWEST: usize = 12;
/// Distance of an outlier from the median, in standard deviations. A Gaussian sample lies there once in two million.
const OUTLIER: f64 = 5.0;

/// Progress of the measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::excavator) enum Progress {
    /// The measurement continues.
    Measuring,
    /// The machine stood.
    Stood(Calibrated),
    /// The machine moved, or too few velocities are valid.
    Failed,
}

/// Bias and noise of the velocity at standstill.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::excavator) struct Calibrated {
    /// Bias, to be subtracted from every velocity [rad/s].
    pub(in crate::excavator) bias: f64,
    /// Measured over described standard deviation, at least 1.
    pub(in crate::excavator) noise: f64,
}

/// Collects the velocities of the first half second.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Calibration {
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    velocities: [f64; CAPACITY],
    valid: usize,
    ticks: usize,
    /// Ticks per row of the source.
    slowness: f64,
    torque_sum: f64,
    torque: f64,
    elapsed: f64,
    variance: f64,
    friction: f64,
    measure_noise: bool,
}

impl Calibration {
    pub(in crate::excavator) fn new(settings: &Settings) -> Self {
        Self {
            velocities: [0.0; CAPACITY],
            valid: 0,
            ticks: 0,
            slowness: 1.0,
            torque_sum: 0.0,
            torque: 0.0,
            elapsed: 0.0,
            variance: 0.0,
            friction: settings.coulomb_friction,
            measure_noise: settings.estimator.measure_noise_at_rest,
        }
    }

    /// Takes one tick of a source with `slowness` ticks per row. The first tick after the window ends the measurement.
    pub(in crate::excavator) fn step(&mut self, tick: &Tick, slowness: f64) -> Progress {
        self.slowness = slowness;
        if self.elapsed >= WINDOW - 1e-6 || self.ticks >= CAPACITY {
            return self.finish();
        }
        self.elapsed += tick.period;
        self.ticks += 1;
        self.torque_sum += tick.torque;
        self.torque += torque_share(tick.period) * (tick.torque - self.torque);
        if let Some(y) = tick.velocity {
            self.velocities[self.valid] = y;
            self.valid += 1;
            self.variance = tick.velocity_variance;
        }
        if self.moves() {
            self.early()
        } else {
            Progress::Measuring
        }
    }

    /// The first `n` velocities without outliers, and their number. The scale is the median distance from the median, which a few outliers
    /// do not change, and at least the described standard deviation.
    fn inliers(&self, n: usize) -> ([f64; CAPACITY], usize) {
        let mut sorted = self.velocities;
        let centre = median(&mut sorted[..n]);
        let mut distances = sorted.map(|v| (v - centre).abs());
        let std = (1.4826 * median(&mut distances[..n])).max(sqrt(self.variance));
        let (mut inside, mut count) = ([0.0; CAPACITY], 0);
        for &v in &self.velocities[..n] {
            if (v - centre).abs() < OUTLIER * std {
                inside[count] = v;
                count += 1;
            }
        }
        (inside, count)
    }

    fn moves(&self) -> bool {
        let recent = self.valid.saturating_sub(RECENT)..self.valid;
        let mut recent_velocities = [0.0; RECENT];
        recent_velocities[..recent.len()].copy_from_slice(&self.velocities[recent]);
        let limit = BIAS_MAX + 1.5 * sqrt(self.variance);
        median(&mut recent_velocities).abs() > limit || self.torque.abs() > self.friction
    }

    /// The machine set off within the window: velocities from before may still give the bias.
    fn early(&self) -> Progress {
        let (before, n) = self.inliers(self.valid.saturating_sub(ONSET));
        let before = &before[..n];
        if n < FEWEST || !plausible(before, self.variance) {
            return Progress::Failed;
        }
        Progress::Stood(Calibrated {
            bias: mean(before),
            noise: 1.0,
        })
    }

    fn finish(&self) -> Progress {
        let (all, n) = self.inliers(self.valid);
        let all = &all[..n];
        let expected = self.ticks as f64 / self.slowness;
        let complete = n as f64 >= 0.8 * expected && n >= FEWEST;
        let torque = self.torque_sum / self.ticks.max(1) as f64;
        if !complete || torque.abs() >= self.friction || !plausible(all, self.variance) {
            return Progress::Failed;
        }
        // Measured noise only widens: a quiet half second may come from a quantised sensor. The margin is the error of a standard deviation
        // from fifty samples.
        let ratio = deviation(all) / sqrt(self.variance);
        let noise = if self.measure_noise && ratio > 1.3 {
            ratio.min(4.0)
        } else {
            1.0
        };
        Progress::Stood(Calibrated {
            bias: mean(all),
            noise,
        })
    }
}

/// Median; sorts the values.
fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Whether the mean is small and steady, and the noise as described.
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

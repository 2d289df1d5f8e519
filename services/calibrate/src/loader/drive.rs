//! A recording of a loader made ready: its rows, and the stretches of driving in it.

use std::ops::Range;

use estimation::loader::Sample;

use crate::excavator::series::{at, moving_mean};

/// Slower than this a slip says nothing [m/s].
const SLOWEST: f64 = 0.7;
/// Half the window that smooths torques and slope [s].
const WINDOW: f64 = 0.05;
/// Length of a block, and the shortest [s].
const LENGTH: f64 = 5.0;
const SHORTEST: f64 = 1.0;
/// A force on the bucket of this share of the weight is digging.
const DIGGING: f64 = 0.01;

/// A recording made ready; NaN is missing.
#[derive(Debug, Clone)]
pub struct Drive {
    /// Its name, for sentences.
    pub name: String,
    /// Time of each row [s].
    pub time: Vec<f64>,
    /// Speed [m/s].
    pub speed: Vec<f64>,
    /// Wheel speeds, front and rear [rad/s].
    pub wheels: [Vec<f64>; 2],
    /// Axle torques, smoothed, front and rear [N m].
    pub torques: [Vec<f64>; 2],
    /// Slope as measured, smoothed [rad].
    pub slope: Vec<f64>,
    /// Specific force [m/s^2].
    pub acceleration: Vec<f64>,
    /// Mass as measured in the middle; none without a column [kg].
    pub mass: Option<f64>,
    /// Stretches of driving.
    pub blocks: Vec<Range<usize>>,
    /// Whether there is an accelerometer.
    pub has_acceleration: bool,
}

impl Drive {
    /// Makes a recording ready; `weight` [N] tells what is digging.
    #[must_use]
    pub fn new(name: &str, samples: &[Sample], weight: f64) -> Self {
        let mut rows: Vec<Sample> = Vec::with_capacity(samples.len());
        for sample in samples.iter().filter(|s| s.time.is_finite()) {
            if rows.last().is_none_or(|last| sample.time > last.time) {
                rows.push(*sample);
            }
        }
        let column = |of: fn(&Sample) -> Option<f64>| -> Vec<f64> {
            rows.iter().map(|s| of(s).unwrap_or(f64::NAN)).collect()
        };
        let time: Vec<f64> = rows.iter().map(|s| s.time).collect();
        let smooth = |of: fn(&Sample) -> Option<f64>| moving_mean(&time, &column(of), WINDOW);
        let masses: Vec<f64> = rows.iter().filter_map(|s| s.mass).collect();
        let acceleration = column(|s| s.acceleration);
        let mut drive = Self {
            name: name.to_owned(),
            speed: column(|s| s.speed),
            wheels: [column(|s| s.front_wheel_speed), column(|s| s.rear_wheel_speed)],
            torques: [smooth(|s| s.front_torque), smooth(|s| s.rear_torque)],
            slope: smooth(|s| s.slope),
            mass: (!masses.is_empty())
                .then(|| crate::excavator::series::percentile(masses, 0.5)),
            has_acceleration: acceleration.iter().any(|a| a.is_finite()),
            acceleration,
            blocks: Vec::new(),
            time,
        };
        let digs = |s: &Sample| {
            let force = s.spade_force_x.unwrap_or(0.0).hypot(s.spade_force_z.unwrap_or(0.0));
            force > DIGGING * weight || s.boom_moving
        };
        drive.blocks = drive.find_blocks(&rows.iter().map(digs).collect::<Vec<_>>());
        drive
    }

    /// Time of driving [s].
    #[must_use]
    pub fn driving_time(&self) -> f64 {
        let blocks = self.blocks.iter();
        blocks.map(|b| self.time[b.end - 1] - self.time[b.start]).sum()
    }

    /// A smoothed torque or the slope at any time.
    #[must_use]
    pub fn value(&self, column: &[f64], time: f64) -> f64 {
        at(&self.time, column, time)
    }

    fn find_blocks(&self, digs: &[bool]) -> Vec<Range<usize>> {
        let speed = moving_mean(&self.time, &self.speed, 2.0 * WINDOW);
        let drives = |k: usize| speed[k].abs() > SLOWEST && !digs[k];
        let mut blocks = Vec::new();
        let mut first = None;
        for k in 0..=self.time.len() {
            let goes = k < self.time.len() && drives(k);
            let start = *first.get_or_insert(k);
            let gap = k > start && k < self.time.len() && self.time[k] - self.time[k - 1] > 0.1;
            let long = k > start && k < self.time.len() && self.time[k] - self.time[start] > LENGTH;
            if goes && !gap && !long {
                continue;
            }
            if k > start && self.time[k - 1] - self.time[start] > SHORTEST {
                blocks.push(start..k);
            }
            first = goes.then_some(k);
            if !goes {
                first = Some(k + 1);
            }
        }
        blocks
    }
}

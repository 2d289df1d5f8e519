//! First look at a row: is its time usable, which of its values count?

use super::estimate::Sample;
use super::settings::Sensors;

/// Refuses rows whose time does not increase and takes impossible values for missing.
#[derive(Debug, Clone)]
pub(super) struct Screen {
    last_time: Option<f64>,
    first_period: f64,
    velocity_limit: f64,
    angle_limit: f64,
    refused: u64,
}

impl Screen {
    pub(super) fn new(sensors: &Sensors) -> Self {
        Self {
            last_time: None,
            first_period: 1.0 / sensors.rate,
            velocity_limit: sensors.swing_velocity_limit,
            angle_limit: sensors.angle_limit,
            refused: 0,
        }
    }

    /// The cleaned row and the time since the row before; `None` if the row is refused.
    pub(super) fn accept(&mut self, sample: &Sample) -> Option<(Sample, f64)> {
        let period = match self.last_time {
            None => self.first_period,
            Some(last) => sample.time - last,
        };
        if !(sample.time.is_finite() && period > 0.0 && period.is_finite()) {
            self.refused += 1;
            return None;
        }
        self.last_time = Some(sample.time);
        Some((self.clean(sample), period))
    }

    /// Rows refused so far.
    pub(super) fn refused(&self) -> u64 {
        self.refused
    }

    fn clean(&self, sample: &Sample) -> Sample {
        // A sensor at the end of its range says only "at least this much": missing.
        let within = |value: Option<f64>, limit: f64| value.filter(|v| v.abs() < limit);
        Sample {
            time: sample.time,
            velocity: within(sample.velocity, self.velocity_limit),
            angle: within(sample.angle, f64::MAX),
            torque: within(sample.torque, 1e12),
            posture: sample.posture.map(|q| within(q, self.angle_limit)),
        }
    }
}

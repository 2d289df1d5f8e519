//! The filter stage: Kalman filter and equal filters (process `kalman`).

use config::Excavator as Description;
use estimation::excavator::{Columns, MotionFilter, Settings};
use messages::{ExcavatorSensors, SwingMotion};
use runtime::Step;
use serde::{Deserialize, Serialize};

use super::{columns, motion_message, sample};
use crate::Error;
use crate::kept::keeps_its_state;
use crate::source::SourceWatch;

/// Sensors in, swing motion out.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FilterStep {
    filter: MotionFilter,
    source: SourceWatch,
}

impl FilterStep {
    /// A filter that waits for its first sample, which shows whether there is a velocity or an
    /// encoder's angle.
    ///
    /// # Errors
    /// The description has a value that the filter cannot use.
    pub fn new(description: &Description) -> Result<Self, Error> {
        Ok(Self {
            filter: MotionFilter::new(&Settings::of(description), VELOCITY)
                .map_err(Error::settings)?,
            source: SourceWatch::default(),
        })
    }
}

/// Columns assumed for a source before its first sample.
const VELOCITY: Columns = Columns {
    velocity: true,
    angle: false,
    torque: false,
    posture: false,
};

impl Step for FilterStep {
    type Input = ExcavatorSensors;
    type Output = SwingMotion;

    fn step(&mut self, input: &ExcavatorSensors) -> SwingMotion {
        // The settings have been checked; without velocity and angle the previous filter continues and
        // reports that nothing is measured.
        if self.source.is_new(&input.stamp)
            && let Ok(filter) = MotionFilter::new(&self.filter.described(), columns(input))
        {
            self.filter = filter;
        }
        motion_message(&self.filter.step(&sample(input)), input.valid)
    }

    keeps_its_state!();
}

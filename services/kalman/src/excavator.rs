//! The excavator's filter stage as a step: sensors to swing motion.

mod settings;
mod translate;

use config::Excavator as Description;
use estimation::excavator::{Columns, MotionFilter, SettingsError};
use messages::{ExcavatorSensors, SwingMotion, excavator_bits as bits};
use runtime::Step;

pub use settings::settings;
pub use translate::{columns, message, motion, sample};

/// Kalman filter and equal filters.
#[derive(Debug, Clone)]
pub struct Excavator {
    /// For a velocity, and for an encoder alone: the first sample says which it is.
    filters: [MotionFilter; 2],
    chosen: Option<usize>,
}

impl Excavator {
    /// A filter that waits for its first sample, which tells the columns of the source.
    ///
    /// # Errors
    /// The description has a value that the filter cannot use.
    pub fn new(description: &Description) -> Result<Self, SettingsError> {
        let settings = settings(description);
        let filter = |velocity| {
            let columns = Columns {
                velocity,
                angle: !velocity,
                ..Columns::default()
            };
            MotionFilter::new(&settings, columns)
        };
        Ok(Self {
            filters: [filter(true)?, filter(false)?],
            chosen: None,
        })
    }
}

impl Step for Excavator {
    type Input = ExcavatorSensors;
    type Output = SwingMotion;

    fn step(&mut self, input: &ExcavatorSensors) -> SwingMotion {
        let encoder = usize::from(input.columns & bits::SWING_VELOCITY == 0);
        let chosen = *self.chosen.get_or_insert(encoder);
        let motion = self.filters[chosen].step(&sample(input));
        translate::swing_motion(&motion, input.valid)
    }
}

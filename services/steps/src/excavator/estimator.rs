//! The excavator's state-space estimators as a step: `auto`, `posture-torque`, `torque`, `posture`,
//! `velocity` (process `ukf`).

use config::Excavator as Description;
use estimation::excavator::{Columns, Method, Settings, SettingsError, SwingEstimator};
use messages::{ExcavatorEstimate, ExcavatorSensors};
use runtime::Step;
use serde::{Deserialize, Serialize};

use super::{columns, estimate_message, method, sample, tag_restart};
use crate::Error;
use crate::kept::{Restart, keeps_its_state};
use crate::source::SourceWatch;

/// One state-space method, or the automatic choice among them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EstimatorStep {
    method: Method,
    estimator: SwingEstimator,
    source: SourceWatch,
    started: bool,
    restart: Restart,
}

impl EstimatorStep {
    /// Constructs the estimator of a method. It waits for its first sample, which shows the
    /// columns of the source.
    ///
    /// # Errors
    /// The name is unknown, belongs to another process, or the description has a value that the
    /// method cannot use.
    pub fn new(description: &Description, name: &str) -> Result<Self, Error> {
        let (method, settings) = (method(name)?, Settings::of(description));
        Ok(Self {
            method,
            estimator: estimator(&settings, method, ALL).map_err(Error::settings)?,
            source: SourceWatch::default(),
            started: false,
            restart: Restart::default(),
        })
    }
}

const ALL: Columns = Columns {
    velocity: true,
    angle: false,
    torque: true,
    posture: true,
};

/// The estimator for these columns. A method that lacks one of its columns gets it without
/// values: it then holds its prior, and is neither fresh nor trusted.
fn estimator(
    settings: &Settings,
    method: Method,
    columns: Columns,
) -> Result<SwingEstimator, SettingsError> {
    let velocity = columns.velocity || !columns.angle;
    let columns = if method == Method::Auto {
        Columns {
            velocity,
            ..columns
        }
    } else {
        Columns { velocity, ..ALL }
    };
    SwingEstimator::new(settings, method, columns)
}

impl Step for EstimatorStep {
    type Input = ExcavatorSensors;
    type Output = ExcavatorEstimate;

    fn step(&mut self, input: &ExcavatorSensors) -> ExcavatorEstimate {
        if self.source.is_new(&input.stamp)
            && let Ok(new) = estimator(&self.estimator.described(), self.method, columns(input))
        {
            self.estimator = new;
        }
        let estimate = self.estimator.step(&sample(input));
        self.started |= !estimate.flags.refused;
        let mut message = estimate_message(&estimate, self.started);
        tag_restart(&mut self.restart, input.stamp.time, &mut message);
        message
    }

    keeps_its_state!(restart);
}

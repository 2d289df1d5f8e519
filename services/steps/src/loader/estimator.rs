//! The loader's estimators as a step.
//!
//! All methods are the same step with different settings. The process `kalman` runs those that linearise the model, `ukf` those with
//! sigma points.

use config::Loader as Description;
use estimation::loader::{CgEstimator, Columns, Reason, Settings};
use messages::{LoaderEstimate, LoaderSensors, loader_bits as bits};
use runtime::Step;
use serde::{Deserialize, Serialize};

use super::{estimate_message, method, sample};
use crate::Error;
use crate::kept::{Bits, Restart, keeps_its_state};

/// Any method of the loader: sensors in, centre of gravity out.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct EstimatorStep {
    estimator: CgEstimator,
    /// Estimator for a source without an accelerometer, until the first sample shows whether it has one.
    without_accelerometer: Option<CgEstimator>,
    restart: Restart,
}

impl EstimatorStep {
    /// Constructs the estimator of a method. It waits for its first sample, which shows the
    /// columns of the source.
    ///
    /// # Errors
    /// The name is unknown, or the description has a value that the method cannot use.
    pub fn new(description: &Description, name: &str) -> Result<Self, Error> {
        let method = method(name)?;
        let settings = Settings::of(description, method);
        let estimator = |acceleration| {
            let columns = Columns { acceleration };
            CgEstimator::new(&settings, method, columns).map_err(Error::settings)
        };
        Ok(Self {
            estimator: estimator(true)?,
            without_accelerometer: Some(estimator(false)?),
            restart: Restart::default(),
        })
    }
}

impl Step for EstimatorStep {
    type Input = LoaderSensors;
    type Output = LoaderEstimate;

    fn step(&mut self, input: &LoaderSensors) -> LoaderEstimate {
        if let Some(other) = self.without_accelerometer.take()
            && input.columns & bits::ACCELERATION == 0
        {
            self.estimator = other;
        }
        let mut message = estimate_message(&self.estimator.step(&sample(input)));
        let bits = Bits {
            restarted: bits::RESTARTED,
            fresh: bits::FRESH,
            trusted: bits::TRUSTED_RATIO | bits::TRUSTED_HEIGHT | bits::TRUSTED_PAYLOAD,
            reason: Reason::Restarted as u32,
        };
        let time = input.stamp.time;
        let verdict = (&mut message.flags, &mut message.reason);
        self.restart.mark(&bits, time, verdict.0, verdict.1);
        message
    }

    keeps_its_state!(restart);
}

//! The loader's estimators as a step.
//!
//! All methods are the same step with different settings. The process `kalman` runs those on the model's tangent, `ukf` those on
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
    /// For sources without an accelerometer, until the first sample says which it is.
    without_accelerometer: Option<CgEstimator>,
    restart: Restart,
}

impl EstimatorStep {
    /// An estimator by the name of its method. It waits for its first sample, which tells the
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
        let said = (&mut message.flags, &mut message.reason);
        self.restart.tell(&bits, time, said.0, said.1);
        message
    }

    keeps_its_state!(restart);
}

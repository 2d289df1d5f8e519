//! The excavator's regressions as a step: their only input is the swing motion (process `rls`).

use config::Excavator as Description;
use estimation::excavator::{Method, Regression, Settings};
use messages::{ExcavatorEstimate, SwingMotion};
use runtime::Step;
use serde::{Deserialize, Serialize};

use super::{estimate_message, method, motion, tag_restart};
use crate::Error;
use crate::kept::{Restart, keeps_its_state};
use crate::source::SourceWatch;

/// `multi-forgetting-rls` or `svf-rls`: swing motion in, inertia out.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RegressionStep {
    method: Method,
    regression: Regression,
    source: SourceWatch,
    started: bool,
    restart: Restart,
}

impl RegressionStep {
    /// Constructs the regression of a method.
    ///
    /// # Errors
    /// The name is unknown, belongs to another process, or the description has a value that the
    /// method cannot use.
    pub fn new(description: &Description, name: &str) -> Result<Self, Error> {
        let (method, settings) = (method(name)?, Settings::of(description));
        Ok(Self {
            method,
            regression: Regression::new(&settings, method).map_err(Error::settings)?,
            source: SourceWatch::default(),
            started: false,
            restart: Restart::default(),
        })
    }
}

impl Step for RegressionStep {
    type Input = SwingMotion;
    type Output = ExcavatorEstimate;

    fn step(&mut self, input: &SwingMotion) -> ExcavatorEstimate {
        // The settings have been checked: this cannot fail.
        if self.source.is_new(&input.stamp)
            && let Ok(regression) = Regression::new(&self.regression.described(), self.method)
        {
            self.regression = regression;
        }
        let motion = motion(input);
        self.started |= !motion.refused;
        let mut message = estimate_message(&self.regression.step(&motion), self.started);
        tag_restart(&mut self.restart, input.stamp.time, &mut message);
        message
    }

    keeps_its_state!(restart);
}

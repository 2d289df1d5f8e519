//! The excavator's regressions as a step: swing motion to inertia.

use config::Excavator as Description;
use estimation::excavator::{Method, Regression, SettingsError};
use kalman::{excavator_message, excavator_settings, swing_motion};
use messages::{ExcavatorEstimate, SwingMotion};
use runtime::Step;

/// `svf-rls` or `multi-forgetting-rls`.
#[derive(Debug, Clone)]
pub struct Excavator(Regression);

impl Excavator {
    /// A regression by the name of its method.
    ///
    /// # Errors
    /// There is no regression of that name, or the description has a value that it cannot use.
    pub fn new(description: &Description, method: &str) -> Result<Self, SettingsError> {
        let unknown = SettingsError::WrongStage {
            method: "of that name",
        };
        let method = Method::parse(method).ok_or(unknown)?;
        Regression::new(&excavator_settings(description), method).map(Self)
    }
}

impl Step for Excavator {
    type Input = SwingMotion;
    type Output = ExcavatorEstimate;

    fn step(&mut self, input: &SwingMotion) -> ExcavatorEstimate {
        excavator_message(&self.0.step(&swing_motion(input)))
    }
}

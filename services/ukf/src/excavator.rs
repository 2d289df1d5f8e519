//! The excavator's state-space estimators as a step: sensors to inertia.

use core::fmt;

use config::Excavator as Description;
use estimation::excavator::{Columns, Method, Settings, SettingsError, SwingEstimator};
use kalman::{excavator_columns, excavator_message, excavator_sample, excavator_settings};
use messages::{ExcavatorEstimate, ExcavatorSensors};
use runtime::Step;

/// `auto`, `posture-torque`, `torque`, `posture` or `velocity`.
#[derive(Debug, Clone)]
pub struct Excavator {
    settings: Settings,
    method: Method,
    estimator: SwingEstimator,
    begun: bool,
}

/// Why an estimator cannot start.
#[derive(Clone, Debug, PartialEq)]
pub enum ExcavatorError {
    /// There is no method of that name.
    UnknownMethod(String),
    /// The description has a value that the method cannot use, or the source lacks a column.
    Settings(SettingsError),
}

impl fmt::Display for ExcavatorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownMethod(name) => {
                let known = Method::ALL.map(Method::name).join(", ");
                write!(
                    f,
                    "the excavator has no method `{name}`; methods are {known}"
                )
            }
            Self::Settings(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ExcavatorError {}

impl Excavator {
    /// An estimator by the name of its method. Its first sample tells the columns of the source.
    ///
    /// # Errors
    /// The name is unknown, or the description has a value that the method cannot use.
    pub fn new(description: &Description, method: &str) -> Result<Self, ExcavatorError> {
        let all = Columns {
            velocity: true,
            angle: true,
            torque: true,
            posture: true,
        };
        Self::with(description, method, all)
    }

    /// Whether `method` can work with a source that has these columns (bits of the message).
    ///
    /// # Errors
    /// As [`Excavator::new`], and where a column is missing that the method needs.
    pub fn check(
        description: &Description,
        method: &str,
        columns: u32,
    ) -> Result<(), ExcavatorError> {
        Self::with(description, method, excavator_columns(columns)).map(drop)
    }

    fn with(
        description: &Description,
        method: &str,
        columns: Columns,
    ) -> Result<Self, ExcavatorError> {
        let method =
            Method::parse(method).ok_or_else(|| ExcavatorError::UnknownMethod(method.into()))?;
        let settings = excavator_settings(description);
        let estimator =
            SwingEstimator::new(&settings, method, columns).map_err(ExcavatorError::Settings)?;
        Ok(Self {
            settings,
            method,
            estimator,
            begun: false,
        })
    }

    /// The columns are known with the first sample. A source that lacks one which a fixed method
    /// needs has been refused before (`check`); should it come anyway, its values are missing.
    fn begin(&mut self, columns: u32) {
        self.begun = true;
        let columns = excavator_columns(columns);
        if let Ok(estimator) = SwingEstimator::new(&self.settings, self.method, columns) {
            self.estimator = estimator;
        }
    }
}

impl Step for Excavator {
    type Input = ExcavatorSensors;
    type Output = ExcavatorEstimate;

    fn step(&mut self, input: &ExcavatorSensors) -> ExcavatorEstimate {
        if !self.begun {
            self.begin(input.columns);
        }
        excavator_message(&self.estimator.step(&excavator_sample(input)))
    }
}

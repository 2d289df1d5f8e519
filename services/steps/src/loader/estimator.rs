//! The loader's unscented Kalman filters: `full`, `isr-ukf`, `isr-ukf-printed`.

use core::fmt;

use config::Loader as Description;
use estimation::loader::{Method, SettingsError};
use kalman::LoaderEstimator;
use messages::{LoaderEstimate, LoaderSensors};
use runtime::Step;

/// One method of the loader.
#[derive(Clone, Copy, Debug)]
pub struct Loader(LoaderEstimator);

/// Why an estimator cannot start.
#[derive(Clone, Debug, PartialEq)]
pub enum LoaderError {
    /// There is no method of that name.
    UnknownMethod(String),
    /// The description has a value that the method cannot use.
    Settings(SettingsError),
}

impl fmt::Display for LoaderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownMethod(name) => {
                let known = Method::ALL.map(Method::name).join(", ");
                write!(f, "the loader has no method `{name}`; methods are {known}")
            }
            Self::Settings(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for LoaderError {}

impl Loader {
    /// An estimator by the name of its method.
    ///
    /// # Errors
    /// The name is unknown, or the description has a value that the method cannot use.
    pub fn new(description: &Description, method: &str) -> Result<Self, LoaderError> {
        let method =
            Method::parse(method).ok_or_else(|| LoaderError::UnknownMethod(method.into()))?;
        LoaderEstimator::new(description, method)
            .map(Self)
            .map_err(LoaderError::Settings)
    }
}

impl Step for Loader {
    type Input = LoaderSensors;
    type Output = LoaderEstimate;

    fn step(&mut self, input: &LoaderSensors) -> LoaderEstimate {
        self.0.step(input)
    }
}

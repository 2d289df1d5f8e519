//! The loader's messages and its step.

mod estimate;
mod estimator;
mod idle;
mod pipeline;
mod sample;

pub use estimate::message as estimate_message;
pub use estimator::EstimatorStep;
pub(crate) use idle::is_idle;
pub use pipeline::PIPELINE;
pub use sample::sample;

use estimation::loader::Method;

use crate::Error;

/// The method of that name.
///
/// # Errors
/// There is none.
pub fn method(name: &str) -> Result<Method, Error> {
    Method::parse(name).ok_or_else(|| Error::UnknownMethod {
        machine: "loader",
        name: name.to_owned(),
        known: Method::NAMES.to_vec(),
    })
}

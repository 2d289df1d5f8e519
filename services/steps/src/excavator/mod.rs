//! The excavator's messages and steps.

mod estimate;
mod estimator;
mod filter;
mod idle;
mod motion;
mod pipeline;
mod regression;
mod sample;
mod smooth;

pub use estimate::message as estimate_message;
use estimate::tag_restart;
pub use estimator::EstimatorStep;
pub use filter::FilterStep;
pub(crate) use idle::is_idle;
pub use motion::{message as motion_message, motion};
pub use pipeline::PIPELINE;
pub use regression::RegressionStep;
pub use sample::{check_columns, columns, sample};
pub use smooth::{Past, past};

use estimation::excavator::Method;

use crate::Error;

/// The method of that name.
///
/// # Errors
/// There is none.
pub fn method(name: &str) -> Result<Method, Error> {
    Method::parse(name).ok_or_else(|| Error::UnknownMethod {
        machine: "excavator",
        name: name.to_owned(),
        known: Method::NAMES.to_vec(),
    })
}

//! The state-space estimators: swing inertia of the excavator, centre of gravity of the loader.

mod excavator;
mod loader;

pub use excavator::Excavator;
pub use kalman::ExcavatorError;
pub use loader::{Loader, LoaderError};

//! The filter stage: the excavator's Kalman filter, and the loader's extended Kalman filter.

mod excavator;
mod loader;

pub use excavator::{
    Excavator, ExcavatorError, SourceWatch, columns as excavator_columns,
    estimate_message as excavator_message, sample as excavator_sample,
    settings as excavator_settings,
};
pub use loader::{Loader, LoaderEstimator, settings as loader_settings};

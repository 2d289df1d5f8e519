//! The filter stage: the excavator's Kalman filter, and the loader's extended Kalman filter.
//!
//! What `rls` and `ukf` need to put a description or a message into the terms of `estimation`
//! stands here too, once.

mod excavator;
mod loader;

pub use excavator::{
    Excavator, columns as excavator_columns, message as excavator_message, motion as swing_motion,
    sample as excavator_sample, settings as excavator_settings,
};
pub use loader::{Loader, LoaderEstimator, settings as loader_settings};

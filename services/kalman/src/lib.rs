//! The filter stage: the excavator's Kalman filter, and the loader's extended Kalman filter.

mod loader;

pub use loader::{Loader, LoaderEstimator, settings as loader_settings};

//! The state-space estimators: swing inertia of the excavator, centre of gravity of the loader.

mod loader;

pub use loader::{Loader, LoaderError};

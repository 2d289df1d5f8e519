//! The sensor service: samples from a simulated machine or from a recording.

mod excavator;
mod loader;
mod recorded;

pub use excavator::SimulatedExcavator;
pub use loader::SimulatedLoader;
pub use recorded::Recorded;

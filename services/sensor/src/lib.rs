//! The sensor service: samples from a simulated machine, a recording, a CAN bus, or standard input.

mod bus;
mod excavator;
mod lines;
mod loader;
mod recorded;
mod socket;

pub use bus::CanBus;
pub use excavator::SimulatedExcavator;
pub use lines::Lines;
pub use loader::SimulatedLoader;
pub use recorded::Recorded;

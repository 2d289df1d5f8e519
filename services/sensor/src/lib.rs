//! The sensor service: samples from a simulated machine, a recording, a CAN bus, or standard input.
//!
//! | file | source |
//! |---|---|
//! | `excavator`, `loader` | the simulators |
//! | `recorded` | rows that were read before |
//! | `bus`, `lines` | frames of a CAN interface, lines of a pipe |

mod bus;
mod excavator;
mod lines;
mod loader;
mod recorded;
mod simulated;
mod socket;

pub use bus::CanBus;
pub use excavator::SimulatedExcavator;
pub use lines::Lines;
pub use loader::SimulatedLoader;
pub use recorded::Recorded;

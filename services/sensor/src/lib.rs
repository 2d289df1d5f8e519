//! Sensor service: samples from a simulated machine, a recording, a CAN bus, or standard input.
//!
//! | file | source |
//! |---|---|
//! | [`excavator`], [`loader`] | the simulators |
//! | `recorded` | rows of a recording |
//! | `bus`, `lines` | frames of a CAN interface, lines of a pipe |

mod bus;
pub mod excavator;
mod lines;
pub mod loader;
mod recorded;
mod simulated;
mod socket;

pub use bus::CanBus;
pub use lines::Lines;
pub use recorded::Recorded;

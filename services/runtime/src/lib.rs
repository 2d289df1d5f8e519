//! What every process of heft shares: ports, wake-ups, clock, real-time set-up, telemetry.
//!
//! This crate alone talks to iceoryx2. A service gives it a [`Step`] (or a [`Source`]) and knows
//! nothing of channels, bells and clocks.

mod step;

pub use step::{Source, Step, answer};

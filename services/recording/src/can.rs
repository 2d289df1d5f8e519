//! CAN: frames, databases, the decoder from frames to rows, and estimates as frames.

pub(crate) mod dbc;
mod decoder;
mod frame;
pub(crate) mod layout;
mod left_out;
mod log;
pub mod node;
mod outgoing;
#[cfg(test)]
mod tests;
mod tokens;

pub use decoder::Decoder;
pub use frame::{Frame, MAX_DATA};
pub(crate) use frame::{Line, parse, text};
pub(crate) use left_out::LeftOut;
pub(crate) use log::Log;
pub use outgoing::Outgoing;
pub(crate) use outgoing::{FrameTable, flags, quantities};

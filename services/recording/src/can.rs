//! CAN: frames, databases, and the decoder that makes rows of them.

pub(crate) mod dbc;
mod decoder;
mod frame;
pub(crate) mod layout;
mod log;
#[cfg(test)]
mod tests;
mod tokens;

pub use decoder::Decoder;
pub use frame::{Frame, MAX_DATA};
pub(crate) use frame::{Line, parse};
pub(crate) use log::read;

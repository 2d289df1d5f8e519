//! Filters of other projects on our problems. Versions are pinned in `Cargo.toml`.
//!
//! Each is used as in its documentation, with the fixed-size types if it has them.

pub mod extended;
pub mod kalman;
pub mod regression;
mod rover;
pub mod square_root;
pub mod unscented;

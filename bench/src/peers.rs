//! Other people's filters on our problems. Versions are pinned in `Cargo.toml`.
//!
//! Each is used as its documentation shows, with the fixed-size types where it has them.

pub mod extended;
pub mod kalman;
pub mod regression;
mod rover;
pub mod square_root;
pub mod unscented;

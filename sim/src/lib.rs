//! Plants, sensors with seeded noise, faults and scenarios: the truth that estimates are judged by.
//!
//! This crate never imports the estimators, so that truth and belief cannot share a mistake.

pub mod blend;
pub mod excavator;
pub mod fault;
pub mod loader;
pub mod named;
pub mod noise;
pub mod rk4;

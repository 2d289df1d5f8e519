//! Plants, sensors with seeded noise, faults and scenarios: the truth against which estimates are judged.
//!
//! This crate never imports the estimators, so that both cannot share a mistake.
//!
//! | module | what |
//! |---|---|
//! | [`excavator`] | the plant of the paper's cases, and machines of real sizes at work |
//! | [`loader`] | plant, road, driver, sensors, tolerances |
//! | [`cylinder`] | hydraulic cylinders with seals and pressure sensors |
//! | [`fault`] | faults of a signal |
//! | [`noise`] | seeded noise, a channel each |
//! | [`named`] | names of machines at work |
//! | [`rk4`], [`blend`] | integration, smooth transitions |

pub mod blend;
pub mod cylinder;
pub mod excavator;
pub mod fault;
pub mod loader;
pub mod named;
pub mod noise;
pub mod rk4;

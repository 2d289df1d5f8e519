//! Load of the machine: reported, weighed, or estimated from its mass and motion.
//!
//! | file | idea |
//! |---|---|
//! | [`payload`] | a load that is reported |
//! | `known_load` | a load that is reported, or weighed by the lift pressure |
//! | `mass_step` | shift of the centre of gravity by a step of the mass |
//! | `inertia` | mass from force and acceleration |
//! | `axle_torque` | probability that one axle's torque has a gain error |
//! | `stated_mass` | test of the stated mass |
//! | `unreported_load` | probability that the bucket has been filled or emptied |

pub(super) mod axle_torque;
pub(super) mod inertia;
pub(super) mod known_load;
pub(super) mod mass_step;
pub mod payload;
pub(super) mod stated_mass;
pub(super) mod unreported_load;

//! What the machine carries: known, or found in its mass and in its motion.
//!
//! | file | idea |
//! |---|---|
//! | [`payload`] | a load that is reported |
//! | `known_load` | a load that is reported, or weighed by the lift pressure |
//! | `mass_step` | a step of the mass moves the centre of gravity |
//! | `inertia` | force over acceleration |
//! | `axle_torque` | whether one axle's torque is off |
//! | `stated_mass` | whether the machine is as heavy as stated |
//! | `unreported_load` | how probable it is that the bucket was filled or emptied since |

pub(super) mod axle_torque;
pub(super) mod inertia;
pub(super) mod known_load;
pub(super) mod mass_step;
pub mod payload;
pub(super) mod stated_mass;
pub(super) mod unreported_load;

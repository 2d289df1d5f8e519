//! Weighing by boom pressures: the moment that the boom's cylinders carry ([`boom_moment`]), while the ground carries no part of it
//! ([`ground`]); [`lifts`] computes it for whole recordings.

pub(super) mod boom_moment;
pub(super) mod ground;
pub(super) mod lifts;

//! What else tells the load: the moment that the boom's cylinders carry ([`boom_moment`]), while the ground carries no part of
//! it ([`ground`]); [`lifts`] has them of whole recordings.

pub(super) mod boom_moment;
pub(super) mod ground;
pub(super) mod lifts;

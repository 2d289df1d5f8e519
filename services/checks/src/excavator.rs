//! Checks of the excavator, a file each.

mod boom;
mod carries;
mod fits;
mod ground;
mod postures;
mod signless;
mod speed;
mod turned;
mod unmoved;

pub use fits::Fits;

//! Checks of the wheel loader, a file each.

mod axles;
mod fits;
mod grade;
mod pair;
mod regression;
mod speed;
mod turning;

pub use fits::Fits;

//! Units that a signal map may name.

use core::f64::consts::{PI, TAU};

/// A unit: name, the SI unit of the same dimension, and its size in that.
pub(crate) struct Unit {
    pub name: &'static str,
    pub si: &'static str,
    pub factor: f64,
}

const fn unit(name: &'static str, si: &'static str, factor: f64) -> Unit {
    Unit { name, si, factor }
}

pub(crate) const UNITS: &[Unit] = &[
    unit("s", "s", 1.0),
    unit("ms", "s", 1e-3),
    unit("us", "s", 1e-6),
    unit("ns", "s", 1e-9),
    unit("min", "s", 60.0),
    unit("rad", "rad", 1.0),
    unit("mrad", "rad", 1e-3),
    unit("deg", "rad", PI / 180.0),
    unit("turn", "rad", TAU),
    unit("rad/s", "rad/s", 1.0),
    unit("deg/s", "rad/s", PI / 180.0),
    unit("rpm", "rad/s", TAU / 60.0),
    unit("turn/s", "rad/s", TAU),
    unit("rad/s^2", "rad/s^2", 1.0),
    unit("m", "m", 1.0),
    unit("mm", "m", 1e-3),
    unit("cm", "m", 1e-2),
    unit("km", "m", 1e3),
    unit("m/s", "m/s", 1.0),
    unit("mm/s", "m/s", 1e-3),
    unit("km/h", "m/s", 1.0 / 3.6),
    unit("mph", "m/s", 0.44704),
    unit("m/s^2", "m/s^2", 1.0),
    unit("g", "m/s^2", 9.80665),
    unit("N", "N", 1.0),
    unit("kN", "N", 1e3),
    unit("N m", "N m", 1.0),
    unit("Nm", "N m", 1.0),
    unit("kN m", "N m", 1e3),
    unit("kNm", "N m", 1e3),
    unit("kg", "kg", 1.0),
    unit("t", "kg", 1e3),
    unit("kg m^2", "kg m^2", 1.0),
    unit("N m s/rad", "N m s/rad", 1.0),
    unit("Pa", "Pa", 1.0),
    unit("kPa", "Pa", 1e3),
    unit("MPa", "Pa", 1e6),
    unit("bar", "Pa", 1e5),
    unit("V", "V", 1.0),
    unit("A", "A", 1.0),
    unit("%", "", 0.01),
    unit("1", "", 1.0),
];

/// The unit called `name`.
pub(crate) fn find(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|u| u.name == name)
}

//! Description of a wheel loader.

pub use estimation::loader::keys::Description as Loader;
use messages::Machine;

use crate::Error;
use crate::keyed::tables;

tables!(
    Loader,
    Machine::Loader,
    contradictions,
    Loader::of_its_size,
    [machine, lift_arm, lift_cylinder, sensors, prior, estimator]
);

/// Largest mass per cube of the wheelbase [kg/m^3]: loaders of 5 to 50 t have
/// 350 to 600, so four times that is another unit.
const HEAVIEST: f64 = 2400.0;
/// Least wheelbase of a real machine, as opposed to a scale model [m].
const LEAST_WHEELBASE: f64 = 1.0;

/// Contradictions between keys that are each in range.
fn contradictions(loader: &Loader) -> Vec<Error> {
    let (e, p, m) = (&loader.estimator, &loader.prior, &loader.machine);
    let limits = [
        (
            "slip_stiffness",
            e.slip_stiffness_min,
            p.slip_stiffness,
            e.slip_stiffness_max,
        ),
        ("cg_height", e.cg_height_min, p.cg_height, e.cg_height_max),
        ("cg_ratio", e.cg_ratio_min, p.cg_ratio, e.cg_ratio_max),
    ];
    let mut found: Vec<Error> = limits
        .into_iter()
        .filter(|(_, low, prior, high)| !(low < high && low <= prior && prior <= high))
        .map(|(name, low, prior, high)| {
            Error::between(
                format!("prior.{name} ({prior}) lies outside estimator.{name}_min to {name}_max ({low} to {high})"),
                &format!("prior.{name}"),
                "give a prior inside the limits, or move the limits",
            )
        })
        .collect();
    let (mass, wheelbase) = (m.mass, m.wheelbase);
    if wheelbase >= LEAST_WHEELBASE && mass > HEAVIEST * wheelbase * wheelbase * wheelbase {
        found.push(Error::between(
            format!("a mass of {mass} kg does not fit a wheelbase of {wheelbase} m: newtons where kilograms belong, or millimetres?"),
            "machine.mass",
            "give the mass in kg and the wheelbase in m",
        ));
    }
    found
}

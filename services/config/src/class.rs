//! A machine by its size alone, as `--class 21t` says it: the keys that follow from the mass.

use messages::Machine;

/// Of a wheel loader per cube root of its mass [m/kg^(1/3)]: wheelbase, wheel radius, reach of the bucket, height of the centre of
/// gravity. Means over loaders of 5 to 15 t; they scatter by 5 %, the height by 15 %.
const WHEELBASE: f64 = 0.136;
const RADIUS: f64 = 0.0318;
const REACH: f64 = 0.094;
const HEIGHT: f64 = 0.051;
/// Inertia of an axle over mass^(5/3) [kg^(-2/3) m^2].
const AXLE: f64 = 4.4e-5;
/// Forces and torques that grow with the weight, as shares of mass [N/kg], and of mass times radius.
const SPADE: f64 = 0.0638;
const DIG: f64 = 0.532;
const EXCITED: f64 = 0.116;
/// Shares of the height: its spread, its limits, what an estimate leaves open, what is enough, its random walk.
const SPREAD: f64 = 0.145;
const LIMITS: [f64; 2] = [0.33, 2.8];
const FLOOR: f64 = 0.0444;
const ENOUGH: f64 = 0.0889;
const WALK: f64 = 3.3e-5;

/// The keys that a machine of this mass \[kg\] has other than the reference machine, as `--set` takes them.
#[must_use]
pub fn class(machine: Machine, mass: f64) -> Vec<String> {
    match machine {
        Machine::Excavator => vec![format!("machine.operating_mass={mass:?}")],
        Machine::Loader => loader(mass),
    }
}

fn loader(mass: f64) -> Vec<String> {
    let length = mass.cbrt();
    let (radius, height) = (RADIUS * length, HEIGHT * length);
    let keys = [
        ("machine.mass", mass),
        ("machine.wheelbase", WHEELBASE * length),
        ("machine.wheel_radius", radius),
        ("machine.bucket_reach", REACH * length),
        ("machine.axle_inertia", AXLE * mass * length * length),
        ("prior.cg_height", height),
        ("prior.cg_height_std", SPREAD * height),
        ("prior.spade_force_std", SPADE * mass),
        ("estimator.q_spade_force", 0.5 * SPADE * mass),
        ("estimator.dig_force", DIG * mass),
        ("estimator.excited_torque", EXCITED * mass * radius),
        ("estimator.cg_height_min", LIMITS[0] * height),
        ("estimator.cg_height_max", LIMITS[1] * height),
        ("estimator.cg_height_floor", FLOOR * height),
        ("estimator.converged_height", ENOUGH * height),
        ("estimator.q_cg_height", WALK * height),
    ];
    keys.iter()
        .map(|(key, value)| format!("{key}={value:?}"))
        .collect()
}

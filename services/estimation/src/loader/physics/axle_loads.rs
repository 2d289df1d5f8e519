//! Vertical axle loads of a loader on a slope, (10) and (11) as they must read.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | F_zf, F_zr | result | axle loads (tyre normal forces) | N |
//! | a = dv/dt | `acceleration` | rate of the speed along the road | m/s^2 |
//! | h, lam | `height`, `ratio` | height of the centre of gravity; share of the static weight in front | m, - |
//! | F_z | `spade_force_z` | force on the bucket tip, down positive | N |
//! | l, l_c, l_l = l + l_c | `wheelbase`, `bucket_reach` | axle distance; front axle to bucket tip | m |
//! | tr | `transfer` | load moved to the front axle | N |
//!
//! ```text
//! F_zf = m g lam cos th     + F_z l_l/l + tr                                 (10)
//! F_zr = m g (1-lam) cos th - F_z l_c/l - tr                                 (11)
//! physical: tr = -m h (dv/dt + g sin th)/l        printed: tr = +m h (dv/dt - g sin th)/l
//! ```
//! Misprints of (6), (7), (10), (11): numerators stand inside the wrong fractions, and dv/dt has the wrong sign. The printed
//! slope term is right, so no choice of axes makes the printed pair consistent with (1). Accelerating unloads the front axle.

use super::machine::{Road, WheelDynamics};
use crate::loader::LoadTransfer;
use crate::scalar::Scalar;

/// Axle loads are at least this share of the weight: a lifted axle still has a slip.
pub(super) const LEAST_LOAD: f64 = 0.02;

/// Front and rear axle load, each floored at 2 % of the weight \[N\].
#[inline(always)]
pub fn axle_loads<T: Scalar>(
    machine: &WheelDynamics,
    acceleration: T,
    height: T,
    ratio: T,
    spade_force_z: f64,
    road: &Road<T>,
) -> (T, T) {
    let (front, rear) =
        unfloored_axle_loads(machine, acceleration, height, ratio, spade_force_z, road);
    let least = T::constant(LEAST_LOAD * machine.mass * machine.gravity);
    (front.max(least), rear.max(least))
}

/// Front and rear axle load; negative where the axle would lift \[N\].
#[inline(always)]
pub fn unfloored_axle_loads<T: Scalar>(
    machine: &WheelDynamics,
    acceleration: T,
    height: T,
    ratio: T,
    spade_force_z: f64,
    road: &Road<T>,
) -> (T, T) {
    let (mass, wheelbase) = (machine.mass, machine.wheelbase);
    let along = road.sine * machine.gravity;
    let transfer = match machine.load_transfer {
        LoadTransfer::Physical => -(height * (acceleration + along) * (mass / wheelbase)),
        LoadTransfer::Printed => height * (acceleration - along) * (mass / wheelbase),
    };
    let weight = road.cosine * (mass * machine.gravity);
    let lever = machine.bucket_reach / wheelbase;
    let front = weight * ratio + spade_force_z * (1.0 + lever) + transfer; // (10)
    let rear = weight * (-ratio + 1.0) - spade_force_z * lever - transfer; // (11)
    (front, rear)
}

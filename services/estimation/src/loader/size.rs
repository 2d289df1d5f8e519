//! Description of a loader from a few numbers: the usual values for its mass.

use nalgebra::ComplexField;

use super::RATED_SHARE;
use super::keys::Description;
use crate::loads;

/// Per cube root of its mass [m/kg^(1/3)]: wheelbase, wheel radius, reach of the bucket, height of the centre of
/// gravity. Means over loaders of 5 to 15 t, of the radius over rolling tyres of 2.5 to 50 t (10.0/75-15.3 to 35/65R33); they scatter
/// by 5 %, the height by 15 %.
const WHEELBASE: f64 = 0.136;
const RADIUS: f64 = 0.0289;
const REACH: f64 = 0.094;
const HEIGHT: f64 = 0.051;
/// Relative standard deviation of a radius that is not stated.
const RADIUS_STD: f64 = 0.05;
/// Inertia of an axle over mass times squared wheel radius: two wheels of 3.5 % of the mass each, with .7 of the radius as radius of gyration.
const AXLE: f64 = 0.035;
/// Forces and torques that grow with the weight, as shares of mass [N/kg], and of mass times radius.
const SPADE: f64 = 0.0638;
const DIG: f64 = 0.532;
const EXCITED: f64 = 0.116;
/// Shares of the height: its prior deviation, its limits, its floor, its limit of convergence, its random walk.
const SPREAD: f64 = 0.145;
const LIMITS: [f64; 2] = [0.33, 2.8];
const FLOOR: f64 = 0.0444;
const ENOUGH: f64 = 0.0889;
const WALK: f64 = 3.3e-5;

/// Relative difference from the reference machine's mass within which the machine counts as that one, weighed or calibrated.
const SAME: f64 = 0.05;

impl Description {
    /// Settings of the ledger of its loads, as far as the machine determines them.
    #[must_use]
    pub fn loads(&self) -> loads::Settings {
        loads::Settings {
            lift_arm: self.loads_common(),
            ..loads::Settings::with_rated(RATED_SHARE * self.machine.mass)
        }
    }

    /// The defaults of a loader of the stated mass; those of the reference machine where none is stated.
    #[must_use]
    pub fn of_its_size(&self) -> Self {
        let mut d = Self {
            stated: self.stated,
            ..Self::default()
        };
        let mass = self.machine.mass;
        if ComplexField::abs(mass / d.machine.mass - 1.0) <= SAME {
            return d;
        }
        let stated = |i: usize, value: f64, default: f64, guess: f64| {
            if value == default && !self.stated[i] {
                guess
            } else {
                value
            }
        };
        let length = ComplexField::cbrt(mass);
        let (m, p, e) = (&mut d.machine, &mut d.prior, &mut d.estimator);
        let radius = stated(
            0,
            self.machine.wheel_radius,
            m.wheel_radius,
            RADIUS * length,
        );
        let height = stated(1, self.prior.cg_height, p.cg_height, HEIGHT * length);
        m.mass = mass;
        m.wheelbase = WHEELBASE * length;
        m.wheel_radius = radius;
        m.bucket_reach = REACH * length;
        m.axle_inertia = AXLE * mass * radius * radius;
        // Also where the radius followed from the mass before.
        if radius == RADIUS * length {
            p.radius_std = RADIUS_STD;
        }
        p.cg_height = height;
        p.cg_height_std = SPREAD * height;
        p.spade_force_std = SPADE * mass;
        e.q_spade_force = 0.5 * SPADE * mass;
        e.dig_force = DIG * mass;
        e.excited_torque = EXCITED * mass * radius;
        [e.cg_height_min, e.cg_height_max] = LIMITS.map(|share| share * height);
        e.cg_height_floor = FLOOR * height;
        e.converged_height = ENOUGH * height;
        e.q_cg_height = WALK * height;
        d
    }
}

//! Standard deviation of the force on the bucket: other causes of the force that the torques do not explain.
//!
//! The filter determines F by the balance of forces along the road,
//! ```text
//! F = T/r - m dv/dt - m g sin th - f m g
//! ```
//! and its own deviation is that of the noise and of the slope's zero. The rest of the right-hand side is not known exactly either:
//!
//! | cause | standard deviation |
//! |---|---|
//! | ground, firm to soft | [`GROUND`] of f m g |
//! | torque gains; mass of a machine whose load nobody states | their shares of T/r |
//! | a load presses the front tyres flat: the inclinometer shows the pitch | m g times that pitch |
//! | friction brakes | the force itself: all of it may be theirs |
//! | standstill, where brakes and rolling resistance hold the machine | what exceeds T/r |
//!
//! The pitch is d (N_f - N_r)/(N_0 l), d the deflection of a tyre under the nominal load N_0. A rolling radius loses a third of the
//! deflection (Jazar, Vehicle Dynamics, 1.5), so d = 3 rho r. A load p at the bucket's reach l_l adds p g (1 + 2 l_l/l) to N_f - N_r.

use crate::loader::physics::wheel_dynamics::WheelDynamics;
use crate::math::sqrt;

/// Relative standard deviation of the rolling resistance: .01 on concrete to .05 on loose gravel (Wong, Theory of Ground Vehicles, 3.2).
const GROUND: f64 = 0.5;
/// Deflection of a tyre over the loss of its rolling radius.
const DEFLECTION: f64 = 3.0;
/// Speed below which brakes may hold the machine [m/s].
const STANDS: f64 = 0.1;
/// Relative standard deviations of the torques that a drive reports, and of a stated mass.
const TORQUE: f64 = 0.03;
const MASS: f64 = 0.02;

/// What else acts along the road.
#[derive(Clone, Copy, Debug)]
pub struct Balance<'a> {
    /// The machine with its present mass.
    pub machine: &'a WheelDynamics,
    /// Front axle to bucket tip, in wheelbases.
    pub reach: f64,
    /// Speed [m/s], and force of the torques on the road [N].
    pub speed: f64,
    pub pull: f64,
    /// Unreported load, as a share of the mass.
    pub unreported: f64,
    /// Friction brakes are reported.
    pub braked: bool,
}

impl Balance<'_> {
    /// Standard deviation of a force on the bucket that the filter knows to `own` \[N\].
    pub fn std(&self, force: f64, own: f64) -> f64 {
        let m = self.machine;
        let weight = m.mass * m.gravity;
        let loaded = 2.0 * (m.mass / m.empty_mass - 1.0) * (1.0 + 2.0 * self.reach);
        let pitch = DEFLECTION * m.radius_load_sensitivity * m.wheel_radius * loaded / m.wheelbase;
        let ground = GROUND * m.rolling_resistance;
        let shares = self.unreported * self.unreported + TORQUE * TORQUE + MASS * MASS;
        let held = if self.braked {
            force
        } else if self.speed.abs() < STANDS {
            force - self.pull
        } else {
            0.0
        };
        sqrt(
            own * own
                + weight * weight * (pitch * pitch + ground * ground)
                + self.pull * self.pull * shares
                + held * held,
        )
    }
}

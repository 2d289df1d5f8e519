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
//! | ground, firm to soft | f m g |
//! | torque gains | their share of T/r |
//! | mass; a load that nobody states | its share of T/r - F |
//! | curves, in which wheels of two axles scrub | [`SCRUB`] gamma^2 m g |
//! | a load presses the front tyres flat: the inclinometer shows the pitch | m g times that pitch |
//! | reported friction brakes | the force itself: all of it may be theirs |
//! | friction brakes by the motion; standstill, where they hold the machine | what the torques do not push with |
//!
//! The pitch is d (N_f - N_r)/(N_0 l), d the deflection of a tyre under the nominal load N_0. A rolling radius loses a third of the
//! deflection (Jazar, Vehicle Dynamics, 1.5), so d = 3 rho r. A load p at the bucket's reach l_l adds p g (1 + 2 l_l/l) to N_f - N_r.

use crate::loader::physics::wheel_dynamics::WheelDynamics;
use crate::math::sqrt;

/// Relative standard deviation of the rolling resistance: .01 on concrete, .05 on loose gravel, more on soil (Wong, Theory of Ground
/// Vehicles, 3.2).
const GROUND: f64 = 1.0;
/// Deflection of a tyre over the loss of its rolling radius.
const DEFLECTION: f64 = 3.0;
/// Resistance of a machine that turns, over its weight and the square of the angle between its bodies: .2 to .3 in independent simulators.
const SCRUB: f64 = 0.25;
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
    /// Square of the angle between the bodies, smoothed [rad^2].
    pub turn: f64,
    /// Standard deviation of the mass by a load that nobody states, as a share.
    pub unreported: f64,
    /// Friction brakes are reported; seem to act.
    pub braked: bool,
    pub brakes: bool,
}

impl Balance<'_> {
    /// Standard deviation of a force on the bucket whose variance in the filter is `own` [N^2], in N.
    pub fn std(&self, force: f64, own: f64) -> f64 {
        let m = self.machine;
        let weight = m.mass * m.gravity;
        let loaded = 2.0 * (m.mass / m.empty_mass - 1.0) * (1.0 + 2.0 * self.reach);
        let pitch = DEFLECTION * m.radius_load_sensitivity * m.wheel_radius * loaded / m.wheelbase;
        let ground = GROUND * m.rolling_resistance;
        let scrub = SCRUB * self.turn;
        let torque = TORQUE * self.pull;
        let mass = self.pull - force;
        let shares = self.unreported * self.unreported + MASS * MASS;
        let held = if self.braked {
            force
        } else if self.brakes || self.speed.abs() < STANDS {
            // Who digs pushes with his torques, who brakes does not.
            force - self.pull.clamp(force.min(0.0), force.max(0.0))
        } else {
            0.0
        };
        sqrt(
            own.max(0.0)
                + weight * weight * (pitch * pitch + ground * ground + scrub * scrub)
                + torque * torque
                + mass * mass * shares
                + held * held,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loader::Settings;

    const PULL: f64 = 2000.0;

    /// Standard deviation of a force, known to 100 N, on a machine that this alters.
    fn std(force: f64, alter: impl FnOnce(&mut Balance, &mut WheelDynamics)) -> f64 {
        let mut machine = WheelDynamics::of(&Settings::DEFAULT);
        let other = machine;
        let mut balance = Balance {
            machine: &other,
            reach: 0.7,
            speed: 2.0,
            pull: PULL,
            turn: 0.0,
            unreported: 0.0,
            braked: false,
            brakes: false,
        };
        alter(&mut balance, &mut machine);
        Balance {
            machine: &machine,
            ..balance
        }
        .std(force, 100.0 * 100.0)
    }

    #[test]
    fn the_rolling_resistance_is_that_of_the_ground() {
        let m = WheelDynamics::of(&Settings::DEFAULT);
        let rolling = m.rolling_resistance * m.mass * m.gravity;
        let driving = std(0.0, |_, _| ());
        assert!(
            (1.0 * rolling..1.1 * rolling).contains(&driving),
            "{driving}"
        );
        let ideal = std(PULL, |_, m| m.rolling_resistance = 0.0);
        assert!(
            (100.0..130.0).contains(&ideal),
            "3 % of the torque: {ideal}"
        );
    }

    #[test]
    fn a_load_pitches_the_machine_and_one_that_nobody_states_has_its_inertia() {
        let empty = std(0.0, |_, _| ());
        let loaded = std(0.0, |_, m| m.mass *= 1.3);
        assert!(loaded > 1.35 * empty, "{loaded} {empty}");
        let rigid = std(0.0, |_, m| {
            m.mass *= 1.3;
            m.radius_load_sensitivity = 0.0;
        });
        assert!(rigid < 1.31 * empty, "{rigid} {empty}");
        let unreported = std(0.0, |b, _| (b.unreported, b.pull) = (0.2, 10_000.0));
        assert!((2000.0..2400.0).contains(&unreported), "{unreported}");
        // A machine that pushes without moving does not accelerate its load.
        let pushing = std(10_000.0, |b, _| (b.unreported, b.pull) = (0.2, 10_000.0));
        assert!(pushing < 1000.0, "{pushing}");
    }

    #[test]
    fn what_brakes_may_hold_is_uncertain() {
        let braked = std(5000.0, |b, _| b.braked = true);
        assert!(braked > 5000.0, "{braked}");
        let parked = std(4000.0, |b, _| (b.speed, b.pull) = (0.0, 0.0));
        assert!(parked > 4000.0, "{parked}");
        let stalled = std(PULL, |b, _| b.speed = 0.0);
        assert!(stalled < 1000.0, "pushes with all of its torque: {stalled}");
        let slowed = |pull: f64| std(8000.0, |b, _| (b.brakes, b.pull) = (true, pull));
        let (digs, coasts) = (slowed(9000.0), slowed(-500.0));
        assert!(digs < 1100.0 && coasts > 8000.0, "{digs} {coasts}");
    }

    #[test]
    fn wheels_scrub_in_a_curve() {
        let [straight, curve] = [0.0, 0.12].map(|turn| std(0.0, |b, _| b.turn = turn));
        assert!(curve > 1.5 * straight, "{curve} {straight}");
    }
}

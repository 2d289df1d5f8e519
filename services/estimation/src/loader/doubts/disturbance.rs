//! Disturbances of the wheel speeds that the reported torques do not contain: brakes, steering, and unmeasured forces.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | gamma | `angle` | angle between front and rear body | rad |
//! | kappa | `gain` | force on the body over the force of the reported torques | 1 |
//! | a_u | `unexplained` | specific force that the torques do not explain | m/s^2 |
//!
//! * **Steering.** In a turn the axles run on different circles. Their speeds differ by about gamma^2 v, depending on the hinge.
//! * **Bending.** While the machine bends, its axles approach each other at gamma dgamma/dt L/4. L is the wheelbase, and the hinge is in the
//!   middle, where small offsets have no effect. The prediction of the wheel speeds includes this; a share of it is noise of the slips.
//! * **Forces.** A force F_u = m a_u that no torque explains is that of the friction brakes, the bucket, or a torque that is reported late.
//!   It may or may not pass through the tyres, so it changes a slip by up to a_u/(g K).
//!
//! Each of these errors keeps its sign while it lasts. It does not average out, so its weight exceeds that of noise of its size. It
//! fades over 0.25 s, because tyres and body settle; brakes count for as long.

use super::gain::{Gain, LARGEST};
use crate::loader::input::inputs::StepInputs;
use crate::loader::load::inertia::Push;
use crate::loader::load::stated_mass::{Kind, StatedMass};
use crate::loader::measurements::accelerometer::Shaking;
use crate::loader::physics::wheel_dynamics::{ROLLING_WIDTH, WheelDynamics};
use crate::math::{sqrt, tanh};

/// Time by which brakes outlast their cause, and time constant with which other disturbances fade [s].
const HOLD: f64 = 0.25;
/// Averaging time of the unexplained specific force [s].
const TIME: f64 = 0.05;
/// Share by which a force in the pile varies from one correlation time to the next.
const VARIES: f64 = 0.3;
/// Specific force that noise and tolerances leave unexplained: for any acceleration [m/s^2], and as a share of the acceleration.
const EXPLAINED: f64 = 0.05;
const EXPLAINED_SHARE: f64 = 0.05;
/// Weight of an unexplained force, relative to noise of its size.
const FORCE_WEIGHT: f64 = 4.0;
/// Excess beyond what is explained, against the motion, that indicates brakes or the ground [m/s^2].
const UNREPORTED: f64 = 0.15;
/// Weight of the steering, relative to noise of its size.
const TURN_WEIGHT: f64 = 1.0;
/// Averaging time of the rate at which the machine bends [s].
const BENDING: f64 = 0.05;
/// Share of the bending effect that remains as noise, by averaging, tyres and an unknown hinge. Without it the worst of 18 good
/// machines covers .86 of its rows, with it .93.
const BENDING_LEFT: f64 = 0.3;
/// Speed below which stiction and the ground act [m/s].
const LEAST_SPEED: f64 = 0.5;
/// Angle between the bodies beyond which the wheels drag [rad].
const STRAIGHT: f64 = 0.1;

/// Largest effect of a disturbance, which fades as tyres and body settle. A lower one shows once the higher has faded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Peak(f64);

impl Peak {
    fn update(&mut self, value: f64, dt: f64) -> f64 {
        self.0 = value.max(self.0 * (1.0 - (dt / HOLD).min(1.0)));
        self.0
    }
}

/// State of the disturbances.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Disturbance {
    /// Time for which brakes still act [s].
    brake: f64,
    /// Time for which reported brakes still act [s].
    reported: f64,
    turn: Peak,
    force: Peak,
    /// Angle between the bodies, low-passed over [`BENDING`] [rad].
    late_angle: f64,
    /// Specific force that the torques do not explain, smoothed over [`TIME`] [m/s^2].
    fast: f64,
    pub gain: Gain,
    /// Whether the machine is as heavy as stated.
    pub mass: StatedMass,
    /// Noise of the accelerometer where it is mounted.
    pub shaking: Shaking,
    /// The row states the mass with its load.
    pub states_mass: bool,
    /// Smoothed specific force that the torques do not explain, forward positive [m/s^2].
    pub unexplained: f64,
}

/// Effect of a step's disturbances on the wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Effect {
    /// Brakes act: the wheel speeds carry no information.
    pub braking: bool,
    /// Reported brakes act.
    pub braked: bool,
    /// Standard deviation of both slips from steering.
    pub turn: f64,
    /// Speed at which the axles approach each other because the machine bends [m/s].
    pub closing: f64,
    /// Standard deviation of both slips from unexplained forces.
    pub force: f64,
    /// Specific force by which an unmeasured force changes in the time of its correlation [m/s^2].
    pub changes: f64,
}

impl Disturbance {
    /// Updates the disturbances with a step of `dt`; `speed`, `stiffness` and `force`, on the bucket, are the predicted ones.
    pub fn update(
        &mut self,
        machine: &WheelDynamics,
        step: &StepInputs,
        [speed, stiffness, force]: [f64; 3],
        dt: f64,
    ) -> Effect {
        self.states_mass = step.states_mass;
        let angle = step.turning(speed, machine.wheelbase);
        let closing = self.closing(angle, machine.wheelbase, dt);
        let mut by_turn = angle * angle;
        if closing != 0.0 {
            by_turn += BENDING_LEFT * closing.abs() / speed.abs().max(LEAST_SPEED);
        }
        let turn = TURN_WEIGHT * self.turn.update(by_turn, dt);
        let followed = force / machine.rolling_mass();
        let [excess, unfollowed] = step.acceleration.map_or([0.0; 2], |a| {
            self.explain(machine, step, [speed, a], dt);
            let explained = EXPLAINED + EXPLAINED_SHARE * a.abs();
            [self.fast, self.fast + followed].map(|left| (left.abs() - explained).max(0.0))
        });
        let varies = VARIES * excess;
        let unreported_braking = excess > UNREPORTED && self.fast * speed < 0.0;
        self.brake = if step.brake || unreported_braking {
            HOLD
        } else {
            self.brake - dt
        };
        self.reported = if step.brake { HOLD } else { self.reported - dt };
        let braking = self.brake > 0.5 * dt;
        let force = FORCE_WEIGHT * self.force.update(excess, dt) / (machine.gravity * stiffness);
        Effect {
            braking,
            braked: self.reported > 0.5 * dt,
            turn,
            closing,
            force,
            changes: sqrt(unfollowed * unfollowed + varies * varies),
        }
    }

    /// Speed at which the axles approach each other because the machine bends [m/s].
    fn closing(&mut self, angle: f64, wheelbase: f64, dt: f64) -> f64 {
        if angle == self.late_angle {
            return 0.0;
        }
        let bending = (angle - self.late_angle) / BENDING;
        self.late_angle += (dt / BENDING).min(1.0) * (angle - self.late_angle);
        0.25 * wheelbase * self.late_angle * bending
    }

    /// Updates the part of the measured specific force that the torques do not explain, and what is learnt from it.
    fn explain(
        &mut self,
        machine: &WheelDynamics,
        step: &StepInputs,
        [speed, measured]: [f64; 2],
        dt: f64,
    ) {
        let u = &step.inputs;
        let inertia = machine.rolling_mass();
        let pull = (u.front_torque + u.rear_torque) / (machine.wheel_radius * inertia);
        let fade = tanh(speed / ROLLING_WIDTH);
        let rolling = machine.rolling_resistance * fade * machine.mass * machine.gravity;
        let needed = measured + (rolling + u.spade_force_x) / inertia;
        let alone = u.spade_force_x == 0.0 && !step.brake;
        let drives = alone && pull * speed > 0.0;
        let residual = needed - self.gain.value() * pull;
        let straight = step.turning(speed, machine.wheelbase).abs() < STRAIGHT;
        let free = alone && speed.abs() > LEAST_SPEED;
        self.shaking.see(residual, free, dt);
        let row = Push {
            acceleration: measured,
            pull,
            speed,
        };
        let kind = Kind {
            states_mass: step.states_mass,
            tells: free && straight && pull.abs() < LARGEST && measured.abs() < LARGEST,
            drives,
            stands: speed.abs() < LEAST_SPEED,
            pushes: self.fast.abs() > UNREPORTED + EXPLAINED + EXPLAINED_SHARE * measured.abs(),
        };
        self.mass.see(machine.mass, &row, &kind, dt);
        self.gain.see(&row, kind.tells && drives, dt);
        self.fast += (dt / TIME).min(1.0) * (residual - self.fast);
        self.unexplained += (dt / HOLD).min(1.0) * (residual - self.unexplained);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loader::physics::wheel_dynamics::Inputs;
    use crate::loader::settings::Settings;

    #[test]
    fn a_lower_peak_is_not_forgotten_with_the_higher_one_before() {
        let mut peak = Peak::default();
        let mut values = [0.0; 31];
        (values[0], values[20]) = (2.0, 1.0);
        let told = values.map(|value| peak.update(value, 0.01));
        for (row, left) in [(20, 1.0), (30, 0.96_f64.powi(10))] {
            assert!((told[row] - left).abs() < 1e-12, "{told:?}");
        }
    }

    #[test]
    fn brakes_act_a_quarter_of_a_second_longer() {
        let machine = WheelDynamics::of(&Settings::DEFAULT);
        let mut step = StepInputs {
            inputs: Inputs::of([0.0; 5]),
            sine: 0.0,
            acceleration: None,
            brake: true,
            states_mass: false,
            articulation: None,
            yaw_rate: None,
        };
        let mut disturbance = Disturbance::default();
        let mut brakes =
            |step: &StepInputs| disturbance.update(&machine, step, [2.0, 19.0, 0.0], 0.01);
        assert!(brakes(&step).braking);
        step.brake = false;
        let after = [0; 30].map(|_| brakes(&step).braking);
        assert_eq!(after.iter().filter(|braking| **braking).count(), 24);
    }
}

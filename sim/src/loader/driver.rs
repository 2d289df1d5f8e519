//! The driver: inputs of the machine in a scenario.

use std::f64::consts::TAU;

use super::arm::{LiftArm, Stance};
use super::cycle::WorkCycle;
use super::lifts;
use super::loading::Loading;
use super::payload::{PAYLOAD_HEIGHT, PAYLOAD_REACH, Payload, loaded};
use super::plant::{GRAVITY, Inputs, Machine};
use super::profile::Profile;
use super::scenario::Scenario;
use crate::noise::Noise;

const CRUISE_SPEED: f64 = 2.5;

/// The driver: inputs of the machine over time.
#[derive(Clone, Debug)]
pub(super) struct Driver {
    scenario: Scenario,
    machine: Machine,
    motor: Profile,
    cycle: WorkCycle,
    bucket: Profile,
    payload: Profile,
    lift: Profile,
    arm: LiftArm,
    /// The plan of `loading`.
    loading: Option<Loading>,
    /// Whether arm and bucket move the centre of gravity.
    arm_counts: bool,
}

impl Driver {
    pub fn new(scenario: Scenario, payload: Option<f64>, machine: &Machine, noise: Noise) -> Self {
        let mass = scenario.payload(payload);
        let picks_up = scenario == Scenario::LoadCycle;
        let is_loading = scenario == Scenario::Loading;
        let loading = is_loading.then(|| Loading::new(machine, payload, noise.clone()));
        let bucket: &[(f64, f64)] = match scenario {
            Scenario::Spading | Scenario::Digging => &[(0.0, 0.0), (5.0, 1.0), (7.0, 0.0)],
            Scenario::LoadCycle => &[(0.0, 0.0), (15.0, 1.0), (18.0, 0.0)],
            _ => &[],
        };
        let steps = |level: f64, at: f64| [(0.0, 0.0), (at, level)];
        Self {
            scenario,
            machine: *machine,
            motor: scenario.motor_torque(machine, machine.mass + mass),
            arm: LiftArm::of(machine),
            arm_counts: is_loading || scenario == Scenario::Lifts,
            loading,
            cycle: WorkCycle::new(scenario, noise),
            bucket: Profile::new(
                bucket,
                if scenario == Scenario::Spading {
                    0.15
                } else {
                    0.5
                },
            ),
            payload: Profile::new(
                &if picks_up {
                    steps(mass, 16.0)
                } else {
                    [(0.0, mass); 2]
                },
                2.0,
            ),
            lift: Profile::new(
                &if picks_up {
                    steps(0.9, 20.0)
                } else {
                    [(0.0, 0.0); 2]
                },
                4.0,
            ),
        }
    }

    /// Sets whether every other run is driven backwards.
    pub fn reversing(self, reverses: bool) -> Self {
        let cycle = self.cycle.reversing(reverses);
        Self { cycle, ..self }
    }

    /// Sets whether arm and bucket move the centre of gravity when they are lifted.
    pub fn with_arm(self, counts: bool) -> Self {
        Self {
            arm_counts: self.arm_counts || counts,
            ..self
        }
    }

    /// The lift arm.
    pub fn arm(&self) -> &LiftArm {
        &self.arm
    }

    /// Stance of arm and bucket at time `t`.
    pub fn stance(&self, t: f64) -> Stance {
        match &self.loading {
            Some(plan) => plan.stance(t),
            None if self.scenario == Scenario::Lifts => lifts::stance(t),
            None => self.arm.raised(PAYLOAD_HEIGHT + self.lift.at(t)),
        }
    }

    /// Share of the bucket in the ground, 0 to 1.
    pub fn contact(&self, t: f64) -> f64 {
        match &self.loading {
            Some(plan) => plan.contact(t),
            None => self.bucket.at(t).clamp(0.0, 1.0),
        }
    }

    /// The payload at time `t`; unless the arm counts, it rises vertically.
    pub fn payload(&self, t: f64) -> Payload {
        let [reach, height] = if self.arm_counts {
            self.arm.place(&self.stance(t))
        } else {
            [PAYLOAD_REACH, PAYLOAD_HEIGHT + self.lift.at(t)]
        };
        let mass = match &self.loading {
            Some(plan) => plan.load(t),
            None => self.payload.at(t),
        };
        Payload {
            mass,
            height,
            reach,
        }
    }

    /// Whether the boom moves with a payload that changes the centre of gravity.
    pub fn boom_moving(&self, t: f64) -> bool {
        let loads = self.loading.as_ref().is_some_and(|plan| plan.moves(t));
        let lifts = self.scenario == Scenario::Lifts && lifts::moves(t);
        loads || lifts || self.payload.moving(t) || self.lift.moving(t)
    }

    /// Whether it loads a truck.
    pub fn loads(&self) -> bool {
        self.loading.is_some()
    }

    /// Inputs at time `t`, to be called in the order of time; `speed` is the machine's just before.
    pub fn inputs(&mut self, t: f64, speed: f64) -> Inputs {
        let (mass, mut cg_height, mut cg_ratio) = loaded(&self.machine, &self.payload(t));
        if self.arm_counts {
            let [forward, up] = self.arm.shift(&self.stance(t));
            cg_ratio += forward / (mass * self.machine.wheelbase);
            cg_height += up / mass;
        }
        let direction = if self.cycle.backwards() { -1.0 } else { 1.0 };
        if let Some((time, a)) = self.cycle.next_leg(t, direction * speed) {
            let direction = if self.cycle.backwards() { -1.0 } else { 1.0 };
            let torque = direction * motor_torque(&self.machine, mass, a);
            self.motor.push(time, torque);
        }
        let mut torque = self.machine.gear_ratio * self.motor.at(t);
        if let Some(plan) = &self.loading {
            let force = plan.traction(&self.machine, mass, t, speed);
            torque = 0.5 * force * self.machine.wheel_radius;
        }
        let share = if self.scenario == Scenario::Dither {
            0.5 + 0.25 * (4.0 * (TAU * t / 6.0).sin()).clamp(-1.0, 1.0)
        } else {
            0.5
        };
        let [spade_force_x, spade_force_z] = self.spade_force(t);
        Inputs {
            front_torque: 2.0 * torque * share,
            rear_torque: 2.0 * torque * (1.0 - share),
            front_brake: 0.0,
            rear_brake: 0.0,
            bend_gain: 1.0,
            bend_offset: 0.0,
            spade_force_x,
            spade_force_z,
            mass,
            cg_height,
            cg_ratio,
        }
    }

    fn spade_force(&self, t: f64) -> [f64; 2] {
        let b = self.bucket.at(t);
        match self.scenario {
            Scenario::Spading => [600.0 * b, 0.0],
            Scenario::Digging => [
                11_000.0 * b * (1.0 + 0.15 * (TAU * 1.3 * t).sin()),
                2_500.0 * b * (1.0 + 0.3 * (TAU * 0.9 * t + 1.0).sin()),
            ],
            Scenario::LoadCycle => [10_000.0 * b, 1_500.0 * b],
            Scenario::Loading => self.loading.as_ref().map_or([0.0; 2], |plan| plan.heap(t)),
            _ => [0.0, 0.0],
        }
    }
}

impl Scenario {
    /// Motor torque per axle [N m]; empty for a work cycle, which decides during the run.
    fn motor_torque(self, machine: &Machine, mass: f64) -> Profile {
        const FIELD: &[(f64, f64)] = &[(0.0, 0.0), (0.3, 50.0)];
        const DIG: &[(f64, f64)] = &[
            (0.0, 0.0),
            (0.3, 50.0),
            (3.0, -20.0),
            (4.8, 120.0),
            (5.2, 210.0),
            (7.0, -30.0),
            (8.0, 40.0),
        ];
        const STEADY: &[(f64, f64)] = &[
            (0.0, 0.0),
            (1.0, 14.0),
            (4.0, 32.0),
            (14.0, -16.0),
            (18.0, 8.0),
        ];
        const HARD: &[(f64, f64)] = &[
            (0.0, 0.0),
            (0.5, 30.0),
            (4.0, 50.0),
            (7.0, 10.0),
            (8.5, -30.0),
            (10.5, 45.0),
            (13.0, 20.0),
            (14.5, -35.0),
            (16.5, 50.0),
            (19.5, 25.0),
            (21.0, 55.0),
            (24.0, -55.0),
            (27.0, -20.0),
            (28.0, 30.0),
        ];
        const LOAD: &[(f64, f64)] = &[
            (0.0, 0.0),
            (0.5, 45.0),
            (5.0, -25.0),
            (7.5, 60.0),
            (10.0, -35.0),
            (12.0, 40.0),
            (14.0, 10.0),
            (15.0, 120.0),
            (15.6, 190.0),
            (18.0, 0.0),
            (18.5, -60.0),
            (22.0, 40.0),
            (24.5, 0.0),
            (25.0, 70.0),
            (30.0, -50.0),
            (33.5, 60.0),
            (38.0, -45.0),
            (42.0, 60.0),
            (46.0, -55.0),
            (50.0, 70.0),
            (54.0, -50.0),
        ];
        match self {
            Self::Bumpy | Self::Spading => Profile::new(FIELD, 0.5),
            Self::Digging => Profile::new(DIG, 0.3),
            Self::ConstantTorque => Profile::new(STEADY, 0.3),
            Self::AccelDecel => Profile::new(HARD, 0.2),
            Self::LoadCycle => Profile::new(LOAD, 0.3),
            Self::WorkCycle | Self::Dither | Self::Loading | Self::Lifts => {
                Profile::new(&[(0.0, 0.0)], WorkCycle::RAMP)
            }
            Self::Cruise => {
                let torque = |a: f64| motor_torque(machine, mass, a);
                let reached = 0.5 + CRUISE_SPEED / 0.8;
                Profile::new(
                    &[(0.0, 0.0), (0.5, torque(0.8)), (reached, torque(0.0))],
                    0.3,
                )
            }
        }
    }
}

/// Motor torque per axle that accelerates the machine by `a` on level ground [N m].
fn motor_torque(machine: &Machine, mass: f64, a: f64) -> f64 {
    let force = (a + machine.rolling_resistance * GRAVITY) * mass;
    force * machine.wheel_radius / (2.0 * machine.gear_ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_cycle_picks_up_what_the_run_asks_for() {
        let driver = Driver::new(
            Scenario::LoadCycle,
            Some(800.0),
            &Machine::NOMINAL,
            Noise::new(1),
        );
        assert_eq!(
            (driver.payload(16.0).mass, driver.payload(18.0).mass),
            (0.0, 800.0)
        );
        assert!(!driver.boom_moving(15.9) && driver.boom_moving(17.0) && driver.boom_moving(22.0));
    }

    #[test]
    fn an_arm_lifts_a_bucket_that_stays_turned_in_and_the_load_goes_forward() {
        let machine = Machine::NOMINAL;
        let driver = Driver::new(Scenario::LoadCycle, None, &machine, Noise::new(1)).with_arm(true);
        let [low, high] = [10.0, 40.0].map(|t| (driver.payload(t), driver.stance(t)));
        assert!((low.0.height - 0.6).abs() < 1e-9 && (high.0.height - 1.5).abs() < 1e-9);
        assert!(high.0.reach > low.0.reach + 0.4, "{high:?}");
        // 43 degrees; at 57 a full bucket spills over its back.
        assert!(
            low.1.bucket == high.1.bucket && high.1.bucket < 0.8,
            "{high:?}"
        );
    }
}

//! Inputs of the plant: the driver's commands, modified by the machine's effects.

use super::driver::Driver;
use super::effects::{self, Effects, Gears};
use super::plant::{Inputs, Machine, State};

/// Inputs of the plant: the driver's commands, modified by the machine's effects.
#[derive(Clone, Debug)]
pub(super) struct Acts {
    pub effects: Effects,
    pub machine: Machine,
    pub gears: Gears,
}

impl Acts {
    pub fn inputs(&mut self, driver: &mut Driver, t: f64, state: &State) -> Inputs {
        let mut inputs = driver.inputs(t, state[0]);
        if driver.loads() && !self.effects.spins {
            let held = |torque, wheel| effects::held(&self.machine, torque, state[0], wheel);
            inputs.front_torque = held(inputs.front_torque, state[1]);
            inputs.rear_torque = held(inputs.rear_torque, state[2]);
        }
        if self.effects == Effects::default() {
            return inputs;
        }
        if self.effects.gear_delay > 0.0 {
            self.gears.follow(t, state[0]);
            let share = self.gears.share(t);
            inputs.front_torque *= share;
            inputs.rear_torque *= share;
        }
        let torques = [inputs.front_torque, inputs.rear_torque];
        let (brake, drive) = self.effects.brake(torques, state[2]);
        [inputs.front_torque, inputs.rear_torque] = drive;
        [inputs.front_brake, inputs.rear_brake] = brake;
        (inputs.bend_gain, inputs.bend_offset) =
            effects::front_speed(&self.machine, &self.effects.bend(t));
        inputs
    }
}

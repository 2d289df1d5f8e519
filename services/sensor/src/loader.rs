//! The simulated wheel loader as a source of messages.

use messages::loader_bits::{
    ACCELERATION, ARTICULATION, BOOM_MOVING, BRAKE, FRONT_TORQUE, FRONT_WHEEL_SPEED, LIFT_ANGLE,
    LIFT_HEAD_PRESSURE, LIFT_ROD_PRESSURE, MASS, REAR_TORQUE, REAR_WHEEL_SPEED, SLOPE,
    SPADE_FORCE_X, SPADE_FORCE_Z, SPEED, TILT_ANGLE, YAW_RATE,
};
use messages::{LoaderSensors, LoaderTruth};
use runtime::Source;
use sim::loader::{InvalidRun, Row, Run, Scenario, Simulation, Tier, Truth};

use crate::simulated::{Columns, mark};

/// What every simulated loader has.
const COLUMNS: u32 = SPEED
    | FRONT_WHEEL_SPEED
    | REAR_WHEEL_SPEED
    | FRONT_TORQUE
    | REAR_TORQUE
    | SLOPE
    | ACCELERATION;
/// All eight true values are known, and the payload behind them.
const ALL_KNOWN: u32 = 0b100_1111_1111;

/// A simulated wheel loader.
#[derive(Debug)]
pub struct Simulator {
    rows: Simulation,
    sequence: u64,
}

impl Simulator {
    /// Begins a run of the simulator.
    ///
    /// # Errors
    /// A number of the run is out of its range.
    pub fn new(run: &Run) -> Result<Self, InvalidRun> {
        Ok(Self {
            rows: Simulation::new(run)?,
            sequence: 0,
        })
    }

    /// Digs, drives and dumps for so long \[s\], with the usual sensors.
    ///
    /// # Errors
    /// The duration is out of its range.
    pub fn at_usual_work(duration: f64, seed: u64) -> Result<Self, InvalidRun> {
        let mut run = Run::new(Scenario::WorkCycle);
        (run.duration, run.seed, run.tier) = (Some(duration), seed, Tier::B);
        Self::new(&run)
    }
}

impl Source for Simulator {
    type Sensors = LoaderSensors;
    type Truth = LoaderTruth;

    fn next(&mut self) -> Option<(LoaderSensors, LoaderTruth)> {
        let row = self.rows.next()?;
        let mut measured = measured(&row);
        let mut known = truth(&row.truth);
        mark(&mut measured, &mut known, &mut self.sequence, row.time);
        Some((measured, known))
    }
}

fn measured(row: &Row) -> LoaderSensors {
    let mut taken = Columns::of(COLUMNS);
    let mut take = |value, bit| taken.take(value, bit);
    let message = LoaderSensors {
        speed: take(Some(row.speed), SPEED),
        front_wheel_speed: take(Some(row.front_wheel_speed), FRONT_WHEEL_SPEED),
        rear_wheel_speed: take(Some(row.rear_wheel_speed), REAR_WHEEL_SPEED),
        front_torque: take(Some(row.front_torque), FRONT_TORQUE),
        rear_torque: take(Some(row.rear_torque), REAR_TORQUE),
        slope: take(Some(row.slope), SLOPE),
        acceleration: take(Some(row.acceleration), ACCELERATION),
        mass: take(row.mass, MASS),
        spade_force_x: take(row.spade_force_x, SPADE_FORCE_X),
        spade_force_z: take(row.spade_force_z, SPADE_FORCE_Z),
        articulation: take(row.articulation, ARTICULATION),
        yaw_rate: take(row.yaw_rate, YAW_RATE),
        lift_angle: take(row.arm.map(|arm| arm.lift_angle), LIFT_ANGLE),
        tilt_angle: take(row.arm.map(|arm| arm.tilt_angle), TILT_ANGLE),
        lift_head_pressure: take(row.arm.map(|arm| arm.head_pressure), LIFT_HEAD_PRESSURE),
        lift_rod_pressure: take(row.arm.map(|arm| arm.rod_pressure), LIFT_ROD_PRESSURE),
        ..LoaderSensors::default()
    };
    for (flag, bit) in [(row.boom_moving, BOOM_MOVING), (row.brake, BRAKE)] {
        if let Some(on) = flag {
            taken.flag(on, bit);
        }
    }
    LoaderSensors {
        valid: taken.valid,
        columns: taken.columns,
        ..message
    }
}

fn truth(truth: &Truth) -> LoaderTruth {
    LoaderTruth {
        speed: truth.speed,
        front_wheel_speed: truth.front_wheel_speed,
        rear_wheel_speed: truth.rear_wheel_speed,
        cg_height: truth.cg_height,
        cg_ratio: truth.cg_ratio,
        slip_stiffness: truth.slip_stiffness,
        spade_force_x: truth.spade_force_x,
        slope: truth.slope,
        payload: truth.payload,
        known: ALL_KNOWN,
        ..LoaderTruth::default()
    }
}

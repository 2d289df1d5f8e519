//! The simulated excavator as a source of messages.

use messages::excavator_bits::{
    ARM_ANGLE, ARM_HEAD_PRESSURE, ARM_ROD_PRESSURE, BOOM_ANGLE, BOOM_HEAD_PRESSURE,
    BOOM_ROD_PRESSURE, BUCKET_ANGLE, PITCH, ROLL, SWING_TORQUE, SWING_VELOCITY,
};
use messages::{ExcavatorSensors, ExcavatorTruth};
use runtime::Source;
use sim::cylinder::Gauges;
use sim::excavator::{InvalidRun, Row, Run, Scenario, Simulation, Size, Truth, Work, cylinders};

use crate::simulated::{Columns, cylinder, mark};

/// Signals of every simulated excavator. An encoder instead of the velocity occurs in recordings only.
const COLUMNS: u32 = SWING_VELOCITY | SWING_TORQUE | BOOM_ANGLE | ARM_ANGLE | BUCKET_ANGLE;
/// All seven true values are known.
const ALL_KNOWN: u32 = 0b111_1111;

/// Drawing of the reference machine's cylinders, as `--set` takes it.
pub fn drawing() -> Vec<String> {
    // No estimator uses the arm's cylinders.
    let [boom, _] = cylinders(&Size::reference().geometry);
    cylinder("machine.boom_cylinder", &boom)
}

/// A simulated excavator.
#[derive(Debug)]
pub struct Simulator {
    rows: Rows,
    sequence: u64,
}

#[derive(Debug)]
enum Rows {
    Run(Box<Simulation>),
    Work(Box<Work>),
}

impl Simulator {
    /// Starts a run of the simulator.
    ///
    /// # Errors
    /// A number of the run is out of its range.
    pub fn new(run: &Run) -> Result<Self, InvalidRun> {
        Ok(Self {
            rows: Rows::Run(Box::new(Simulation::new(run)?)),
            sequence: 0,
        })
    }

    /// Digs, swings and dumps for this duration \[s\].
    ///
    /// # Errors
    /// The duration is out of its range.
    pub fn at_usual_work(duration: f64, seed: u64) -> Result<Self, InvalidRun> {
        let mut run = Run::new(Scenario::Cycle);
        (run.duration, run.seed) = (duration, seed);
        Self::new(&run)
    }

    /// The same with pressures in its cylinders, and with the values that its owner states, as `--set` takes them.
    ///
    /// # Errors
    /// The duration is out of its range.
    pub fn weighing(duration: f64, seed: u64) -> Result<(Self, Vec<String>), InvalidRun> {
        let mut run = Run::new(Scenario::Cycle);
        (run.duration, run.seed) = (duration, seed);
        run.gauges = Some(Gauges::default());
        Ok((Self::new(&run)?, drawing()))
    }

    /// A machine at work, without an end.
    pub fn at_work(work: Work) -> Self {
        Self {
            rows: Rows::Work(Box::new(work)),
            sequence: 0,
        }
    }
}

impl Source for Simulator {
    type Sensors = ExcavatorSensors;
    type Truth = ExcavatorTruth;

    fn next(&mut self) -> Option<(ExcavatorSensors, ExcavatorTruth)> {
        let row = match &mut self.rows {
            Rows::Run(run) => run.next(),
            Rows::Work(work) => work.next(),
        }?;
        let mut measured = measured(&row);
        let mut known = truth(&row.truth);
        mark(&mut measured, &mut known, &mut self.sequence, row.time);
        Some((measured, known))
    }
}

fn measured(row: &Row) -> ExcavatorSensors {
    let mut taken = Columns::of(COLUMNS);
    let mut take = |value, bit| taken.take(value, bit);
    let [boom, arm, bucket] = row.posture;
    let [pitch, roll] = row.inclination;
    let [boom_head, boom_rod, arm_head, arm_rod] = row.pressures;
    let message = ExcavatorSensors {
        swing_velocity: take(row.swing_velocity, SWING_VELOCITY),
        swing_torque: take(row.swing_torque, SWING_TORQUE),
        boom_angle: take(boom, BOOM_ANGLE),
        arm_angle: take(arm, ARM_ANGLE),
        bucket_angle: take(bucket, BUCKET_ANGLE),
        pitch: take(pitch, PITCH),
        roll: take(roll, ROLL),
        boom_head_pressure: take(boom_head, BOOM_HEAD_PRESSURE),
        boom_rod_pressure: take(boom_rod, BOOM_ROD_PRESSURE),
        arm_head_pressure: take(arm_head, ARM_HEAD_PRESSURE),
        arm_rod_pressure: take(arm_rod, ARM_ROD_PRESSURE),
        ..ExcavatorSensors::default()
    };
    ExcavatorSensors {
        valid: taken.valid,
        columns: taken.columns,
        ..message
    }
}

fn truth(truth: &Truth) -> ExcavatorTruth {
    ExcavatorTruth {
        inertia: truth.inertia,
        damping: truth.damping,
        friction: truth.friction,
        torque: truth.torque,
        velocity: truth.velocity,
        acceleration: truth.acceleration,
        payload: truth.payload,
        known: ALL_KNOWN,
        ..ExcavatorTruth::default()
    }
}

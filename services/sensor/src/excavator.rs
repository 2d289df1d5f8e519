//! The simulated excavator as a source of messages.

use messages::excavator_bits::{ARM_ANGLE, BOOM_ANGLE, BUCKET_ANGLE, SWING_TORQUE, SWING_VELOCITY};
use messages::{ExcavatorSensors, ExcavatorTruth, Message};
use runtime::Source;
use sim::excavator::{InvalidRun, Row, Run, Simulation, Truth};

/// What a simulated excavator has: an encoder in place of the velocity is a matter of recordings.
const COLUMNS: u32 = SWING_VELOCITY | SWING_TORQUE | BOOM_ANGLE | ARM_ANGLE | BUCKET_ANGLE;
/// All seven true values are known.
const ALL_KNOWN: u32 = 0b111_1111;

/// A simulated excavator.
#[derive(Debug)]
pub struct SimulatedExcavator {
    rows: Simulation,
    sequence: u64,
}

impl SimulatedExcavator {
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
}

impl Source for SimulatedExcavator {
    type Sensors = ExcavatorSensors;
    type Truth = ExcavatorTruth;

    fn next(&mut self) -> Option<(ExcavatorSensors, ExcavatorTruth)> {
        let row = self.rows.next()?;
        let mut measured = measured(&row);
        let mut known = truth(&row.truth);
        for stamp in [&mut measured.stamp, &mut known.stamp] {
            stamp.sequence = self.sequence;
            stamp.time = row.time;
        }
        measured.mark_simulated();
        known.mark_simulated();
        self.sequence += 1;
        Some((measured, known))
    }
}

fn measured(row: &Row) -> ExcavatorSensors {
    let mut valid = 0;
    let mut take = |value: Option<f64>, bit: u32| match value {
        Some(value) if value.is_finite() => {
            valid |= bit;
            value
        }
        _ => 0.0,
    };
    let [boom, arm, bucket] = row.posture;
    let message = ExcavatorSensors {
        swing_velocity: take(row.swing_velocity, SWING_VELOCITY),
        swing_torque: take(row.swing_torque, SWING_TORQUE),
        boom_angle: take(boom, BOOM_ANGLE),
        arm_angle: take(arm, ARM_ANGLE),
        bucket_angle: take(bucket, BUCKET_ANGLE),
        columns: COLUMNS,
        ..ExcavatorSensors::default()
    };
    ExcavatorSensors { valid, ..message }
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

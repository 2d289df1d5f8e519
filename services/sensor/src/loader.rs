//! The simulated wheel loader as a source of messages.

use messages::loader_bits::{
    ACCELERATION, ARTICULATION, BOOM_MOVING, BRAKE, FRONT_TORQUE, FRONT_WHEEL_SPEED, LIFT_ANGLE,
    LIFT_HEAD_PRESSURE, LIFT_ROD_PRESSURE, MASS, REAR_TORQUE, REAR_WHEEL_SPEED, SLOPE,
    SPADE_FORCE_X, SPADE_FORCE_Z, SPEED, TILT_ANGLE, YAW_RATE,
};
use messages::{LoaderSensors, LoaderTruth};
use runtime::Source;
use sim::cylinder::Gauges;
use sim::loader::{InvalidRun, LiftArm, Row, Run, Scenario, Simulation, Size, Tier, Truth};

use crate::simulated::{Columns, cylinder, mark};

/// Signals of every simulated loader.
const COLUMNS: u32 = SPEED
    | FRONT_WHEEL_SPEED
    | REAR_WHEEL_SPEED
    | FRONT_TORQUE
    | REAR_TORQUE
    | SLOPE
    | ACCELERATION;
/// All eight true values, and the payload after them, are known.
const ALL_KNOWN: u32 = 0b100_1111_1111;

/// Drawing of the reference machine's lift arm, as `--set` takes it.
pub fn drawing() -> Vec<String> {
    let arm = LiftArm::of(&Size::Reference.machine());
    let mut settings: Vec<String> = [
        ("length", arm.length),
        ("pivot_x", arm.pivot_x),
        ("pivot_z", arm.pivot_z),
        ("mass", arm.mass),
        ("mass_distance", arm.mass_distance),
        ("bucket_mass", arm.bucket_mass),
        ("payload_distance", arm.payload_distance),
        // Its tilt cylinder is on the arm, and its driver levels the bucket.
        ("bucket_turn", 1.0),
        ("reference_angle", arm.reference.lift),
        ("reference_tilt", arm.reference.bucket - arm.reference.lift),
    ]
    .map(|(key, value)| format!("machine.lift_arm.{key}={value:?}"))
    .into();
    settings.extend(cylinder("machine.lift_arm.cylinder", &arm.cylinder));
    settings.push("sensors.angle_offset_std=0.009".into());
    settings
}

/// Standard deviations of the empty machine's values from axle scales and a ramp: load fraction, height of the centre of gravity \[m\].
const WEIGHED: [f64; 2] = [0.01, 0.045];

/// A simulated wheel loader.
#[derive(Debug)]
pub struct Simulator {
    rows: Simulation,
    sequence: u64,
}

impl Simulator {
    /// Starts a run of the simulator.
    ///
    /// # Errors
    /// A number of the run is out of its range.
    pub fn new(run: &Run) -> Result<Self, InvalidRun> {
        Ok(Self {
            rows: Simulation::new(run)?,
            sequence: 0,
        })
    }

    /// Digs, drives and dumps for this duration \[s\], with the usual sensors.
    ///
    /// # Errors
    /// The duration is out of its range.
    pub fn at_usual_work(duration: f64, seed: u64) -> Result<Self, InvalidRun> {
        let mut run = Run::new(Scenario::WorkCycle);
        (run.duration, run.seed, run.tier) = (Some(duration), seed, Tier::B);
        Self::new(&run)
    }

    /// Fills, carries and dumps for this duration \[s\], with pressures in its lift cylinders. Also returns the values that its owner
    /// states, as `--set` takes them: the drawing, and the weighed values of the empty machine, half a standard deviation off.
    ///
    /// # Errors
    /// The duration is out of its range.
    pub fn weighing(duration: f64, seed: u64) -> Result<(Self, Vec<String>), InvalidRun> {
        let mut run = Run::new(Scenario::Loading);
        (run.duration, run.seed, run.tier) = (Some(duration), seed, Tier::B);
        run.gauges = Some(Gauges::default());
        let simulator = Self::new(&run)?;
        let machine = simulator.rows.machine();
        let mut settings = drawing();
        let empty = [("ratio", machine.cg_ratio), ("height", machine.cg_height)];
        for ((key, truth), std) in empty.into_iter().zip(WEIGHED) {
            settings.push(format!(
                "machine.lift_arm.empty_{key}={}",
                truth + 0.5 * std
            ));
            settings.push(format!("machine.lift_arm.empty_{key}_std={std}"));
        }
        Ok((simulator, settings))
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

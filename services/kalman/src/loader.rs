//! The loader's estimators as a step: messages to samples, estimates to messages.
//!
//! All methods are the same step with different settings. `kalman` runs the extended Kalman filter, `ukf` the others.

mod settings;

use config::Loader as Description;
use estimation::loader::{CgEstimator, Columns, Estimate, Method, Sample, SettingsError, Status};
use messages::{LOADER_METHODS, LoaderEstimate, LoaderSensors, loader_bits as bits};
use runtime::Step;

pub use settings::settings;

/// The extended Kalman filter on six states.
#[derive(Clone, Copy, Debug)]
pub struct Loader(LoaderEstimator);

impl Loader {
    /// A filter that waits for its first sample.
    ///
    /// # Errors
    /// The description has a value that the filter cannot use.
    pub fn new(description: &Description) -> Result<Self, SettingsError> {
        LoaderEstimator::new(description, Method::Ekf).map(Self)
    }
}

impl Step for Loader {
    type Input = LoaderSensors;
    type Output = LoaderEstimate;

    fn step(&mut self, input: &LoaderSensors) -> LoaderEstimate {
        self.0.step(input)
    }
}

/// Any method of the loader.
#[derive(Clone, Copy, Debug)]
pub struct LoaderEstimator {
    estimator: CgEstimator,
    /// For sources without an accelerometer, until the first sample says which it is.
    without_accelerometer: Option<CgEstimator>,
}

impl LoaderEstimator {
    /// An estimator that waits for its first sample, which tells the columns of the source.
    ///
    /// # Errors
    /// The description has a value that the method cannot use.
    pub fn new(description: &Description, method: Method) -> Result<Self, SettingsError> {
        let settings = settings(description, method);
        let estimator = |acceleration| {
            CgEstimator::new(
                &settings,
                method,
                Columns {
                    acceleration,
                    ..Columns::default()
                },
            )
        };
        Ok(Self {
            estimator: estimator(true)?,
            without_accelerometer: Some(estimator(false)?),
        })
    }
}

impl Step for LoaderEstimator {
    type Input = LoaderSensors;
    type Output = LoaderEstimate;

    fn step(&mut self, input: &LoaderSensors) -> LoaderEstimate {
        if let Some(other) = self.without_accelerometer.take()
            && input.columns & bits::ACCELERATION == 0
        {
            self.estimator = other;
        }
        message(&self.estimator.step(&sample(input)))
    }
}

/// The sample in a message; a signal without its bit is missing.
fn sample(m: &LoaderSensors) -> Sample {
    let valid = |bit: u32, value: f64| (m.valid & bit != 0).then_some(value);
    Sample {
        time: m.stamp.time,
        speed: valid(bits::SPEED, m.speed),
        front_wheel_speed: valid(bits::FRONT_WHEEL_SPEED, m.front_wheel_speed),
        rear_wheel_speed: valid(bits::REAR_WHEEL_SPEED, m.rear_wheel_speed),
        front_torque: valid(bits::FRONT_TORQUE, m.front_torque),
        rear_torque: valid(bits::REAR_TORQUE, m.rear_torque),
        slope: valid(bits::SLOPE, m.slope),
        acceleration: valid(bits::ACCELERATION, m.acceleration),
        mass: valid(bits::MASS, m.mass),
        spade_force_x: valid(bits::SPADE_FORCE_X, m.spade_force_x),
        spade_force_z: valid(bits::SPADE_FORCE_Z, m.spade_force_z),
        boom_moving: m.valid & bits::BOOM_MOVING != 0,
        articulation: valid(bits::ARTICULATION, m.articulation),
        yaw_rate: valid(bits::YAW_RATE, m.yaw_rate),
        brake: m.valid & bits::BRAKE != 0,
    }
}

/// The message of an estimate; what the method does not estimate stays 0 without its bit.
fn message(e: &Estimate) -> LoaderEstimate {
    let force = e.spade_force_x.unwrap_or_default();
    let name = e.method.name();
    LoaderEstimate {
        speed: e.speed,
        front_wheel_speed: e.front_wheel_speed,
        rear_wheel_speed: e.rear_wheel_speed,
        slip_stiffness: e.slip_stiffness.value,
        slip_stiffness_std: e.slip_stiffness.std,
        cg_height: e.cg_height.value,
        cg_height_std: e.cg_height.std,
        cg_ratio: e.cg_ratio.value,
        cg_ratio_std: e.cg_ratio.std,
        cg_distance: e.cg_distance,
        spade_force_x: force.value,
        spade_force_x_std: force.std,
        slope_bias: e.slope_bias.unwrap_or_default(),
        front_radius_scale: e.front_radius_scale.unwrap_or_default(),
        rear_radius_scale: e.rear_radius_scale.unwrap_or_default(),
        nis: e.nis,
        speed_delay: e.speed_delay.unwrap_or_default().value,
        speed_delay_std: e.speed_delay.unwrap_or_default().std,
        flags: flags(e),
        estimated: estimated(e),
        method: LOADER_METHODS
            .iter()
            .position(|m| *m == name)
            .map_or(0, |i| i as u32),
        resets: e.resets,
        refused: e.refused,
        reason: e.reason as u32,
        ..LoaderEstimate::default()
    }
}

fn flags(e: &Estimate) -> u32 {
    set_bits(&[
        (bits::EXCITED_RATIO, e.excited_ratio),
        (bits::EXCITED_HEIGHT, e.excited_height),
        (bits::CONSISTENT, e.consistent),
        (bits::FRESH, e.fresh),
        (bits::IDENTIFIABLE_RATIO, e.identifiable_ratio),
        (bits::IDENTIFIABLE_HEIGHT, e.identifiable_height),
        (bits::CONVERGED_RATIO, e.converged_ratio),
        (bits::CONVERGED_HEIGHT, e.converged_height),
        (bits::FROZEN, e.frozen),
        (bits::RESET, e.reset),
        (bits::TRUSTED_RATIO, e.trusted_ratio),
        (bits::TRUSTED_HEIGHT, e.trusted_height),
        (bits::REFUSED, e.status == Status::Refused),
        (bits::DIVERGED, e.status == Status::Diverged),
    ])
}

fn estimated(e: &Estimate) -> u32 {
    set_bits(&[
        (bits::STATE, e.started),
        (
            bits::ESTIMATED_SPADE_FORCE_X,
            e.started && e.spade_force_x.is_some(),
        ),
        (bits::SLOPE_BIAS, e.started && e.slope_bias.is_some()),
        (
            bits::RADIUS_SCALES,
            e.started && e.front_radius_scale.is_some(),
        ),
        (bits::SPEED_DELAY, e.started && e.speed_delay.is_some()),
    ])
}

fn set_bits(bits: &[(u32, bool)]) -> u32 {
    bits.iter()
        .filter(|(_, set)| *set)
        .fold(0, |all, (bit, _)| all | bit)
}

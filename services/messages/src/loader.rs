//! Messages of the wheel loader.

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::message::message;

/// Bits of the loader's messages.
pub mod loader_bits {
    // Signals: `LoaderSensors::{valid, columns}`.
    /// Speed.
    pub const SPEED: u32 = 1;
    /// Front wheel speed.
    pub const FRONT_WHEEL_SPEED: u32 = 1 << 1;
    /// Rear wheel speed.
    pub const REAR_WHEEL_SPEED: u32 = 1 << 2;
    /// Front axle torque.
    pub const FRONT_TORQUE: u32 = 1 << 3;
    /// Rear axle torque.
    pub const REAR_TORQUE: u32 = 1 << 4;
    /// Slope.
    pub const SLOPE: u32 = 1 << 5;
    /// Specific force along the body axis.
    pub const ACCELERATION: u32 = 1 << 6;
    /// Mass.
    pub const MASS: u32 = 1 << 7;
    /// Horizontal spade force.
    pub const SPADE_FORCE_X: u32 = 1 << 8;
    /// Vertical spade force.
    pub const SPADE_FORCE_Z: u32 = 1 << 9;
    /// In `valid`: the boom moves. In `columns`: the source has that signal.
    pub const BOOM_MOVING: u32 = 1 << 10;
    /// Articulation of the steering.
    pub const ARTICULATION: u32 = 1 << 11;
    /// Yaw rate.
    pub const YAW_RATE: u32 = 1 << 12;
    /// In `valid`: friction brakes act. In `columns`: the source has that signal.
    pub const BRAKE: u32 = 1 << 13;
    /// Angle of the lift arm.
    pub const LIFT_ANGLE: u32 = 1 << 14;
    /// Angle of the bucket.
    pub const TILT_ANGLE: u32 = 1 << 15;
    /// Pressure at the head side of the lift cylinders.
    pub const LIFT_HEAD_PRESSURE: u32 = 1 << 16;
    /// Pressure at the rod side of the lift cylinders.
    pub const LIFT_ROD_PRESSURE: u32 = 1 << 17;
    /// Number of the truck that is loaded.
    pub const TRUCK: u32 = 1 << 18;

    // Flags: `LoaderEstimate::flags`.
    /// The motion carries information about the ratio.
    pub const EXCITED_RATIO: u32 = 1;
    /// The motion carries information about the height.
    pub const EXCITED_HEIGHT: u32 = 1 << 1;
    /// Innovations agree with their predicted size.
    pub const CONSISTENT: u32 = 1 << 2;
    /// Inputs are recent and complete.
    pub const FRESH: u32 = 1 << 3;
    /// The interval of the ratio is narrower than the stated limit.
    pub const CONVERGED_RATIO: u32 = 1 << 4;
    /// The interval of the height is narrower than the stated limit.
    pub const CONVERGED_HEIGHT: u32 = 1 << 5;
    /// Parameters are frozen (low speed, digging).
    pub const FROZEN: u32 = 1 << 6;
    /// A reset happened within the last 2 s.
    pub const RESET: u32 = 1 << 7;
    /// The ratio may be believed.
    pub const TRUSTED_RATIO: u32 = 1 << 8;
    /// The height may be believed.
    pub const TRUSTED_HEIGHT: u32 = 1 << 9;
    /// The row was refused (time not increasing or not finite); the state is untouched.
    pub const REFUSED: u32 = 1 << 10;
    /// The filter diverged (only methods without protection).
    pub const DIVERGED: u32 = 1 << 11;
    /// These inputs can determine the ratio, and it is not at a bound.
    pub const IDENTIFIABLE_RATIO: u32 = 1 << 12;
    /// These inputs can determine the height, and it is not at a bound.
    pub const IDENTIFIABLE_HEIGHT: u32 = 1 << 13;

    /// The service was started again and has not been trusted since.
    pub const RESTARTED: u32 = 1 << 14;
    /// The payload may be believed.
    pub const TRUSTED_PAYLOAD: u32 = 1 << 15;

    // Quantities: `LoaderEstimate::estimated`.
    /// Speed, wheel speeds, slip stiffness, height, ratio (0 until the first accepted row).
    pub const STATE: u32 = 1;
    /// Horizontal spade force.
    pub const ESTIMATED_SPADE_FORCE_X: u32 = 1 << 1;
    /// Slope bias.
    pub const SLOPE_BIAS: u32 = 1 << 2;
    /// Rolling-radius scales.
    pub const RADIUS_SCALES: u32 = 1 << 3;
    /// Delay of the speed.
    pub const SPEED_DELAY: u32 = 1 << 4;
    /// Payload.
    pub const PAYLOAD: u32 = 1 << 5;
}

message! {
    /// What the loader's sensors measured; a signal without its bit in `valid` is 0 and means nothing.
    pub struct LoaderSensors, "LoaderSensors", size 208, marked in columns {
        /// Forward speed of the body.
        speed: f64, "m/s";
        /// Speed of the front wheels.
        front_wheel_speed: f64, "rad/s";
        /// Speed of the rear wheels.
        rear_wheel_speed: f64, "rad/s";
        /// Front axle torque at the wheels, total.
        front_torque: f64, "N m";
        /// Rear axle torque at the wheels, total.
        rear_torque: f64, "N m";
        /// Road slope, uphill in the driving direction positive.
        slope: f64, "rad";
        /// Specific force along the body axis, dv/dt + g sin(slope).
        acceleration: f64, "m/s^2";
        /// Mass of the machine with its load.
        mass: f64, "kg";
        /// Force on the bucket tip that pushes the machine backward.
        spade_force_x: f64, "N";
        /// Force on the bucket tip that pushes the machine down.
        spade_force_z: f64, "N";
        /// Angle between front and rear body, positive when the machine turns left.
        articulation: f64, "rad";
        /// Yaw rate of the rear body, positive anticlockwise from above.
        yaw_rate: f64, "rad/s";
        /// Bits of the signals that this sample carries.
        valid: u32, "";
        /// Bits of the signals that the source has at all.
        columns: u32, "";
        /// Angle of the lift arm to the horizontal, up positive.
        lift_angle: f64, "rad";
        /// Angle of the bucket relative to the lift arm, tip up positive.
        tilt_angle: f64, "rad";
        /// Pressure at the head side of the lift cylinders, their mean.
        lift_head_pressure: f64, "Pa";
        /// Pressure at the rod side of the lift cylinders, their mean.
        lift_rod_pressure: f64, "Pa";
        /// Number of the truck that is loaded; another number begins the next truck.
        truck: f64, "";
    }
}

message! {
    /// The truth behind a simulated or annotated sample; estimators never read it.
    pub struct LoaderTruth, "LoaderTruth", size 136, marked in known {
        /// True forward speed.
        speed: f64, "m/s";
        /// True speed of the front wheels.
        front_wheel_speed: f64, "rad/s";
        /// True speed of the rear wheels.
        rear_wheel_speed: f64, "rad/s";
        /// True height of the centre of gravity above ground.
        cg_height: f64, "m";
        /// True share of the static weight on the front axle.
        cg_ratio: f64, "";
        /// True slip stiffness.
        slip_stiffness: f64, "";
        /// True horizontal spade force.
        spade_force_x: f64, "N";
        /// True slope.
        slope: f64, "rad";
        /// Bit i is set where field i (speed = 0) is known.
        known: u32, "";
        /// Reserved, 0.
        reserved: u32, "";
    }
}

message! {
    /// Estimated centre of gravity with its verdict.
    pub struct LoaderEstimate, "LoaderEstimate", size 256, marked in flags {
        /// Forward speed.
        speed: f64, "m/s";
        /// Speed of the front wheels.
        front_wheel_speed: f64, "rad/s";
        /// Speed of the rear wheels.
        rear_wheel_speed: f64, "rad/s";
        /// Slip stiffness of the tyres, F_x = K slip F_z.
        slip_stiffness: f64, "";
        /// Standard deviation of the slip stiffness.
        slip_stiffness_std: f64, "";
        /// Height of the centre of gravity above ground.
        cg_height: f64, "m";
        /// Standard deviation of the height, floor included.
        cg_height_std: f64, "m";
        /// Share of the static weight on the front axle.
        cg_ratio: f64, "";
        /// Standard deviation of the ratio, floor included.
        cg_ratio_std: f64, "";
        /// Distance from the front axle to the centre of gravity.
        cg_distance: f64, "m";
        /// Horizontal spade force, measured plus unknown.
        spade_force_x: f64, "N";
        /// Standard deviation of the spade force.
        spade_force_x_std: f64, "N";
        /// Bias of the slope sensor (true slope = measured - bias).
        slope_bias: f64, "rad";
        /// Rolling radius of the front wheels over its nominal value.
        front_radius_scale: f64, "";
        /// Rolling radius of the rear wheels over its nominal value.
        rear_radius_scale: f64, "";
        /// Normalised innovation squared of this sample per accepted measurement.
        nis: f64, "";
        /// Delay of the measured speed.
        speed_delay: f64, "s";
        /// Standard deviation of that delay.
        speed_delay_std: f64, "s";
        /// Verdict bits.
        flags: u32, "";
        /// Bits of the quantities that the method estimates.
        estimated: u32, "";
        /// Index of the method that made this estimate.
        method: u32, "";
        /// Resets so far.
        resets: u32, "";
        /// Rows refused so far.
        refused: u64, "";
        /// Why an estimate is not consistent or not fresh: index into `LOADER_REASONS`, 0 for none.
        reason: u32, "";
        /// Reserved, 0.
        reserved: u32, "";
        /// Payload.
        payload: f64, "kg";
        /// Standard deviation of the payload.
        payload_std: f64, "kg";
    }
}

/// Reasons of the loader's estimates by their code, [`LoaderEstimate::reason`]: name in the tables, and words. 0 is no reason.
pub const LOADER_REASONS: &[(&str, &str)] = &[
    ("", ""),
    ("missing", "an input is missing or too old"),
    ("stuck speed", "the speed never changes"),
    ("stuck front wheel", "the front wheel speed never changes"),
    ("stuck rear wheel", "the rear wheel speed never changes"),
    ("stuck front torque", "the front torque never changes"),
    ("stuck rear torque", "the rear torque never changes"),
    ("stuck slope", "the slope never changes"),
    ("stuck acceleration", "the acceleration never changes"),
    ("unexplained", "the motion does not follow the model"),
    ("latency", "the speed comes later than a sensor may"),
    ("stiffness", "the slip stiffness is none that tyres have"),
    ("brakes", "friction brakes seem to act"),
    ("steering", "the machine turns"),
    ("slope", "the slope does not fit the motion"),
    ("torque", "the torques do not fit the motion and the mass"),
    ("load", "the load may have changed"),
    (
        "disagreement",
        "manoeuvres disagree by more than they claim",
    ),
    ("limit", "an estimate is at its limit"),
    ("restarted", "the service was started again"),
    (
        "locked drive",
        "the axles turn alike: the torques told are not theirs",
    ),
];

/// Names of the loader estimation methods, indexed by [`LoaderEstimate::method`].
pub const LOADER_METHODS: &[&str] = &["full", "isr-ukf-printed", "isr-ukf", "ekf", "full-ekf"];

/// The loader's channels.
pub mod channels {
    use super::{LoaderEstimate, LoaderSensors, LoaderTruth};
    use crate::channels::{ChannelOf, Rate, channels};

    channels! {
        /// What the loader's sensors measured.
        LOADER_SENSORS: LoaderSensors = "loader/sensors", 512, Rate::Sensors;
        /// The truth behind them, where there is one.
        LOADER_TRUTH: LoaderTruth = "loader/truth", 512, Rate::Sensors;
        /// Estimates of the extended Kalman filter.
        LOADER_CG_EKF: LoaderEstimate = "loader/cg_ekf", 512, Rate::Sensors;
        /// Estimates of the square-root unscented Kalman filter.
        LOADER_CG_UKF: LoaderEstimate = "loader/cg_ukf", 512, Rate::Sensors;
    }
}

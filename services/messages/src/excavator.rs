//! Messages of the excavator.

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::message::message;

/// Bits of the excavator's messages.
pub mod excavator_bits {
    // Signals: `ExcavatorSensors::{valid, columns}`.
    /// Swing velocity.
    pub const SWING_VELOCITY: u32 = 1;
    /// Swing angle (an encoder in place of the velocity).
    pub const SWING_ANGLE: u32 = 1 << 1;
    /// Swing torque.
    pub const SWING_TORQUE: u32 = 1 << 2;
    /// Boom angle.
    pub const BOOM_ANGLE: u32 = 1 << 3;
    /// Arm angle.
    pub const ARM_ANGLE: u32 = 1 << 4;
    /// Bucket angle.
    pub const BUCKET_ANGLE: u32 = 1 << 5;
    /// Pitch of the upper body.
    pub const PITCH: u32 = 1 << 6;
    /// Roll of the upper body.
    pub const ROLL: u32 = 1 << 7;
    /// Pressure at the head side of the boom cylinders.
    pub const BOOM_HEAD_PRESSURE: u32 = 1 << 8;
    /// Pressure at the rod side of the boom cylinders.
    pub const BOOM_ROD_PRESSURE: u32 = 1 << 9;
    /// Pressure at the head side of the arm cylinder.
    pub const ARM_HEAD_PRESSURE: u32 = 1 << 10;
    /// Pressure at the rod side of the arm cylinder.
    pub const ARM_ROD_PRESSURE: u32 = 1 << 11;
    /// Number of the truck that is loaded.
    pub const TRUCK: u32 = 1 << 12;

    // Flags: `ExcavatorEstimate::flags`.
    /// The motion carries information about the inertia.
    pub const EXCITED: u32 = 1;
    /// Innovations agree with their predicted size.
    pub const CONSISTENT: u32 = 1 << 1;
    /// Inputs are recent and complete.
    pub const FRESH: u32 = 1 << 2;
    /// The interval is narrower than the stated limit.
    pub const CONVERGED: u32 = 1 << 3;
    /// These inputs can determine the inertia at all.
    pub const IDENTIFIABLE: u32 = 1 << 4;
    /// Standstill: the estimate is held.
    pub const HELD: u32 = 1 << 5;
    /// The payload is changing.
    pub const CHANGING: u32 = 1 << 6;
    /// The filter was reset at this sample.
    pub const RESET: u32 = 1 << 7;
    /// All of excited, consistent, fresh, converged, identifiable.
    pub const TRUSTED: u32 = 1 << 8;
    /// Paper mode: the nominal-parameter rule acted (Eqs. 28-29).
    pub const NOMINAL: u32 = 1 << 9;
    /// Paper mode: inside a change window (section 3.5).
    pub const WINDOW: u32 = 1 << 10;
    /// The row was refused (time not increasing or not finite); the state is untouched.
    pub const REFUSED: u32 = 1 << 11;
    /// The service was started again and has not been trusted since.
    pub const RESTARTED: u32 = 1 << 12;

    // Quantities: `ExcavatorEstimate::estimated`; a method that does not estimate one leaves it 0.
    /// Damping.
    pub const DAMPING: u32 = 1;
    /// Torque.
    pub const TORQUE: u32 = 1 << 1;
    /// Payload.
    pub const PAYLOAD: u32 = 1 << 2;
    /// Coulomb friction.
    pub const FRICTION: u32 = 1 << 3;
    /// Torque offset.
    pub const OFFSET: u32 = 1 << 4;
    /// Inertia (every method has it; 0 until the first accepted row).
    pub const INERTIA: u32 = 1 << 5;
    /// Acceleration.
    pub const ACCELERATION: u32 = 1 << 6;

    // Flags of `SwingMotion::flags`, beside `REFUSED` (its signal bits are those of the sensors, in `valid`).
    /// A manoeuvre begins or goes on (change window).
    pub const MANOEUVRE: u32 = 1;
    /// The machine stands still.
    pub const STANDSTILL: u32 = 1 << 1;
}

message! {
    /// What the excavator's sensors measured; a signal without its bit in `valid` is 0 and means nothing.
    pub struct ExcavatorSensors, "ExcavatorSensors", size 176, marked in columns {
        /// Swing rate, positive anticlockwise from above.
        swing_velocity: f64, "rad/s";
        /// Swing angle, same sign.
        swing_angle: f64, "rad";
        /// Swing torque at the upper body, positive in the direction of positive motion.
        swing_torque: f64, "N m";
        /// Boom angle to the horizontal, up positive.
        boom_angle: f64, "rad";
        /// Arm angle relative to the boom.
        arm_angle: f64, "rad";
        /// Bucket angle relative to the arm.
        bucket_angle: f64, "rad";
        /// Bits of the signals that this sample carries.
        valid: u32, "";
        /// Bits of the signals that the source has at all.
        columns: u32, "";
        /// Pitch of the upper body, nose up positive.
        pitch: f64, "rad";
        /// Roll of the upper body, left side low positive.
        roll: f64, "rad";
        /// Pressure at the head side of the boom cylinders, their mean.
        boom_head_pressure: f64, "Pa";
        /// Pressure at the rod side of the boom cylinders, their mean.
        boom_rod_pressure: f64, "Pa";
        /// Pressure at the head side of the arm cylinder.
        arm_head_pressure: f64, "Pa";
        /// Pressure at the rod side of the arm cylinder.
        arm_rod_pressure: f64, "Pa";
        /// Number of the truck that is loaded; another number begins the next truck.
        truck: f64, "";
    }
}

message! {
    /// The truth behind a simulated or annotated sample; estimators never read it.
    pub struct ExcavatorTruth, "ExcavatorTruth", size 128, marked in known {
        /// True swing inertia.
        inertia: f64, "kg m^2";
        /// True viscous damping.
        damping: f64, "N m s/rad";
        /// True Coulomb friction torque.
        friction: f64, "N m";
        /// True swing torque.
        torque: f64, "N m";
        /// True swing velocity.
        velocity: f64, "rad/s";
        /// True swing acceleration.
        acceleration: f64, "rad/s^2";
        /// True payload.
        payload: f64, "kg";
        /// Bit i is set where field i (inertia = 0) is known.
        known: u32, "";
        /// Reserved, 0.
        reserved: u32, "";
    }
}

message! {
    /// Swing motion after the filter stage.
    pub struct SwingMotion, "SwingMotion", size 192, marked in flags {
        /// Velocity of the Kalman filter.
        velocity: f64, "rad/s";
        /// Its standard deviation.
        velocity_std: f64, "rad/s";
        /// Acceleration of the Kalman filter.
        acceleration: f64, "rad/s^2";
        /// Its standard deviation.
        acceleration_std: f64, "rad/s^2";
        /// Innovation of the Kalman filter, 0 where the measurement is missing; with an encoder's
        /// angle in rad.
        innovation: f64, "rad/s";
        /// Predicted standard deviation of the innovation, in the same unit.
        innovation_std: f64, "rad/s";
        /// Velocity through the common second-order filter.
        filtered_velocity: f64, "rad/s";
        /// Acceleration through the common second-order filter.
        filtered_acceleration: f64, "rad/s^2";
        /// Torque through the same filter.
        filtered_torque: f64, "N m";
        /// Direction of motion through the same filter, -1 to 1.
        filtered_direction: f64, "";
        /// A constant 1 through the same filter: what an offset looks like behind it.
        filtered_one: f64, "";
        /// Online convergence delay of the Kalman filter.
        convergence_delay: f64, "s";
        /// Sampling period of this sample.
        period: f64, "s";
        /// Time since the last accepted velocity or angle.
        age: f64, "s";
        /// Reserved, 0.
        reserved: f64, "";
        /// Signal bits of the sample that this was made from.
        valid: u32, "";
        /// Bits of this message.
        flags: u32, "";
    }
}

message! {
    /// Estimated swing inertia with its verdict.
    pub struct ExcavatorEstimate, "ExcavatorEstimate", size 240, marked in flags {
        /// Swing inertia.
        inertia: f64, "kg m^2";
        /// Standard deviation of the inertia.
        inertia_std: f64, "kg m^2";
        /// Viscous damping.
        damping: f64, "N m s/rad";
        /// Standard deviation of the damping.
        damping_std: f64, "N m s/rad";
        /// Torque.
        torque: f64, "N m";
        /// Standard deviation of the torque.
        torque_std: f64, "N m";
        /// Payload.
        payload: f64, "kg";
        /// Standard deviation of the payload.
        payload_std: f64, "kg";
        /// Swing velocity.
        velocity: f64, "rad/s";
        /// Swing acceleration.
        acceleration: f64, "rad/s^2";
        /// Coulomb friction torque.
        friction: f64, "N m";
        /// Standard deviation of the friction.
        friction_std: f64, "N m";
        /// Torque offset.
        offset: f64, "N m";
        /// Standard deviation of the offset.
        offset_std: f64, "N m";
        /// Normalised innovation squared of this sample, 0 where none was accepted.
        nis: f64, "";
        /// Forgetting factor of the inertia (regressions; else 0).
        forgetting_inertia: f64, "";
        /// Forgetting factor of the damping.
        forgetting_damping: f64, "";
        /// Forgetting factor of the torque.
        forgetting_torque: f64, "";
        /// Verdict bits.
        flags: u32, "";
        /// Bits of the quantities that the method estimates.
        estimated: u32, "";
        /// Index of the method that made this estimate.
        method: u32, "";
        /// Code of the reason: what the machine does beside its description, or why the estimate is not trusted.
        reason: u32, "";
        /// Rows refused so far.
        refused: u64, "";
        /// Reserved, 0.
        reserved_2: u64, "";
    }
}

/// Reasons of the excavator's estimates by their code, [`ExcavatorEstimate::reason`]: name in the tables, and
/// words. 0 is no reason.
pub const EXCAVATOR_REASONS: &[(&str, &str)] = &[
    ("", ""),
    ("slope", "the ground seems inclined"),
    ("losses", "the swing drive seems to lose torque"),
    ("friction", "the friction differs from the described one"),
    ("gain", "the torque's gain seems not to be 1"),
    ("delay", "velocity and torque do not come together"),
    ("offset", "the torque seems to have an offset"),
    ("damping", "the damping differs from the described one"),
    ("unexplained", "the motion does not follow the model"),
    ("disagreement", "swings disagree by more than they claim"),
    ("limit", "the estimate is at the end of its range"),
    ("content", "the bucket's content may have changed"),
    ("frozen", "a sensor repeats one value"),
    ("sign", "a sensor seems to have the other sign"),
    (
        "method",
        "this method cannot tell the inertia of a machine that is not calibrated",
    ),
    ("restarted", "the service was started again"),
    (
        "jump",
        "a joint angle has jumped further than a joint moves",
    ),
    (
        "contradiction",
        "an emptied bucket or the friction contradicts what a sensor says",
    ),
    ("hanging", "the load hangs or swings"),
    ("attachment", "the bucket weighs otherwise than described"),
];

/// Names of the excavator estimation methods on the command line and in every output, indexed by
/// [`ExcavatorEstimate::method`].
pub const EXCAVATOR_METHODS: &[&str] = &[
    "auto",
    "multi-forgetting-rls",
    "svf-rls",
    "posture-torque",
    "torque",
    "posture",
    "velocity",
];

/// The excavator's channels.
pub mod channels {
    use super::{ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth, SwingMotion};
    use crate::channels::{ChannelOf, Rate, channels};

    channels! {
        /// What the excavator's sensors measured.
        EXCAVATOR_SENSORS: ExcavatorSensors = "excavator/sensors", 512, Rate::Sensors;
        /// The truth behind them, where there is one.
        EXCAVATOR_TRUTH: ExcavatorTruth = "excavator/truth", 512, Rate::Sensors;
        /// Swing motion after the filter stage.
        EXCAVATOR_MOTION: SwingMotion = "excavator/motion", 512, Rate::Sensors;
        /// Estimates of the regression.
        EXCAVATOR_INERTIA_RLS: ExcavatorEstimate = "excavator/inertia_rls", 512, Rate::Sensors;
        /// Estimates of the state-space filters.
        EXCAVATOR_INERTIA_UKF: ExcavatorEstimate = "excavator/inertia_ukf", 512, Rate::Sensors;
    }
}

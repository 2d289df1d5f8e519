//! Messages of the excavator.

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::message::message;
use crate::words::{Entry, Words, estimates, method_names, reason_pairs, sensors, signal_entries};
use sheet::excavator::{ESTIMATED, FLAGS, METHODS, REASONS, SIGNALS};

/// Names of the bits of the sensors' message.
const SENSOR_WORDS: &[(&str, Words)] = &[
    ("valid", Words::Bits(SIGNAL_BITS)),
    ("columns", Words::Bits(SIGNAL_BITS)),
];
const SIGNAL_BITS: &[Entry] = &signal_entries::<{ SIGNALS.len() }>(SIGNALS);
const FLAG_BITS: &[Entry] = &sheet::flag_entries::<{ FLAGS.len() }>(FLAGS);
/// Names of the bits and codes of an estimate.
const ESTIMATE_WORDS: &[(&str, Words)] = &[
    ("flags", Words::Bits(FLAG_BITS)),
    ("estimated", Words::Bits(ESTIMATED)),
    ("method", Words::Codes(METHODS)),
    ("reason", Words::Codes(REASONS)),
];

/// Names of the bits of a swing motion.
const MOTION_WORDS: &[(&str, Words)] = &[
    ("valid", Words::Bits(SIGNAL_BITS)),
    ("flags", Words::Bits(MOTION_FLAGS)),
];
const MOTION_FLAGS: &[Entry] = &[
    Entry {
        number: excavator_bits::MANOEUVRE,
        name: "manoeuvre",
        doc: "A manoeuvre begins or goes on (change window).",
    },
    Entry {
        number: excavator_bits::STANDSTILL,
        name: "standstill",
        doc: "The machine stands still.",
    },
    Entry {
        number: excavator_bits::REFUSED,
        name: "refused",
        doc: "The row was refused (time not increasing or not finite).",
    },
];

/// Bits of the excavator's messages.
pub mod excavator_bits {
    pub use sheet::excavator::bits::*;

    // Flags of `SwingMotion::flags`, beside `REFUSED` (its signal bits are those of the sensors, in `valid`).
    /// A manoeuvre begins or goes on (change window).
    pub const MANOEUVRE: u32 = 1;
    /// The machine stands still.
    pub const STANDSTILL: u32 = 1 << 1;
}

/// The message of its sensors from the rows of the sheet.
macro_rules! sensors_of_excavator {
    ($($rows:tt)*) => {
        sensors! {
            /// What the excavator's sensors measured; a signal without its bit in `valid` is 0 and means nothing.
            ExcavatorSensors, "ExcavatorSensors", size 176, words SENSOR_WORDS
            $($rows)*
        }
    };
}

sheet::excavator_signals!(sensors_of_excavator);

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
    pub struct SwingMotion, "SwingMotion", size 192, marked in flags, words MOTION_WORDS {
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

/// The message of its estimates from the rows of the sheet.
macro_rules! estimates_of_excavator {
    ($($rows:tt)*) => {
        estimates! {
            /// Estimated swing inertia with its verdict.
            ExcavatorEstimate, "ExcavatorEstimate", size 240, words ESTIMATE_WORDS {
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
            $($rows)*
        }
    };
}

sheet::excavator_quantities!(estimates_of_excavator);

/// Reasons of the excavator's estimates by their code, [`ExcavatorEstimate::reason`]: name in the tables, and
/// words. 0 is no reason.
pub const EXCAVATOR_REASONS: &[(&str, &str)] = sheet::excavator_reasons!(reason_pairs);

/// Names of the excavator estimation methods on the command line and in every output, indexed by
/// [`ExcavatorEstimate::method`].
pub const EXCAVATOR_METHODS: &[&str] = sheet::excavator_methods!(method_names);

/// The excavator's channels.
pub mod channels {
    use super::{ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth, SwingMotion};
    use crate::ExcavatorLoads;
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
        /// Loads as they are counted.
        EXCAVATOR_LOADS: ExcavatorLoads = "excavator/loads", 64, Rate::Hz(10.0);
    }
}

//! Messages of the wheel loader.

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::message::message;
use crate::words::{Entry, Words, estimates, method_names, reason_pairs, sensors, signal_entries};
use sheet::loader::{ESTIMATED, FLAGS, METHODS, REASONS, SIGNALS};

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

/// Bits of the loader's messages.
pub mod loader_bits {
    pub use sheet::loader::bits::*;
}

/// The message of its sensors from the rows of the sheet.
macro_rules! sensors_of_loader {
    ($($rows:tt)*) => {
        sensors! {
            /// What the loader's sensors measured; a signal without its bit in `valid` is 0 and means nothing.
            LoaderSensors, "LoaderSensors", size 208, words SENSOR_WORDS
            $($rows)*
        }
    };
}

sheet::loader_signals!(sensors_of_loader);

message! {
    /// The truth behind a simulated or annotated sample; estimators never read it.
    pub struct LoaderTruth, "LoaderTruth", size 144, marked in known {
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
        /// True payload.
        payload: f64, "kg";
    }
}

/// The message of its estimates from the rows of the sheet.
macro_rules! estimates_of_loader {
    ($($rows:tt)*) => {
        estimates! {
            /// Estimated centre of gravity with its verdict.
            LoaderEstimate, "LoaderEstimate", size 256, words ESTIMATE_WORDS {
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
                /// Why an estimate is not consistent or not fresh: index of `LOADER_REASONS`, 0 for none.
                reason: u32, "";
                /// Reserved, 0.
                reserved: u32, "";
            }
            $($rows)*
        }
    };
}

sheet::loader_quantities!(estimates_of_loader);

/// Reasons of the loader's estimates by their code, [`LoaderEstimate::reason`]: name in the tables, and words. 0 is no reason.
pub const LOADER_REASONS: &[(&str, &str)] = sheet::loader_reasons!(reason_pairs);

/// Names of the loader estimation methods, indexed by [`LoaderEstimate::method`].
pub const LOADER_METHODS: &[&str] = sheet::loader_methods!(method_names);

/// The loader's channels.
pub mod channels {
    use super::{LoaderEstimate, LoaderSensors, LoaderTruth};
    use crate::LoaderLoads;
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
        /// Loads as they are counted.
        LOADER_LOADS: LoaderLoads = "loader/loads", 64, Rate::Hz(10.0);
    }
}

//! Checks of samples by a machine's knowledge of itself.

use config::Keyed;
use recording::{Finding, Sensors};

/// Checks whether samples can be of the machine.
pub trait Look: Sized {
    /// The description of the machine.
    type Described: Keyed;
    /// What the sensors of the machine measure.
    type Sensors: Sensors;
    /// Checks against a description.
    fn of(described: &Self::Described) -> Self;
    /// The largest value of a signal that the estimators accept; none without a limit.
    fn largest(described: &Self::Described, signal: &str) -> Option<f64>;
    /// Takes a sample.
    fn add(&mut self, sample: &Self::Sensors);
    /// Whether a value that repeats exactly, far from all others of its signal, is a measurement and no mark of a missing sample.
    fn is_measurement(&self, _signal: &str, _value: f64) -> bool {
        false
    }
    /// Why data and description cannot be of one machine.
    fn fault(&self) -> Option<Finding> {
        None
    }
}

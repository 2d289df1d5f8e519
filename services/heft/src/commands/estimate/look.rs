//! What a machine sees in the samples that estimates are made of.

use config::Keyed;
use recording::Sensors;

/// Looks at samples, and says at the end why they cannot be of the machine.
pub trait Look: Sized {
    /// The description of the machine.
    type Described: Keyed;
    /// What the sensors of the machine measure.
    type Sensors: Sensors;
    /// For a description.
    fn of(described: &Self::Described) -> Self;
    /// The largest value of a signal that the estimators take; none where they take any.
    fn largest(described: &Self::Described, signal: &str) -> Option<f64>;
    /// Takes a sample.
    fn add(&mut self, sample: &Self::Sensors);
    /// Why data and description cannot be of one machine, and what to do.
    fn fault(&self) -> Option<String> {
        None
    }
}

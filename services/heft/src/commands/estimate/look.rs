//! What a machine sees in the samples that estimates are made of.

use config::Description;
use recording::Sensors;

/// Looks at samples, and says at the end what is strange about them.
pub trait Look {
    /// What the sensors of the machine measure.
    type Sensors: Sensors;
    /// For a description.
    fn of(description: &Description) -> Self;
    /// Takes a sample.
    fn add(&mut self, sample: &Self::Sensors);
    /// Says so.
    fn tell(&self) {}
    /// Why data and description cannot be of one machine, and what to do.
    fn fault(&self) -> Option<String> {
        None
    }
}

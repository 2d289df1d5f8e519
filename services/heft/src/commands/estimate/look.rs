//! What a machine sees in the samples of `heft estimate`.

use config::Description;

/// Looks at the samples of `heft estimate`, and says at the end what is strange about them.
pub trait Look<S> {
    /// For a description.
    fn of(description: &Description) -> Self;
    /// Takes a sample.
    fn add(&mut self, sample: &S);
    /// Says so.
    fn tell(&self) {}
    /// Why data and description cannot be of one machine, and what to do.
    fn fault(&self) -> Option<String> {
        None
    }
}

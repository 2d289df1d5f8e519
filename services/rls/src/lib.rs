//! The regression stage: recursive least squares on the filtered swing motion.

mod excavator;

pub use excavator::Excavator;

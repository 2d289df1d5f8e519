//! The regression stage: the paper's recursive least squares with multiple forgetting, and its
//! relative with measured torque. Sees the swing motion only.

mod excavator;

pub use excavator::Excavator;

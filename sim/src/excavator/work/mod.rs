//! Working excavators that deviate from their description: real sizes, a duty cycle of dig, lift and swing, dump, return, and
//! ordinary physical effects that the estimators' model omits.
//!
//! Nothing is shared with [`super::plant`]: other machines, another duty cycle, another integration (semi-implicit Euler at 1 ms,
//! because of springs and dry friction).

mod cases;
mod chance;
mod duty;
mod effects;
mod machine;
mod measure;
mod size;
mod trial;

pub use cases::cases;
pub use effects::Effects;
pub use measure::Work;
pub use size::Size;

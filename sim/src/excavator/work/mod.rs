//! Excavators at work that are not what their description says: real sizes, a duty cycle of dig, lift and
//! swing, dump, return, and the ordinary physics that the estimators' model leaves out.
//!
//! Nothing here is shared with [`super::plant`]: other machines, another course of events, another
//! integration (semi-implicit Euler at 1 ms, since springs and dry friction are in it).

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

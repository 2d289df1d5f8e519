//! A machine's own parameters from recordings: `heft calibrate`.
//!
//! The equation of motion is homogeneous: torques, damping, friction and inertia can all be larger by
//! the same factor and the motion stays the same. Only something of known mass fixes the scale, and
//! that is why a recording with a weighed load stands beside one without. Everything is found at once,
//! as the maximum of the likelihood of the filter's innovations times what the description states
//! with its tolerances.
//!
//! | file | what |
//! |---|---|
//! | [`parameter`] | a number to be found |
//! | [`model`] | blocks of recordings that give innovations |
//! | [`fit`] | the maximum, by scoring steps with the damping of Levenberg and Marquardt |
//! | [`honesty`] | what the data do not determine, the scatter between blocks, profiles, hold-out |
//! | [`agreement`] | whether parts of the recordings tell the same machine |
//! | `lasting` | least squares of equations whose errors last |
//! | [`cylinders`] | cylinders whose pressures weigh |
//! | [`outcome`] | what came out, for any machine |
//! | [`excavator`] | swings of an excavator |
//! | [`loader`] | drives of a loader |
//! | [`output`] | the description with its origin |
//! | [`algebra`] | faer |
//! | [`parallel`] | blocks and seeds on all cores |

pub mod agreement;
pub mod algebra;
mod column;
pub mod cylinders;
pub mod excavator;
pub mod fit;
pub mod honesty;
mod lasting;
pub mod loader;
pub mod model;
pub mod outcome;
pub mod output;
pub mod parallel;
pub mod parameter;

pub use model::{Innovation, Model};
pub use outcome::{FitResult, Summary};
pub use parameter::{Law, Parameter, Source};

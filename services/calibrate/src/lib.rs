//! Identifies a machine's parameters from recordings: `heft calibrate`.
//!
//! The equation of motion is homogeneous: if torques, damping, friction and inertia are all larger by
//! the same factor the motion is the same. Only a known mass fixes the scale, so
//! a recording with a weighed load is needed beside one without. All parameters are estimated jointly,
//! as the maximum of the likelihood of the filter's innovations times the prior from the description
//! and its tolerances.
//!
//! | file | what |
//! |---|---|
//! | [`parameter`] | a parameter to be identified |
//! | [`model`] | blocks of recordings that give innovations |
//! | [`fit`] | the maximum, by scoring steps with the damping of Levenberg and Marquardt |
//! | [`honesty`] | undetermined directions, scatter between blocks, profiles, hold-out |
//! | [`agreement`] | consistency of parts of the recordings with one machine |
//! | `lasting` | least squares of equations with correlated errors |
//! | [`cylinders`] | cylinders whose pressures weigh |
//! | [`outcome`] | results, for any machine |
//! | [`excavator`] | swings of an excavator |
//! | [`loader`] | drives of a loader |
//! | [`output`] | the calibrated description with its origin |
//! | [`algebra`] | linear algebra |
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

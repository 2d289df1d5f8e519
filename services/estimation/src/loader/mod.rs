//! Centre of gravity of a wheel loader from its motion: Yang, Wang, Han 2021, as printed, corrected, and extended to real machines.
//!
//! The load on each axle shows in its slip: quasi-steadily K F_z = T/(r slip). The sum over the axles gives the slip stiffness K.
//! Their ratio gives the share lam of the weight in front, less the load h a_x/(g l) that acceleration moves backward. So lam needs
//! traction and accurate slips, and the height h needs *changes* of acceleration.
//!
//! | file or folder | idea |
//! |---|---|
//! | `sample`, `estimate`, `settings`, `method` | inputs and outputs |
//! | [`keys`], `size` | the keys of a description; their defaults by the machine's mass |
//! | `physics` | the machine's equations: [`axle_loads`], [`wheel_dynamics`], [`cg_model`] |
//! | `layout` | position of each quantity in the state |
//! | `input` | from rows to inputs of a step |
//! | `measurements` | noise of the measurements, and what the model does not contain |
//! | `load` | load of the machine: known, or found |
//! | `lift_arm` | the second witness: lift pressure and arm geometry |
//! | `doubts` | errors that no state represents |
//! | `filter`, `estimator` | processing of one row |
//! | `answer` | the estimate after it |
//! | `verdict`, `reason` | whether to trust it, and why not |
//! | `floors` | errors that cannot be identified on line |
//! | [`weigh`] | the static reference |

mod answer;
mod doubts;
mod estimate;
mod estimator;
mod filter;
mod floors;
mod input;
pub mod keys;
mod layout;
mod lift_arm;
mod load;
mod measurements;
mod method;
mod physics;
mod reason;
mod sample;
pub mod settings;
mod size;
mod verdict;
pub mod weigh;

pub use estimate::{Estimate, Status};
pub use estimator::CgEstimator;
pub use filter::wheel_spins;
pub use input::carriage::Carriage;
pub use input::plausible::{Mismatch, Plausible};
pub use lift_arm::{LiftKnown, LiftMoment, Lifts};
pub use load::payload::{self, Payload};
pub use method::Method;
pub use physics::{axle_loads, cg_model, wheel_dynamics};
pub use reason::Reason;
pub use sample::{Columns, Sample, largest};
pub use settings::{LoadTransfer, Machine, MustBe, Prior, Sensors, Settings, SettingsError};

/// Rated payload over the machine's mass, half of what tips a loader (ISO 14397-1): .29 to .33 for machines of 5 to 25 t (makers'
/// sheets).
pub const RATED_SHARE: f64 = 0.32;

//! The excavator: swing inertia, damping, torque and payload.
//!
//! Two ways lead from the sensors to an estimate. [`MotionFilter`] and then [`Regression`] are the
//! paper's (Oh, Yi, Seo, Kim, Lee 2017) and its measured-torque relative; [`SwingEstimator`] holds
//! the state-space estimators and chooses among them by the columns that exist. Each takes one
//! sample and gives one answer.
//!
//! The physics of the state-space estimators is `J a + Jd w = T - b w - T_f sgn(w)`, with Jd the
//! posture's part of dJ/dt: material that leaves the bucket takes its momentum along. The paper's
//! Eq. 11 lacks `Jd w` and the sign of the friction.

mod align;
mod consider;
mod estimate;
mod input;
pub mod keys;
mod mode;
mod payload;
mod reason;
mod regression;
mod settings;
mod swing;
mod verdict;
mod working;

use input::{calibration, delay, encoder, frozen, grid, motion, screen, standstill};
use mode::{drive, onset, posture, posture_torque, state, torque, unknown_torque, velocity};
use payload::{change, changing_payload, drop_mixture, opening};
use regression::{joint, single, svf};
use settings::{doubts, geometry, settings_error};

pub use crate::Quantity;
pub use doubts::Doubts;
pub use estimate::{Columns, Estimate, Flags, Method, Sample};
pub use geometry::{Geometry, Inertia};
pub use motion::{Motion, MotionFilter};
pub use reason::Reason;
pub use regression::Regression;
pub use settings::{Estimator, Paper, Prior, Sensors, Settings, Variant};
pub use settings_error::SettingsError;
pub use swing::{Details, SwingEstimator};
pub use working::{Smoothed, Smoother, Trail};

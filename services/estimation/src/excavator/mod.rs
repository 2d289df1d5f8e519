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
mod calibration;
mod change;
mod changing_payload;
mod consider;
mod delay;
mod described;
mod doubts;
mod drive;
mod drop_mixture;
mod encoder;
mod estimate;
mod frozen;
mod geometry;
mod grid;
mod joint;
pub mod keys;
mod mode;
mod motion;
mod onset;
mod opening;
mod payload;
mod posture;
mod posture_torque;
mod reason;
mod regression;
mod screen;
mod settings;
mod settings_error;
mod single;
mod standstill;
mod state;
mod svf;
mod swing;
mod torque;
mod unknown_torque;
mod velocity;
mod verdict;
mod working;

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

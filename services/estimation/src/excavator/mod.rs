//! The excavator: swing inertia, damping, torque and payload.
//!
//! Two methods lead from the sensors to an estimate. [`MotionFilter`] followed by [`Regression`] is that of the paper
//! (Oh, Yi, Seo, Kim, Lee 2017) and its variant with measured torque. [`SwingEstimator`] contains the state-space
//! estimators, and chooses among them by the available columns. Each takes one sample and returns one estimate.
//!
//! The state-space estimators use `J a + Jd w = T - b w - T_f sgn(w)`, with Jd the posture's part of dJ/dt:
//! material that leaves the bucket takes its momentum along. The paper's Eq. 11 lacks `Jd w` and the sign of the
//! friction.
//!
//! | file | idea |
//! |---|---|
//! | `estimate`, `settings`, [`keys`] | inputs and outputs; the keys of a description |
//! | `size` | a description from the operating mass and a few more numbers |
//! | `plausible`, `mismatch` | whether data and description belong to one machine |
//! | `input` | rows on a grid; missing, late, held, noisy, coarse, frozen and jumping signals; encoder; standstill |
//! | `align`, `consider` | removal of stated delays; errors by parameters that are held fixed |
//! | `regression` | the paper's method: motion in, inertia out, by recursive least squares |
//! | `swing`, `mode` | the state-space method: one step for all modes; the modes by available columns |
//! | `mode::{velocity, torque, posture, posture_torque}` | modes A, BM, C, D |
//! | `mode::{unknown_torque, onset, drive, state}` | their common parts |
//! | `payload` | mode D of a calibrated machine: changing payload, drops, opening bucket |
//! | `working` | mode D of an uncalibrated machine, the default: all uncertain parameters are states |
//! | `measurements` | the moment of the boom's cylinders, and when the ground carries part of it |
//! | `verdict`, `reason` | whether an estimate is trusted, and why not |

mod align;
mod consider;
mod estimate;
mod input;
mod joints;
pub mod keys;
mod measurements;
mod mismatch;
mod mode;
mod payload;
mod plausible;
mod reason;
mod regression;
mod settings;
mod size;
mod swing;
mod verdict;
mod working;

use input::{
    angle, calibration, delay, encoder, frozen, grid, hold, jump, lag, motion, quantisation, range,
    repeated, screen, standstill, steady, swing_angle,
};
use mode::{drive, onset, posture, posture_torque, state, torque, unknown_torque, velocity};
use payload::{change, changing_payload, opening};
use regression::{joint, single, svf};
use settings::{cylinder, doubts, geometry, settings_error};

pub use crate::{FULL_PRESSURE, Quantity};
pub use cylinder::Cylinder;
pub use doubts::{Correlations, Doubts, OfBucket};
pub use estimate::{Columns, Estimate, Flags, Method, Sample};
pub use geometry::{Geometry, Inertia};
pub use input::screen::largest;
pub use joints::{joint, true_posture};
pub use measurements::boom_moment::{FADING, GRAVITY, Moment};
pub use measurements::lifts::Lifts;
pub use mismatch::Mismatch;
pub use motion::{Motion, MotionFilter};
pub use plausible::Plausible;
pub use reason::Reason;
pub use regression::Regression;
pub use settings::{Estimator, Paper, Prior, Sensors, Settings, Variant};
pub use settings_error::SettingsError;
pub use swing::{Details, SwingEstimator};
pub use working::{Smoothed, Smoother, Trail};

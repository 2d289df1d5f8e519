//! Equations of the machine, common to `calibrate` and the filters.
//!
//! | file | idea |
//! |---|---|
//! | [`axle_loads`] | (6), (7), (10), (11) |
//! | `machine` | parameters of the machine, and the road under it |
//! | [`wheel_dynamics`] | (1)-(5), (8), (9), (12)-(14), (18): the process |
//! | [`cg_model`] | (15)-(17): states and measurements |
//! | `tangent` | the derivatives of the process |

pub mod axle_loads;
pub mod cg_model;
mod machine;
pub(super) mod tangent;
pub mod wheel_dynamics;

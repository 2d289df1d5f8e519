//! Evidence that no state carries: what makes an estimate doubtful, and what must be learnt again.
//!
//! | file | idea |
//! |---|---|
//! | `disturbance` | brakes, steering, forces that nobody measures |
//! | `gain` | force on the body over the force that the torques tell |
//! | `manoeuvres` | independent manoeuvres must agree |
//! | `curves` | curves that nobody reports |
//! | `constancy` | a ratio that changes while nothing was loaded |
//! | `coupling` | a centre drive that is locked |
//! | `directions` | whether the load sensitivity of the radii can be learnt |
//! | `axles` | what the slips of each axle tell to first order |
//! | `shared_slip` | errors that the slips of all wheels share |
//! | `stated_ratio` | slips, and what was known of the ratio before them |
//! | `relearning` | what was learnt wrongly: the start, the radii under another load |
//! | `witnesses` | slips and weight: the sharper answers, the other checks it |

pub(super) mod axles;
pub(super) mod constancy;
pub(super) mod coupling;
pub(super) mod curves;
pub(super) mod directions;
pub(super) mod disturbance;
pub(super) mod gain;
pub(super) mod manoeuvres;
pub(super) mod relearning;
pub(super) mod shared_slip;
pub(super) mod stated_ratio;
pub(super) mod witnesses;

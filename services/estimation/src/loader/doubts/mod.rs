//! Errors of the estimate that no state of the filter represents (*doubts*), and what must be learnt again.
//!
//! | file | idea |
//! |---|---|
//! | `digging_force` | other causes of the force on the bucket |
//! | `disturbance` | brakes, steering, unmeasured forces |
//! | `gain` | force on the body over the force of the reported torques |
//! | `manoeuvres` | agreement of independent manoeuvres |
//! | `curves` | unreported curves |
//! | `constancy` | drift of the empty machine's ratio |
//! | `coupling` | probability of a locked centre drive |
//! | `directions` | observability of the load sensitivity of the radii |
//! | `axles` | information of first order in the slips of each axle |
//! | `shared_slip` | errors common to the slips of all wheels |
//! | `stated_ratio` | combination of the slips with the stated ratio |
//! | `relearning` | what was learnt wrongly: at the start, and of the radii under another load |
//! | `witnesses` | slips and weight: the one with the smaller deviation is reported, the other checks it |

pub(super) mod axles;
pub(super) mod constancy;
pub(super) mod coupling;
pub(super) mod curves;
pub(super) mod digging_force;
pub(super) mod directions;
pub(super) mod disturbance;
pub(super) mod gain;
pub(super) mod manoeuvres;
pub(super) mod relearning;
pub(super) mod shared_slip;
pub(super) mod stated_ratio;
pub(super) mod witnesses;

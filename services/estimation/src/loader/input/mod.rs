//! From rows to inputs of a step.
//!
//! | file | idea |
//! |---|---|
//! | `steady` | a torque or slope that leaps |
//! | `stuck` | a sensor whose value never changes |
//! | `inclinometer` | a slope sensor that is late and follows the acceleration |
//! | `inputs` | inputs between rows |
//! | `plausible` | check of units, signs and machine |
//! | `carriage` | check of the bucket's angle while driving: wrong signs and zeros |

pub(super) mod carriage;
pub(super) mod inclinometer;
pub(super) mod inputs;
pub(super) mod plausible;
pub(super) mod steady;
pub(super) mod stuck;

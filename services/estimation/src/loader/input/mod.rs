//! From rows to inputs of a step.
//!
//! | file | idea |
//! |---|---|
//! | `steady` | a torque or slope that leaps |
//! | `stuck` | a sensor whose value never changes |
//! | `inclinometer` | a slope sensor that is late and follows the acceleration |
//! | `inputs` | inputs between rows |
//! | `carriage` | how the bucket is carried, which shows signs that are wrong |

pub(super) mod carriage;
pub(super) mod inclinometer;
pub(super) mod inputs;
pub(super) mod steady;
pub(super) mod stuck;

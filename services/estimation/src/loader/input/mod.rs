//! From rows to inputs of a step.
//!
//! | file | idea |
//! |---|---|
//! | `stuck` | a sensor whose value never changes |
//! | `inclinometer` | a slope sensor that is late and follows the acceleration |
//! | `inputs` | inputs between rows |

pub(super) mod inclinometer;
pub(super) mod inputs;
pub(super) mod stuck;

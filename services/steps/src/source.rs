//! Detects when an estimator must restart.

use messages::Stamp;
use serde::{Deserialize, Serialize};

/// Detects the first sample of a source, and of a source that was restarted with its clock set back:
/// an older state would refuse its rows for ever.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct SourceWatch {
    last: Option<(u32, f64)>,
}

impl SourceWatch {
    /// Whether the estimator must restart with this sample.
    pub(crate) fn is_new(&mut self, stamp: &Stamp) -> bool {
        let new = self
            .last
            .is_none_or(|(epoch, time)| stamp.epoch != epoch && stamp.time <= time);
        self.last = Some((stamp.epoch, stamp.time));
        new
    }
}

//! When an estimator must begin anew.

use messages::Stamp;
use serde::{Deserialize, Serialize};

/// Notices the first sample of a source, and of one that was restarted with its clock set back:
/// a state from before would refuse its rows for ever.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct SourceWatch {
    last: Option<(u32, f64)>,
}

impl SourceWatch {
    /// Whether the estimator must begin anew with this sample.
    pub(crate) fn is_new(&mut self, stamp: &Stamp) -> bool {
        let new = self
            .last
            .is_none_or(|(epoch, time)| stamp.epoch != epoch && stamp.time <= time);
        self.last = Some((stamp.epoch, stamp.time));
        new
    }
}

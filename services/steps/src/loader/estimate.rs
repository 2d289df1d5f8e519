//! Message of a loader estimate.

use estimation::loader::Estimate;
use messages::{LoaderEstimate, LoaderEstimate as EstimateMessage};

use crate::rows::{flags_of_estimate, numbers_of_estimate};

/// The message of an estimate; what the method does not estimate stays 0 without its bit.
pub fn message(e: &Estimate) -> LoaderEstimate {
    LoaderEstimate {
        flags: flags(e),
        estimated: estimated(e, e.started),
        method: e.method as u32,
        resets: e.resets,
        refused: e.refused,
        reason: e.reason as u32,
        ..numbers(e)
    }
}

sheet::loader_flags!(flags_of_estimate);
sheet::loader_quantities!(numbers_of_estimate);

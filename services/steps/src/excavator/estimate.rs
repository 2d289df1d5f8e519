//! Message of an excavator estimate.

use estimation::excavator::{Estimate, Reason};
use messages::{ExcavatorEstimate, ExcavatorEstimate as EstimateMessage, excavator_bits as bits};

use crate::kept::{Bits, Restart};
use crate::rows::{flags_of_estimate, numbers_of_estimate};

/// The message of an excavator estimate; what the method does not estimate stays 0 without its bit.
/// `started`: a row has been accepted.
pub fn message(e: &Estimate, started: bool) -> ExcavatorEstimate {
    ExcavatorEstimate {
        flags: flags(e),
        estimated: estimated(e, started),
        method: e.method.index(),
        refused: e.refused,
        reason: e.reason.code(),
        ..numbers(e)
    }
}

/// Marks an estimate as restarted, until it is trusted.
pub(super) fn tag_restart(restart: &mut Restart, time: f64, m: &mut ExcavatorEstimate) {
    let bits = Bits {
        restarted: bits::RESTARTED,
        fresh: bits::FRESH,
        trusted: bits::TRUSTED,
        reason: Reason::Restarted.code(),
    };
    restart.mark(&bits, time, &mut m.flags, &mut m.reason);
}

sheet::excavator_flags!(flags_of_estimate);
sheet::excavator_quantities!(numbers_of_estimate);

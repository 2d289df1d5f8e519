//! Why a load is not trusted: reason and flags of its estimate as one number, and as text.

use super::outage::Outage;
use estimation::loads::{Load, Witness};
use messages::{EXCAVATOR_REASONS, LOADER_REASONS, Machine, excavator_bits, loader_bits};

const _: () = {
    // Reason and flags fit in one number.
    assert!(EXCAVATOR_REASONS.len() < REASON as usize && LOADER_REASONS.len() < REASON as usize);
    assert!(excavator_bits::RESTARTED < 1 << 24 && loader_bits::RESTARTED < 1 << 24);
};

/// Bits of the reason; those of the flags are above.
pub(super) const REASON: u32 = 0xff;

/// Reason and flags in one number.
pub(super) fn why(reason: u32, flags: u32, trusted: bool) -> u32 {
    if trusted {
        0
    } else {
        reason.min(REASON) | flags << 8
    }
}

/// Reason and flags of the estimate that weighed a load.
pub fn reason_and_flags(load: &Load) -> (u32, u32) {
    (load.why & REASON, load.why >> 8)
}

/// Text of why a load is not trusted; empty where it is.
pub fn why_words(machine: Machine, load: &Load) -> &'static str {
    if load.trusted {
        return "";
    }
    if load.witness == Witness::Nothing {
        return "it was seen to leave and not weighed before";
    }
    let (reason, flags) = reason_and_flags(load);
    if let Some(words) = reason_words(machine, reason) {
        return words;
    }
    let missing: &[(u32, &str)] = match machine {
        Machine::Excavator => &[
            (excavator_bits::FRESH, TOO_OLD),
            (
                excavator_bits::IDENTIFIABLE,
                "the motion does not determine it yet",
            ),
            (
                excavator_bits::CONSISTENT,
                "the measurements do not agree with the model",
            ),
            (excavator_bits::EXCITED, "the machine did not swing"),
            (excavator_bits::CONVERGED, "the interval is still wide"),
        ],
        Machine::Loader => &[
            (loader_bits::FRESH, TOO_OLD),
            (
                loader_bits::TRUSTED_PAYLOAD,
                "the load is not weighed closely yet",
            ),
        ],
    };
    let found = missing.iter().find(|(bit, _)| flags & bit == 0);
    found.map_or("nothing confirms it", |(_, words)| words)
}

const TOO_OLD: &str = "an input is missing or too old";

/// The cause of a reason; `None` without a reason.
fn reason_words(machine: Machine, reason: u32) -> Option<&'static str> {
    let reasons = match machine {
        Machine::Excavator => EXCAVATOR_REASONS,
        Machine::Loader => LOADER_REASONS,
    };
    let found = reasons.get(reason as usize).filter(|_| reason != 0);
    found.map(|(_, words)| *words)
}

/// Text of why no load was weighed.
pub fn outage_words(machine: Machine, outage: &Outage) -> &'static str {
    reason_words(machine, outage.reason).unwrap_or(TOO_OLD)
}

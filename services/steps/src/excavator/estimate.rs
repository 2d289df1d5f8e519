//! What every excavator estimator says, as a message.

use estimation::excavator::{Estimate, Reason};
use messages::{ExcavatorEstimate, excavator_bits as bits};

use crate::bits::set_bits;
use crate::kept::{Bits, Restart};
use crate::rows::flags_of_estimate;

/// The message of an excavator estimate; what the method does not estimate stays 0 without its bit.
/// `started`: a row has been accepted.
#[must_use]
pub fn message(e: &Estimate, started: bool) -> ExcavatorEstimate {
    let [damping, torque, payload, friction, offset] =
        [e.damping, e.torque, e.payload, e.friction, e.offset].map(Option::unwrap_or_default);
    let [forgetting_inertia, forgetting_damping, forgetting_torque] = e.forgetting;
    ExcavatorEstimate {
        inertia: e.inertia,
        inertia_std: e.inertia_std,
        damping: damping.value,
        damping_std: damping.std,
        torque: torque.value,
        torque_std: torque.std,
        payload: payload.value,
        payload_std: payload.std,
        velocity: e.velocity,
        acceleration: e.acceleration,
        friction: friction.value,
        friction_std: friction.std,
        offset: offset.value,
        offset_std: offset.std,
        nis: e.nis,
        forgetting_inertia,
        forgetting_damping,
        forgetting_torque,
        flags: flags(e),
        estimated: estimated(e, started),
        method: e.method.index(),
        refused: e.refused,
        reason: e.reason.code(),
        ..ExcavatorEstimate::default()
    }
}

/// Says in an estimate that its process was started again, until it is trusted.
pub(super) fn tell_restart(restart: &mut Restart, time: f64, m: &mut ExcavatorEstimate) {
    let bits = Bits {
        restarted: bits::RESTARTED,
        fresh: bits::FRESH,
        trusted: bits::TRUSTED,
        reason: Reason::Restarted.code(),
    };
    restart.tell(&bits, time, &mut m.flags, &mut m.reason);
}

sheet::excavator_flags!(flags_of_estimate);

fn estimated(e: &Estimate, started: bool) -> u32 {
    set_bits(&[
        (bits::DAMPING, started && e.damping.is_some()),
        (bits::TORQUE, started && e.torque.is_some()),
        (bits::PAYLOAD, started && e.payload.is_some()),
        (bits::FRICTION, started && e.friction.is_some()),
        (bits::OFFSET, started && e.offset.is_some()),
        (bits::INERTIA, started),
        (bits::ACCELERATION, started),
    ])
}

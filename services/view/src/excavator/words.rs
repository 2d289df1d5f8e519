//! The excavator's verdict in words.

use estimation::HALF_WIDTH_95;
use messages::{EXCAVATOR_REASONS, ExcavatorEstimate, excavator_bits as bits};

use crate::judgement::Judgement;
use crate::number::{self, significant};

/// What heft says of the swing inertia.
pub(crate) fn inertia(e: &ExcavatorEstimate) -> Judgement {
    if e.estimated & bits::INERTIA == 0 {
        return Judgement {
            value: "There is no swing inertia yet".into(),
            trusted: false,
            reasons: vec!["no sample has been accepted so far".into()],
        };
    }
    let trusted = e.flags & bits::TRUSTED != 0;
    Judgement {
        value: value(e),
        trusted,
        reasons: if trusted {
            reasons_for(e)
        } else {
            reasons_against(e)
        },
    }
}

fn value(e: &ExcavatorEstimate) -> String {
    let unit = number::unit("kg m^2");
    let mut text = format!(
        "The swing inertia is {} (95\u{a0}%: {}{}{unit}",
        number::with_std(e.inertia, e.inertia_std, &unit),
        number::interval_95(e.inertia, e.inertia_std),
        number::GROUP,
    );
    if e.estimated & bits::PAYLOAD != 0 {
        let payload = number::with_std(e.payload, e.payload_std, "kg");
        text.push_str(&format!("; payload {payload}"));
    }
    text.push(')');
    text
}

/// Half width of the 95\u{a0}% interval in percent of the value.
fn percent(e: &ExcavatorEstimate) -> String {
    significant(
        100.0 * HALF_WIDTH_95 * e.inertia_std / e.inertia.abs().max(1e-9),
        2,
    )
}

fn reasons_for(e: &ExcavatorEstimate) -> Vec<String> {
    let mut reasons = vec![
        "the machine swings".into(),
        "the inputs are complete and can determine the inertia".into(),
        "the measurements agree with the model".into(),
        format!(
            "the 95\u{a0}% interval is narrow (±\u{a0}{}\u{a0}%)",
            percent(e)
        ),
    ];
    reasons.extend(cause(e).map(|cause| format!("{cause}: the interval allows for it")));
    reasons
}

fn reasons_against(e: &ExcavatorEstimate) -> Vec<String> {
    let has = |bit| e.flags & bit != 0;
    let mut reasons = Vec::new();
    if has(bits::REFUSED) {
        reasons.push("the last sample was refused (its time does not increase)".into());
    }
    if !has(bits::IDENTIFIABLE) {
        reasons.push("these inputs cannot determine the inertia (or not yet)".into());
    }
    if !has(bits::EXCITED) {
        let why = if has(bits::HELD) {
            "the machine stands still (the value is held)"
        } else {
            "the machine swings too slowly to tell its inertia"
        };
        reasons.push(why.into());
    }
    if !has(bits::FRESH) {
        reasons.push("measurements are missing, rejected or too old".into());
    }
    if !has(bits::CONSISTENT) {
        reasons.push("the measurements disagree with the model by more than their noise".into());
    }
    if has(bits::CHANGING) {
        reasons.push("the payload is changing".into());
    } else if !has(bits::CONVERGED) {
        reasons.push(format!(
            "the 95\u{a0}% interval is still wide (±\u{a0}{}\u{a0}%)",
            percent(e)
        ));
    }
    reasons.extend(cause(e));
    reasons
}

/// What the machine does beside its description.
fn cause(e: &ExcavatorEstimate) -> Option<String> {
    let (_, words) = EXCAVATOR_REASONS.get(e.reason as usize)?;
    (!words.is_empty()).then(|| (*words).to_owned())
}

/// What would bring trust: the first thing that is missing, and what to do about it.
pub(crate) fn advice(e: &ExcavatorEstimate) -> &'static str {
    let has = |bit| e.flags & bit != 0;
    if !has(bits::FRESH) {
        "check the sensors and the map: an input is missing, rejected or old"
    } else if !has(bits::EXCITED) {
        "swing at more than 0.1 rad/s"
    } else if !has(bits::IDENTIFIABLE) {
        "swing on; torque and three joint angles are needed"
    } else if !has(bits::CONSISTENT) {
        "look up the reason in docs/reasons.md"
    } else if has(bits::CHANGING) {
        "keep the bucket still while swinging"
    } else if !has(bits::CONVERGED) {
        "one more swing, best with an empty bucket; or calibrate"
    } else {
        "look up the reason in docs/reasons.md"
    }
}

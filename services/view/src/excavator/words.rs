//! The excavator's verdict in words.

use estimation::HALF_WIDTH_95;
use messages::{EXCAVATOR_REASONS, ExcavatorEstimate, excavator_bits as bits};

use crate::judgement::Judgement;
use crate::number::{self, significant};
use crate::words::remedy;

/// Verdict on the swing inertia.
pub(crate) fn inertia(e: &ExcavatorEstimate) -> Judgement {
    if e.estimated & bits::INERTIA == 0 {
        return Judgement::without_estimate("There is no swing inertia yet");
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
        advice: if trusted {
            ""
        } else {
            advice(e.reason, e.flags)
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
    // At standstill, the pressures provide the excitation.
    let excited = match e.flags & bits::HELD {
        0 => "the machine swings",
        _ => "the machine stands still, and its pressures weigh the load",
    };
    let mut reasons = vec![
        excited.into(),
        "the inputs are complete and can determine the inertia".into(),
        "the measurements agree with the model".into(),
        format!(
            "the 95\u{a0}% interval is narrow (half width {}\u{a0}%)",
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
    if !has(bits::FRESH) {
        reasons.push("measurements are missing, rejected or too old".into());
    } else if !has(bits::EXCITED) {
        let why = if has(bits::HELD) {
            "the machine stands still (the value is held)"
        } else {
            "the machine swings too slowly to determine its inertia"
        };
        reasons.push(why.into());
    }
    if !has(bits::CONSISTENT) {
        reasons.push("the measurements disagree with the model by more than their noise".into());
    }
    if has(bits::CHANGING) {
        reasons.push("the payload is changing".into());
    } else if !has(bits::CONVERGED) {
        reasons.push(format!(
            "the 95\u{a0}% interval is still wide (half width {}\u{a0}%)",
            percent(e)
        ));
    }
    reasons.extend(cause(e));
    reasons
}

/// The deviation of the machine from its description.
fn cause(e: &ExcavatorEstimate) -> Option<String> {
    let (_, words) = EXCAVATOR_REASONS.get(e.reason as usize)?;
    (!words.is_empty()).then(|| (*words).to_owned())
}

/// Remedy for each reason; docs/reasons.md has the same texts.
pub(crate) const REMEDIES: &[(&str, &str)] = &[
    (
        "slope",
        "measure pitch and roll, or work on: small slopes are estimated; check an inclinometer's zero",
    ),
    (
        "losses",
        "run heft calibrate, or set machine.drive_efficiency",
    ),
    ("friction", "warm up, then run heft calibrate"),
    (
        "gain",
        "check displacement, gear ratio and unit of the torque; then run heft calibrate with a weighed load",
    ),
    (
        "delay",
        "run heft calibrate, or set sensors.swing_torque_delay or sensors.swing_velocity_delay",
    ),
    (
        "offset",
        "zero the torque sensor at standstill, or run heft calibrate",
    ),
    ("damping", "warm up, then run heft calibrate"),
    (
        "unexplained",
        "swing freely; if it stays so, look for a brake, a swinging load, or a wrong column",
    ),
    (
        "disagreement",
        "swing on: swings that agree end it; look for slope, temperature, load that spills",
    ),
    (
        "limit",
        "check units and signs of torque and velocity, and machine.operating_mass",
    ),
    ("content", "swing on: the next swing decides"),
    ("frozen", "check the sensor and its cable"),
    ("sign", "check the signs in the map (sign = -1)"),
    (
        "method",
        "use the method auto with torque and all three angles, or run heft calibrate",
    ),
    ("restarted", "wait for half a second of motion"),
    (
        "jump",
        "check the angle sensor; after its repair begin another run or recording",
    ),
    (
        "contradiction",
        "there from the start: run heft calibrate; new: check torque, velocity and angles, then swing twice with an emptied bucket",
    ),
    (
        "hanging",
        "wait until the load hangs still, or carry it in the bucket",
    ),
    (
        "attachment",
        "state machine.geometry.bucket_mass of the mounted bucket",
    ),
];

/// Remedy for a load that is not trusted: that of the reason, whether or not the swing is over.
pub(crate) fn load_advice(reason: u32, flags: u32) -> &'static str {
    remedy(reason, EXCAVATOR_REASONS, REMEDIES).unwrap_or_else(|| advice(reason, flags))
}

/// Reasons that are of an input, or because of which none counts as recent.
const OF_INPUT: [&str; 5] = ["frozen", "sign", "jump", "contradiction", "restarted"];

/// Remedy: that of the reason, else of the first missing condition.
fn advice(reason: u32, flags: u32) -> &'static str {
    let has = |bit| flags & bit != 0;
    let of_reason = remedy(reason, EXCAVATOR_REASONS, REMEDIES);
    // No swing helps there.
    let needs_another_method = EXCAVATOR_REASONS
        .get(reason as usize)
        .is_some_and(|(name, _)| *name == "method");
    if !has(bits::FRESH) {
        // No swing helps where nothing arrives.
        let name = EXCAVATOR_REASONS
            .get(reason as usize)
            .map(|(name, _)| *name);
        of_reason
            .filter(|_| name.is_some_and(|name| OF_INPUT.contains(&name)))
            .unwrap_or("check the sensors and the map: an input is missing, rejected or too old")
    } else if !has(bits::EXCITED) && !needs_another_method {
        "swing faster than 6 degrees a second (0.1 rad/s)"
    } else if let Some(of_reason) = of_reason {
        of_reason
    } else if !has(bits::IDENTIFIABLE) {
        "swing on; torque and the three joint angles are needed"
    } else if !has(bits::CONSISTENT) {
        "swing on; if it stays so, check the sensors and the machine file"
    } else if has(bits::CHANGING) {
        "keep the bucket still while swinging"
    } else {
        "swing once more, best with an emptied bucket; or run heft calibrate"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_the_method_cannot_tell_no_faster_swing_is_advised() {
        let code = |name| EXCAVATOR_REASONS.iter().position(|(n, _)| *n == name);
        let advised = |name| advice(code(name).expect("a reason") as u32, bits::FRESH);
        assert!(advised("method").contains("heft calibrate"));
        assert!(advised("slope").contains("swing faster"));
        let silent = |name| advice(code(name).expect("a reason") as u32, bits::EXCITED);
        assert!(silent("disagreement").contains("an input is missing"));
        assert!(silent("jump").contains("angle sensor"));
    }
}

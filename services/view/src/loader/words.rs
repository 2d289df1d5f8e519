//! The wheel loader's verdict in words.

use estimation::HALF_WIDTH_95;
use estimation::loader::Reason;
use messages::{LOADER_REASONS, LoaderEstimate, loader_bits as bits};

use crate::judgement::Judgement;
use crate::number::{self, significant};
use crate::words::remedy;

/// Verdict on the position of the centre of gravity along the machine.
pub(crate) fn position(e: &LoaderEstimate) -> Judgement {
    if e.estimated & bits::STATE == 0 {
        return Judgement::without_estimate("There is no position of the centre of gravity yet");
    }
    let share = number::with_std(100.0 * e.cg_ratio, 100.0 * e.cg_ratio_std, "%");
    // d = (1 - ratio) l: its standard deviation is that of the ratio times the wheelbase.
    let behind = 1.0 - e.cg_ratio;
    let std = e.cg_ratio_std * e.cg_distance / behind;
    let value = if behind > 0.0 && e.cg_ratio >= 0.0 {
        format!(
            "The centre of gravity lies {} behind the front axle (95\u{a0}%: {}{}m; {share} of the weight on the front axle{})",
            number::with_std(e.cg_distance, std, "m"),
            number::interval_95(e.cg_distance, std),
            number::GROUP,
            payload(e),
        )
    } else {
        format!(
            "There is no position of the centre of gravity: the front axle would carry {share} of the weight, and the machine would tip{}",
            payload(e),
        )
    };
    let width = format!(
        "half width {}\u{a0}%",
        significant(
            100.0 * HALF_WIDTH_95 * e.cg_ratio_std / e.cg_ratio.abs().max(1e-9),
            2
        )
    );
    judgement(e, value, &Part::POSITION, &width)
}

/// The payload, which has a verdict of its own; empty if nothing weighs it.
fn payload(e: &LoaderEstimate) -> String {
    if e.estimated & bits::PAYLOAD == 0 {
        return String::new();
    }
    let verdict = if e.flags & bits::TRUSTED_PAYLOAD != 0 {
        "trusted"
    } else {
        "not trusted"
    };
    format!(
        "; payload {}, {verdict}",
        number::with_std(e.payload, e.payload_std, "kg")
    )
}

/// Verdict on the height of the centre of gravity.
pub(crate) fn height(e: &LoaderEstimate) -> Judgement {
    if e.estimated & bits::STATE == 0 {
        return Judgement::without_estimate("There is no height of the centre of gravity yet");
    }
    let value = format!(
        "The centre of gravity lies {} above the ground (95\u{a0}%: {}{}m)",
        number::with_std(e.cg_height, e.cg_height_std, "m"),
        number::interval_95(e.cg_height, e.cg_height_std),
        number::GROUP,
    );
    let width = format!(
        "half width {}\u{a0}m",
        significant(HALF_WIDTH_95 * e.cg_height_std, 2)
    );
    judgement(e, value, &Part::HEIGHT, &width)
}

/// Bits and words of one of the two quantities.
struct Part {
    trusted: u32,
    excited: u32,
    converged: u32,
    identifiable: u32,
    idle: &'static str,
    moving: &'static str,
    /// Remedies without excitation, and with a wide interval.
    to_do: [&'static str; 2],
}

impl Part {
    const POSITION: Self = Self {
        trusted: bits::TRUSTED_RATIO,
        excited: bits::EXCITED_RATIO,
        converged: bits::CONVERGED_RATIO,
        identifiable: bits::IDENTIFIABLE_RATIO,
        idle: "the axle torques hardly change, and only changes determine the position",
        moving: "the axle torques change",
        to_do: [
            "accelerate and brake with the drive",
            "accelerate and brake some more; or run heft calibrate",
        ],
    };
    const HEIGHT: Self = Self {
        trusted: bits::TRUSTED_HEIGHT,
        excited: bits::EXCITED_HEIGHT,
        converged: bits::CONVERGED_HEIGHT,
        identifiable: bits::IDENTIFIABLE_HEIGHT,
        idle: "the machine hardly accelerates or brakes, and only that determines the height",
        moving: "the machine accelerates and brakes",
        to_do: [
            "accelerate and brake hard",
            "add lift pressures, or state stiffness_load_exponent_std and radius_load_sensitivity_std of measured tyres",
        ],
    };
}

fn judgement(e: &LoaderEstimate, value: String, part: &Part, width: &str) -> Judgement {
    let trusted = e.flags & part.trusted != 0;
    let reasons = if trusted {
        vec![
            if has_weight(e) { WEIGHED } else { part.moving }.into(),
            "the inputs are complete".into(),
            "the measurements agree with the model".into(),
            format!("the 95\u{a0}% interval is narrow ({width})"),
        ]
    } else {
        reasons_against(e, part, width)
    };
    Judgement {
        value,
        trusted,
        reasons,
        advice: if trusted { "" } else { advice(e, part) },
    }
}

/// Whether lift pressures weigh the load.
fn has_weight(e: &LoaderEstimate) -> bool {
    e.estimated & bits::PAYLOAD != 0
}

/// The words of a reason.
fn words_of(reason: Reason) -> &'static str {
    LOADER_REASONS[reason as usize].1
}

fn reasons_against(e: &LoaderEstimate, part: &Part, width: &str) -> Vec<String> {
    let has = |bit| e.flags & bit != 0;
    let mut reasons: Vec<String> = Vec::new();
    if has(bits::REFUSED) {
        reasons.push("the last sample was refused (its time does not increase)".into());
    }
    if has(bits::DIVERGED) {
        reasons.push("the filter has diverged".into());
    }
    if has(bits::FROZEN) {
        reasons.push("the machine stands, crawls or digs (the value is held)".into());
    } else if !has(part.excited) {
        reasons.push(part.idle.into());
    }
    if !has(bits::FRESH) {
        match LOADER_REASONS.get(e.reason as usize).map(|reason| reason.0) {
            // The text of the reason states it.
            Some(name) if name == "missing" || name.starts_with("stuck") => {}
            None | Some("") => reasons.push("measurements are missing, rejected or too old".into()),
            Some(_) => reasons.push("measurements are rejected".into()),
        }
    }
    if !has(bits::CONSISTENT) {
        reasons.push("the measurements disagree with the model by more than their noise".into());
    }
    if let Some((_, words)) = LOADER_REASONS
        .get(e.reason as usize)
        .filter(|r| !r.1.is_empty())
    {
        reasons.push((*words).into());
    }
    // An estimate has one reason code; this one may have been displaced by another.
    if has(bits::CHANGING) && e.reason != Reason::Load as u32 {
        reasons.push(words_of(Reason::Load).into());
    }
    if !has(part.identifiable) {
        reasons.push("these measurements do not determine it yet".into());
    }
    if has(bits::RESET) {
        reasons.push("the filter has just been reset".into());
    } else if !has(part.converged) {
        reasons.push(format!("the 95\u{a0}% interval is still wide ({width})"));
    }
    reasons
}

/// Remedy for each reason; docs/reasons.md has the same texts.
pub(crate) const REMEDIES: &[(&str, &str)] = &[
    ("missing", "check the wiring, the bus and max_age"),
    ("stuck speed", "check the sensor"),
    ("stuck front wheel", "check the sensor"),
    ("stuck rear wheel", "check the sensor"),
    ("stuck front torque", "check the signal of the front motor"),
    ("stuck rear torque", "check the signal of the rear motor"),
    ("stuck slope", "check the inclinometer"),
    ("stuck acceleration", "check the accelerometer"),
    (
        "unexplained",
        "drive on firm ground; else look for a wrong column",
    ),
    ("latency", "run heft calibrate, or set sensors.speed_delay"),
    (
        "stiffness",
        "check units and noise of wheel speeds and torques, and machine.wheel_radius; then run heft calibrate",
    ),
    ("brakes", "map the brake signal, or brake with the drive"),
    (
        "steering",
        "drive straight; map articulation or yaw rate, and wheel speeds of one time",
    ),
    (
        "slope",
        "check sign and unit of the slope, then run heft calibrate",
    ),
    (
        "torque",
        "check unit, sign and gear ratio of the torques; state machine.mass; run heft calibrate",
    ),
    (
        "load",
        "accelerate and brake with the new load; map the payload if it is weighed",
    ),
    (
        "disagreement",
        "drive on until they agree; look for changes of ground, load, tyres",
    ),
    (
        "limit",
        "check units, machine.mass, and whether front and rear wheel speeds are exchanged",
    ),
    ("restarted", "wait for one acceleration"),
    (
        "locked drive",
        "open the lock; a rigid centre drive: weigh by lift pressures",
    ),
    (
        "one way",
        "drive both ways once, or state machine.radius_load_sensitivity_std",
    ),
    (
        "wheel radius",
        "check unit and gear ratio of the wheel speeds, the speed, and machine.wheel_radius",
    ),
    ("lift cylinder", "check its pressures, machine.lift_arm"),
    (
        "accelerometer",
        "map the acceleration along the machine; or weigh by lift pressures",
    ),
];

const WEIGHED: &str = "lift pressures weigh the load";
const CARRY: &str = "lift the bucket off the ground, and do not turn it";
const MISSING: &str = "check the sensors and the map: an input is missing, rejected or too old";
const WEIGH: &str = "weigh the axles of the empty machine once, level and on a ramp (heft weigh); or run heft calibrate";

const WEIGH_A_LOAD: &str =
    "run heft calibrate with a weighed load, or state the numbers of machine.lift_arm more closely";

/// Remedy for a load that is not trusted: that of the reason, else of the missing condition.
pub(crate) fn load_advice(reason: u32, flags: u32) -> &'static str {
    let missing = if flags & bits::FRESH == 0 {
        MISSING
    } else {
        WEIGH_A_LOAD
    };
    remedy(reason, LOADER_REASONS, REMEDIES).unwrap_or(missing)
}

/// Reasons that are of the load: they arise while the machine digs or stands, and no drive alone ends them.
const OF_LOAD: [u32; 2] = [Reason::Load as u32, Reason::LiftCylinder as u32];

/// Remedy: that of the reason, else of the first missing condition.
fn advice(e: &LoaderEstimate, part: &Part) -> &'static str {
    let has = |bit| e.flags & bit != 0;
    let of_reason = remedy(e.reason, LOADER_REASONS, REMEDIES);
    if !has(bits::FRESH) {
        of_reason.unwrap_or(MISSING)
    } else if e.reason == Reason::Load as u32 && has_weight(e) {
        CARRY
    } else if has(bits::FROZEN) && !OF_LOAD.contains(&e.reason) {
        "drive, faster than 0.5 m/s and without digging"
    } else if let Some(of_reason) = of_reason {
        of_reason
    } else if !has(part.excited) {
        part.to_do[0]
    } else if !has(bits::CONSISTENT) {
        "drive on; if it stays so, check the sensors and the machine file"
    } else if has_weight(e) {
        WEIGH
    } else {
        part.to_do[1]
    }
}

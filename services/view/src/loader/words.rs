//! The wheel loader's verdict in words.

use estimation::HALF_WIDTH_95;
use messages::{LOADER_REASONS, LoaderEstimate, loader_bits as bits};

use crate::judgement::Judgement;
use crate::number::{self, significant};

/// What heft says of the centre of gravity along the machine.
pub(crate) fn position(e: &LoaderEstimate) -> Judgement {
    if e.estimated & bits::STATE == 0 {
        return none("There is no position of the centre of gravity yet");
    }
    // d = (1 - ratio) l: its standard deviation is that of the ratio times the wheelbase.
    let wheelbase = e.cg_distance / (1.0 - e.cg_ratio).max(1e-9);
    let std = e.cg_ratio_std * wheelbase;
    let value = format!(
        "The centre of gravity lies {} behind the front axle (95\u{a0}%: {}{}m; {} of the weight on the front axle)",
        number::with_std(e.cg_distance, std, "m"),
        number::interval_95(e.cg_distance, std),
        number::GROUP,
        number::with_std(100.0 * e.cg_ratio, 100.0 * e.cg_ratio_std, "%"),
    );
    let width = format!(
        "±\u{a0}{}\u{a0}%",
        significant(196.0 * e.cg_ratio_std / e.cg_ratio.abs().max(1e-9), 2)
    );
    judgement(e, value, &Part::POSITION, &width)
}

/// What heft says of the height of the centre of gravity.
pub(crate) fn height(e: &LoaderEstimate) -> Judgement {
    if e.estimated & bits::STATE == 0 {
        return none("There is no height of the centre of gravity yet");
    }
    let value = format!(
        "The centre of gravity lies {} above the ground (95\u{a0}%: {}{}m)",
        number::with_std(e.cg_height, e.cg_height_std, "m"),
        number::interval_95(e.cg_height, e.cg_height_std),
        number::GROUP,
    );
    let width = format!(
        "±{}{}\u{a0}m",
        number::GROUP,
        significant(HALF_WIDTH_95 * e.cg_height_std, 2)
    );
    judgement(e, value, &Part::HEIGHT, &width)
}

fn none(value: &str) -> Judgement {
    Judgement {
        value: value.into(),
        trusted: false,
        reasons: vec!["no sample has been accepted so far".into()],
    }
}

/// The bits and words of one of the two quantities.
struct Part {
    trusted: u32,
    excited: u32,
    converged: u32,
    identifiable: u32,
    idle: &'static str,
    moving: &'static str,
}

impl Part {
    const POSITION: Self = Self {
        trusted: bits::TRUSTED_RATIO,
        excited: bits::EXCITED_RATIO,
        converged: bits::CONVERGED_RATIO,
        identifiable: bits::IDENTIFIABLE_RATIO,
        idle: "the axle torques hardly change, which tells nothing about the position",
        moving: "the axle torques change",
    };
    const HEIGHT: Self = Self {
        trusted: bits::TRUSTED_HEIGHT,
        excited: bits::EXCITED_HEIGHT,
        converged: bits::CONVERGED_HEIGHT,
        identifiable: bits::IDENTIFIABLE_HEIGHT,
        idle: "the machine hardly accelerates or brakes, and only that tells the height",
        moving: "the machine accelerates and brakes",
    };
}

fn judgement(e: &LoaderEstimate, value: String, part: &Part, width: &str) -> Judgement {
    let trusted = e.flags & part.trusted != 0;
    let reasons = if trusted {
        vec![
            part.moving.into(),
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
    }
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
        reasons.push("measurements are missing, rejected or too old".into());
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

/// What would bring trust in the front-axle load: the first thing that is missing, and what to do about it.
pub(crate) fn advice(e: &LoaderEstimate) -> &'static str {
    let has = |bit| e.flags & bit != 0;
    if !has(bits::FRESH) {
        "check the sensors and the map: an input is missing, rejected or old"
    } else if has(bits::FROZEN) {
        "drive faster than walking speed, without digging"
    } else if !has(bits::EXCITED_RATIO) {
        "accelerate and brake with the drive"
    } else if !has(bits::CONSISTENT) {
        "look up the reason in docs/reasons.md"
    } else if !has(bits::IDENTIFIABLE_RATIO) || !has(bits::CONVERGED_RATIO) {
        "some more accelerations; or calibrate"
    } else {
        "look up the reason in docs/reasons.md"
    }
}

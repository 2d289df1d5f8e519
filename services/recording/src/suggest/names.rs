//! What others call heft's signals.

use std::fmt::Write;

use crate::signal::{self, Sensors};
use crate::{steers, unit};

use super::languages::english;

/// A text as a TOML string.
pub(crate) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        let _ = match c {
            '"' | '\\' => write!(out, "\\{c}"),
            c if steers(c) => write!(out, "\\U{:08X}", u32::from(c)),
            c => write!(out, "{c}"),
        };
    }
    out + "\""
}

/// The signals of a machine that sensors measure, the time first.
pub(super) fn wanted<S: Sensors>() -> Vec<String> {
    let names = signal::signals::<S>().into_iter().map(|s| s.name);
    names.filter(|name| !name.starts_with("true_")).collect()
}

/// For each signal, words of which a name must have all, in the order of trust: `^word` only where a word of the name begins,
/// `=word` only where the name is no more than that and its unit, `[unit` where the name tells a unit of this dimension.
const WORDS: &[(&str, &[&[&str]])] = &[
    (
        "t",
        &[
            &["timestamp"],
            &["time"],
            &["zeit"],
            &["=t"],
            &["=ts"],
            &["=stamp"],
            &["=epoch"],
            &["=clock"],
            &["=date"],
            &["=datum"],
            &["=fecha"],
            &["=hora"],
            &["=heure"],
            &["=tempo"],
            &["elapsed"],
            &["=datenum"],
            &["=ticks"],
            // LabVIEW's.
            &["=x_value"],
        ],
    ),
    (
        "swing_velocity",
        &[
            &["swing", "vel"],
            &["swing", "rate"],
            &["swing", "speed"],
            &["slew", "speed"],
            &["slew", "vel"],
            &["slew", "rate"],
            &["swing", "omega"],
            &["gyro", "z"],
            &["yaw", "rate"],
            &["=gyro"],
            &["=omega"],
            &["=angular_velocity"],
            &["swing", "[rad/s"],
            &["slew", "[rad/s"],
        ],
    ),
    (
        "swing_angle",
        &[
            &["swing", "angle"],
            &["swing", "pos"],
            &["swing", "deg"],
            &["slew", "angle"],
        ],
    ),
    (
        "swing_torque",
        &[
            &["swing", "torque"],
            &["slew", "torque"],
            &["swing", "moment"],
            &["slew", "moment"],
            &["=torque"],
            &["=moment"],
            &["swing", "[N m"],
            &["slew", "[N m"],
        ],
    ),
    (
        "boom_angle",
        &[
            &["boom", "angle"],
            &["boom", "deg"],
            &["boom", "pos"],
            &["boom"],
        ],
    ),
    (
        "arm_angle",
        &[
            &["arm", "angle"],
            &["stick", "angle"],
            &["dipper", "angle"],
            &["arm", "deg"],
            &["arm", "pos"],
            &["arm", "incl"],
            &["stick"],
            &["dipper"],
            &["^arm"],
        ],
    ),
    (
        "bucket_angle",
        &[&["bucket", "angle"], &["bucket", "deg"], &["bucket"]],
    ),
    (
        "speed",
        &[
            &["wheelbased", "speed"],
            &["vehicle", "speed"],
            &["ground", "speed"],
            &["machine", "speed"],
            &["^veh", "speed"],
            &["travel", "speed"],
            &["gps", "speed"],
            &["ccvs"],
            &["=speed"],
            &["=velocity"],
        ],
    ),
    (
        "front_wheel_speed",
        &[
            &["front", "wheel", "speed"],
            &["front", "axle"],
            &["front", "rpm"],
            &["front", "speed"],
        ],
    ),
    (
        "rear_wheel_speed",
        &[
            &["rear", "wheel", "speed"],
            &["rear", "axle"],
            &["rear", "rpm"],
            &["rear", "speed"],
            &["output", "shaft"],
        ],
    ),
    ("front_torque", &[&["front", "torque"]]),
    ("rear_torque", &[&["rear", "torque"]]),
    (
        "slope",
        &[
            &["slope"],
            &["grade"],
            &["gradient"],
            &["inclin"],
            &["pitch", "angle"],
            &["pitch"],
        ],
    ),
    (
        "acceleration",
        &[&["accel", "long"], &["accel", "x"], &["accel"]],
    ),
    (
        "mass",
        &[
            &["gross", "mass"],
            &["vehicle", "mass"],
            &["mass"],
            &["gross", "weight"],
            &["=weight"],
        ],
    ),
    ("pitch", &[&["pitch"]]),
    ("roll", &[&["roll"], &["=wank"]]),
    ("articulation", &[&["articul"], &["steer", "angle"]]),
    ("yaw_rate", &[&["yaw", "rate"], &["gyro", "z"]]),
    ("brake", &[&["brake"]]),
    (
        "boom_head_pressure",
        &[
            &["boom", "head", "press"],
            &["boom", "bottom", "press"],
            &["boom", "bore", "press"],
            &["boom", "piston", "press"],
            &["boom", "cap", "press"],
        ],
    ),
    ("boom_rod_pressure", &[&["boom", "rod", "press"]]),
    (
        "arm_head_pressure",
        &[
            &["arm", "head", "press"],
            &["stick", "head", "press"],
            &["arm", "bottom", "press"],
            &["stick", "bottom", "press"],
            &["arm", "piston", "press"],
            &["arm", "cap", "press"],
            &["stick", "cap", "press"],
        ],
    ),
    (
        "arm_rod_pressure",
        &[&["arm", "rod", "press"], &["stick", "rod", "press"]],
    ),
    (
        "lift_angle",
        &[&["lift", "ang"], &["lift", "arm"], &["boom", "ang"]],
    ),
    ("tilt_angle", &[&["tilt", "ang"], &["bucket", "ang"]]),
    (
        "lift_head_pressure",
        &[
            &["lift", "head", "press"],
            &["lift", "bottom", "press"],
            &["lift", "piston", "press"],
            &["lift", "cap", "press"],
            &["hoist", "head", "press"],
            &["hoist", "bottom", "press"],
            &["boom", "head", "press"],
            &["boom", "bottom", "press"],
        ],
    ),
    (
        "lift_rod_pressure",
        &[
            &["lift", "rod", "press"],
            &["hoist", "rod", "press"],
            &["boom", "rod", "press"],
        ],
    ),
    ("truck", &[&["truck", "number"], &["truck", "id"]]),
];

/// Words of what is commanded or something else than motion: a joystick measures no stick.
const OTHERS: [&str; 9] = [
    "joystick", "lever", "pilot", "command", "cmd", "setpoint", "valve", "flow", "temper",
];

/// Whether a name has a word of [`WORDS`]: an alarm is no arm.
fn has(name: &str, word: &str) -> bool {
    if let Some(word) = word.strip_prefix('=') {
        return unit::without(name).replace([' ', '-'], "_") == word;
    }
    if let Some(si) = word.strip_prefix('[') {
        return unit::is_of(name, si);
    }
    let Some(word) = word.strip_prefix('^') else {
        return name.contains(word);
    };
    let mut found = name.match_indices(word);
    found.any(|(at, _)| !name[..at].ends_with(char::is_alphabetic))
}

/// Position of the name that fits a signal best and is not taken: heft's own name, else the first
/// that has the words.
pub(crate) fn fitting(signal: &str, names: &[&str], taken: &[usize]) -> Option<usize> {
    let free = |at: &usize| !taken.contains(at);
    let lower: Vec<String> = names.iter().map(|n| n.to_lowercase()).collect();
    let own = lower
        .iter()
        .position(|n| n == signal || n.trim_end_matches("_s") == signal);
    if let Some(at) = own.filter(free) {
        return Some(at);
    }
    let lower: Vec<String> = names.iter().map(|n| english(n)).collect();
    let (_, alternatives) = WORDS.iter().find(|(name, _)| *name == signal)?;
    alternatives.iter().find_map(|words| {
        // `boom_head_pressure` is no angle of the boom.
        let is_pressure = |n: &str| n.contains("press");
        let fits = |n: &String| {
            words.iter().all(|w| has(n, w))
                && is_pressure(n) == is_pressure(signal)
                && !OTHERS.iter().any(|w| n.contains(w))
        };
        (0..lower.len()).filter(free).find(|at| fits(&lower[*at]))
    })
}

#[cfg(test)]
mod tests {
    use super::fitting;

    #[test]
    fn a_bare_name_with_its_unit_is_enough_where_it_says_all() {
        for (signal, name) in [
            ("t", "ts_ms"),
            ("t", "t [s]"),
            ("t", "Elapsed (s)"),
            ("t", "X_Value"),
            ("t", "Ticks"),
            ("t", "Tempo [s]"),
            ("roll", "Wank [°]"),
            ("swing_torque", "torque_Nm"),
            ("swing_velocity", "omega_rad_s"),
            ("swing_velocity", "Slew rate (rpm)"),
            ("speed", "Speed (km/h)"),
            ("lift_angle", "boom_angle_deg"),
            ("swing_velocity", "swing_rpm"),
            ("swing_velocity", "Slew [°/s]"),
            ("swing_velocity", "swing_deg_s"),
            ("swing_angle", "swing_deg"),
            ("swing_torque", "swing_kNm"),
            ("swing_torque", "Torque:kNm"),
            ("swing_torque", "Torque / kN m"),
            ("speed", "speed_km_h"),
        ] {
            assert_eq!(fitting(signal, &["x", name], &[]), Some(1), "{name}");
        }
        for (signal, name) in [
            ("swing_torque", "engine_torque_Nm"),
            ("t", "ts_brake"),
            ("t", "temporary_x"),
            ("roll", "Drehzahlschwankung"),
            ("speed", "engine_speed_rpm"),
            ("swing_velocity", "swing_deg"),
            ("swing_angle", "swing_bar"),
            ("swing_torque", "swing_bar"),
        ] {
            assert_eq!(fitting(signal, &["x", name], &[]), None, "{name}");
        }
    }

    #[test]
    fn an_arm_is_found_by_its_bare_name_and_what_commands_it_is_not() {
        for name in ["arm", "Arm_Incl", "INC.ArmInclination", "dipper_deg"] {
            assert_eq!(fitting("arm_angle", &["x", name], &[]), Some(1), "{name}");
        }
        for name in ["alarm", "warm", "joystick_y", "arm_cmd", "arm_valve_mA"] {
            assert_eq!(fitting("arm_angle", &["x", name], &[]), None, "{name}");
        }
    }
}

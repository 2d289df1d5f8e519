//! Names of heft's signals in foreign files.

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

/// For each signal, texts in its names, in the order of trust; of `a + b` both must occur. `^word` matches only at the beginning of a
/// word in the name, `|word` only a whole word. `=word` matches only the whole name without its unit, `[unit` a unit of this dimension in
/// the name. `x_value` is of LabVIEW, `effort` of ROS, `tau` of Modelica.
const WORDS: &str = "
t: timestamp, time, zeit, =t, =ts, =stamp, =epoch, =utc, =clock, =date, =datum, =fecha, =hora, =heure, =tempo, elapsed, =datenum, =cas
t: =ticks, =x_value, =ms, =msec, =millis, =sec, =seconds, =s
swing_velocity: swing + vel, swing + rate, swing + speed, swing + omega, gyro + z
swing_velocity: yaw + rate, =gyro, =omega, =angular_velocity, swing + |w, swing + |qd, swing + |dq, swing + |dot, swing + [rad/s
swing_angle: swing + angle, swing + pos, swing + deg
swing_torque: swing + torque, swing + effort, swing + ^tau, =torque, swing + [N m
boom_angle: boom + angle, boom + deg, boom + pos, boom
arm_angle: arm + angle, stick + angle, dipper + angle, arm + deg, arm + pos, arm + incl, stick, dipper, ^arm
bucket_angle: bucket + angle, bucket + deg, bucket
speed: wheelbased + speed, vehicle + speed, ground + speed, machine + speed, ^veh + speed, travel + speed, gps + speed, ccvs
speed: =speed, =velocity
front_wheel_speed: front + wheel + speed, front + axle, front + rpm, front + speed, front + wheel
rear_wheel_speed: rear + wheel + speed, rear + axle, rear + rpm, rear + speed, output + shaft, rear + wheel
front_torque: front + torque
rear_torque: rear + torque
slope: slope, grade, gradient, inclin, pitch + angle, pitch
acceleration: accel + long, accel + x, accel
mass: gross + mass, vehicle + mass, mass, gross + weight, =weight
pitch: pitch
roll: ^roll, =wank
articulation: articul, steer + angle
yaw_rate: yaw + rate, gyro + z
brake: brake
boom_head_pressure: boom + |head + press
boom_rod_pressure: boom + |rod + press
arm_head_pressure: ^arm + |head + press, stick + |head + press, dipper + |head + press
arm_rod_pressure: ^arm + |rod + press, stick + |rod + press, dipper + |rod + press
lift_angle: lift + ang, lift + arm, lift + linkage, boom + ang
tilt_angle: tilt + ang, tilt + linkage, bucket + ang
lift_head_pressure: lift + |head + press, hoist + |head + press, boom + |head + press
lift_rod_pressure: lift + |rod + press, hoist + |rod + press, boom + |rod + press
truck: truck + number, truck + id
";

/// Words of commands or of other quantities: a joystick is no stick.
const OTHERS: &str = "joystick, lever, pilot, command, cmd, setpoint, set point, set_point, valve, flow, temper, roller";

/// Words of commands, bounds, states and statistics, which are no measurements.
const NO_MEASUREMENT: &str = "target ref reference desired demand request requested req limit lim max min maximum minimum valid validity \
    status quality fault error flag alarm pedal mode std stddev sigma variance offset sp soll sollwert vorgabe consigne";

/// Signals, by their name or its end, and words that mean another quantity: the rate of a boom is no angle of it.
const OF_OTHERS: &[(&str, &str)] = &[
    (
        "_angle slope pitch roll articulation",
        "rate vel velocity speed accel acceleration omega torque moment force stroke length",
    ),
    (
        "_velocity _speed speed yaw_rate",
        "accel acceleration angle torque moment force power",
    ),
    ("_torque", "rate vel velocity speed angle accel power"),
    // Of two motors, of which the sum is the torque.
    ("swing_torque", "left right"),
    ("acceleration", "accelerator"),
    (
        "slope pitch roll",
        "boom arm stick dipper bucket lift blade",
    ),
    ("_wheel_speed speed", "engine diesel turbine turbo pump fan"),
    // Speeds of the shaft, before the gear.
    ("swing_velocity", "motor engine moteur motore pump shaft"),
    ("articulation", "wheel whl"),
    ("mass", "payload load bucket fuel air attachment"),
    (
        "t",
        "cycle zone delta dt diff step remaining delay lag response",
    ),
];

/// Whether the name of a column excludes a measurement of this signal.
fn is_other(signal: &str, name: &str) -> bool {
    // The name of a bus message, or of a path, may contain such words.
    let own = unit::without(name).rsplit(['.', '/', '\\', '|']).next();
    let own = own.unwrap_or(name);
    // At the end of a name `min` would be taken for a unit.
    let last = unit::words(unit::before_brackets(name)).pop();
    let texts = [
        own.to_owned(),
        english(own),
        last.unwrap_or_default().to_owned(),
    ];
    let words = texts.iter().flat_map(|text| unit::words(text));
    let words: Vec<String> = words.map(str::to_lowercase).collect();
    let is_of = |key: &str| key == signal || key.starts_with('_') && signal.ends_with(key);
    let others = OF_OTHERS
        .iter()
        .filter(|(keys, _)| keys.split(' ').any(is_of));
    let all = others.map(|(_, words)| *words).chain([NO_MEASUREMENT]);
    let mut all = all.flat_map(|words| words.split(' '));
    all.any(|other| words.iter().any(|word| word == other))
}

/// Whether a column of this name may be a measurement of this signal.
pub(super) fn may_be(signal: &str, name: &str) -> bool {
    !is_other(signal, name) && !OTHERS.split(", ").any(|word| english(name).contains(word))
}

/// Whether a name contains an entry of [`WORDS`].
fn has(name: &str, word: &str) -> bool {
    if let Some(word) = word.strip_prefix('=') {
        return unit::without(name).replace([' ', '-'], "_") == word;
    }
    if let Some(si) = word.strip_prefix('[') {
        return unit::is_of(name, si);
    }
    if let Some(word) = word.strip_prefix('|') {
        return unit::words(name).contains(&word);
    }
    let Some(word) = word.strip_prefix('^') else {
        return name.contains(word);
    };
    let mut found = name.match_indices(word);
    found.any(|(at, _)| !name[..at].ends_with(char::is_alphabetic))
}

/// A part of words for a pressure.
const PRESSURE: &str = "press";
/// The sides of a cylinder: after the name of a link, without another quantity, they mean its pressures (`boom head`).
const SIDES: [&str; 2] = ["head", "rod"];
/// Other quantities of a side of a cylinder.
const OF_A_SIDE: [&str; 9] = [
    "angle", "pos", "position", "stroke", "length", "force", "area", "speed", "diameter",
];

/// A name in small letters and English, with the word for a pressure if its unit, or a side of a cylinder, means one.
fn with_pressure(name: &str) -> String {
    let english_name = english(name);
    let apart = english(&unit::words(name).join(" "));
    if english_name.contains(PRESSURE) {
        // In `BoomHeadPressure` the side is a separate word too.
        return format!("{english_name} {apart}");
    }
    let words = unit::words(unit::before_brackets(&apart));
    let has = |all: &[&str]| words.iter().any(|word| all.contains(word));
    let alone = || has(&SIDES) && !has(&OF_A_SIDE) && unit::foreign(name, "Pa").is_none();
    match unit::is_of(name, "Pa") || alone() {
        true => format!("{PRESSURE} {apart}"),
        false => english_name,
    }
}

/// Words for the cap side of a cylinder that call the other side its head, as in Japan and Korea.
const BOTTOMS: [&str; 4] = ["bottom", "btm", "ボトム", "보텀"];

/// Words of the links whose cylinders have sides.
const LINKS: [&str; 8] = [
    "boom", "arm", "stick", "dipper", "lift", "hoist", "tilt", "bucket",
];

/// For each name, whether it is a pressure at the head of a cylinder and means the side of the rod: of the same link, another name
/// calls the other side the bottom, and none has a rod.
pub(super) fn heads_of_rods(names: &[&str]) -> Vec<bool> {
    let side = |name: &&str| {
        let translated = with_pressure(name);
        let words = unit::words(&translated);
        let is_bottom = BOTTOMS
            .iter()
            .any(|word| name.to_lowercase().contains(word));
        let side = match () {
            () if !translated.contains(PRESSURE) => None,
            () if is_bottom => Some("bottom"),
            () => SIDES.into_iter().find(|side| words.contains(side)),
        };
        let link = LINKS.into_iter().find(|link| words.contains(link));
        side.map(|side| (link, side))
    };
    let sides: Vec<_> = names.iter().map(side).collect();
    let is_of_rod = |(link, side): (Option<&str>, &str)| {
        let has = |other: &str| sides.contains(&Some((link, other)));
        side == "head" && has("bottom") && !has("rod")
    };
    sides
        .iter()
        .map(|side| side.is_some_and(is_of_rod))
        .collect()
}

/// Whether the name of a column means a pressure.
pub(super) fn is_pressure(name: &str) -> bool {
    with_pressure(name).contains(PRESSURE)
}

/// Index of the free name that fits a signal best: heft's own name, else the first
/// with its words.
pub(crate) fn fitting(signal: &str, names: &[&str], taken: &[usize]) -> Option<usize> {
    let free = |at: &usize| !taken.contains(at);
    let lower: Vec<String> = names.iter().map(|n| n.to_lowercase()).collect();
    let own = lower.iter().position(|n| {
        let n = unit::before_brackets(n).trim();
        n == signal || n.trim_end_matches("_s") == signal
    });
    if let Some(at) = own.filter(free) {
        return Some(at);
    }
    let of_rods = heads_of_rods(names);
    let lower = names.iter().zip(&of_rods).map(|(name, is_of_rod)| {
        let name = with_pressure(name);
        match is_of_rod {
            true => name.replace("head", "rod"),
            false => name,
        }
    });
    let lower: Vec<String> = lower.collect();
    let rows = WORDS
        .lines()
        .filter_map(|row| row.strip_prefix(signal)?.strip_prefix(": "));
    rows.flat_map(|row| row.split(", ")).find_map(|words| {
        // `boom_head_pressure` is no angle of the boom.
        let fits = |n: &String| {
            words.split(" + ").all(|w| has(n, w))
                && n.contains(PRESSURE) == signal.contains(PRESSURE)
        };
        let mut free = (0..lower.len()).filter(free);
        free.find(|at| fits(&lower[*at]) && may_be(signal, names[*at]))
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
            ("swing_velocity", "qd_swing"),
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
    fn what_is_no_measurement_of_a_signal_is_not_taken_for_it() {
        for (signal, other, own) in [
            ("boom_angle", "Boom rate", "Boom"),
            (
                "swing_velocity",
                "Schwenkrate_Soll [°/s]",
                "Schwenkrate_Ist [°/s]",
            ),
            ("bucket_angle", "bucket_angle_sp", "bucket_angle_act"),
            ("arm_angle", "arm_angle_offset", "arm_angle_act"),
            ("swing_torque", "left_swing_torque", "swing_torque_sum"),
            ("boom_angle", "Boom cylinder stroke", "Boom"),
            ("boom_angle", "Boom angle target [deg]", "Boom [deg]"),
            ("boom_angle", "Boom angle min", "Boom angle"),
            (
                "swing_torque",
                "Swing torque limit [kNm]",
                "Swing torque [kNm]",
            ),
            (
                "swing_velocity",
                "Status Swing rate",
                "Status.Swing rate [deg/s]",
            ),
            ("swing_velocity", "SwingRateValid", "SwingRate"),
            ("pitch", "Pitch rate [deg/s]", "Pitch [deg]"),
            ("roll", "Controller state", "IMU_roll"),
            ("acceleration", "AccelPedalPos1", "LongAccel"),
            ("mass", "Payload mass [kg]", "Vehicle mass [kg]"),
            ("articulation", "Steering wheel angle", "Steer angle"),
            ("slope", "Lift arm inclination", "Inclination"),
            ("lift_angle", "Lift arm velocity", "Lift arm"),
            ("t", "Cycle time [s]", "Time [s]"),
            ("swing_velocity", "Swing motor speed [rpm]", "Swing [rpm]"),
            (
                "swing_velocity",
                "Rotation moteur",
                "Rotation tourelle [°/s]",
            ),
            (
                "swing_torque",
                "swing.velocity",
                "joint_states/swing/effort",
            ),
            ("swing_torque", "swing.w", "excavator.swing.tau"),
            ("swing_velocity", "swing.tau", "excavator.swingJoint.w"),
            (
                "front_wheel_speed",
                "Front engine speed [rpm]",
                "Front wheel [rpm]",
            ),
        ] {
            assert_eq!(fitting(signal, &[other, own], &[]), Some(1), "{other}");
            assert_eq!(fitting(signal, &[other], &[]), None, "{other}");
        }
    }

    #[test]
    fn the_head_beside_a_bottom_is_the_side_of_the_rod() {
        let (bottom, head) = (
            "Boom cyl. bottom press. (MPa)",
            "Boom cyl. head press. (MPa)",
        );
        for names in [
            ["x", bottom, head],
            ["x", "ブームボトム圧", "ブームヘッド圧"],
            ["x", "BoomBtmPrs", "BoomHeadPrs"],
        ] {
            let exchanged = [names[0], names[2], names[1]];
            for (names, [of_head, of_rod]) in [(names, [1, 2]), (exchanged, [2, 1])] {
                let at = |signal| fitting(signal, &names, &[]);
                assert_eq!(at("boom_head_pressure"), Some(of_head), "{names:?}");
                assert_eq!(at("boom_rod_pressure"), Some(of_rod), "{names:?}");
            }
        }
        let names = ["boom_head", "boom_bottom", "stick_rod"];
        assert_eq!(fitting("boom_rod_pressure", &names, &[]), Some(0));
        assert_eq!(fitting("arm_rod_pressure", &names, &[]), Some(2));
        let names = ["Boom bottom [bar]", "Boom rod [bar]", "Arm head [bar]"];
        assert_eq!(fitting("arm_head_pressure", &names, &[]), Some(2));
        assert_eq!(fitting("boom_head_pressure", &[head], &[]), Some(0));
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

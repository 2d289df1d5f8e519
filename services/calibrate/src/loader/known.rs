//! What is known of the parameters of a loader before its recordings.

use config::Loader as Description;
use estimation::Quantity;

use super::drive::Drive;
use super::guess::{Guess, Scatter};
use super::residuals::LONGEST_DELAY;
use super::role::{Role, Told};
use crate::parameter::{Parameter, Source};

/// Tolerances where the description states none, or less than what only a calibration can know.
const GAIN_STD: f64 = 0.02;
const SENSITIVITY_STD: f64 = 0.3;
const ROLLING_STD: f64 = 0.3;
const FRICTION_STD: f64 = 0.2;
const TORQUE_DELAY_STD: f64 = 0.02;
const RELAXATION_STD: f64 = 0.05;
/// Mass of a machine against its data sheet, and against a mass that was measured on board.
pub const MASS_STD: f64 = 0.02;
/// Where a load lies ahead of the front axle, as a share of the way to the bucket's tip, and how high, as a share of the height of
/// the empty machine's centre of gravity: value and tolerance.
const REACH: (f64, f64) = (0.75, 0.2);
const LIFT: (f64, f64) = (0.8, 0.5);
/// Of the shift at which two drives fit best [m].
const MARK_STD: f64 = 0.5;
/// Scatter within a factor of e^1.5 or so, and usual values.
const SCATTER_STD: f64 = 1.5;
const SCATTER: Scatter = Scatter {
    wheels: 1e-3,
    speed: 3e-3,
    force: 0.01,
    motion: 5e-3,
    way: 1e-3,
};

/// What no recording changes, and where the guesses begin.
pub fn described(d: &Description) -> Guess {
    let m = &d.machine;
    Guess {
        mass: m.mass,
        ratio: d.prior.cg_ratio,
        height: d.prior.cg_height,
        radius: m.wheel_radius,
        radius_errors: [d.prior.front_radius_error, d.prior.rear_radius_error],
        load_sensitivity: m.radius_load_sensitivity,
        stiffness: d.prior.slip_stiffness,
        stiffness_ratio: m.stiffness_ratio,
        load_exponent: m.stiffness_load_exponent,
        friction: if m.friction > 0.0 {
            m.friction
        } else {
            f64::INFINITY
        },
        torque_gains: [d.sensors.front_torque_gain, d.sensors.rear_torque_gain],
        rolling_resistance: m.rolling_resistance,
        slope_bias: d.prior.slope_bias,
        acceleration_offset: d.sensors.acceleration_offset,
        slope_delay: d.sensors.slope_delay,
        slope_follows: d.sensors.slope_follows,
        speed_delay: d.sensors.speed_delay,
        torque_delay: 0.0,
        relaxation_length: m.relaxation_length,
        axle_inertia: m.axle_inertia,
        wheelbase: m.wheelbase,
        scatter: SCATTER,
    }
}

/// Scatter of the slopes there and back.
pub fn way_scatter() -> Parameter {
    Parameter::noise(
        "scatter of the way",
        "the scatter of the slopes there and back",
        "rad",
        SCATTER.way,
        SCATTER_STD,
    )
}

/// What is left of the shift between the marks of a way.
pub fn mark(there: &str, back: &str) -> Parameter {
    Parameter::described(
        &format!("mark, {back}"),
        &format!("how far {back} set out from the mark of {there}"),
        "m",
        0.0,
        MARK_STD,
        (-10.0 * MARK_STD, 10.0 * MARK_STD),
    )
}

/// The parameters of recordings with these loads: what each is, and what is known of it.
pub fn parameters(drives: &[Drive], loads: &[Told], d: &Description) -> Vec<(Role, Parameter)> {
    let g = described(d);
    let (m, p, s) = (&d.machine, &d.prior, &d.sensors);
    let linear = Parameter::described;
    let noise =
        |key: &str, words: &str, unit, mean| Parameter::noise(key, words, unit, mean, SCATTER_STD);
    let radius =
        |key: &str, words: &str, mean| linear(key, words, "", mean, p.radius_std, (-0.2, 0.2));
    let gain_std = s.torque_gain_std.max(GAIN_STD);
    let gain = |key: &str, words: &str, mean| linear(key, words, "", mean, gain_std, (0.2, 5.0));
    let sensitivity_std = m
        .radius_load_sensitivity_std
        .max(SENSITIVITY_STD * m.radius_load_sensitivity)
        .max(1e-4);
    let mut all = vec![
        (
            Role::FrontRadius,
            radius(
                "prior.front_radius_error",
                "the error of the front rolling radius",
                g.radius_errors[0],
            ),
        ),
        (
            Role::RearRadius,
            radius(
                "prior.rear_radius_error",
                "the error of the rear rolling radius",
                g.radius_errors[1],
            ),
        ),
        (
            Role::LoadSensitivity,
            linear(
                "machine.radius_load_sensitivity",
                "the load sensitivity of the rolling radius",
                "",
                m.radius_load_sensitivity,
                sensitivity_std,
                (0.0, 0.2),
            ),
        ),
        (
            Role::FrontGain,
            gain(
                "sensors.front_torque_gain",
                "the gain of the front torque",
                g.torque_gains[0],
            ),
        ),
        (
            Role::RearGain,
            gain(
                "sensors.rear_torque_gain",
                "the gain of the rear torque",
                g.torque_gains[1],
            ),
        ),
        (
            Role::Stiffness,
            linear(
                "prior.slip_stiffness",
                "the slip stiffness",
                "",
                p.slip_stiffness,
                p.slip_stiffness_std,
                (0.2 * p.slip_stiffness, 5.0 * p.slip_stiffness),
            ),
        ),
        (
            Role::StiffnessRatio,
            linear(
                "machine.stiffness_ratio",
                "the slip stiffness in front over that behind",
                "",
                m.stiffness_ratio,
                m.stiffness_ratio_std.max(1e-3),
                (0.1, 10.0),
            ),
        ),
        (
            Role::LoadExponent,
            linear(
                "machine.stiffness_load_exponent",
                "the fall of the slip stiffness with the load",
                "",
                m.stiffness_load_exponent,
                m.stiffness_load_exponent_std.max(1e-3),
                (-1.0, 1.0),
            ),
        ),
        (
            Role::Rolling,
            linear(
                "machine.rolling_resistance",
                "the rolling resistance",
                "",
                m.rolling_resistance,
                (ROLLING_STD * m.rolling_resistance).max(1e-3),
                (0.0, 1.0),
            ),
        ),
        (
            Role::SlopeBias,
            linear(
                "prior.slope_bias",
                "the zero of the slope",
                "rad",
                p.slope_bias,
                p.slope_bias_std,
                (-0.5, 0.5),
            ),
        ),
        (
            Role::SlopeDelay,
            linear(
                "sensors.slope_delay",
                "the delay of the slope",
                "s",
                s.slope_delay,
                s.slope_delay_std,
                (-0.2, 5.0),
            ),
        ),
        (
            Role::SpeedDelay,
            linear(
                "sensors.speed_delay",
                "the delay of the speed",
                "s",
                s.speed_delay,
                s.speed_delay_std,
                (-0.1, LONGEST_DELAY),
            ),
        ),
        (
            Role::TorqueDelay,
            linear(
                "sensors.torque_delay",
                "the delay of the torques",
                "s",
                0.0,
                TORQUE_DELAY_STD,
                (-0.2, 0.2),
            ),
        ),
        (
            Role::Relaxation,
            linear(
                "machine.relaxation_length",
                "the relaxation length of the tyres",
                "m",
                m.relaxation_length,
                RELAXATION_STD,
                (0.0, 2.0),
            ),
        ),
        (
            Role::WheelScatter,
            noise(
                "scatter of the wheels",
                "the scatter between the wheels",
                "m/s",
                SCATTER.wheels,
            ),
        ),
        (
            Role::SpeedScatter,
            noise(
                "scatter of the speed",
                "the scatter of the speed",
                "m/s",
                SCATTER.speed,
            ),
        ),
        (
            Role::MotionScatter,
            noise(
                "scatter of the motion",
                "the scatter of the motion",
                "m/s",
                SCATTER.motion,
            ),
        ),
    ];
    if drives.iter().any(|drive| drive.has_acceleration) {
        let parameter = noise(
            "scatter of the force",
            "the scatter of the balance of force",
            "m/s^2",
            SCATTER.force,
        );
        all.push((Role::ForceScatter, parameter));
        let parameter = linear(
            "sensors.slope_follows",
            "the share of the acceleration that the slope sensor follows",
            "",
            s.slope_follows,
            s.slope_follows_std,
            (-0.3, 0.9),
        );
        all.push((Role::SlopeFollows, parameter));
        let parameter = linear(
            "sensors.acceleration_offset",
            "the zero of the accelerometer",
            "m/s^2",
            s.acceleration_offset,
            s.acceleration_offset_std,
            (-2.0, 2.0),
        );
        all.push((Role::AccelerationOffset, parameter));
    }
    if m.friction > 0.0 {
        let parameter = linear(
            "machine.friction",
            "the limit of the tyres' friction",
            "",
            m.friction,
            FRICTION_STD * m.friction,
            (0.3 * m.friction, 3.0 * m.friction),
        );
        all.push((Role::Friction, parameter));
    }
    for (l, told) in loads.iter().enumerate() {
        let of = |empty: &str, what: &str| match l {
            0 => (empty.to_owned(), format!("the {what} without load")),
            _ => (
                format!("load {l}, {what}"),
                format!("the {what} with load {l}"),
            ),
        };
        let known = |parameter: Parameter, told: Option<Quantity>| match told {
            Some(q) => Parameter {
                mean: q.value,
                std: q.std.max(1e-4 * q.value),
                source: Source::Measured,
                ..parameter
            },
            None => parameter,
        };
        let (key, words) = of("machine.mass", "mass");
        let mass = told.mass.map_or(m.mass, |q| q.value);
        let range = (0.3 * mass, 3.0 * mass);
        let parameter = linear(&key, &words, "kg", m.mass, MASS_STD * m.mass, range);
        all.push((Role::Mass(l), known(parameter, told.mass)));
        if l == 0 || told.ratio.is_some() {
            let (key, words) = of("prior.cg_ratio", "share of the weight in front");
            let parameter = linear(&key, &words, "", p.cg_ratio, p.cg_ratio_std, (0.05, 0.95));
            all.push((Role::Ratio(l), known(parameter, told.ratio)));
        } else {
            let words = format!("how far load {l} lies ahead of the front axle");
            let (mean, std) = (REACH.0 * m.bucket_reach, REACH.1 * m.bucket_reach);
            let range = (-m.wheelbase, 2.0 * m.bucket_reach);
            let parameter = linear(&format!("load {l}, reach"), &words, "m", mean, std, range);
            all.push((Role::Reach(l), parameter));
        }
        if l == 0 || told.height.is_some() {
            let (key, words) = of("prior.cg_height", "height of the centre of gravity");
            let parameter = linear(
                &key,
                &words,
                "m",
                p.cg_height,
                p.cg_height_std,
                (0.05, 10.0),
            );
            all.push((Role::Height(l), known(parameter, told.height)));
        } else {
            let words = format!("how high load {l} lies");
            let (mean, std) = (LIFT.0 * p.cg_height, LIFT.1 * p.cg_height);
            let range = (0.0, 10.0);
            let parameter = linear(&format!("load {l}, height"), &words, "m", mean, std, range);
            all.push((Role::Lift(l), parameter));
        }
    }
    all
}

//! Priors of a loader's parameters.

use config::Loader as Description;
use estimation::Quantity;
use estimation::loader::Machine;

use super::drive::Drive;
use super::guess::{Guess, Scatter};
use super::residuals::LONGEST_DELAY;
use super::role::{Role, StatedLoad};
use crate::parameter::{Parameter, Source, rows};

/// Tolerances where the description states none, or ones too narrow before a calibration.
const GAIN_STD: f64 = 0.02;
const SENSITIVITY_STD: f64 = 0.3;
const ROLLING_STD: f64 = 0.3;
const FRICTION_STD: f64 = 0.2;
const TORQUE_DELAY_STD: f64 = 0.02;
/// Usual relaxation length of a tyre, in radii, and its standard deviation: .3 to .7 of a radius, longer at low pressure (Pacejka, Tyre and
/// Vehicle Dynamics, 2012, ch. 5 and 7).
const RELAXATION: (f64, f64) = (0.5, 0.2);
/// Standard deviation of the pitch of the chassis by the specific force [rad per g]: on tyres that a standing machine presses in by
/// d = 40 mm, at a wheelbase of l = 3 m and a height of h = 1.1 m, 4 d h/l^2.
const SQUAT_STD: f64 = 0.02;
/// Standard deviation of the pitch under a load over that by the springs of an acceleration. These are those of both axles, a load presses
/// mostly on the front one. Its tyres are .5 to 2 times as stiff as the rear ones, and stiffen by a half from their empty load to twice that.
const SETTLING_STD: f64 = 0.25;
/// Relative standard deviation of the described mass, and of a mass that was measured on board.
pub const MASS_STD: f64 = 0.02;
/// Value and tolerance of the position of a load ahead of the front axle, as a share of the distance to the bucket's tip. Value and
/// tolerance of its height, as a share of the height of the empty machine's centre of gravity.
const REACH: (f64, f64) = (0.75, 0.2);
const LIFT: (f64, f64) = (0.8, 0.5);
/// Largest height of a load, as a share of the same: that of a full bucket lifted to the edge of a truck.
const HIGHEST: f64 = 3.0;
/// Standard deviation of the share of a brush's curve: tyres lie between both.
const BRUSH_STD: f64 = 0.5;
/// Variance of an axle's load on bumps, over its mean load's square, and its standard deviation: 15 % in rms. A machine without
/// springs heaves and pitches on its tyres by 5 to 25 %.
const LOAD_VARIANCE: f64 = 0.0225;
/// Standard deviation of the offset at which two drives match best [m].
const MARK_STD: f64 = 0.5;
/// Standard deviation of the logarithm of a scatter, and usual values.
const SCATTER_STD: f64 = 1.5;
const SCATTER: Scatter = Scatter {
    wheels: 1e-3,
    speed: 3e-3,
    force: 0.01,
    motion: 5e-3,
    path: 1e-3,
};

/// The stated relaxation length, or that of a usual tyre [m]: the default of the key is for the noise of a row, not for a size.
fn relaxation_length(m: &Machine) -> f64 {
    if m.relaxation_length == Machine::DEFAULT.relaxation_length {
        RELAXATION.0 * m.wheel_radius
    } else {
        m.relaxation_length
    }
}

/// Values that no recording changes, and initial values of the others.
pub fn described(d: &Description) -> Guess {
    let m = &d.machine;
    Guess {
        mass: m.mass,
        empty_mass: m.mass,
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
        brush: 0.0,
        load_variance: 0.0,
        torque_gains: [d.sensors.front_torque_gain, d.sensors.rear_torque_gain],
        rolling_resistance: m.rolling_resistance,
        slope_bias: d.prior.slope_bias,
        acceleration_offset: d.sensors.acceleration_offset,
        slope_delay: d.sensors.slope_delay,
        slope_sensitivity: d.sensors.slope_acceleration_sensitivity,
        squat: 0.0,
        speed_delay: d.sensors.speed_delay,
        torque_delay: 0.0,
        relaxation_length: relaxation_length(m),
        axle_inertia: m.axle_inertia,
        wheelbase: m.wheelbase,
        scatter: SCATTER,
    }
}

/// Scatter of the slopes out and back.
pub fn path_scatter() -> Parameter {
    Parameter::noise(
        "scatter of the way",
        "the scatter of the slopes out and back",
        "rad",
        SCATTER.path,
        SCATTER_STD,
    )
}

/// Remaining offset between the marks of a path.
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

/// The parameters of recordings with these loads: roles and priors.
pub fn parameters(
    drives: &[Drive],
    loads: &[StatedLoad],
    d: &Description,
) -> Vec<(Role, Parameter)> {
    let mut all = of_machine(d);
    all.extend(scatters());
    if loads.len() > 1 && drives.iter().any(|drive| drive.has_acceleration) {
        all.extend(rows! {
            Role::Settling, "settling", "the pitch of the chassis under a load over that by its squat", "",
                1.0, SETTLING_STD, (0.0, 4.0);
        });
    }
    if drives.iter().any(|drive| drive.has_acceleration) {
        all.extend(of_accelerometer(d));
    }
    let friction = d.machine.friction;
    if friction > 0.0 {
        all.extend(rows! {
            Role::Friction, "machine.friction", "the friction coefficient of the tyres", "",
                friction, FRICTION_STD * friction, (0.3 * friction, 3.0 * friction);
            Role::Brush, "brush", "the share of a brush's curve of the slip", "",
                0.0, BRUSH_STD, (-1.0, 2.0);
        });
    }
    let numbered = loads.iter().enumerate();
    all.extend(numbered.flat_map(|(l, stated)| of_load(l, stated, d)));
    all
}

/// Parameters of the machine and its sensors, for every recording.
fn of_machine(d: &Description) -> Vec<(Role, Parameter)> {
    let (m, p, s) = (&d.machine, &d.prior, &d.sensors);
    let gain_std = s.torque_gain_std.max(GAIN_STD);
    let sensitivity = m.radius_load_sensitivity;
    let sensitivity_std = m
        .radius_load_sensitivity_std
        .max(SENSITIVITY_STD * sensitivity)
        .max(1e-4);
    let stiffness = p.slip_stiffness;
    let rolling_std = (ROLLING_STD * m.rolling_resistance).max(1e-3);
    let rows = rows! {
        Role::FrontRadius, "prior.front_radius_error", "the relative error of the front rolling radius", "",
            p.front_radius_error, p.radius_std, (-0.2, 0.2);
        Role::RearRadius, "prior.rear_radius_error", "the relative error of the rear rolling radius", "",
            p.rear_radius_error, p.radius_std, (-0.2, 0.2);
        Role::LoadSensitivity, "machine.radius_load_sensitivity", "the load sensitivity of the rolling radius", "",
            sensitivity, sensitivity_std, (0.0, 0.2);
        Role::FrontGain, "sensors.front_torque_gain", "the gain of the front torque", "",
            s.front_torque_gain, gain_std, (0.2, 5.0);
        Role::RearGain, "sensors.rear_torque_gain", "the gain of the rear torque", "",
            s.rear_torque_gain, gain_std, (0.2, 5.0);
        Role::Stiffness, "prior.slip_stiffness", "the slip stiffness", "",
            stiffness, p.slip_stiffness_std, (0.2 * stiffness, 5.0 * stiffness);
        Role::StiffnessRatio, "machine.stiffness_ratio", "the front to rear ratio of the slip stiffness", "",
            m.stiffness_ratio, m.stiffness_ratio_std.max(1e-3), (0.1, 10.0);
        Role::LoadExponent, "machine.stiffness_load_exponent", "the load exponent of the slip stiffness", "",
            m.stiffness_load_exponent, m.stiffness_load_exponent_std.max(1e-3), (-1.0, 1.0);
        Role::LoadVariance, "load variance", "the variance of the axle loads on bumps", "",
            LOAD_VARIANCE, LOAD_VARIANCE, (0.0, 0.3);
        Role::Rolling, "machine.rolling_resistance", "the rolling resistance", "",
            m.rolling_resistance, rolling_std, (0.0, 1.0);
        Role::SlopeBias, "prior.slope_bias", "the bias of the slope sensor", "rad",
            p.slope_bias, p.slope_bias_std, (-0.5, 0.5);
        Role::SlopeDelay, "sensors.slope_delay", "the delay of the slope sensor", "s",
            s.slope_delay, s.slope_delay_std, (-0.2, 5.0);
        Role::SpeedDelay, "sensors.speed_delay", "the delay of the speed", "s",
            s.speed_delay, s.speed_delay_std, (-0.1, LONGEST_DELAY);
        Role::TorqueDelay, "sensors.torque_delay", "the delay of the torques", "s",
            0.0, TORQUE_DELAY_STD, (-0.2, 0.2);
        Role::Relaxation, "machine.relaxation_length", "the relaxation length of the tyres", "m",
            relaxation_length(m), RELAXATION.1 * m.wheel_radius, (0.0, 2.0);
    };
    rows.into()
}

fn noise(key: &str, words: &str, unit: &'static str, mean: f64) -> Parameter {
    Parameter::noise(key, words, unit, mean, SCATTER_STD)
}

/// Scatter parameters, for every recording.
fn scatters() -> [(Role, Parameter); 3] {
    let (wheels, speed) = ("scatter of the wheels", "scatter of the speed");
    let motion = "scatter of the motion";
    [
        (
            Role::WheelScatter,
            noise(
                wheels,
                "the noise of the wheel speeds' difference",
                "m/s",
                SCATTER.wheels,
            ),
        ),
        (
            Role::SpeedScatter,
            noise(speed, "the noise of the speed", "m/s", SCATTER.speed),
        ),
        (
            Role::MotionScatter,
            noise(motion, "the unmodelled motion", "m/s", SCATTER.motion),
        ),
    ]
}

/// Parameters of an accelerometer.
fn of_accelerometer(d: &Description) -> Vec<(Role, Parameter)> {
    let s = &d.sensors;
    let words = "the unmodelled force per mass";
    let force = noise("scatter of the force", words, "m/s^2", SCATTER.force);
    let mut all = vec![(Role::ForceScatter, force)];
    all.extend(rows! {
        Role::SlopeFollows, "sensors.slope_acceleration_sensitivity", "the sensitivity of the slope sensor to acceleration", "",
            s.slope_acceleration_sensitivity, s.slope_acceleration_sensitivity_std, (-0.3, 0.9);
        Role::AccelerationOffset, "sensors.acceleration_offset", "the bias of the accelerometer", "m/s^2",
            s.acceleration_offset, s.acceleration_offset_std, (-2.0, 2.0);
        Role::Squat, "squat", "the pitch of the chassis by the specific force", "rad/g",
            0.0, SQUAT_STD, (-0.1, 0.2);
    });
    all
}

/// A parameter with its stated value, if there is one, which counts as data.
fn measured(parameter: Parameter, stated: Option<Quantity>) -> Parameter {
    match stated {
        Some(q) => Parameter {
            mean: q.value,
            std: q.std.max(1e-4 * q.value),
            source: Source::Measured,
            ..parameter
        },
        None => parameter,
    }
}

/// Parameters of the machine with load `l`: mass, front share, height; without axle weights the position of the load instead.
fn of_load(l: usize, stated: &StatedLoad, d: &Description) -> [(Role, Parameter); 3] {
    let (m, p) = (&d.machine, &d.prior);
    let of = |empty: &str, what: &str| match l {
        0 => (empty.to_owned(), format!("the {what} without load")),
        _ => (
            format!("load {l}, {what}"),
            format!("the {what} with load {l}"),
        ),
    };
    let linear = Parameter::described;
    let (key, words) = of("machine.mass", "mass");
    let mass = stated.mass.map_or(m.mass, |q| q.value);
    let range = (0.3 * mass, 3.0 * mass);
    let mass = linear(&key, &words, "kg", m.mass, MASS_STD * m.mass, range);
    let ratio = if l == 0 || stated.ratio.is_some() {
        let (key, words) = of("prior.cg_ratio", "front-axle load fraction");
        let ratio = linear(&key, &words, "", p.cg_ratio, p.cg_ratio_std, (0.05, 0.95));
        (Role::Ratio(l), measured(ratio, stated.ratio))
    } else {
        let words = format!("the distance of load {l} ahead of the front axle");
        let usual = Quantity {
            value: REACH.0 * m.bucket_reach,
            std: REACH.1 * m.bucket_reach,
        };
        let Quantity { value: mean, std } = stated.reach.unwrap_or(usual);
        let range = (-m.wheelbase, 2.0 * m.bucket_reach);
        (
            Role::Reach(l),
            linear(&format!("load {l}, reach"), &words, "m", mean, std, range),
        )
    };
    let height = if l == 0 || stated.height.is_some() {
        let (key, words) = of("prior.cg_height", "height of the centre of gravity");
        let height = linear(
            &key,
            &words,
            "m",
            p.cg_height,
            p.cg_height_std,
            (0.05, 10.0),
        );
        (Role::Height(l), measured(height, stated.height))
    } else {
        let words = format!("the height of load {l} above the ground");
        let usual = Quantity {
            value: LIFT.0 * p.cg_height,
            std: LIFT.1 * p.cg_height,
        };
        let Quantity { value: mean, std } = stated.lift.unwrap_or(usual);
        (
            Role::Lift(l),
            linear(
                &format!("load {l}, height"),
                &words,
                "m",
                mean,
                std,
                (0.0, HIGHEST * p.cg_height),
            ),
        )
    };
    [(Role::Mass(l), measured(mass, stated.mass)), ratio, height]
}

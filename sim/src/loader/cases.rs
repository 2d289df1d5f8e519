//! The effects one at a time, at the severities that machines have, and together.

use super::effects::{Effects, PayloadReport};

const NONE: Effects = Effects {
    speed_delay: 0.0,
    spins: false,
    brakes: 0.0,
    brakes_reported: true,
    steering: 0.0,
    steering_reported: true,
    hinge: 0.0,
    locked_drive: false,
    slope_follows: 0.0,
    slope_lag: 0.0,
    gear_delay: 0.0,
    stiffness_difference: 0.0,
    stiffness_exponent: 0.0,
    radius_sensitivity: 0.0,
    braking_stiffness: 0.0,
    roughness: 0.0,
    rolling_resistance: 0.0,
    reverses: false,
    torque_gain: 0.0,
    rear_torque_gain: 0.0,
    speed_gain: 0.0,
    front_speed_gain: 0.0,
    torque_delay: 0.0,
    slope_bias: 0.0,
    acceleration_offset: 0.0,
    speed_period: 0.0,
    jitter: 0.0,
    mass_error: 0.0,
    radius_error: 0.0,
    payload_reported: PayloadReport::All,
};

const fn late(speed_delay: f64) -> Effects {
    Effects {
        speed_delay,
        ..NONE
    }
}

const fn brakes(brakes: f64, brakes_reported: bool) -> Effects {
    Effects {
        brakes,
        brakes_reported,
        ..NONE
    }
}

const fn steering(steering: f64) -> Effects {
    Effects {
        steering,
        hinge: 0.1,
        ..NONE
    }
}

const fn payload(payload_reported: PayloadReport) -> Effects {
    Effects {
        payload_reported,
        ..NONE
    }
}

/// What machines at work do that their description does not say: name, severity in words, effects. The first does
/// nothing of the kind.
pub const CASES: [(&str, &str, Effects); 39] = [
    ("none", "", NONE),
    ("late speed", "30 ms", late(0.03)),
    ("late speed", "100 ms", late(0.1)),
    ("brakes", "20 %", brakes(0.2, true)),
    ("brakes", "50 %", brakes(0.5, true)),
    ("brakes, not stated", "50 %", brakes(0.5, false)),
    ("steering", "10 deg", steering(0.175)),
    ("steering", "20 deg", steering(0.349)),
    (
        "locked drive",
        "",
        Effects {
            locked_drive: true,
            ..NONE
        },
    ),
    (
        "slope sensor follows",
        "30 %, 0.2 s",
        Effects {
            slope_follows: 0.3,
            slope_lag: 0.2,
            ..NONE
        },
    ),
    (
        "gear changes late",
        "50 ms",
        Effects {
            gear_delay: 0.05,
            ..NONE
        },
    ),
    (
        "stiffness of the axles",
        "10 %",
        Effects {
            stiffness_difference: 0.1,
            ..NONE
        },
    ),
    (
        "stiffness falls with load",
        "p .2",
        Effects {
            stiffness_exponent: 0.2,
            ..NONE
        },
    ),
    (
        "radius sensitivity",
        "+.005",
        Effects {
            radius_sensitivity: 0.005,
            ..NONE
        },
    ),
    (
        "braking stiffness",
        "-10 %",
        Effects {
            braking_stiffness: -0.1,
            ..NONE
        },
    ),
    (
        "braking stiffness",
        "+10 %",
        Effects {
            braking_stiffness: 0.1,
            ..NONE
        },
    ),
    (
        "rough road",
        "ISO 8608 C",
        Effects {
            roughness: 256e-6,
            ..NONE
        },
    ),
    (
        "rough road",
        "ISO 8608 D",
        Effects {
            roughness: 1024e-6,
            ..NONE
        },
    ),
    (
        "rolling resistance",
        "+.03 in patches",
        Effects {
            rolling_resistance: 0.03,
            ..NONE
        },
    ),
    (
        "reversing",
        "",
        Effects {
            reverses: true,
            ..NONE
        },
    ),
    (
        "torque gain",
        "+6 %",
        Effects {
            torque_gain: 0.06,
            ..NONE
        },
    ),
    (
        "torque gain",
        "-6 %",
        Effects {
            torque_gain: -0.06,
            ..NONE
        },
    ),
    (
        "rear axle torque",
        "+20 %",
        Effects {
            rear_torque_gain: 0.2,
            ..NONE
        },
    ),
    (
        "rear axle torque",
        "-15 %",
        Effects {
            rear_torque_gain: -0.15,
            ..NONE
        },
    ),
    (
        "rear axle torque",
        "-30 %",
        Effects {
            rear_torque_gain: -0.3,
            ..NONE
        },
    ),
    (
        "speed too low",
        "5 %",
        Effects {
            speed_gain: -0.05,
            ..NONE
        },
    ),
    (
        "front wheel speed",
        "+10 %",
        Effects {
            front_speed_gain: 0.1,
            ..NONE
        },
    ),
    (
        "late torque",
        "20 ms",
        Effects {
            torque_delay: 0.02,
            ..NONE
        },
    ),
    (
        "slope bias",
        "4 deg",
        Effects {
            slope_bias: 0.07,
            ..NONE
        },
    ),
    (
        "speed every",
        "200 ms",
        Effects {
            speed_period: 0.2,
            ..NONE
        },
    ),
    (
        "jitter",
        "10 ms",
        Effects {
            jitter: 0.01,
            ..NONE
        },
    ),
    (
        "mass",
        "+20 %",
        Effects {
            mass_error: 0.2,
            ..NONE
        },
    ),
    (
        "mass",
        "-20 %",
        Effects {
            mass_error: -0.2,
            ..NONE
        },
    ),
    (
        "radius",
        "+2 %",
        Effects {
            radius_error: 0.02,
            ..NONE
        },
    ),
    (
        "radius",
        "-2 %",
        Effects {
            radius_error: -0.02,
            ..NONE
        },
    ),
    (
        "reversing",
        "radius sensitivity -.005",
        Effects {
            reverses: true,
            radius_sensitivity: -0.005,
            ..NONE
        },
    ),
    ("payload", "mass stated", payload(PayloadReport::Mass)),
    ("payload", "not stated", payload(PayloadReport::Nothing)),
    (
        "good machine",
        "all a little",
        Effects {
            speed_delay: 0.02,
            brakes: 0.15,
            steering: 0.12,
            hinge: 0.05,
            slope_follows: 0.1,
            slope_lag: 0.05,
            stiffness_difference: 0.03,
            stiffness_exponent: 0.05,
            radius_sensitivity: 0.001,
            ..NONE
        },
    ),
];

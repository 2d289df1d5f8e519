//! The effects one at a time, at the severities that machines have, and together.

use super::effects::Effects;

/// What machines at work do that their description does not say: name, severity in words, effects. The first does
/// nothing of the kind.
pub fn cases() -> Vec<(&'static str, &'static str, Effects)> {
    let none = Effects::default();
    let slope = |degrees: f64| Effects {
        slope: degrees.to_radians(),
        ..none
    };
    let inclined = |degrees: f64| Effects {
        inclinometer: true,
        ..slope(degrees)
    };
    let efficiency = |efficiency| Effects { efficiency, ..none };
    let gain = |torque_gain| Effects {
        torque_gain,
        ..none
    };
    let lag = |torque_lag| Effects { torque_lag, ..none };
    let late = |gyro_delay| Effects { gyro_delay, ..none };
    let friction = |friction| Effects { friction, ..none };
    let boom = |boom_mode| Effects { boom_mode, ..none };
    let swinging = |pendulum, pendulum_length| Effects {
        pendulum,
        pendulum_length,
        ..none
    };
    let wrong_masses = |mass_error, length_error| Effects {
        mass_error,
        length_error,
        ..none
    };
    vec![
        ("none", "", none),
        ("slope", "2 deg", slope(2.0)),
        ("slope", "4 deg", slope(4.0)),
        ("slope", "8 deg", slope(8.0)),
        ("slope, inclinometer", "4 deg", inclined(4.0)),
        ("slope, inclinometer", "8 deg", inclined(8.0)),
        ("gear losses", ".97", efficiency(0.97)),
        ("gear losses", ".93", efficiency(0.93)),
        ("torque gain", "+2 %", gain(1.02)),
        ("torque gain", "+5 %", gain(1.05)),
        ("torque gain", "-5 %", gain(0.95)),
        ("torque gain", "+10 %", gain(1.10)),
        ("torque gain", "-10 %", gain(0.90)),
        ("torque filter", "20 ms", lag(0.02)),
        ("torque filter", "50 ms", lag(0.05)),
        (
            "torque every",
            "40 ms",
            Effects {
                torque_period: 0.04,
                ..none
            },
        ),
        (
            "torque offset",
            "1.5 %",
            Effects {
                torque_offset: 0.015,
                ..none
            },
        ),
        ("gyro late", "10 ms", late(0.01)),
        ("gyro late", "30 ms", late(0.03)),
        (
            "gyro filter",
            "20 ms",
            Effects {
                gyro_lag: 0.02,
                ..none
            },
        ),
        (
            "gyro bias",
            ".01 rad/s",
            Effects {
                gyro_bias: 0.01,
                ..none
            },
        ),
        (
            "gyro quantum",
            ".01 rad/s",
            Effects {
                gyro_quantum: 0.01,
                ..none
            },
        ),
        ("friction", "x1.3", friction(1.3)),
        ("friction", "x2", friction(2.0)),
        (
            "friction, Stribeck",
            "x1.6",
            Effects {
                stribeck: 1.6,
                ..none
            },
        ),
        (
            "friction, overturning",
            "+50 %",
            Effects {
                overturning: 0.5,
                ..none
            },
        ),
        (
            "damping",
            "x1.5",
            Effects {
                damping: 1.5,
                ..none
            },
        ),
        ("boom mode", "4 Hz", boom(4.0)),
        ("boom mode", "2.5 Hz", boom(2.5)),
        ("swinging load", "20 %", swinging(0.2, 0.8)),
        ("swinging load", "50 %", swinging(0.5, 0.8)),
        ("hook load", "2 m", swinging(1.0, 2.0)),
        (
            "spill",
            "10 %",
            Effects {
                spill: 0.10,
                ..none
            },
        ),
        (
            "dump in the swing",
            "",
            Effects {
                dumps_swinging: true,
                ..none
            },
        ),
        ("masses, lengths", "2 %, 1 %", wrong_masses(0.02, 0.01)),
        ("masses, lengths", "3 %, 1.5 %", wrong_masses(0.03, 0.015)),
        (
            "joint angles",
            "1 deg",
            Effects {
                angle_error: 1f64.to_radians(),
                ..none
            },
        ),
        (
            "jitter",
            "3 ms",
            Effects {
                jitter: 0.003,
                ..none
            },
        ),
        (
            "jitter",
            "10 ms",
            Effects {
                jitter: 0.01,
                ..none
            },
        ),
        (
            "relief valve",
            "30 %",
            Effects {
                relief: 0.3,
                ..none
            },
        ),
        ("good machine", "", Effects::good()),
        ("usual machine", "", Effects::usual()),
        ("worn machine", "", Effects::worn()),
    ]
}

//! The lines of the honesty table, and what the estimators are told of a simulated machine.

use estimation::excavator::{Doubts, Geometry, Settings};
use sim::excavator::{Effects, Work};

/// What is asked of a line.
#[derive(Clone, Copy)]
pub struct Asked {
    /// Largest share of wrong among the trusted.
    pub wrong: f64,
    /// Least trusted share of the moving time.
    pub trusted: f64,
    /// Least coverage of all rows.
    pub covered: f64,
}

const EFFECT: Asked = Asked {
    wrong: 0.05,
    trusted: 0.0,
    covered: 0.0,
};
const SOUND: Asked = Asked {
    trusted: 0.70,
    covered: 0.93,
    ..EFFECT
};
const GOOD: Asked = Asked {
    trusted: 0.50,
    covered: 0.93,
    ..EFFECT
};
const USUAL: Asked = Asked {
    wrong: 0.10,
    ..EFFECT
};

/// The effects with their severities.
pub fn effects() -> Vec<(&'static str, &'static str, Effects, Asked)> {
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
    let e = EFFECT;
    vec![
        ("none", "", none, SOUND),
        ("slope", "2 deg", slope(2.0), e),
        ("slope", "4 deg", slope(4.0), e),
        ("slope", "8 deg", slope(8.0), e),
        ("slope, inclinometer", "4 deg", inclined(4.0), e),
        ("slope, inclinometer", "8 deg", inclined(8.0), e),
        ("gear losses", ".97", efficiency(0.97), e),
        ("gear losses", ".93", efficiency(0.93), e),
        ("torque gain", "+2 %", gain(1.02), e),
        ("torque gain", "+5 %", gain(1.05), e),
        ("torque gain", "-5 %", gain(0.95), e),
        ("torque gain", "+10 %", gain(1.10), e),
        ("torque gain", "-10 %", gain(0.90), e),
        ("torque filter", "20 ms", lag(0.02), e),
        ("torque filter", "50 ms", lag(0.05), e),
        (
            "torque every",
            "40 ms",
            Effects {
                torque_period: 0.04,
                ..none
            },
            e,
        ),
        (
            "torque offset",
            "1.5 %",
            Effects {
                torque_offset: 0.015,
                ..none
            },
            e,
        ),
        ("gyro late", "10 ms", late(0.01), e),
        ("gyro late", "30 ms", late(0.03), e),
        (
            "gyro filter",
            "20 ms",
            Effects {
                gyro_lag: 0.02,
                ..none
            },
            e,
        ),
        (
            "gyro bias",
            ".01 rad/s",
            Effects {
                gyro_bias: 0.01,
                ..none
            },
            e,
        ),
        (
            "gyro quantum",
            ".01 rad/s",
            Effects {
                gyro_quantum: 0.01,
                ..none
            },
            e,
        ),
        ("friction", "x1.3", friction(1.3), e),
        ("friction", "x2", friction(2.0), e),
        (
            "friction, Stribeck",
            "x1.6",
            Effects {
                stribeck: 1.6,
                ..none
            },
            e,
        ),
        (
            "friction, overturning",
            "+50 %",
            Effects {
                overturning: 0.5,
                ..none
            },
            e,
        ),
        (
            "damping",
            "x1.5",
            Effects {
                damping: 1.5,
                ..none
            },
            e,
        ),
        ("boom mode", "4 Hz", boom(4.0), e),
        ("boom mode", "2.5 Hz", boom(2.5), e),
        ("swinging load", "20 %", swinging(0.2, 0.8), e),
        ("swinging load", "50 %", swinging(0.5, 0.8), e),
        ("hook load", "2 m", swinging(1.0, 2.0), e),
        (
            "spill",
            "10 %",
            Effects {
                spill: 0.10,
                ..none
            },
            e,
        ),
        (
            "dump in the swing",
            "",
            Effects {
                dumps_swinging: true,
                ..none
            },
            e,
        ),
        ("masses, lengths", "2 %, 1 %", wrong_masses(0.02, 0.01), e),
        (
            "masses, lengths",
            "3 %, 1.5 %",
            wrong_masses(0.03, 0.015),
            e,
        ),
        (
            "joint angles",
            "1 deg",
            Effects {
                angle_error: 1f64.to_radians(),
                ..none
            },
            e,
        ),
        (
            "jitter",
            "3 ms",
            Effects {
                jitter: 0.003,
                ..none
            },
            e,
        ),
        (
            "relief valve",
            "30 %",
            Effects {
                relief: 0.3,
                ..none
            },
            e,
        ),
        ("good machine", "", Effects::good(), GOOD),
        ("usual machine", "", Effects::usual(), USUAL),
        ("worn machine", "", Effects::worn(), USUAL),
    ]
}

/// What a competent user states of a machine: its data sheet.
pub fn described(work: &Work) -> Settings {
    let (size, told) = (work.size(), work.told());
    let tool = &told.attachment;
    let geometry = Geometry {
        upper_inertia: told.upper_inertia,
        boom_pin: told.boom_pin,
        lengths: [told.boom_length, told.arm_length],
        centres: [told.boom.centre, told.arm.centre, tool.link.centre],
        payload_centre: tool.payload_centre,
        payload_gyration: tool.payload_gyration,
        masses: [told.boom.mass, told.arm.mass, tool.link.mass],
        inertias: [
            told.boom.flat_inertia,
            told.arm.flat_inertia,
            tool.link.flat_inertia,
        ],
        axial_inertias: [
            told.boom.upright_inertia,
            told.arm.upright_inertia,
            tool.link.upright_inertia,
        ],
    };
    let mut s = Settings {
        geometry,
        nominal_damping: size.damping,
        coulomb_friction: size.friction,
        inertia_min: 0.95 * told.upper_inertia,
        ..Settings::default()
    };
    s.prior.inertia = geometry
        .inertia([0.6, -1.8, -0.5])
        .with_payload(0.5 * size.rated);
    s.prior.inertia_std = 0.3 * s.prior.inertia;
    s.inertia_max = 4.0 * s.prior.inertia;
    s.prior.payload = 0.5 * size.rated;
    s.prior.payload_std = 0.4 * size.rated;
    s.prior.damping_std = 0.15 * size.damping;
    s.prior.torque_offset_std = 0.015 * size.torque;
    s.prior.known_torque_offset_std = 0.0075 * size.torque;
    s.prior.friction_std = 0.3 * size.friction;
    s.sensors.swing_velocity_std = size.gyro_noise;
    s.sensors.swing_torque_std = size.torque_noise;
    s.estimator.payload_max = 1.6 * size.rated;
    s.estimator.payload_min = -0.1 * size.rated;
    let doubts = Doubts {
        friction_std: s.prior.friction_std,
        ..Doubts::default()
    };
    s.sensors.swing_torque_gain_std = doubts.gain_std;
    s.doubts = Some(doubts);
    s
}

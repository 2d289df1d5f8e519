//! The lines of the honesty table, and what the estimators are given of a simulated machine.

use estimation::excavator::{Doubts, Geometry, Settings};
use sim::excavator::{Effects, Work, cases};

/// What is asked of a line.
#[derive(Clone, Copy)]
pub struct Requirement {
    /// Largest share of wrong among the trusted.
    pub wrong: f64,
    /// Least trusted share of the moving time.
    pub trusted: f64,
    /// Least coverage of all rows.
    pub covered: f64,
}

/// One effect.
pub const EFFECT: Requirement = Requirement {
    wrong: 0.05,
    trusted: 0.0,
    covered: 0.0,
};
const SOUND: Requirement = Requirement {
    trusted: 0.70,
    covered: 0.93,
    ..EFFECT
};
const GOOD: Requirement = Requirement {
    trusted: 0.50,
    covered: 0.93,
    ..EFFECT
};
/// Everything at once, as on most machines.
pub const USUAL: Requirement = Requirement {
    wrong: 0.10,
    ..EFFECT
};

/// The effects with their severities, and what is asked of each.
pub fn effects() -> impl Iterator<Item = (&'static str, &'static str, Effects, Requirement)> {
    cases().into_iter().map(|(effect, severity, effects)| {
        let asked = match effect {
            "none" => SOUND,
            "good machine" => GOOD,
            "usual machine" | "worn machine" => USUAL,
            _ => EFFECT,
        };
        (effect, severity, effects, asked)
    })
}

/// What a competent user states of a machine: its data sheet.
pub fn described(work: &Work) -> Settings {
    let (size, nominal) = (work.size(), work.nominal());
    let tool = &nominal.attachment;
    let geometry = Geometry {
        upper_inertia: nominal.upper_inertia,
        boom_pin: nominal.boom_pin,
        lengths: [nominal.boom_length, nominal.arm_length],
        centres: [nominal.boom.centre, nominal.arm.centre, tool.link.centre],
        payload_centre: tool.payload_centre,
        payload_gyration: tool.payload_gyration,
        rises: [0.0; 3],
        masses: [nominal.boom.mass, nominal.arm.mass, tool.link.mass],
        inertias: [
            nominal.boom.flat_inertia,
            nominal.arm.flat_inertia,
            tool.link.flat_inertia,
        ],
        axial_inertias: [
            nominal.boom.upright_inertia,
            nominal.arm.upright_inertia,
            tool.link.upright_inertia,
        ],
    };
    let mut s = Settings {
        geometry,
        nominal_damping: size.damping,
        coulomb_friction: size.friction,
        inertia_min: 0.95 * nominal.upper_inertia,
        ..Settings::calibrated()
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

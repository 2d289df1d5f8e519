//! The lines of the honesty table, and the description of a simulated machine for the estimators.

use estimation::excavator::Geometry;
use estimation::excavator::keys::{Attachment, Description, Variant};
use sim::excavator::{Effects, Work, cases, cylinders};

/// Requirement on a line.
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
/// All effects at once, as on most machines.
pub const USUAL: Requirement = Requirement {
    wrong: 0.10,
    ..EFFECT
};

/// The effects with their severities and requirements.
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

/// Adds the boom's cylinders from the drawing.
pub fn describe_boom_cylinder(d: &mut Description, work: &Work) {
    let [boom, _] = cylinders(&work.size().geometry);
    let c = &mut d.boom_cylinder;
    (c.count, c.head_area, c.rod_area) = (boom.count, boom.head_area, boom.rod_area);
    (c.base_distance, c.rod_distance) = (boom.base_distance, boom.rod_distance);
    (c.angle, c.friction) = (boom.angle, boom.friction);
    c.friction_std = 0.5 * boom.friction;
}

/// The statements of a competent user: the data sheet of the machine.
pub fn described(work: &Work) -> Description {
    let (size, nominal) = (work.size(), work.nominal());
    let tool = &nominal.attachment;
    let mut d = Description {
        geometry: Attachment {
            boom_pin: nominal.boom_pin,
            boom_length: nominal.boom_length,
            arm_length: nominal.arm_length,
            boom_centre: nominal.boom.centre,
            arm_centre: nominal.arm.centre,
            bucket_centre: tool.link.centre,
            payload_centre: tool.payload_centre,
            payload_gyration: tool.payload_gyration,
            boom_mass: nominal.boom.mass,
            arm_mass: nominal.arm.mass,
            bucket_mass: tool.link.mass,
            boom_inertia: nominal.boom.flat_inertia,
            arm_inertia: nominal.arm.flat_inertia,
            bucket_inertia: tool.link.flat_inertia,
            boom_axial_inertia: nominal.boom.upright_inertia,
            arm_axial_inertia: nominal.arm.upright_inertia,
            bucket_axial_inertia: tool.link.upright_inertia,
            ..Attachment::default()
        },
        ..Description::default()
    };
    d.estimator.variant = Variant::Auto;
    d.machine.upper_inertia = nominal.upper_inertia;
    d.machine.nominal_damping = size.damping;
    d.machine.coulomb_friction = size.friction;
    d.machine.inertia_min = 0.95 * nominal.upper_inertia;
    d.prior.inertia = Geometry::of(&d)
        .inertia([0.6, -1.8, -0.5])
        .with_payload(0.5 * size.rated);
    d.prior.inertia_std = 0.3 * d.prior.inertia;
    d.machine.inertia_max = 4.0 * d.prior.inertia;
    d.prior.payload = 0.5 * size.rated;
    d.prior.payload_std = 0.4 * size.rated;
    d.prior.damping_std = 0.15 * size.damping;
    d.prior.torque_offset_std = 0.015 * size.torque;
    d.prior.known_torque_offset_std = 0.0075 * size.torque;
    d.prior.friction_std = 0.3 * size.friction;
    d.sensors.swing_velocity_std = size.gyro_noise;
    d.sensors.swing_torque_std = size.torque_noise;
    d.estimator.payload_max = 1.6 * size.rated;
    d.estimator.payload_min = -0.1 * size.rated;
    d
}

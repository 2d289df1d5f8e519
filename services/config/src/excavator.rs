//! Description of an excavator.

pub use estimation::excavator::keys::Description as Excavator;
use messages::Machine;

use crate::Error;
use crate::keyed::tables;

tables!(
    Excavator,
    Machine::Excavator,
    contradictions,
    Excavator::of_its_size,
    [
        machine,
        geometry,
        boom_cylinder,
        sensors,
        prior,
        estimator,
        paper
    ]
);

/// Contradictions between keys that are each in range.
fn contradictions(excavator: &Excavator) -> Vec<Error> {
    let mut found = Vec::new();
    let (machine, estimator) = (&excavator.machine, &excavator.estimator);
    if machine.inertia_min >= machine.inertia_max {
        found.push(Error::between(
            format!(
                "inertia_min ({} kg m^2) is not below inertia_max ({} kg m^2)",
                machine.inertia_min, machine.inertia_max
            ),
            "machine.inertia_min",
            "make inertia_min the smaller of the two",
        ));
    } else if !(machine.inertia_min..=machine.inertia_max).contains(&excavator.prior.inertia) {
        found.push(Error::between(
            format!(
                "prior.inertia ({} kg m^2) lies outside inertia_min to inertia_max ({} to {} kg m^2)",
                excavator.prior.inertia, machine.inertia_min, machine.inertia_max
            ),
            "prior.inertia",
            "give a prior inside the limits, or move machine.inertia_min and machine.inertia_max",
        ));
    }
    let reached = most_empty(excavator);
    // A description without boom, arm and bucket is of another kind of axis.
    if excavator.geometry != Default::default() && machine.inertia_max < reached {
        found.push(Error::between(
            format!(
                "inertia_max ({} kg m^2) is less than the geometry gives with the empty bucket far out ({reached:.0} kg m^2)",
                machine.inertia_max
            ),
            "machine.inertia_max",
            "give an inertia_max above what the machine can reach, or mend the geometry",
        ));
    }
    let lengths = [
        ("boom_length", excavator.geometry.boom_length),
        ("arm_length", excavator.geometry.arm_length),
    ];
    // A machine of a stated mass has a boom and an arm, to which the deviations of its class are relative.
    let absent = lengths.iter().find(|(_, length)| *length == 0.0);
    if let Some((name, _)) = absent.filter(|_| machine.operating_mass.is_some()) {
        found.push(Error::between(
            format!("machine.geometry.{name} is 0 m"),
            &format!("machine.geometry.{name}"),
            "measure it from pin to pin, or leave it out for that of a usual machine",
        ));
    }
    if estimator.payload_min >= estimator.payload_max {
        found.push(Error::between(
            format!(
                "payload_min ({} kg) is not below payload_max ({} kg)",
                estimator.payload_min, estimator.payload_max
            ),
            "estimator.payload_min",
            "make payload_min the smaller of the two",
        ));
    }
    if !matches!(estimator.forgetting.len(), 0 | 1 | 3) {
        found.push(Error::between(
            format!(
                "forgetting has {} factors; it takes one, or one each for inertia, damping and torque",
                estimator.forgetting.len()
            ),
            "estimator.forgetting",
            "give one factor, three (inertia, damping, torque; method multi-forgetting-rls), or none",
        ));
    }
    found
}

/// Inertia of the empty machine with arm and bucket stretched at 20 degrees above the ground [kg m^2].
fn most_empty(excavator: &Excavator) -> f64 {
    let posture = [0.8, -0.6, -0.1];
    estimation::excavator::Geometry::of(excavator)
        .inertia(posture)
        .empty
}

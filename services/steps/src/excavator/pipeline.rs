//! The excavator's processes.

use messages::channels::{
    EXCAVATOR_INERTIA_RLS, EXCAVATOR_INERTIA_UKF, EXCAVATOR_MOTION, EXCAVATOR_SENSORS,
    EXCAVATOR_TRUTH,
};
use messages::{Hop, Machine};

use super::{EstimatorStep, FilterStep, RegressionStep};
use crate::described;
use crate::stages::{LOGGER, Pipeline, Role, RowOf, SENDER, Stage};

/// The excavator's processes, upstream first.
pub static PIPELINE: Pipeline = Pipeline {
    machine: Machine::Excavator,
    about: "Swing inertia, damping, torque, payload",
    main: "ukf",
    stages: &[
        Stage {
            name: "sensor",
            wakes: &["kalman", "ukf"],
            priority: 50,
            role: Role::Source {
                sensors: EXCAVATOR_SENSORS.any(),
                truth: EXCAVATOR_TRUTH.any(),
            },
        },
        Stage {
            name: "kalman",
            wakes: &["rls"],
            priority: 60,
            role: Role::Step(&RowOf {
                input: &EXCAVATOR_SENSORS,
                output: &EXCAVATOR_MOTION,
                hop: Hop::Filter,
                methods: &[],
                new: |d, _| FilterStep::new(described(d)?),
            }),
        },
        Stage {
            name: "rls",
            wakes: &["probe"],
            priority: 70,
            role: Role::Step(&RowOf {
                input: &EXCAVATOR_MOTION,
                output: &EXCAVATOR_INERTIA_RLS,
                hop: Hop::Estimate,
                methods: &["svf-rls", "multi-forgetting-rls"],
                new: |d, method| RegressionStep::new(described(d)?, method),
            }),
        },
        Stage {
            name: "ukf",
            wakes: &[],
            priority: 55,
            role: Role::Step(&RowOf {
                input: &EXCAVATOR_SENSORS,
                output: &EXCAVATOR_INERTIA_UKF,
                hop: Hop::Estimate,
                methods: &["auto", "posture-torque", "torque", "posture", "velocity"],
                new: |d, method| EstimatorStep::new(described(d)?, method),
            }),
        },
        LOGGER,
        Stage {
            name: "probe",
            wakes: &[],
            priority: 80,
            role: Role::Probe(EXCAVATOR_INERTIA_RLS.any()),
        },
        SENDER,
    ],
};

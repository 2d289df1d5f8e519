//! The loader's processes.

use messages::channels::{LOADER_CG_EKF, LOADER_CG_UKF, LOADER_SENSORS, LOADER_TRUTH};
use messages::{Hop, Machine};

use super::EstimatorStep;
use crate::described;
use crate::stages::{LOGGER, Pipeline, Role, RowOf, SENDER, Stage};

/// The loader's processes, upstream first.
pub static PIPELINE: Pipeline = Pipeline {
    machine: Machine::Loader,
    about: "Payload, centre of gravity, slip stiffness, bucket force",
    main: "ukf",
    stages: &[
        Stage {
            name: "sensor",
            wakes: &["kalman", "ukf"],
            priority: 50,
            role: Role::Source {
                sensors: LOADER_SENSORS.any(),
                truth: LOADER_TRUTH.any(),
            },
        },
        Stage {
            name: "kalman",
            wakes: &[],
            priority: 60,
            role: Role::Step(&RowOf {
                input: &LOADER_SENSORS,
                output: &LOADER_CG_EKF,
                hop: Hop::Estimate,
                methods: &["full-ekf", "ekf"],
                new: |d, method| EstimatorStep::new(described(d)?, method),
            }),
        },
        Stage {
            name: "ukf",
            wakes: &["probe"],
            priority: 60,
            role: Role::Step(&RowOf {
                input: &LOADER_SENSORS,
                output: &LOADER_CG_UKF,
                hop: Hop::Estimate,
                methods: &["full", "isr-ukf", "isr-ukf-printed"],
                new: |d, method| EstimatorStep::new(described(d)?, method),
            }),
        },
        LOGGER,
        Stage {
            name: "probe",
            wakes: &[],
            priority: 80,
            role: Role::Probe(LOADER_CG_UKF.any()),
        },
        SENDER,
    ],
};

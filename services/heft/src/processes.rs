//! The one table of processes: who reads what, who writes what, who wakes whom.

use config::Kind;
use messages::channels::{
    Channel, EXCAVATOR_INERTIA_RLS, EXCAVATOR_INERTIA_UKF, EXCAVATOR_MOTION, EXCAVATOR_SENSORS,
    LOADER_CG_EKF, LOADER_CG_UKF, LOADER_SENSORS,
};

/// A process of a pipeline.
#[derive(Debug)]
pub struct Process {
    /// Name of the service.
    pub name: &'static str,
    /// Channel that it reads; the sensor reads none, the logger all.
    pub input: Option<&'static Channel>,
    /// Channel that it writes.
    pub output: Option<&'static Channel>,
    /// Processes whose bell it rings, next stage first.
    pub wakes: &'static [&'static str],
    /// SCHED_FIFO priority under `--rt`, rising downstream; 0: normal, off the path.
    pub priority: u8,
}

/// The excavator's pipeline, upstream first.
const EXCAVATOR: &[Process] = &[
    Process {
        name: "sensor",
        input: None,
        output: Some(&EXCAVATOR_SENSORS),
        wakes: &["kalman", "ukf"],
        priority: 50,
    },
    Process {
        name: "kalman",
        input: Some(&EXCAVATOR_SENSORS),
        output: Some(&EXCAVATOR_MOTION),
        wakes: &["rls"],
        priority: 60,
    },
    Process {
        name: "rls",
        input: Some(&EXCAVATOR_MOTION),
        output: Some(&EXCAVATOR_INERTIA_RLS),
        wakes: &["probe"],
        priority: 70,
    },
    Process {
        name: "ukf",
        input: Some(&EXCAVATOR_SENSORS),
        output: Some(&EXCAVATOR_INERTIA_UKF),
        wakes: &[],
        priority: 55,
    },
    LOGGER,
    Process {
        name: "probe",
        input: Some(&EXCAVATOR_INERTIA_RLS),
        output: None,
        wakes: &[],
        priority: 80,
    },
];

/// The wheel loader's pipeline, upstream first.
const LOADER: &[Process] = &[
    Process {
        name: "sensor",
        input: None,
        output: Some(&LOADER_SENSORS),
        wakes: &["kalman", "ukf"],
        priority: 50,
    },
    Process {
        name: "kalman",
        input: Some(&LOADER_SENSORS),
        output: Some(&LOADER_CG_EKF),
        wakes: &[],
        priority: 60,
    },
    Process {
        name: "ukf",
        input: Some(&LOADER_SENSORS),
        output: Some(&LOADER_CG_UKF),
        wakes: &["probe"],
        priority: 60,
    },
    LOGGER,
    Process {
        name: "probe",
        input: Some(&LOADER_CG_UKF),
        output: None,
        wakes: &[],
        priority: 80,
    },
];

/// Reads everything, and tells a lossless source how far it has got.
const LOGGER: Process = Process {
    name: "logger",
    input: None,
    output: None,
    wakes: &["sensor"],
    priority: 0,
};

/// The pipeline of a machine, upstream first.
pub fn of_machine(machine: Kind) -> &'static [Process] {
    match machine {
        Kind::Excavator => EXCAVATOR,
        Kind::Loader => LOADER,
    }
}

/// The process that writes what this one reads.
fn writer(machine: Kind, reader: &Process) -> Option<&'static Process> {
    let input = reader.input?.name;
    of_machine(machine)
        .iter()
        .find(|p| p.output.is_some_and(|o| o.name == input))
}

/// Hops from the sensor to this process.
pub fn hops_before(machine: Kind, process: &Process) -> usize {
    writer(machine, process).map_or(0, |writer| 1 + hops_before(machine, writer))
}

/// Name of process `index` of a pipeline, as `health` messages tell it.
pub fn name(machine: Kind, index: u32) -> &'static str {
    of_machine(machine)
        .get(index as usize)
        .map_or("?", |p| p.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_reads_a_channel_is_woken_by_its_writer() {
        for machine in Kind::ALL {
            for reader in of_machine(machine) {
                let writer = writer(machine, reader);
                if reader.input.is_none() {
                    continue;
                }
                assert!(
                    writer.is_some_and(|w| w.wakes.contains(&reader.name)),
                    "{}",
                    reader.name
                );
            }
        }
    }

    #[test]
    fn neighbours_of_the_chain_lie_one_hop_apart() {
        let hops = |machine| -> Vec<usize> {
            let of = |p| hops_before(machine, p);
            of_machine(machine).iter().map(of).collect()
        };
        // sensor, kalman, rls, ukf, logger, probe
        assert_eq!(hops(Kind::Excavator), [0, 1, 2, 1, 0, 3]);
        // sensor, kalman, ukf, logger, probe
        assert_eq!(hops(Kind::Loader), [0, 1, 1, 0, 2]);
    }
}

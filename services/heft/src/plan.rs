//! The plan of a run: all settings that the supervisor passes to its workers, in one file.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use config::Description;
use messages::Machine;
use recording::Metadata;
use runtime::Domain;
use serde::{Deserialize, Serialize};
use steps::stages::Pipeline;

use crate::bounds::LimitArgs;
use crate::failure::Failure;
use crate::fleet::Fleet;
use crate::fleet_run::FleetRun;
use crate::outputs::CanOutput;
use crate::spin::Spinners;

/// Settings of a run. Written to the domain by the supervisor, read by every worker.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Plan {
    /// Which machine.
    #[serde(with = "by_name")]
    pub machine: Machine,
    /// Scenario of the simulator; unused with an input file.
    pub scenario: String,
    /// Payload of the simulator \[kg\], its own default where absent.
    pub payload: Option<f64>,
    /// Whether the simulated machine has pressure sensors at its cylinders.
    pub pressures: bool,
    /// Recording to take the samples from.
    pub input: Option<PathBuf>,
    /// Signal map of that recording.
    pub map: Option<PathBuf>,
    /// Where estimates are sent, beside the recording.
    pub output: Option<CanOutput>,
    /// The machine's description, as canonical TOML.
    pub description: String,
    /// Method of each process that has a choice, by the name of the process.
    pub methods: BTreeMap<String, String>,
    /// Duration of a simulated run \[s\]; endless if absent.
    pub duration: Option<f64>,
    /// Sampling rate of the simulator \[Hz\].
    pub rate: f64,
    /// Seed of the simulator.
    pub seed: u64,
    /// As fast as the readers take the samples, instead of real time.
    pub lossless: bool,
    /// Its services are threads of the supervisor instead of processes.
    pub threads: bool,
    /// Real-time scheduling was asked for.
    pub realtime: bool,
    /// Cores for the stages of this machine under real-time scheduling, taken in turn along the
    /// chain; empty: the system chooses.
    pub cores: Vec<usize>,
    /// Processes that poll for messages continuously, with the core of each.
    pub spinners: Spinners,
    /// Parameters restored from an earlier run, as text; the description contains them.
    pub restored: Option<String>,
    /// The fleet that it belongs to.
    pub fleet: Option<Fleet>,
    /// Identity among the runs of its machine, for the fleet.
    #[serde(flatten)]
    pub run: FleetRun,
    /// Version of heft.
    pub version: String,
    /// File to record to.
    pub recording: PathBuf,
    /// Bounds of the recording.
    pub limits: LimitArgs,
    /// The group of users that may look at the run.
    pub group: Option<u32>,
    /// File of a probe: a process in the chain that only measures the arrival of estimates.
    pub probe: Option<PathBuf>,
    /// Whether that process waits for the iceoryx2 event of its channel instead of its bell.
    pub probe_listens: bool,
}

impl Plan {
    /// The pipeline of its machine.
    pub fn pipeline(&self) -> &'static Pipeline {
        Pipeline::of(self.machine)
    }

    /// The machine's description.
    pub fn description(&self) -> Result<Description, Failure> {
        Ok(Description::parse(
            &self.description,
            "the plan of the run",
            Some(self.machine),
        )?)
    }

    /// Method of a process; empty where it has no choice.
    pub fn method(&self, process: &str) -> &str {
        self.methods.get(process).map_or("", String::as_str)
    }

    /// Writes it to the domain.
    pub fn write(&self, domain: &Domain) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(self).map_err(|e| {
            // Only a path that is no Unicode can be refused.
            let remedy = "rename the folder or the file: a run hands its names on as text";
            Failure::input(
                format!("a name is not UTF-8: {e}"),
                "the paths of this run",
                remedy,
            )
        })?;
        let file = domain.plan_file();
        fs::write(&file, text).map_err(|e| Failure::file("write", &file, &e))
    }

    /// Reads it from the domain.
    pub fn read(domain: &Domain) -> Result<Self, Failure> {
        let file = domain.plan_file();
        let text = fs::read_to_string(&file).map_err(|e| Failure::file("read", &file, &e))?;
        serde_json::from_str(&text).map_err(|error| {
            Failure::input(
                format!("the plan of the run is damaged: {error}"),
                file.display(),
                "start the run again with `heft run`, which writes it",
            )
        })
    }

    /// Metadata of a recording of this run.
    pub fn metadata(&self) -> Metadata {
        let mut metadata = Metadata::new();
        let mut put = |key: &str, value: String| {
            metadata.insert(key.to_owned(), value);
        };
        put("heft.version", env!("CARGO_PKG_VERSION").to_owned());
        put(crate::build::KEY, crate::build::IDENTITY.to_owned());
        put("machine", self.machine.name().to_owned());
        put("run", self.run.id.to_string());
        let processes = self.pipeline().stages.iter().map(|p| p.name);
        put("processes", processes.collect::<Vec<_>>().join(","));
        put("description", self.description.clone());
        put("description.sha256", recording::sha256(&self.description));
        for (process, method) in &self.methods {
            put(&method_key(process), method.clone());
        }
        match &self.input {
            Some(input) => put("input", input.display().to_string()),
            None => {
                put("scenario", self.scenario.clone());
                put("seed", self.seed.to_string());
                if let Some(payload) = self.payload {
                    put("payload_kg", payload.to_string());
                }
                if !self.pressures {
                    put("without", "pressure".to_owned());
                }
            }
        }
        if let Some(restored) = &self.restored {
            put("state", restored.clone());
        }
        if self.threads {
            put("services", "threads of one process".to_owned());
        }
        put("rate_hz", self.rate.to_string());
        put(
            "pace",
            if self.lossless { "max" } else { "realtime" }.to_owned(),
        );
        put(
            "scheduling",
            if self.realtime {
                "SCHED_FIFO asked for"
            } else {
                "normal"
            }
            .to_owned(),
        );
        if self.limits.split.is_some() {
            put(
                "split",
                "parts of one recording, each whole by itself".to_owned(),
            );
        }
        let system = rustix::system::uname();
        put("host", system.nodename().to_string_lossy().into_owned());
        put(
            "kernel",
            format!(
                "{} {}",
                system.sysname().to_string_lossy(),
                system.release().to_string_lossy()
            ),
        );
        metadata
    }
}

/// Key under which a recording names the method of a process.
pub fn method_key(process: &str) -> String {
    format!("method.{process}")
}

/// Identity that a state must have to be continued by this build: process, method, description.
pub fn state_identity(description: &str, process: &str, method: &str) -> u64 {
    let parts = [crate::build::IDENTITY, process, method, description];
    let sum = recording::sha256(parts.join("\n"));
    u64::from_str_radix(&sum[..16], 16).unwrap_or_default()
}

/// A machine by its name.
mod by_name {
    use messages::Machine;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(machine: &Machine, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(machine.name())
    }

    pub fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<Machine, D::Error> {
        let name = String::deserialize(from)?;
        Machine::from_name(&name)
            .ok_or_else(|| D::Error::custom(format!("there is no machine `{name}`")))
    }
}

//! The gateway's part of the plan that the supervisor wrote.

use std::path::PathBuf;

use messages::Machine;
use messages::channels::Channel;
use runtime::Domain;
use serde::Deserialize;
use steps::stages::Pipeline;

use crate::error;

/// The part of a run's plan that concerns a gateway.
#[derive(Debug, Clone, Deserialize)]
pub struct Plan {
    /// Which machine.
    pub machine: String,
    /// Samples a second.
    pub rate: f64,
    /// The recording.
    pub recording: PathBuf,
    /// Id of the run (random); [`Plan::run_count`] is its number in the machine's count.
    pub run: u64,
    /// Number of the run; 0 if the machine cannot count its runs.
    pub run_count: u64,
    /// Version of heft.
    pub version: String,
}

impl Plan {
    /// Reads the plan of a domain.
    ///
    /// # Errors
    /// There is none, or it is of another version.
    pub fn read(domain: &Domain) -> Result<Self, String> {
        let file = domain.plan_file();
        let failed = |what: String| {
            error(
                what,
                file.display(),
                "name the domain of a run of this version of heft; `heft doctor` lists them",
            )
        };
        let text =
            std::fs::read(&file).map_err(|e| failed(format!("there is no such run: {e}")))?;
        serde_json::from_slice(&text)
            .map_err(|e| failed(format!("the plan of the run cannot be read: {e}")))
    }

    /// The channel of its sensors.
    ///
    /// # Errors
    /// As [`Plan::pipeline`].
    pub fn sensors(&self) -> Result<&'static Channel, String> {
        self.pipeline()?.sensors().ok_or_else(|| {
            error(
                format!("a {} has no sensors", self.machine),
                "--samples",
                "leave it out",
            )
        })
    }

    /// The processes of its machine.
    ///
    /// # Errors
    /// This version does not know the machine.
    pub fn pipeline(&self) -> Result<&'static Pipeline, String> {
        let machine = Machine::from_name(&self.machine).ok_or_else(|| {
            error(
                format!("there is no machine `{}`", self.machine),
                "the plan of the run",
                "use the gateway of the same version",
            )
        })?;
        Ok(Pipeline::of(machine))
    }
}

//! Outputs of estimates beside recording and page: `--output can:can0`.

use std::path::PathBuf;

use messages::Machine;
use recording::can::Outgoing;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// A CAN interface that estimates are sent to.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct CanOutput {
    /// Its name.
    pub interface: String,
    /// Map of the frames; all frames of the machine if absent.
    pub map: Option<PathBuf>,
}

impl CanOutput {
    /// The output that `--output` and `--output-map` name.
    pub fn of(name: &str, map: Option<PathBuf>) -> Result<Self, Failure> {
        match name.strip_prefix("can:") {
            Some(interface) if !interface.is_empty() => Ok(Self {
                interface: interface.to_owned(),
                map,
            }),
            _ => Err(Failure::input(
                format!("`{name}` is no output"),
                "--output",
                "name a CAN interface: can:can0; the folder of recording and report is --out",
            )),
        }
    }

    /// The frames.
    pub fn outgoing(&self, machine: Machine) -> Result<Outgoing, Failure> {
        Ok(Outgoing::new(machine, self.map.as_deref())?)
    }
}

//! The dependencies: advisories and licences of all three lock files, by `.ci/supply`.

use std::path::Path;
use std::process::{Command, Output};

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::Ground;

pub struct Supply;

impl Attack for Supply {
    fn name(&self) -> String {
        "advisories and licences".into()
    }

    fn attempt(&mut self, _rng: &mut Rng, _ground: &Ground) -> Result<Outcome, String> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let output = Command::new("python3")
            .arg(root.join(".ci/supply"))
            .output();
        let Ok(Output {
            status,
            stdout,
            stderr,
        }) = output
        else {
            return Ok(Outcome::Skipped);
        };
        if status.success() {
            return Ok(Outcome::Survived { gap: 0 });
        }
        let said = [stdout, stderr].concat();
        Err(format!("{status}: {}", String::from_utf8_lossy(&said)))
    }
}

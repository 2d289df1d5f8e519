//! Many pipelines started at once: each of them runs, without disturbing another.

use std::process::Stdio;
use std::time::{Duration, Instant};

use messages::ExcavatorSensors;
use recording::Reader;

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::Ground;

pub struct Storm;

impl Attack for Storm {
    fn name(&self) -> String {
        "start storm".into()
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        let mut children = Vec::new();
        for n in 0..rng.between(4, 13) {
            let out = ground.folder().join(n.to_string());
            let mut command = ground.quiet_run("1", &out);
            command
                .args(["--domain", &format!("{}-{n}", ground.domain())])
                .stdout(Stdio::null())
                .stderr(Stdio::piped());
            children.push((out, command.spawn().map_err(|e| e.to_string())?));
        }
        let begun = Instant::now();
        let mut outcome = Ok(Outcome::Survived { gap: 0 });
        for (out, mut child) in children {
            while child.try_wait().map_err(|e| e.to_string())?.is_none() {
                if begun.elapsed() > Duration::from_secs(60) {
                    let _ = child.kill();
                    outcome = Err(format!("{} did not end", out.display()));
                }
                std::thread::sleep(Duration::from_millis(5));
            }
            let output = child.wait_with_output().map_err(|e| e.to_string())?;
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            let reader = Reader::open(out.join("run.mcap")).map_err(|e| format!("{e}: {said}"))?;
            let samples = reader.messages::<ExcavatorSensors>("excavator/sensors");
            let samples = samples.map_err(|e| e.to_string())?.len();
            // A loaded machine may lose samples, which the status reports.
            if output.status.code().is_none_or(|code| code > 1) || samples == 0 {
                outcome = Err(format!("{}, {samples} samples: {said}", output.status));
            }
            if samples < 100 && output.status.success() {
                outcome = Err(format!("{samples} of 101 samples and status 0: {said}"));
            }
        }
        outcome
    }
}

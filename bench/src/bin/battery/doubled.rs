//! Two runs into one folder, in sequence and at the same time: no recording is lost.

use std::fs;
use std::time::Duration;

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::Ground;

pub struct Doubled;

impl Attack for Doubled {
    fn name(&self) -> String {
        "two runs into one folder".into()
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        let first = ground.run(2.5, &[])?;
        let other = |seconds: &str| {
            let mut command = ground.quiet_run(seconds, &ground.folder().join("out"));
            command.output().map_err(|e| e.to_string())
        };
        std::thread::sleep(Duration::from_millis(rng.between(0, 1000)));
        let mut made = 1 + u32::from(other("0.5")?.status.success());
        let remains = first.remains(Duration::from_secs(10))?;
        let gap = remains.check(0)?;
        made += u32::from(other("0.5")?.status.success());
        let entries = fs::read_dir(ground.folder().join("out")).map_err(|e| e.to_string())?;
        let recordings = entries
            .flatten()
            .filter(|e| e.path().extension().is_some_and(|x| x == "mcap"))
            .count();
        if recordings != made as usize {
            return Err(format!(
                "{made} runs with status 0 left {recordings} recordings"
            ));
        }
        Ok(Outcome::Survived { gap })
    }
}

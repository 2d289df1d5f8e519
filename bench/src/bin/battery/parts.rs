//! `kill -9` of the logger of a split recording, close to the ends of its parts: no sample is lost, and each is recorded once and
//! in order.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use recording::Reader;
use rustix::process::Signal;

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::{Ground, RATE, Run};

/// Kills in one run.
const KILLS: u64 = 5;
/// One flush \[samples\], for a logger that starts slower than the channels' buffers fill.
const GAP: u64 = RATE / 2;

#[derive(Default)]
pub struct Parts {
    kills: u64,
}

impl Attack for Parts {
    fn name(&self) -> String {
        "kill the logger at ends of parts".into()
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        let run = ground.run(60.0, &["--split", "1s"])?;
        run.wait_for_all()?;
        let out = ground.folder().join("out");
        for _ in 0..KILLS {
            let victim = run.wait_for("logger")?;
            wait_for_a_part(&out, &run)?;
            // Just after the end of a part, or before the next one.
            let pause = match rng.between(0, 2) {
                0 => rng.between(0, 30),
                _ => rng.between(900, 1100),
            };
            std::thread::sleep(Duration::from_millis(pause));
            run.signal("logger", Signal::KILL);
            while run.wait_for("logger")? == victim {
                std::thread::sleep(Duration::from_millis(1));
            }
            self.kills += 1;
        }
        std::thread::sleep(Duration::from_millis(600));
        run.end();
        let remains = run.remains(Duration::from_secs(12))?;
        let gap = remains.check(GAP)?;
        if !remains.samples.windows(2).all(|w| w[0] < w[1]) {
            return Err("samples are there twice, or not in order".into());
        }
        let gaps = remains.samples.windows(2).filter(|w| w[1] > w[0] + 1);
        if gaps.count() as u64 > KILLS {
            return Err("more gaps than deaths".into());
        }
        let damage = Reader::open(&out).map_err(|e| e.to_string())?;
        if !damage.damage().is_empty() {
            return Err(format!("damaged: {:?}", damage.damage()));
        }
        Ok(Outcome::Survived { gap })
    }

    fn note(&self) -> Option<String> {
        Some(format!("{}: {} kills", self.name(), self.kills))
    }
}

/// Waits until another part has begun.
fn wait_for_a_part(out: &Path, run: &Run) -> Result<(), String> {
    let parts = || fs::read_dir(out).map_or(0, |entries| entries.flatten().count());
    let (begun, before) = (Instant::now(), parts());
    while parts() <= before {
        if begun.elapsed() > Duration::from_secs(10) {
            return Err(format!("no part ends: {}", run.text()));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(())
}

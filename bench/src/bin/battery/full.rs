//! Shared memory that other programs fill for three seconds, while a service is killed: it is restarted as soon as there is room.
//! The memory is a separate mount in a namespace, so that other processes of the host are not affected.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use rustix::process::Signal;

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::{Ground, RATE};

pub struct SharedMemory;

/// Mount of the shared memory with its size, and time for which it is full.
const MOUNT: &str = "mount -t tmpfs -o size=256M tmpfs /dev/shm && exec \"$0\" \"$@\"";
const FULL: Duration = Duration::from_secs(3);
/// Time without memory, plus a start on a loaded machine \[samples\].
const GAP: u64 = 6 * RATE;

impl Attack for SharedMemory {
    fn name(&self) -> String {
        "shared memory full at a death".into()
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        let words = ["unshare", "-m", "sh", "-c", MOUNT];
        let tried = Command::new(words[0])
            .args(&words[1..])
            .arg("true")
            .stderr(Stdio::null())
            .status();
        if !tried.is_ok_and(|status| status.success()) {
            return Ok(Outcome::Skipped);
        }
        let run = ground.run_by(ground.heft_behind(&words), 20.0, &[])?;
        run.wait_for_all()?;
        let shm = format!("/proc/{}/root/dev/shm", run.supervisor());
        let filler = Path::new(&shm).join("of-others");
        fill(&filler)?;
        let victim = rng.one(&["ukf", "rls", "kalman"]);
        let before = run.wait_for(victim)?;
        run.signal(victim, Signal::KILL);
        std::thread::sleep(FULL);
        fs::remove_file(&filler).map_err(|e| format!("{e}: {}", run.text()))?;
        std::thread::sleep(Duration::from_secs(3));
        if run.service(victim).is_none_or(|pid| pid == before) {
            return Err(format!("{victim} did not come back: {}", run.text()));
        }
        let remains = run.remains(Duration::from_secs(25))?;
        if !remains.text.contains("died") {
            return Err(format!(
                "the death of {victim} is not reported: {}",
                remains.text
            ));
        }
        let gap = remains.check(GAP)?;
        Ok(Outcome::Survived { gap })
    }
}

/// Fills the remaining memory.
fn fill(file: &Path) -> Result<(), String> {
    let mut file = fs::File::create(file).map_err(|e| e.to_string())?;
    let block = vec![1; 1 << 12];
    while file.write_all(&block).is_ok() {}
    Ok(())
}

//! Another user takes the name of the folder of a user's runs, before the first of them: the runs work nevertheless.

use std::fs;
use std::os::unix::fs::{MetadataExt, chown};
use std::process::Command;
use std::time::Duration;

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::{Ground, RATE};

pub struct Squatter;

/// User ids that are not in use.
const VICTIM: u32 = 61_345;
const FOE: u32 = 61_346;

/// Contents of the path, created by the foe.
const MADE: [&str; 4] = [
    "mkdir -m 700 $PLACE",
    "mkdir -m 777 $PLACE",
    "touch $PLACE",
    "ln -s /etc $PLACE",
];

impl Attack for Squatter {
    fn name(&self) -> String {
        "the folder of a user is taken".into()
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        let place = format!("/dev/shm/heft-{VICTIM}");
        let made = rng.one(&MADE);
        let foe = by(FOE)
            .args(["sh", "-c", made])
            .env("PLACE", &place)
            .status();
        if !foe.is_ok_and(|status| status.success()) {
            return Ok(Outcome::Skipped);
        }
        let outcome = victim(ground).map_err(|why| format!("{made}: {why}"));
        let removed = fs::remove_dir(&place).or_else(|_| fs::remove_file(&place));
        removed.map_err(|e| format!("{made}: {place} of the other user is gone: {e}"))?;
        outcome
    }
}

/// A run of the victim, and its outcome.
fn victim(ground: &Ground) -> Result<Outcome, String> {
    chown(ground.folder(), Some(VICTIM), Some(VICTIM)).map_err(|e| e.to_string())?;
    let id = format!("--reuid={VICTIM}");
    let group = format!("--regid={VICTIM}");
    let mut heft = ground.heft_behind(&["setpriv", &id, &group, "--clear-groups"]);
    heft.env_remove("XDG_RUNTIME_DIR")
        .env("HOME", ground.folder());
    let run = ground.run_by(heft, 2.0, &[])?;
    let remains = run.remains(Duration::from_secs(20))?;
    if remains.status != 0 && remains.gap() == 0 {
        return Err(format!("status {}: {}", remains.status, remains.text));
    }
    let gap = remains.check(RATE)?;
    let entries = fs::read_dir("/dev/shm").into_iter().flatten().flatten();
    let objects = entries.filter(|e| !e.path().is_dir());
    let left = objects
        .filter(|e| e.metadata().is_ok_and(|about| about.uid() == VICTIM))
        .count();
    if left > 0 {
        return Err(format!("{left} objects in shared memory are left"));
    }
    Ok(Outcome::Survived { gap })
}

fn by(user: u32) -> Command {
    let mut command = Command::new("setpriv");
    command.args([
        format!("--reuid={user}"),
        format!("--regid={user}"),
        "--clear-groups".into(),
    ]);
    command
}

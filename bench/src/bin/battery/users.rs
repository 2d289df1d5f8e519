//! Another user of the host tries to read, truncate, replace and signal the products of a run.

use std::process::Command;
use std::time::Duration;

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::Ground;

pub struct SecondUser;

/// Every line must fail for the other user. No line creates missing files, because a connection may disappear between two lines.
const ATTEMPTS: &str = "
for f in /dev/shm/heft-*.$DOMAIN* $OUT/* $HOME_OF_RUN $HOME_OF_RUN/*; do
  test -e $f || continue # connections come and go
  cat $f && echo read $f
  truncate -c -s 0 $f && test -e $f && echo shortened $f
  ( flock -n 9 && echo locked $f ) 9<$f
  rm -r $f && echo removed $f
  mv -T $f $f.moved && echo moved $f
done
for p in $PIDS; do kill -0 $p && echo signalled $p; done
true";

impl Attack for SecondUser {
    fn name(&self) -> String {
        "second user".into()
    }

    fn attempt(&mut self, _rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        let foe = ["--reuid=65534", "--regid=65534", "--clear-groups"];
        let can = Command::new("setpriv").args(foe).arg("true").status();
        if !can.is_ok_and(|status| status.success()) {
            return Ok(Outcome::Skipped);
        }
        let run = ground.run(4.0, &[])?;
        run.wait_for_all()?;
        std::thread::sleep(Duration::from_millis(500));
        let pids: Vec<String> = run
            .service("kalman")
            .into_iter()
            .chain(run.service("logger"))
            .map(|p| p.to_string())
            .collect();
        let home = format!("/dev/shm/heft-{}", rustix::process::geteuid().as_raw());
        let output = Command::new("setpriv")
            .args(foe)
            .args(["sh", "-c", ATTEMPTS])
            .env("DOMAIN", ground.domain())
            .env("OUT", ground.folder().join("out"))
            .env("HOME_OF_RUN", home)
            .env("PIDS", pids.join(" "))
            .output()
            .map_err(|e| e.to_string())?;
        let done = String::from_utf8_lossy(&output.stdout).into_owned();
        let remains = run.remains(Duration::from_secs(8))?;
        if !done.is_empty() {
            return Err(format!("another user could do this:\n{done}"));
        }
        if remains.status != 0 {
            return Err(format!("status {}: {}", remains.status, remains.text));
        }
        let gap = remains.check(0)?;
        Ok(Outcome::Survived { gap })
    }
}

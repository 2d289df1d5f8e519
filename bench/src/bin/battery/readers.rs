//! Every reader on damaged recordings: it returns all that the run wrote, or reports that it does not.
//!
//! Python is tested if `import heft` works in `python3`, or in the interpreter of HEFT_PYTHON.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use recording::Reader;

use crate::attack::{Attack, Outcome, Rng};
use crate::files::{Damage, Original, rows};
use crate::ground::Ground;

/// Damaged copies per attempt.
const COPIES: usize = 4;
/// The channel that `estimate`, `loads` and `report` require.
const SENSORS: &str = "excavator/sensors";
/// Reads a recording, and prints every warning and the error of the package.
const PYTHON: &str = "
import sys, warnings, heft
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter('always')
    try:
        frames = heft.read(sys.argv[1])
    except heft.HeftError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
for warning in said:
    print(warning.message, file=sys.stderr)
";

#[derive(Default)]
pub struct Readers {
    original: Option<Original>,
    read: u32,
    python: u32,
}

impl Attack for Readers {
    fn name(&self) -> String {
        "readers of damaged recordings".into()
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        let original = match self.original.take() {
            Some(original) => original,
            None => Original::make(ground)?,
        };
        let mut outcome = Ok(Outcome::Survived { gap: 0 });
        for _ in 0..COPIES {
            let damage = rng.one(&[Damage::Cut, Damage::Flip]);
            let (bytes, what) = original.damaged(damage, rng);
            let file = ground.folder().join("damaged.mcap");
            fs::write(&file, bytes).map_err(|e| e.to_string())?;
            if let Err(why) = self.judge(&file, &original, ground) {
                outcome = Err(format!("{what}: {why}"));
            }
        }
        self.original = Some(original);
        outcome
    }

    fn note(&self) -> Option<String> {
        let Self { read, python, .. } = self;
        Some(format!(
            "{}: {read} readings, {python} of them by Python",
            self.name()
        ))
    }
}

impl Readers {
    fn judge(&mut self, file: &Path, original: &Original, ground: &Ground) -> Result<(), String> {
        let found = Reader::open(file)
            .map(|reader| rows(&reader))
            .unwrap_or_default();
        let is_short = found != original.rows;
        let lacks_samples = found.get(SENSORS) != original.rows.get(SENSORS);
        for (words, needs_all) in [
            ("export", true),
            ("report", true),
            ("estimate", false),
            ("loads", false),
        ] {
            let mut command = ground.heft();
            command
                .arg(words)
                .arg(file)
                .arg("-o")
                .arg(ground.folder().join(format!("read.{words}")));
            if words != "export" && words != "report" {
                command.args(["--machine", "excavator"]);
            }
            let output = command.output().map_err(|e| e.to_string())?;
            self.read += 1;
            let lost = if needs_all { is_short } else { lacks_samples };
            is_said(words, &output, lost, true)?;
            let _ = fs::remove_dir_all(ground.folder().join("read.export"));
        }
        let interpreter = std::env::var("HEFT_PYTHON").unwrap_or_else(|_| "python3".into());
        let python = |code: &str| {
            Command::new(&interpreter)
                .args(["-c", code])
                .arg(file)
                .output()
        };
        if python("import heft").is_ok_and(|output| output.status.success()) {
            let output = python(PYTHON).map_err(|e| e.to_string())?;
            (self.read, self.python) = (self.read + 1, self.python + 1);
            is_said("heft.read of Python", &output, is_short, false)?;
        }
        Ok(())
    }
}

/// Checks that a reader reported an incomplete result; a command must also set its status.
fn is_said(reader: &str, output: &Output, lost: bool, costs_status: bool) -> Result<(), String> {
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.code().is_none_or(|code| code > 2) || said.contains("panicked") {
        return Err(format!("{reader}: {}: {said}", output.status));
    }
    if lost && said.trim().is_empty() {
        return Err(format!(
            "{reader}: something is missing and nothing is said"
        ));
    }
    if lost && costs_status && output.status.success() {
        return Err(format!(
            "{reader}: something is missing and the status is 0: {said}"
        ));
    }
    Ok(())
}

//! `--state` on files that are no state of heft, and on states that do not fit, in sequence: no foreign file is changed, and no
//! learnt state is lost.

use std::fs;
use std::path::Path;
use std::time::Duration;

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::Ground;

pub struct States;

/// Contents of the path.
#[derive(Clone, Copy, Debug)]
enum There {
    Folder,
    Table,
    Json,
    Link,
    Pipe,
}

impl Attack for States {
    fn name(&self) -> String {
        "--state on what is not its own".into()
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        use There::*;
        let there = rng.one(&[Folder, Table, Json, Link, Pipe]);
        let home = ground.folder().join("home");
        fs::create_dir_all(&home).map_err(|e| e.to_string())?;
        make(there, &home)?;
        let before = what_is_in(&home);
        let (status, said) = run(ground, "excavator", &home.join("x"), "none")?;
        if status != 2 || what_is_in(&home) != before {
            let after = what_is_in(&home);
            return Err(format!(
                "{there:?}: status {status}, {before:?} became {after:?}: {said}"
            ));
        }
        refused_twice(ground)?;
        Ok(Outcome::Survived { gap: 0 })
    }
}

fn make(there: There, home: &Path) -> Result<(), String> {
    let (path, other) = (home.join("x"), home.join("other"));
    let made = match there {
        There::Folder => fs::create_dir(&path).and_then(|()| fs::write(path.join("mine"), "mine")),
        There::Table => fs::write(&path, "time,torque\n0,1\n"),
        There::Json => fs::write(&path, "{\"mine\": 1}"),
        There::Link => {
            fs::write(&other, "mine").and_then(|()| std::os::unix::fs::symlink(&other, &path))
        }
        There::Pipe => {
            let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
            let made =
                rustix::fs::mknodat(rustix::fs::CWD, &path, rustix::fs::FileType::Fifo, mode, 0);
            made.map_err(std::io::Error::from)
        }
    };
    made.map_err(|e| e.to_string())
}

/// A state of another machine file is retained, and so is the next one: none overwrites another.
fn refused_twice(ground: &Ground) -> Result<(), String> {
    let home = ground.folder().join("own");
    fs::create_dir_all(&home).map_err(|e| e.to_string())?;
    let file = home.join("x");
    let mut refused = Vec::new();
    for machine in ["excavator", "loader", "excavator"] {
        if let Ok(text) = fs::read(&file) {
            refused.push(text);
        }
        let (status, said) = run(ground, machine, &file, machine)?;
        if status != 0 {
            return Err(format!(
                "a state of another machine: status {status}: {said}"
            ));
        }
    }
    for (k, text) in refused.iter().enumerate() {
        let name = if k == 0 {
            "x.refused".into()
        } else {
            format!("x.refused-{}", k + 1)
        };
        if fs::read(home.join(&name)).ok().as_ref() != Some(text) {
            return Err(format!(
                "{name} is not what was refused: {:?}",
                what_is_in(&home)
            ));
        }
    }
    Ok(())
}

/// A short run with this state; returns its status and its output.
fn run(ground: &Ground, machine: &str, state: &Path, out: &str) -> Result<(i32, String), String> {
    let mut command = ground.heft_behind(&["timeout", "20"]);
    command.args([
        "run",
        machine,
        "--quiet",
        "--no-report",
        "--duration",
        "0.3",
        "--pace",
        "max",
        "--state",
    ]);
    command
        .arg(state)
        .arg("--out")
        .arg(ground.folder().join(format!("out-{out}")));
    let output = command.output().map_err(|e| e.to_string())?;
    std::thread::sleep(Duration::from_millis(10));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    Ok((output.status.code().unwrap_or(-1), said))
}

/// Name, kind and text of everything in a folder and in the folders in it.
fn what_is_in(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let Ok(kind) = entry.file_type() else {
            continue;
        };
        let name = entry.file_name().to_string_lossy().into_owned();
        let text = if kind.is_file() {
            fs::read_to_string(entry.path()).unwrap_or_default()
        } else {
            String::new()
        };
        found.push(format!("{name} {kind:?} {text}"));
        if kind.is_dir() {
            found.extend(what_is_in(&entry.path()));
        }
    }
    found.sort();
    found
}

//! Mutated inputs for every parser, and mutated recordings up to their report. Each target runs in a
//! process of its own, with a limit of memory and of time, so that whatever it does is noticed.
//!
//! Chance with a seed, guided by nothing: coverage-guided fuzzing needs a nightly compiler.

mod memory;
mod mutate;
mod targets;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::Ground;
use mutate::mutate;
use targets::{TARGETS, Target};

/// How long a target has its turn.
const TURN: Duration = Duration::from_secs(2);
/// No single input may take longer than this, on a loaded machine and in the slowest build.
const PATIENCE: Duration = Duration::from_secs(30);

struct Fuzz {
    target: &'static Target,
    /// Inputs so far.
    inputs: u64,
}

/// One attack a target.
pub fn all() -> impl Iterator<Item = Box<dyn Attack>> {
    TARGETS
        .iter()
        .map(|target| Box::new(Fuzz { target, inputs: 0 }) as Box<dyn Attack>)
}

impl Attack for Fuzz {
    fn name(&self) -> String {
        format!("fuzz {}", self.target.name)
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        let (seed, folder) = (rng.between(0, u64::MAX), ground.folder());
        self.inputs += apart(self.target.name, TURN, seed, folder)?;
        Ok(Outcome::Survived { gap: 0 })
    }

    fn note(&self) -> Option<String> {
        Some(format!("{}: {} inputs", self.name(), self.inputs))
    }
}

/// Runs a target in a process of its own; the number of inputs that it survived. An input that it did
/// not is kept.
fn apart(target: &str, time: Duration, seed: u64, folder: &Path) -> Result<u64, String> {
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let mut child = Command::new(program)
        .args(["--fuzz", target, "--seed", &seed.to_string()])
        .args(["--seconds", &time.as_secs_f64().to_string()])
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(fs::File::create(folder.join("said")).map_err(|e| e.to_string())?)
        .spawn()
        .map_err(|e| e.to_string())?;
    let begun = Instant::now();
    let status = loop {
        match child.try_wait().map_err(|e| e.to_string())? {
            Some(status) => break Some(status),
            None if begun.elapsed() > time + PATIENCE => {
                let _ = child.kill();
                let _ = child.wait();
                break None;
            }
            None => std::thread::sleep(Duration::from_millis(10)),
        }
    };
    let printed = child.wait_with_output().map_err(|e| e.to_string())?.stdout;
    if status.is_some_and(|status| status.success()) {
        return Ok(String::from_utf8_lossy(&printed)
            .trim()
            .parse()
            .unwrap_or(0));
    }
    let said = fs::read_to_string(folder.join("said")).unwrap_or_default();
    let kept = keep(target, seed, folder);
    let how = status.map_or_else(|| "no end".to_owned(), |status| status.to_string());
    Err(format!("{how}, seed {seed}, input {kept}: {said}"))
}

/// Keeps the last input of a target that failed, for the corpus.
fn keep(target: &str, seed: u64, folder: &Path) -> String {
    let at = std::env::temp_dir().join(format!("heft-finding-{target}-{seed}"));
    match fs::copy(folder.join(targets::INPUT), &at) {
        Ok(_) => at.display().to_string(),
        Err(e) => format!("lost ({e})"),
    }
}

/// The program as one target: first the corpus as it is, then mutations of it, in the folder where it
/// was started. Prints how many inputs there were.
pub fn run(name: &str, seconds: f64, seed: u64) -> Result<(), String> {
    let known: Vec<&str> = TARGETS.iter().map(|t| t.name).collect();
    let target = TARGETS.iter().find(|t| t.name == name);
    let target = target.ok_or_else(|| format!("no target {name}; known: {}", known.join(", ")))?;
    let corpus = corpus(target);
    if corpus.is_empty() {
        return Err(format!("the corpus of {name} is empty"));
    }
    let mut rng = Rng::new(seed);
    let begun = Instant::now();
    let mut count = 0_u64;
    let mut input = Vec::new();
    while count < corpus.len() as u64 || begun.elapsed().as_secs_f64() < seconds {
        input.clone_from(&corpus[count as usize % corpus.len()]);
        if count >= corpus.len() as u64 {
            input.clone_from(&corpus[rng.between(0, corpus.len() as u64) as usize]);
            mutate(&mut input, &corpus, &mut rng);
        }
        fs::write(targets::INPUT, &input).map_err(|e| e.to_string())?;
        memory::limited(|| (target.run)(&input))?;
        count += 1;
    }
    println!("{count}");
    Ok(())
}

/// Inputs to begin with: files of the project's tests, and everything that was found before.
fn corpus(target: &Target) -> Vec<Vec<u8>> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
    let found = fs::read_dir(root.join("tests/fuzz").join(target.name));
    let found = found.into_iter().flatten().flatten().map(|e| e.path());
    let named = target.seeds.iter().map(|file| root.join(file));
    let mut files: Vec<PathBuf> = named.chain(found).collect();
    files.sort();
    let read = |file: PathBuf| {
        let mut bytes = fs::read(file).ok()?;
        bytes.truncate(target.longest);
        Some(bytes)
    };
    let made = target.made.map(|made| made());
    files.into_iter().filter_map(read).chain(made).collect()
}

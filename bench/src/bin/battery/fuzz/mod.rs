//! The targets of `bench/fuzz` with random mutations from a seed. Each target runs in a separate process with a limit of memory
//! and of time, so that every failure is noticed. `bench/fuzz/guided` mutates the inputs of the same targets by their coverage.

mod mutate;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio, abort};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

use fuzz::{Limited, TARGETS, Target, limited};

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::Ground;
use mutate::mutate;

#[global_allocator]
static ALLOCATOR: Limited = Limited;

/// Time for a target per attempt.
const TURN: Duration = Duration::from_secs(2);
/// Time limit of a single input, on a loaded machine and in the slowest build.
const PATIENCE: Duration = Duration::from_secs(30);
/// File of the present input, in the folder of the process.
const INPUT: &str = "input";

struct Fuzz {
    target: &'static Target,
    /// Inputs tried.
    inputs: u64,
}

/// One attack per target.
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
        self.inputs += apart(self.target.name, seed, folder)?;
        Ok(Outcome::Survived { gap: 0 })
    }

    fn note(&self) -> Option<String> {
        Some(format!("{}: {} inputs", self.name(), self.inputs))
    }
}

/// Runs a target in a separate process; returns the number of inputs that it survived. An input that fails is saved.
fn apart(target: &str, seed: u64, folder: &Path) -> Result<u64, String> {
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let output = Command::new(program)
        .args(["--fuzz", target, "--seed", &seed.to_string()])
        .args(["--seconds", &TURN.as_secs_f64().to_string()])
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .map_err(|e| e.to_string())?;
    let printed = String::from_utf8_lossy(&output.stdout);
    if output.status.success() {
        return Ok(printed.trim().parse().unwrap_or(0));
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let kept = keep(target, seed, folder);
    Err(format!(
        "{}, seed {seed}, input {kept}: {said}",
        output.status
    ))
}

/// Saves the last input of a target that failed, for the corpus.
fn keep(target: &str, seed: u64, folder: &Path) -> String {
    let at = std::env::temp_dir().join(format!("heft-finding-{target}-{seed}"));
    match fs::copy(folder.join(INPUT), &at) {
        Ok(_) => at.display().to_string(),
        Err(e) => format!("lost ({e})"),
    }
}

/// Runs the program as one target, in the folder where it was started: first the unchanged corpus, then mutations of it. Prints
/// the number of inputs.
pub fn run(name: &str, seconds: f64, seed: u64) -> Result<(), String> {
    let target = fuzz::target(name)?;
    let corpus = target.corpus();
    if corpus.is_empty() {
        return Err(format!("the corpus of {name} is empty"));
    }
    std::thread::spawn(watch);
    let mut rng = Rng::new(seed);
    let begun = Instant::now();
    let mut input = Vec::new();
    while DONE.load(Relaxed) < corpus.len() as u64 || begun.elapsed().as_secs_f64() < seconds {
        let count = DONE.load(Relaxed) as usize;
        input.clone_from(&corpus[count % corpus.len()]);
        if count >= corpus.len() {
            input.clone_from(&corpus[rng.between(0, corpus.len() as u64) as usize]);
            mutate(&mut input, &corpus, &mut rng);
        }
        fs::write(INPUT, &input).map_err(|e| e.to_string())?;
        limited(|| (target.run)(&input))?;
        DONE.fetch_add(1, Relaxed);
    }
    println!("{}", DONE.load(Relaxed));
    Ok(())
}

/// Inputs that this process has survived.
static DONE: AtomicU64 = AtomicU64::new(0);

/// Aborts the process when an input takes too long.
fn watch() {
    loop {
        let before = DONE.load(Relaxed);
        std::thread::sleep(PATIENCE);
        if DONE.load(Relaxed) == before {
            eprintln!("an input takes longer than {} s", PATIENCE.as_secs());
            abort();
        }
    }
}

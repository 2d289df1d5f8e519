//! Runs of one machine with a wrong clock, over a router and a collector: each run is in the history, whatever its clock.
//!
//! Needs `heft-fleet` and `heft-gateway` beside heft or in PATH, and `faketime`. The attack with invented names needs a client of
//! Zenoh: services/gateway/tests/clocks.rs.

use std::collections::BTreeMap;
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::Ground;

pub struct Clocks;

/// A right clock, one an hour late, one most of a day ahead, and one of a machine that has not yet received the time.
const CLOCKS: [&str; 4] = ["+0h", "-1h", "+20h", "@1970-01-01 00:01:00"];
/// Length of a run \[s\].
const SECONDS: &str = "3";

/// A process that ends with the attempt.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Attack for Clocks {
    fn name(&self) -> String {
        "fleet: clocks of a machine".into()
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        if !works(ground.heft().args(["fleet", "--help"])) || !works(faketime("+0h").arg("true")) {
            return Ok(Outcome::Skipped);
        }
        let port = TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr());
        let router = format!("tcp/{}", port.map_err(|e| e.to_string())?);
        let db = ground.folder().join("fleet.sqlite");
        let _router = quietly(ground.heft().args(["fleet", "router", "--listen", &router]))?;
        let mut collector = ground.heft();
        collector.args([
            "fleet",
            "--connect",
            &router,
            "--page",
            "127.0.0.1:0",
            "--db",
        ]);
        let _collector = quietly(collector.arg(&db))?;
        std::thread::sleep(Duration::from_secs(2));
        let clocks = rng.some(&CLOCKS, CLOCKS.len());
        for clock in &clocks {
            machine(ground, clock, &router)?;
        }
        let begun = Instant::now();
        loop {
            let judged = judge(&runs(ground, &db)?, clocks.len());
            if judged.is_ok() || begun.elapsed() > Duration::from_secs(20) {
                let explained = |why| format!("clocks {clocks:?}: {why}");
                return judged
                    .map(|()| Outcome::Survived { gap: 0 })
                    .map_err(explained);
            }
            std::thread::sleep(Duration::from_millis(500));
        }
    }
}

/// Whether there are `count` runs of full length: they simulate the same.
fn judge(runs: &BTreeMap<u64, usize>, count: usize) -> Result<(), String> {
    let most = runs.values().copied().max();
    let whole = runs.values().all(|n| Some(*n) == most);
    if runs.len() == count && whole {
        return Ok(());
    }
    Err(format!(
        "{count} runs were sent; estimates stored of each: {runs:?}"
    ))
}

/// One run of the machine with that clock.
fn machine(ground: &Ground, clock: &str, router: &str) -> Result<(), String> {
    let mut words = faketime(clock);
    words.arg(ground.program()).args([
        "run",
        "excavator",
        "--quiet",
        "--no-report",
        "--rate",
        "50",
    ]);
    words.args([
        "--duration",
        SECONDS,
        "--site",
        "north",
        "--machine-id",
        "ex-9",
        "--fleet",
        router,
    ]);
    words
        .arg("--out")
        .arg(ground.folder().join("run"))
        .args(["--domain", ground.domain()]);
    let output = words
        .stdin(Stdio::null())
        .output()
        .map_err(|e| e.to_string())?;
    if output.status.code().is_none_or(|code| code > 1) {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!("clock {clock}: {}: {said}", output.status));
    }
    Ok(())
}

/// Estimates of each run in the history.
fn runs(ground: &Ground, db: &Path) -> Result<BTreeMap<u64, usize>, String> {
    let mut query = ground.heft();
    query.args([
        "fleet",
        "query",
        "--what",
        "estimates",
        "--format",
        "json",
        "--db",
    ]);
    let output = query.arg(db).output().map_err(|e| e.to_string())?;
    let mut runs = BTreeMap::new();
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let message: serde_json::Value = serde_json::from_str(line).map_err(|e| e.to_string())?;
        let run = message["run"].as_u64().ok_or("an estimate of no run")?;
        *runs.entry(run).or_default() += 1;
    }
    Ok(runs)
}

/// Changes the wall clock only.
fn faketime(clock: &str) -> Command {
    let mut command = Command::new("faketime");
    command
        .env("FAKETIME_DONT_FAKE_MONOTONIC", "1")
        .args(["-f", clock]);
    command
}

fn works(command: &mut Command) -> bool {
    let command = command.stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

fn quietly(command: &mut Command) -> Result<Process, String> {
    let command = command.stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().map(Process).map_err(|e| e.to_string())
}

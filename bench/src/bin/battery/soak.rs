//! `battery --soak MINUTES`: both machines at once in real time, with bounded recordings. It measures the slope of the memory of
//! every process, its descriptors, and the disk usage.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use crate::ground::Ground;

/// Sampling period of the measurements.
const PERIOD: Duration = Duration::from_secs(5);
/// Share of the time that the slopes leave out at the beginning, while buffers fill once.
const WARM_UP: f64 = 0.25;
/// Permitted growth: a slope, and pages touched for the first time during the soak [kB/min], \[kB\].
const SLOPE: f64 = 1.0;
const PAGES: f64 = 256.0;
/// Disk usage of a run: `--keep`, and the part that is being written.
const KEEP: &str = "20MB";
const MOST: u64 = 24_000_000;

/// Course of one process: time \[min\], own memory \[kB\], descriptors.
type Course = Vec<(f64, f64, usize)>;

/// Runs for `minutes` and prints the table; returns whether nothing grows.
pub fn run(heft: &Path, minutes: f64) -> Result<bool, String> {
    let ground = Ground::new(heft, 0);
    let machines = ["excavator", "loader"];
    let folders = machines.map(|machine| ground.folder().join(machine));
    let mut runs: Vec<Child> = Vec::new();
    for (machine, folder) in machines.iter().zip(&folders) {
        runs.push(start(&ground, machine, folder, minutes)?);
    }
    let begun = Instant::now();
    let mut courses: BTreeMap<String, Course> = BTreeMap::new();
    let mut most = 0;
    while runs
        .iter_mut()
        .any(|run| matches!(run.try_wait(), Ok(None)))
    {
        let time = begun.elapsed().as_secs_f64() / 60.0;
        if time > minutes + 1.0 {
            for pid in runs.iter().filter_map(|run| Pid::from_raw(run.id() as i32)) {
                let _ = kill_process(pid, Signal::TERM);
            }
            return Err("a run does not end".into());
        }
        for (name, memory, descriptors) in processes(ground.domain()) {
            courses
                .entry(name)
                .or_default()
                .push((time, memory, descriptors));
        }
        most = folders.iter().map(|f| size(f)).max().unwrap_or(0).max(most);
        std::thread::sleep(PERIOD);
    }
    let mut good = most <= MOST;
    println!(
        "{:<22} {:>9} {:>12} {:>12} {:>12}",
        "process", "looks", "memory kB", "slope kB/min", "descriptors"
    );
    for (name, course) in &courses {
        let later: Course = course
            .iter()
            .filter(|c| c.0 >= WARM_UP * minutes)
            .copied()
            .collect();
        let (Some(first), Some(last)) = (later.first(), later.last()) else {
            continue;
        };
        let slope = slope(&later);
        good &= slope <= SLOPE + PAGES / minutes && last.2 <= first.2 + 2;
        let descriptors = format!("{} to {}", first.2, last.2);
        println!(
            "{name:<22} {:>9} {:>12.0} {slope:>12.2} {descriptors:>12}",
            course.len(),
            last.1
        );
    }
    for (machine, run) in machines.iter().zip(&mut runs) {
        let status = run.wait().map_err(|e| e.to_string())?;
        let said = fs::read_to_string(ground.folder().join(format!("{machine}.said")));
        println!(
            "{machine}: {status}\n{}",
            said.unwrap_or_default().trim_end()
        );
        // A loaded machine may lose samples, which the status reports.
        good &= status.code().is_some_and(|code| code < 2);
    }
    println!(
        "at most {:.1} MB of recordings a machine, {KEEP} and a part asked for",
        most as f64 / 1e6
    );
    Ok(good)
}

/// A run of a working machine with a bounded recording.
fn start(ground: &Ground, machine: &str, folder: &Path, minutes: f64) -> Result<Child, String> {
    let said = fs::File::create(ground.folder().join(format!("{machine}.said")));
    let said = said.map_err(|e| e.to_string())?;
    let scenario = if machine == "loader" {
        "work-cycle"
    } else {
        "cycle"
    };
    let mut command: Command = ground.heft();
    command.args([
        "run",
        machine,
        "--scenario",
        scenario,
        "--quiet",
        "--no-report",
    ]);
    command.args(["--duration", &(60.0 * minutes).to_string()]);
    command
        .args(["--split", "2MB", "--keep", KEEP, "--out"])
        .arg(folder);
    command.args(["--domain", &format!("{}-{machine}", ground.domain())]);
    let other = said.try_clone().map_err(|e| e.to_string())?;
    command.stdout(Stdio::from(said)).stderr(other);
    command.spawn().map_err(|e| e.to_string())
}

/// Every process of both runs: its name, its own memory \[kB\], its descriptors.
fn processes(domain: &str) -> Vec<(String, f64, usize)> {
    let entries = fs::read_dir("/proc").into_iter().flatten().flatten();
    let about = |entry: fs::DirEntry| {
        let line = fs::read(entry.path().join("cmdline")).ok()?;
        let words: Vec<String> = line
            .split(|b| *b == 0)
            .map(|w| String::from_utf8_lossy(w).into_owned())
            .collect();
        let machine = words
            .iter()
            .find_map(|w| w.strip_prefix(domain)?.strip_prefix('-'))?;
        let role = if words.get(1).is_some_and(|w| w == "service") {
            words.get(2)?.as_str()
        } else {
            "supervisor"
        };
        let status = fs::read_to_string(entry.path().join("status")).ok()?;
        let memory = status.lines().find_map(|l| l.strip_prefix("RssAnon:"))?;
        let memory = memory.trim().strip_suffix(" kB")?.parse().ok()?;
        let descriptors = fs::read_dir(entry.path().join("fd")).ok()?.count();
        Some((format!("{machine} {role}"), memory, descriptors))
    };
    entries.filter_map(about).collect()
}

fn size(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .filter_map(|e| e.metadata().ok())
        .map(|m| m.len())
        .sum()
}

/// Slope by least squares [kB/min].
fn slope(course: &Course) -> f64 {
    let n = course.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64, usize)) -> f64| course.iter().map(of).sum::<f64>() / n;
    let (time, memory) = (mean(&|c| c.0), mean(&|c| c.1));
    let spread: f64 = course.iter().map(|c| (c.0 - time).powi(2)).sum();
    let both: f64 = course.iter().map(|c| (c.0 - time) * (c.1 - memory)).sum();
    if spread > 0.0 { both / spread } else { 0.0 }
}

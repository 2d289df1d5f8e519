//! Whole pipelines side by side: cost of a machine as separate processes, by the processor time that the system counts.
//!
//! Each machine is a run of `heft run`: sensor, kalman, rls, ukf, logger and their supervisor. Starting costs more than running,
//! so every count is the difference of a long and a short run.
//!
//! The system's part of it is that of as many bare chains ([`limits`]). They have four processes each, as many as a machine wakes
//! with every sample, which only sleep and wake the next by a futex.

use limits::{Options, Primitive};
use rustix::param::clock_ticks_per_second;
use std::collections::BTreeSet;
use std::io;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Numbers of machines. If 80 start at once on two cores (480 processes), some are not ready in time.
pub const MACHINES: [usize; 4] = [1, 10, 20, 40];
/// Lengths of the two runs [s].
const LENGTHS: [u64; 2] = [4, 16];
/// Samples a second [Hz].
const RATE: u64 = 100;

/// Cost of a number of pipelines.
#[derive(Debug, Clone, Copy)]
pub struct Cost {
    /// Pipelines that ran at the same time.
    pub machines: usize,
    /// Processor time per machine and sample, all processes together \[ns\].
    pub sample_ns: f64,
    /// The same of bare chains of four processes \[ns\].
    pub bare_ns: f64,
    /// Memory per machine, with a share of shared pages \[bytes\].
    pub bytes: f64,
    /// Samples that some process did not receive.
    pub lost: u64,
}

/// Runs `machines` pipelines of the program `heft`.
///
/// # Errors
/// A pipeline cannot be started or fails.
pub fn measure(heft: &Path, machines: usize) -> io::Result<Cost> {
    let [short, long] = LENGTHS;
    let (start, _, _) = run(heft, machines, short)?;
    let (all, bytes, lost) = run(heft, machines, long)?;
    let bare = bare(machines, long)? - bare(machines, short)?;
    let samples = ((long - short) * RATE) as f64 * machines as f64;
    let per_sample = |seconds: f64| seconds.max(0.0) * 1e9 / samples;
    Ok(Cost {
        machines,
        sample_ns: per_sample(all - start),
        bare_ns: per_sample(bare),
        bytes,
        lost,
    })
}

/// Processor time [s], memory per machine [bytes] and lost samples of some pipelines.
fn run(heft: &Path, machines: usize, seconds: u64) -> io::Result<(f64, f64, u64)> {
    let folder = std::env::temp_dir().join(format!("heft-scale-{}", std::process::id()));
    let before = time_of_children()?;
    let pipelines: Vec<io::Result<Child>> = (0..machines)
        .map(|i| start(heft, &folder.join(i.to_string()), i, seconds))
        .collect();
    std::thread::sleep(Duration::from_secs(seconds / 2 + 1));
    let bytes = memory(pipelines.iter().flatten()) / machines as f64;
    // All are waited for before the first failure is reported, so that none disturbs the next measurement.
    let ended: Vec<io::Result<u64>> = pipelines.into_iter().map(|p| finish(p?)).collect();
    let _ = std::fs::remove_dir_all(&folder);
    let lost = ended.into_iter().sum::<io::Result<u64>>()?;
    Ok((time_of_children()? - before, bytes, lost))
}

/// Processor time of bare chains [s].
fn bare(machines: usize, seconds: u64) -> io::Result<f64> {
    let options = Options {
        rate_hz: RATE as f64,
        samples: (seconds * RATE) as usize,
        ..Options::default()
    };
    let before = time_of_children()?;
    std::thread::scope(|scope| {
        let chains: Vec<_> = (0..machines)
            .map(|_| scope.spawn(|| limits::chain(Primitive::Futex, &options)))
            .collect();
        let gone = |_| Err(io::Error::other("a thread of a bare chain panicked"));
        chains
            .into_iter()
            .try_for_each(|chain| chain.join().unwrap_or_else(gone).map(drop))
    })?;
    Ok(time_of_children()? - before)
}

/// Waits for a pipeline; returns the samples it lost.
fn finish(pipeline: Child) -> io::Result<u64> {
    let output = pipeline.wait_with_output()?;
    if output.status.success() {
        return Ok(lost_in(&String::from_utf8_lossy(&output.stdout)));
    }
    let text = String::from_utf8_lossy(&output.stderr);
    let reason = text.lines().find(|line| line.starts_with("heft: "));
    Err(io::Error::other(format!(
        "a pipeline ended with {}, {}",
        output.status,
        reason.unwrap_or("without a reason")
    )))
}

fn start(heft: &Path, folder: &Path, index: usize, seconds: u64) -> io::Result<Child> {
    Command::new(heft)
        .args(["run", "excavator", "--scenario", "cycle", "--quiet"])
        .arg("--no-report")
        .args(["--rate", &RATE.to_string()])
        .args(["--duration", &seconds.to_string()])
        .args(["--domain", &format!("scale-{}-{index}", std::process::id())])
        .arg("--out")
        .arg(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
}

/// Processor time of all children that have ended, and of their children [s].
fn time_of_children() -> io::Result<f64> {
    let fields = stat("self")?;
    // Fields 16 and 17 of proc(5); the first field here is the third there.
    let ticks: u64 = fields[13..=14]
        .iter()
        .filter_map(|f| f.parse::<u64>().ok())
        .sum();
    Ok(ticks as f64 / clock_ticks_per_second() as f64)
}

/// The fields of /proc/PID/stat after the name: the state, then the parent.
fn stat(pid: &str) -> io::Result<Vec<String>> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/stat"))?;
    let after_name = text.rsplit_once(')').map_or("", |(_, rest)| rest);
    let fields: Vec<String> = after_name.split_whitespace().map(str::to_owned).collect();
    if fields.len() < 15 {
        return Err(io::Error::other(format!("/proc/{pid}/stat is short")));
    }
    Ok(fields)
}

/// Memory of the pipelines: of their supervisors and of the supervisors' children [bytes].
fn memory<'a>(pipelines: impl Iterator<Item = &'a Child>) -> f64 {
    let supervisors: BTreeSet<String> = pipelines.map(|p| p.id().to_string()).collect();
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    entries
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|pid| {
            supervisors.contains(pid)
                || stat(pid).is_ok_and(|fields| supervisors.contains(&fields[1]))
        })
        .filter_map(|pid| proportional_set(&pid))
        .sum()
}

fn proportional_set(pid: &str) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/smaps_rollup")).ok()?;
    let line = text.lines().find(|line| line.starts_with("Pss:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024.0)
}

/// Sum of the numbers before the word `lost` in the summary of a run.
fn lost_in(summary: &str) -> u64 {
    let words: Vec<&str> = summary.split_whitespace().collect();
    words
        .windows(2)
        .filter(|pair| pair[1] == "lost")
        .filter_map(|pair| pair[0].parse::<u64>().ok())
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lost_samples_of_all_processes_are_added() {
        let summary = "  kalman  answers; 401 samples, 2 lost\n  ukf  401 samples, 3 lost\n  kept what was lost";
        assert_eq!(lost_in(summary), 5);
    }

    #[test]
    fn processor_time_of_ended_children_is_counted() {
        let before = time_of_children().unwrap();
        let spin = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done";
        Command::new("sh").args(["-c", spin]).status().unwrap();
        // The loop takes at least some ticks of 10 ms.
        assert!(time_of_children().unwrap() > before + 0.02);
    }

    #[test]
    fn a_pipeline_that_fails_is_reported_with_its_reason() {
        let script = "echo 'warning: slow' >&2; echo 'heft: kalman did not get ready' >&2; exit 1";
        let child = Command::new("sh")
            .args(["-c", script])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let text = finish(child).unwrap_err().to_string();
        assert!(
            text.contains("exit status: 1") && text.contains("kalman"),
            "{text}"
        );
    }
}

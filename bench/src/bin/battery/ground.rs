//! Environment of an attack: a pipeline in a folder and a domain of its own, and its remains.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use messages::{ExcavatorEstimate, ExcavatorSensors, Message};
use recording::Reader;
use rustix::process::{Pid, Signal, kill_process};

/// Samples a second.
pub const RATE: u64 = 200;
/// Services of the pipeline.
pub const SERVICES: [&str; 5] = ["sensor", "kalman", "rls", "ukf", "logger"];

/// Least length of a recording with samples, not only metadata \[bytes\].
const RECORDS: u64 = 20_000;

/// A folder, a domain and the program under attack.
pub struct Ground {
    heft: PathBuf,
    domain: String,
    folder: PathBuf,
}

impl Ground {
    /// A new environment.
    pub fn new(heft: &Path, number: u32) -> Self {
        let domain = format!("battery-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(&domain);
        let _ = fs::create_dir(&folder);
        Self {
            heft: heft.to_owned(),
            domain,
            folder,
        }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Its domain, and prefix of the names of further ones.
    pub fn domain(&self) -> &str {
        &self.domain
    }

    /// The program under attack.
    pub fn program(&self) -> &Path {
        &self.heft
    }

    /// A command of heft.
    pub fn heft(&self) -> Command {
        let mut command = Command::new(&self.heft);
        command.stdin(Stdio::null());
        command
    }

    /// A command of heft after other words, which end in `exec`: another user, another clock.
    pub fn heft_behind(&self, words: &[&str]) -> Command {
        let mut command = Command::new(words[0]);
        command.args(&words[1..]).arg(&self.heft);
        command.stdin(Stdio::null());
        command
    }

    /// A run of `seconds` that records into this folder with little output.
    pub fn quiet_run(&self, seconds: &str, out: &Path) -> Command {
        let mut command = self.heft();
        command
            .args(["run", "excavator", "--quiet", "--no-report"])
            .args(["--duration", seconds, "--out"])
            .arg(out);
        command
    }

    /// Starts a run of `seconds`.
    pub fn run(&self, seconds: f64, more: &[&str]) -> Result<Run, String> {
        self.run_by(self.heft(), seconds, more)
    }

    /// Starts a run with this command of heft.
    pub fn run_by(&self, mut heft: Command, seconds: f64, more: &[&str]) -> Result<Run, String> {
        let (out, said) = (self.folder.join("out"), self.folder.join("said"));
        let file = fs::File::create(&said).map_err(|e| e.to_string())?;
        let other = file.try_clone().map_err(|e| e.to_string())?;
        let child = heft
            .args(["run", "excavator", "--quiet", "--no-report"])
            .args([
                "--rate",
                &RATE.to_string(),
                "--duration",
                &seconds.to_string(),
            ])
            .args(["--domain", &self.domain, "--out"])
            .arg(&out)
            .args(more)
            .stdout(file)
            .stderr(other)
            .spawn()
            .map_err(|e| e.to_string())?;
        Ok(Run {
            child,
            domain: self.domain.clone(),
            out,
            said,
        })
    }
}

impl Drop for Ground {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// A run under attack.
pub struct Run {
    child: Child,
    domain: String,
    out: PathBuf,
    said: PathBuf,
}

/// The remains of a run.
pub struct Remains {
    /// Exit status.
    pub status: i32,
    /// Its output.
    pub text: String,
    /// Numbers of the samples, and of their answers by `rls` and `ukf`.
    pub samples: Vec<u64>,
    pub answers: Vec<(&'static str, Vec<u64>)>,
}

impl Run {
    /// Process id of a service, if it runs.
    pub fn service(&self, name: &str) -> Option<u32> {
        fs::read_dir("/proc").ok()?.flatten().find_map(|entry| {
            let pid: u32 = entry.file_name().to_str()?.parse().ok()?;
            let line = fs::read(entry.path().join("cmdline")).ok()?;
            let mut words = line.split(|b| *b == 0);
            let is = |word: Option<&[u8]>, wanted: &str| word == Some(wanted.as_bytes());
            words.next();
            (is(words.next(), "service")
                && is(words.next(), name)
                && words.any(|w| w == self.domain.as_bytes()))
            .then_some(pid)
        })
    }

    /// Waits until a service runs.
    pub fn wait_for(&self, name: &str) -> Result<u32, String> {
        let begun = Instant::now();
        loop {
            if let Some(pid) = self.service(name) {
                return Ok(pid);
            }
            if begun.elapsed() > Duration::from_secs(20) {
                return Err(format!("{name} did not appear: {}", self.text()));
            }
            std::thread::sleep(Duration::from_micros(500));
        }
    }

    /// Waits until all services run and samples are recorded: a loaded machine starts slowly.
    pub fn wait_for_all(&self) -> Result<(), String> {
        SERVICES
            .iter()
            .try_for_each(|name| self.wait_for(name).map(|_| ()))?;
        let begun = Instant::now();
        let file = self.out.join("run.mcap");
        while fs::metadata(&file).map_or(0, |file| file.len()) < RECORDS {
            if begun.elapsed() > Duration::from_secs(20) {
                return Err(format!("nothing is recorded: {}", self.text()));
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        Ok(())
    }

    /// Its supervisor.
    pub fn supervisor(&self) -> u32 {
        self.child.id()
    }

    /// Signals a service, if it runs.
    pub fn signal(&self, name: &str, signal: Signal) {
        if let Some(pid) = self.service(name) {
            send(pid, signal);
        }
    }

    /// Asks the run to end.
    pub fn end(&self) {
        send(self.child.id(), Signal::TERM);
    }

    /// Its output so far.
    pub fn text(&self) -> String {
        fs::read_to_string(&self.said).unwrap_or_default()
    }

    /// Waits for the end, at most `limit`, and examines the remains.
    pub fn remains(mut self, limit: Duration) -> Result<Remains, String> {
        let begun = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().map_err(|e| e.to_string())? {
                break status;
            }
            if begun.elapsed() > limit {
                let _ = self.child.kill();
                let _ = self.child.wait();
                return Err(format!("did not end within {limit:?}: {}", self.text()));
            }
            std::thread::sleep(Duration::from_millis(2));
        };
        let text = self.text();
        let Some(status) = status.code() else {
            return Err(format!("ended by a signal: {text}"));
        };
        if text.contains("panicked") {
            return Err(format!("a panic: {text}"));
        }
        let left: Vec<&str> = SERVICES
            .into_iter()
            .filter(|n| self.service(n).is_some())
            .collect();
        if !left.is_empty() {
            return Err(format!("{left:?} still live: {text}"));
        }
        if shared_memory(&self.domain) {
            return Err(format!("shared memory is left: {text}"));
        }
        let file = self.out.join("run.mcap");
        let numbers = |e: String| format!("{e}: {text}");
        let answers = ["rls", "ukf"].map(|process| {
            let channel = format!("excavator/inertia_{process}");
            sequences::<ExcavatorEstimate>(&file, &channel).map(|numbers| (process, numbers))
        });
        Ok(Remains {
            status,
            samples: sequences::<ExcavatorSensors>(&file, "excavator/sensors").map_err(numbers)?,
            answers: answers
                .into_iter()
                .collect::<Result<_, _>>()
                .map_err(numbers)?,
            text,
        })
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Remains {
    /// Longest run of missing numbers in the samples or in their answers.
    pub fn gap(&self) -> u64 {
        let end = self
            .samples
            .iter()
            .chain(self.answers.iter().flat_map(|(_, a)| a))
            .max();
        let end = end.map_or(0, |last| last + 1);
        let all = self.answers.iter().map(|(_, a)| a).chain([&self.samples]);
        all.map(|numbers| longest_gap(numbers, end))
            .max()
            .unwrap_or(0)
    }

    /// Checks that nothing is lost without a report: a gap in the data requires status 1 and a text.
    pub fn check(&self, limit: u64) -> Result<u64, String> {
        let gap = self.gap();
        let reported = [
            "were not answered",
            "were not measured",
            "may have a gap",
            "has gaps",
            "died",
            "hung",
        ];
        if self.samples.is_empty() {
            return Err(format!("nothing was recorded: {}", self.text));
        }
        if gap > 0 && (self.status != 1 || !reported.iter().any(|words| self.text.contains(words)))
        {
            return Err(format!(
                "a gap of {gap}, status {}: {}",
                self.status, self.text
            ));
        }
        if gap > limit {
            return Err(format!(
                "a gap of {gap} samples, more than {limit}: {}",
                self.text
            ));
        }
        if self.status > 1 {
            return Err(format!("status {}: {}", self.status, self.text));
        }
        Ok(gap)
    }
}

fn longest_gap(numbers: &[u64], end: u64) -> u64 {
    let mut next = 0;
    let mut longest = 0;
    for &number in numbers.iter().chain([&end]) {
        longest = longest.max(number.saturating_sub(next));
        next = next.max(number + 1);
    }
    longest
}

fn send(pid: u32, signal: Signal) {
    if let Some(pid) = Pid::from_raw(pid as i32) {
        let _ = kill_process(pid, signal);
    }
}

/// Whether shared memory of this domain is left; that of another user under such a name does not count.
fn shared_memory(domain: &str) -> bool {
    let part = format!(".{domain}.");
    let user = rustix::process::geteuid().as_raw();
    let ours = |e: &fs::DirEntry| e.metadata().is_ok_and(|about| about.uid() == user);
    let mut entries = fs::read_dir("/dev/shm").into_iter().flatten().flatten();
    entries.any(|e| e.file_name().to_string_lossy().contains(&part) && ours(&e))
}

fn sequences<M: Message>(file: &Path, channel: &str) -> Result<Vec<u64>, String> {
    let reader = Reader::open(file).map_err(|e| e.to_string())?;
    let messages: Vec<M> = reader.messages(channel).map_err(|e| e.to_string())?;
    Ok(messages.iter().map(|m| m.stamp().sequence).collect())
}

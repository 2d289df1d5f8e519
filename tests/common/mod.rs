//! Common functions of the integration tests: running the binary as a user does.
#![allow(dead_code, reason = "each test uses its own part")]

pub mod machines;
pub mod table;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use recording::Reader;

/// The binary under test.
pub fn heft() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_heft"));
    command.stdin(Stdio::null());
    command
}

/// The words of a command line.
pub fn words(command: &str) -> Vec<&str> {
    command.split(' ').collect()
}

/// Runs it to its end.
pub fn run(args: &[&str]) -> Output {
    heft().args(args).output().expect("heft starts")
}

/// Runs it and expects success; the output is in the message otherwise.
pub fn run_ok(args: &[&str]) -> String {
    let output = run(args);
    assert!(
        output.status.success(),
        "heft {args:?}: {}\n{}",
        output.status,
        both(&output)
    );
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The name of a file in a folder, as an argument.
pub fn path_in(folder: &Path, name: &str) -> String {
    let path = folder.join(name);
    path.to_str().expect("a path").to_owned()
}

/// The whole output of a run.
pub fn both(output: &Output) -> String {
    format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}

/// Checks that the output of a run contains these words.
#[track_caller]
pub fn says(output: &Output, words: &str) {
    let said = both(output);
    assert!(said.contains(words), "`{words}` is missing in: {said}");
}

/// A domain name that no other test uses.
pub fn domain(name: &str) -> String {
    format!("t{}-{name}", std::process::id())
}

/// A golden file of the project.
pub fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden")
        .join(name)
}

/// A pipeline that runs in the background.
pub struct Running {
    pub child: Child,
    pub domain: String,
    pub folder: tempfile::TempDir,
}

impl Running {
    /// Starts `heft run` with its own domain and folder.
    pub fn start(name: &str, args: impl IntoIterator<Item: AsRef<OsStr>>) -> Self {
        Self::start_with(heft(), name, args)
    }

    /// The same with another copy of the binary, or another environment.
    pub fn start_with(
        mut heft: Command,
        name: &str,
        args: impl IntoIterator<Item: AsRef<OsStr>>,
    ) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let domain = domain(name);
        let child = heft
            .arg("run")
            .args(args)
            .args(["--quiet", "--no-report", "--domain", &domain, "--out"])
            .arg(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("heft starts");
        Self {
            child,
            domain,
            folder,
        }
    }

    pub fn recording(&self) -> PathBuf {
        self.folder.path().join("run.mcap")
    }

    /// Sends a signal to the supervisor.
    pub fn signal(&self, signal: rustix::process::Signal) {
        kill(self.child.id(), signal);
    }

    /// Waits for the end and returns what was printed.
    pub fn wait(self) -> (Output, tempfile::TempDir) {
        (
            self.child.wait_with_output().expect("heft ends"),
            self.folder,
        )
    }

    /// Process id of a service of this run.
    pub fn service(&self, name: &str) -> Option<u32> {
        processes().into_iter().find_map(|(pid, args)| {
            let ours = args.contains(&self.domain);
            (ours
                && args.get(1).is_some_and(|a| a == "service")
                && args.get(2).is_some_and(|a| a == name))
            .then_some(pid)
        })
    }

    /// Waits until all services of an excavator run exist.
    pub fn wait_for_services(&self) {
        wait_until("all services run", Duration::from_secs(20), || {
            ["sensor", "kalman", "rls", "ukf", "logger"]
                .iter()
                .all(|n| self.service(n).is_some())
        });
    }
}

/// Kills a process; its absence is no error.
pub fn kill(pid: u32, signal: rustix::process::Signal) {
    if let Some(pid) = rustix::process::Pid::from_raw(pid as i32) {
        let _ = rustix::process::kill_process(pid, signal);
    }
}

/// Living processes with their arguments.
pub fn processes() -> Vec<(u32, Vec<String>)> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir("/proc").expect("/proc").flatten() {
        let Some(pid) = entry.file_name().to_str().and_then(|n| n.parse().ok()) else {
            continue;
        };
        let Ok(text) = std::fs::read(entry.path().join("cmdline")) else {
            continue;
        };
        let args = text
            .split(|b| *b == 0)
            .filter(|a| !a.is_empty())
            .map(|a| String::from_utf8_lossy(a).into_owned())
            .collect::<Vec<_>>();
        if !args.is_empty() {
            all.push((pid, args));
        }
    }
    all
}

/// Processes of a domain that still live.
pub fn survivors(domain: &str) -> Vec<u32> {
    processes()
        .into_iter()
        .filter(|(_, args)| args.iter().any(|a| a == domain))
        .map(|(pid, _)| pid)
        .collect()
}

/// Files of a domain in shared memory.
pub fn shared_memory(domain: &str) -> Vec<String> {
    let names = |path: &str| -> Vec<String> {
        std::fs::read_dir(path)
            .into_iter()
            .flatten()
            .flatten()
            .map(|e| e.file_name().to_string_lossy().into_owned())
            .collect()
    };
    let mut found = names("/dev/shm");
    let user = rustix::process::geteuid().as_raw();
    found.retain(|n| n.starts_with(&format!("heft-{user}.{domain}.")));
    let folder = runtime::Domain::new(domain).expect("a name").folder();
    found.extend(folder.exists().then(|| domain.to_owned()));
    found
}

/// Waits until a condition holds.
pub fn wait_until(what: &str, limit: Duration, mut condition: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !condition() {
        assert!(begun.elapsed() < limit, "waited {limit:?} in vain: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Sequence numbers on a channel of a recording.
pub fn sequences<M: messages::Message>(recording: &Path, channel: &str) -> Vec<u64> {
    let reader = Reader::open(recording).expect("a recording");
    let messages: Vec<M> = reader.messages(channel).expect("its messages");
    messages.iter().map(|m| m.stamp().sequence).collect()
}

//! Fleets: `--fleet` runs `heft-gateway` beside a pipeline, and `heft fleet` is `heft-fleet`.
//!
//! Both are separate programs, so that a build for one machine does not compile Zenoh. The gateway reads
//! the channels as any program may; a run neither waits for it nor ends because of it.

use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use clap::Args;
use runtime::Domain;
use rustix::process::{Pid, Signal};
use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::notify::Notify;

/// Exit status of a gateway that cannot use what it was given.
const WRONG_USE: i32 = 2;
/// First pause before a gateway that died is started again; it doubles.
const FIRST_PAUSE: Duration = Duration::from_millis(500);
const LONGEST_PAUSE: Duration = Duration::from_secs(30);
/// Life above which a death is accidental: the pause starts from its first value again.
const LONG_LIFE: Duration = Duration::from_secs(10);
/// Longest wait of a run under a service manager for its gateway, from the begin of its end: less than the 30 s
/// (`TimeoutStopSec` of heft@.service) after which everything is killed, more than the 20 s for which a gateway still answers.
const END_LIMIT: Duration = Duration::from_secs(25);
/// Period of the checks whether it has ended.
const END_LOOK: Duration = Duration::from_millis(50);

/// `heft run ... --fleet`
#[derive(Debug, Clone, Default, Args)]
pub struct FleetArgs {
    /// Send what is found to a fleet, by this router of Zenoh (needs heft-gateway)
    #[arg(long, value_name = "tcp/HOST:PORT", requires_all = ["site", "machine_id"], value_parser = endpoint)]
    pub fleet: Option<String>,
    /// The site, for --fleet
    #[arg(long, requires = "fleet")]
    pub site: Option<String>,
    /// Name of the machine within its site, for --fleet
    #[arg(long, requires = "fleet")]
    pub machine_id: Option<String>,
    /// Send every sample of the sensors too, for `heft fleet serve` at the site: 10 to 20 kB a second at 100 Hz
    #[arg(long, requires = "fleet")]
    pub fleet_samples: bool,
    /// Keys and certificates, for --fleet: a configuration file of Zenoh
    #[arg(long, requires = "fleet", value_name = "FILE")]
    pub zenoh_config: Option<PathBuf>,
}

/// An address as Zenoh writes it: another one would end every gateway of the run at its start.
fn endpoint(text: &str) -> Result<String, String> {
    let is_word = |word: &str| {
        let mut letters = word.chars();
        !word.is_empty() && letters.all(|c| c.is_ascii_alphanumeric() || c == '-')
    };
    match text.split_once('/') {
        Some((protocol, address)) if is_word(protocol) && !address.is_empty() => Ok(text.into()),
        _ => Err("write it like tcp/192.168.0.10:7447 or tls/site.example:7447".into()),
    }
}

/// How a machine belongs to a fleet.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Fleet {
    program: PathBuf,
    arguments: Vec<String>,
}

impl Fleet {
    /// The fleet of the arguments, if any.
    pub fn of(args: &FleetArgs) -> Result<Option<Self>, Failure> {
        let (Some(connect), Some(site), Some(machine)) =
            (&args.fleet, &args.site, &args.machine_id)
        else {
            return Ok(None);
        };
        let mut arguments = vec![
            "--connect",
            connect,
            "--site",
            site,
            "--machine-id",
            machine,
        ];
        let file = args.zenoh_config.as_deref().map(std::path::absolute);
        let file = file.transpose().map_err(Failure::internal)?;
        if let Some(file) = &file {
            // A run does not end because of its gateway, which would fail again and again.
            std::fs::File::open(file).map_err(|e| Failure::file("read", file, &e))?;
        }
        let file = file.map(|f| f.display().to_string());
        if let Some(file) = &file {
            arguments.extend(["--zenoh-config", file]);
        }
        if args.fleet_samples {
            arguments.push("--samples");
        }
        Ok(Some(Self {
            program: program("heft-gateway", "--fleet")?,
            arguments: arguments.into_iter().map(str::to_owned).collect(),
        }))
    }
}

/// A program beside this one, or in the search path.
fn program(name: &str, place: &str) -> Result<PathBuf, Failure> {
    let beside = std::env::current_exe().ok();
    let beside = beside.as_deref().and_then(Path::parent).map(Path::to_owned);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut folders = beside.into_iter().chain(std::env::split_paths(&path));
    let found = folders.find_map(|f| Some(f.join(name)).filter(|file| file.is_file()));
    found.ok_or_else(|| {
        Failure::input(
            format!("{name} is not installed beside heft, nor in PATH"),
            place,
            "build it, `cargo build --release --manifest-path services/gateway/Cargo.toml`, and put it beside heft",
        )
    })
}

/// `heft fleet`
#[derive(Debug, Args)]
pub struct PassedArgs {
    /// See `heft fleet --help`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub args: Vec<String>,
}

/// `heft fleet`: becomes `heft-fleet`.
pub fn fleet(args: &PassedArgs) -> Result<(), Failure> {
    let program = program("heft-fleet", "heft fleet")?;
    let error = Command::new(&program).args(&args.args).exec();
    Err(Failure::file("start", &program, &error))
}

/// The gateway of a run, started again when it dies.
pub struct Gateway {
    fleet: Fleet,
    domain: String,
    child: Option<Child>,
    started: Instant,
    /// Pause before its next start; none where another start does not help.
    pause: Option<Duration>,
}

impl Gateway {
    /// Starts it.
    pub fn start(fleet: Fleet, domain: &Domain) -> Self {
        let mut gateway = Self {
            fleet,
            domain: domain.name().to_owned(),
            child: None,
            started: Instant::now(),
            pause: Some(FIRST_PAUSE),
        };
        gateway.spawn();
        gateway
    }

    fn spawn(&mut self) {
        self.started = Instant::now();
        let child = Command::new(&self.fleet.program)
            .args(["--domain", &self.domain])
            .args(&self.fleet.arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            // It ends by itself after the run, when it has answered requests for missing data.
            .process_group(0)
            .env_remove("NOTIFY_SOCKET")
            .env_remove("WATCHDOG_USEC")
            .spawn();
        match child {
            Ok(child) => self.child = Some(child),
            Err(error) => tracing::warn!(%error, "the gateway to the fleet cannot be started"),
        }
    }

    /// Restarts it after its death, when the pause is over.
    pub fn keep_alive(&mut self) {
        if let Some(child) = &mut self.child {
            let Ok(Some(status)) = child.try_wait() else {
                return;
            };
            self.child = None;
            self.plan_restart(status);
        } else if self
            .pause
            .is_some_and(|pause| self.started.elapsed() >= pause)
        {
            self.spawn();
        }
    }

    fn plan_restart(&mut self, status: ExitStatus) {
        if status.code() == Some(WRONG_USE) {
            self.pause = None;
            tracing::error!(
                "the gateway to the fleet cannot use what it was given; the run goes on without it"
            );
            return;
        }
        let longer = |pause: Duration| (pause * 2).min(LONGEST_PAUSE);
        self.pause = match self.started.elapsed() > LONG_LIFE {
            true => Some(FIRST_PAUSE),
            false => self.pause.map(longer),
        };
        tracing::warn!(%status, "the gateway to the fleet ended; it is started again");
        self.started = Instant::now();
    }

    /// Reports the failure of the run to the gateway, before the domain ends.
    pub fn gave_up(&self) {
        let pid = self.child.as_ref().map(Child::id);
        let pid = pid.and_then(|pid| i32::try_from(pid).ok());
        if let Some(pid) = pid.and_then(Pid::from_raw) {
            let _ = rustix::process::kill_process(pid, Signal::HUP);
        }
    }

    /// Waits for the gateway to end by itself after the run, whose end began at `begun`. A service manager kills the rest when its main
    /// process ends, and unsent data would be lost. Meanwhile the manager receives the watchdog message.
    pub fn wait(mut self, begun: Instant, mut notify: Notify) {
        while let Some(child) = &mut self.child
            && matches!(child.try_wait(), Ok(None))
            && begun.elapsed() < END_LIMIT
        {
            notify.awake();
            std::thread::sleep(END_LOOK);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::process::ExitStatusExt;

    use super::*;

    #[test]
    fn a_gateway_that_dies_is_started_again_but_not_one_that_was_given_nonsense() {
        let mut gateway = Gateway {
            fleet: Fleet {
                program: "/nowhere".into(),
                arguments: Vec::new(),
            },
            domain: String::new(),
            child: None,
            started: Instant::now(),
            pause: Some(FIRST_PAUSE),
        };
        // A signal, and status 1.
        for status in [9, 1 << 8] {
            gateway.plan_restart(ExitStatus::from_raw(status));
        }
        assert_eq!(gateway.pause, Some(4 * FIRST_PAUSE));
        gateway.plan_restart(ExitStatus::from_raw(2 << 8));
        assert_eq!(gateway.pause, None);
    }

    #[test]
    fn an_address_names_its_protocol() {
        for good in [
            "tcp/127.0.0.1:7447",
            "tls/site.example:7447",
            "udp/[::1]:1",
            "unixsock-stream//tmp/router",
        ] {
            assert_eq!(endpoint(good).as_deref(), Ok(good));
        }
        for bad in [
            "127.0.0.1:7447",
            "http://site:7447",
            "tcp:7447",
            "/x",
            "tcp/",
        ] {
            assert!(
                endpoint(bad).is_err_and(|said| said.contains("tcp/")),
                "{bad}"
            );
        }
    }
}

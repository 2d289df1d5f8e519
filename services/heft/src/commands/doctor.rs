//! `heft doctor`: reports what this host lacks for real-time work, and remains of killed runs.

use std::fs;
use std::path::PathBuf;

use clap::Args;
use runtime::{Domain, Needs, free_shared_memory, realtime};
use rustix::process::{Resource, getrlimit};

use crate::failure::Failure;

/// Result of one check.
struct Finding {
    good: bool,
    what: String,
    remedy: Option<String>,
}

fn good(what: impl Into<String>) -> Finding {
    Finding {
        good: true,
        what: what.into(),
        remedy: None,
    }
}

fn bad(what: impl Into<String>, remedy: impl Into<String>) -> Finding {
    Finding {
        good: false,
        what: what.into(),
        remedy: Some(remedy.into()),
    }
}

/// `heft doctor`
#[derive(Debug, Args)]
pub struct DoctorArgs {
    /// Remove what killed runs left behind
    #[arg(long)]
    pub clean: bool,
}

/// `heft doctor`
pub fn doctor(args: &DoctorArgs) -> Result<(), Failure> {
    if args.clean {
        for name in Domain::remove_leftovers() {
            println!("removed  what the killed run `{name}` had left behind");
        }
        for file in Domain::strays() {
            match fs::remove_file(&file) {
                Ok(()) => println!("removed  {}", file.display()),
                Err(e) => println!("kept     {}: {e}", file.display()),
            }
        }
    }
    let findings = [
        domains(),
        recordings(),
        room(),
        priority(),
        memory(),
        files(),
        clock(),
        cores(),
        kernel(),
    ];
    let mut all_good = true;
    for finding in findings.iter().flatten() {
        all_good &= finding.good;
        println!(
            "{}  {}",
            if finding.good { "ok     " } else { "missing" },
            finding.what
        );
        if let Some(remedy) = &finding.remedy {
            println!("         {remedy}");
        }
    }
    println!(
        "note     everything of a run belongs to the user who runs it (mode 0600): other users can neither open nor see it"
    );
    match runtime::home() {
        Ok(home) => println!(
            "note     the domains of this user are in {}",
            home.display()
        ),
        Err(error) => println!("missing  {error}"),
    }
    if all_good {
        Ok(())
    } else {
        Err(Failure::answer_is_no(
            "heft runs, but not everything is as it should be for real-time work",
        ))
    }
}

fn domains() -> Vec<Finding> {
    let mut findings: Vec<Finding> = Domain::all()
        .into_iter()
        .map(|domain| {
            if domain.is_alive() {
                good(format!("the run `{}` is alive", domain.name()))
            } else {
                bad(
                    format!("a killed run left the domain `{}` behind", domain.name()),
                    "heft doctor --clean",
                )
            }
        })
        .collect();
    let strays = Domain::strays().len();
    if strays > 0 {
        findings.push(bad(
            format!("{strays} objects of killed runs in /dev/shm"),
            "heft doctor --clean",
        ));
    }
    if findings.iter().all(|f| f.good) {
        findings.push(good("nothing left behind in shared memory"));
    }
    findings
}

/// Recordings in parts or cut off by a crash, in the default folders of runs and of the unit.
fn recordings() -> Vec<Finding> {
    let mut folders = vec![PathBuf::from(".")];
    for home in ["runs", "/var/lib/heft"] {
        let inside = fs::read_dir(home).into_iter().flatten().flatten();
        folders.extend(
            inside
                .map(|entry| entry.path())
                .filter(|path| path.is_dir()),
        );
    }
    let mut findings = Vec::new();
    for first in folders
        .iter()
        .flat_map(|folder| recording::recordings(folder))
    {
        let Ok(reader) = recording::Reader::open(&first) else {
            continue;
        };
        let files = reader.files().count();
        let is_split = reader.metadata().contains_key("split");
        if reader.is_being_written() || reader.is_complete() && (files < 2 || is_split) {
            continue;
        }
        let what = if reader.is_complete() {
            "was not joined"
        } else {
            "was cut off"
        };
        let parts = if files > 1 {
            format!(" ({files} parts)")
        } else {
            String::new()
        };
        findings.push(bad(
            format!(
                "the recording {} {what}{parts}; every command reads it as it is",
                first.display()
            ),
            format!(
                "heft recover {} writes one whole copy beside it",
                first.display()
            ),
        ));
    }
    findings
}

fn room() -> Vec<Finding> {
    let home = runtime::home().ok();
    if let Some(lack) = home.and_then(|home| runtime::lack(&home, Needs::Run)) {
        return vec![bad(format!("{}: {}", lack.place, lack.what), lack.remedy)];
    }
    let mib = free_shared_memory() >> 20;
    let few = if mib < 128 {
        ": room for one run only"
    } else {
        ""
    };
    vec![good(format!("{mib} MiB free in /dev/shm{few}"))]
}

fn priority() -> Vec<Finding> {
    vec![if realtime::permitted() {
        good("SCHED_FIFO is permitted")
    } else {
        bad(
            "SCHED_FIFO is not permitted: --rt runs without it",
            "ulimit -r 90, or sudo setcap cap_sys_nice,cap_ipc_lock+ep $(command -v heft), or LimitRTPRIO=90 in the systemd unit",
        )
    }]
}

fn memory() -> Vec<Finding> {
    let limit = getrlimit(Resource::Memlock).current;
    let enough =
        limit.is_none_or(|bytes| bytes >= 256 << 20) || rustix::process::geteuid().is_root();
    vec![if enough {
        good("memory can be locked")
    } else {
        bad(
            format!(
                "only {} KiB of memory can be locked",
                limit.unwrap_or(0) >> 10
            ),
            "ulimit -l unlimited, or LimitMEMLOCK=infinity in the systemd unit",
        )
    }]
}

fn files() -> Vec<Finding> {
    let limit = getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX);
    let what = format!("{limit} open files permitted");
    vec![if limit >= 512 {
        good(what)
    } else {
        bad(what, "ulimit -n 4096")
    }]
}

fn clock() -> Vec<Finding> {
    let path = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
    let Ok(source) = fs::read_to_string(path) else {
        return Vec::new();
    };
    let source = source.trim();
    let fast = [
        "tsc",
        "kvm-clock",
        "arch_sys_counter",
        "hyperv_clocksource_tsc_page",
    ];
    vec![if fast.contains(&source) {
        good(format!(
            "the clock source {source} is read without a system call"
        ))
    } else {
        bad(
            format!("the clock source {source} needs a system call per reading"),
            format!("echo tsc | sudo tee {path}"),
        )
    }]
}

fn cores() -> Vec<Finding> {
    let n = realtime::cores().len();
    vec![if n > 1 {
        good(format!(
            "{n} cores: the stages of one machine share the last one under --rt"
        ))
    } else {
        bad(
            "one core only",
            "under load every process waits for every other; use --rt",
        )
    }]
}

fn kernel() -> Vec<Finding> {
    let version = rustix::system::uname()
        .version()
        .to_string_lossy()
        .into_owned();
    vec![good(if version.contains("PREEMPT_RT") {
        "the kernel is a real-time kernel (PREEMPT_RT)".to_owned()
    } else {
        format!(
            "the kernel is not PREEMPT_RT ({version}): rare delays of a millisecond must be expected"
        )
    })]
}

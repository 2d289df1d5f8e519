//! Fleets: what a machine's pipeline finds, carried to a site by Zenoh, kept and shown there.
//!
//! The machine's side (`heft-gateway`) reads the channels as the logger does, sends a selection of what they
//! carry, and answers questions for what did not arrive from the machine's own recording. The site's side
//! (`heft-fleet`) stores it, asks for what is missing, and shows it.
//!
//! | module | what |
//! |---|---|
//! | [`key`], [`label`], [`status`], [`question`] | the words of the protocol: keys, attachments, what a machine says of itself, questions for what is missing |
//! | [`schema`] | what the messages mean |
//! | [`downsample`], [`load`] | which messages are sent; the same rule, live and from a recording |
//! | [`link`] | sessions and routers of Zenoh |
//! | [`machine`] | the gateway: reading, publishing, answering from the recording |
//! | [`site`] | estimates at the site, of the samples that machines send as they are |
//! | [`collector`] | the collector: intake, store, repair, alarms, page, queries |

pub mod collector;
pub mod downsample;
pub mod key;
pub mod label;
pub mod link;
pub mod load;
pub mod machine;
pub mod question;
pub mod schema;
pub mod site;
pub mod status;
mod track;

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Version of the programs; a build that is not for use says so.
pub const VERSION: &str = if cfg!(debug_assertions) {
    concat!(env!("CARGO_PKG_VERSION"), " (debug build)")
} else {
    env!("CARGO_PKG_VERSION")
};

/// Machines that a site takes, and a router lets in, at a time.
pub(crate) const MACHINES: usize = 20_000;

/// What a mutex holds, also after a thread that held it has panicked.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An error in heft's three lines: what, where, what to do.
pub fn error(
    what: impl std::fmt::Display,
    place: impl std::fmt::Display,
    remedy: impl std::fmt::Display,
) -> String {
    format!("{what}\n  where: {place}\n  what to do: {remedy}")
}

/// The wall clock [ms since 1970].
pub fn wall_ms() -> u64 {
    runtime::since_1970().as_millis() as u64
}

/// What the programs of a fleet say on standard error, unless the environment chooses otherwise: what they do, and errors of
/// all that they are made of. `program` stands in each line.
pub fn log(program: &'static str) -> tracing::span::EnteredSpan {
    diagnostics::start(
        "error,gateway=info,iceoryx2=off,iceoryx2_log=off",
        std::io::stderr,
    );
    tracing::error_span!(target: "gateway", "process", pid = std::process::id(), process = program)
        .entered()
}

/// Sets `stop` when the process is asked to end.
///
/// # Errors
/// The system refuses.
pub fn on_signal(stop: &std::sync::Arc<std::sync::atomic::AtomicBool>) -> Result<(), String> {
    catch(
        &[signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM],
        stop,
    )
}

/// Sets `gave_up` when the process is told that the run beside it failed.
///
/// # Errors
/// The system refuses.
pub fn on_hang_up(gave_up: &std::sync::Arc<std::sync::atomic::AtomicBool>) -> Result<(), String> {
    catch(&[signal_hook::consts::SIGHUP], gave_up)
}

fn catch(
    signals: &[i32],
    flag: &std::sync::Arc<std::sync::atomic::AtomicBool>,
) -> Result<(), String> {
    for signal in signals {
        let registered = signal_hook::flag::register(*signal, std::sync::Arc::clone(flag));
        registered.map_err(|e| {
            error(
                format!("signals cannot be caught: {e}"),
                "the system",
                "check its limits",
            )
        })?;
    }
    Ok(())
}

/// Why a program ends: an error in heft's three lines, and its status.
#[derive(Debug)]
pub struct Failure {
    error: String,
    status: u8,
}

impl From<String> for Failure {
    /// 2: wrong use or bad input. Another start does not help.
    fn from(error: String) -> Self {
        Self { error, status: 2 }
    }
}

impl Failure {
    /// 1: another start may help.
    pub fn passing(error: String) -> Self {
        Self { error, status: 1 }
    }
}

/// Tells the error of a program, if any, and how it ends.
pub fn exit(program: &str, result: Result<(), impl Into<Failure>>) -> std::process::ExitCode {
    match result.map_err(Into::into) {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(Failure { error, status }) => {
            eprintln!("{program}: {error}");
            std::process::ExitCode::from(status)
        }
    }
}

//! Fleets: the results of many machines, carried to a site by Zenoh, stored and shown there.
//!
//! The machine's side (`heft-gateway`) reads the channels as the logger does and sends a selection of their messages. It answers
//! requests for lost messages from the machine's own recording. The site's side (`heft-fleet`) stores the messages, requests the
//! missing ones, and shows the result.
//!
//! | module | what |
//! |---|---|
//! | [`key`], [`label`], [`status`], [`question`] | the protocol: keys, attachments, the status of a machine, requests for missing messages |
//! | [`schema`] | the schemas of the messages |
//! | [`downsample`], [`load`] | which messages are sent; the same rule, live and from a recording |
//! | [`link`] | sessions and routers of Zenoh |
//! | [`machine`] | the gateway: reading, publishing, answering from the recording |
//! | [`site`] | estimates at the site, from the unmodified samples of machines |
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

/// Version of the programs; a debug build is marked as such.
pub const VERSION: &str = if cfg!(debug_assertions) {
    concat!(env!("CARGO_PKG_VERSION"), " (debug build)")
} else {
    env!("CARGO_PKG_VERSION")
};

/// Most machines that a site accepts and sessions that a router admits, at a time.
pub(crate) const MACHINES: usize = 20_000;

/// Locks a mutex, also after a thread that held it has panicked.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An error in heft's three lines: what, where, remedy.
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

/// Starts the log on standard error: the messages of the fleet's programs and the errors of their libraries, unless the
/// environment chooses otherwise. `program` is part of each line.
pub fn log(program: &'static str) -> tracing::span::EnteredSpan {
    diagnostics::start(
        "error,gateway=info,iceoryx2=off,iceoryx2_log=off",
        true,
        std::io::stderr,
    );
    tracing::error_span!(target: "gateway", "process", pid = std::process::id(), process = program)
        .entered()
}

/// Sets `stop` on SIGINT or SIGTERM.
///
/// # Errors
/// The handler cannot be registered.
pub fn on_signal(stop: &std::sync::Arc<std::sync::atomic::AtomicBool>) -> Result<(), String> {
    catch(
        &[signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM],
        stop,
    )
}

/// Sets `gave_up` on SIGHUP: the run beside this process failed.
///
/// # Errors
/// The handler cannot be registered.
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

/// The end of a program: an error in heft's three lines, and its exit status.
#[derive(Debug)]
pub struct Failure {
    error: String,
    status: u8,
}

impl From<String> for Failure {
    /// Status 2: wrong use or bad input. Another start does not help.
    fn from(error: String) -> Self {
        Self { error, status: 2 }
    }
}

impl Failure {
    /// Status 1: another start may help.
    pub fn passing(error: String) -> Self {
        Self { error, status: 1 }
    }

    /// Standard output takes no more.
    pub fn not_written(cause: &std::io::Error) -> Self {
        let status = match cause.kind() {
            std::io::ErrorKind::BrokenPipe => READER_LEFT,
            _ => 2,
        };
        let error = error(
            format!("cannot write: {cause}"),
            "standard output",
            "check where it goes",
        );
        Self { error, status }
    }
}

/// Exit status of a program whose reader left (`| head`), as of `heft`; nothing is said then.
const READER_LEFT: u8 = 141;

/// Prints the error of a program, if any; returns its exit code.
pub fn exit(program: &str, result: Result<(), impl Into<Failure>>) -> std::process::ExitCode {
    match result.map_err(Into::into) {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(Failure { error, status }) => {
            if status != READER_LEFT {
                eprintln!("{program}: {error}");
            }
            std::process::ExitCode::from(status)
        }
    }
}

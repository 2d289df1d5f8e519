//! heft: the command line, and the supervisor of the processes.

#[macro_use]
mod out;

mod args;
mod attached;
mod bounds;
mod build;
mod commands;
mod compare;
mod doubts;
mod drawing;
mod failure;
mod fault;
mod fleet;
mod fleet_run;
mod group;
mod image;
mod life;
mod limits;
mod live;
mod machines;
mod many;
mod marked;
mod misplaced;
mod notify;
mod outputs;
mod page;
mod parts;
mod plan;
mod quantity;
mod results;
mod serve;
mod service;
mod signals;
mod size;
mod small_file;
mod sources;
mod spare;
mod spin;
mod state;
mod story;
mod summary;
mod supervised;
mod supervisor;
mod tally;
mod target;
mod watch;

use std::process::ExitCode;

use clap::Parser;
use commands::{Cli, Command};
use failure::Failure;

fn main() -> ExitCode {
    let cli = Cli::try_parse().unwrap_or_else(|error| misplaced::exit(error));
    let stays = matches!(
        cli.command,
        None | Some(Command::Run(_) | Command::Serve(_) | Command::Service(_))
    );
    // Warnings, unless the environment chooses otherwise.
    diagnostics::start("warn,iceoryx2=off,iceoryx2_log=off", stays, || out::Log);
    let _process = stays.then(span);
    take_signals();
    // Lists of processes would show the name that `image` starts it by.
    let _ = rustix::thread::set_name(c"heft");
    match dispatch(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if failure.status != out::READER_LEFT {
                eprintln!("heft: {failure}");
            }
            ExitCode::from(failure.status)
        }
    }
}

/// Takes SIGXFSZ and SIGCHLD. A file that may grow no further (`LimitFSIZE` of a unit) is then an error like a full disk, and does not
/// kill the process. An ignored SIGCHLD is inherited, and the kernel would then discard the exit statuses of a run's processes.
fn take_signals() {
    for signal in [signal_hook::consts::SIGXFSZ, signal_hook::consts::SIGCHLD] {
        if let Err(error) = signal_hook::flag::register(signal, std::sync::Arc::default()) {
            tracing::warn!(%error, signal, "a signal cannot be taken");
        }
    }
}

/// Span that identifies this process in its log lines; of a level that no filter drops.
fn span() -> tracing::span::EnteredSpan {
    tracing::error_span!(
        "process",
        pid = std::process::id(),
        process = tracing::field::Empty,
        machine = tracing::field::Empty,
        domain = tracing::field::Empty,
        restarts = tracing::field::Empty
    )
    .entered()
}

fn dispatch(cli: Cli) -> Result<(), Failure> {
    if matches!(
        cli.command,
        None | Some(Command::Run(_) | Command::Service(_))
    ) {
        // Files that a run creates are readable by its user only.
        rustix::process::umask(rustix::fs::Mode::RWXG | rustix::fs::Mode::RWXO);
    }
    match cli.command {
        None => commands::demo::demo(cli.verbose),
        Some(command) => command.run(),
    }
}

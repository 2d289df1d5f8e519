//! heft: the command line, and the supervisor of the processes.

#[macro_use]
mod out;

mod attached;
mod bounds;
mod build;
mod cli;
mod commands;
mod compare;
mod failure;
mod fault;
mod fleet;
mod group;
mod image;
mod live;
mod machines;
mod many;
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
mod sources;
mod spare;
mod spin;
mod state;
mod summary;
mod supervised;
mod supervisor;
mod tally;
mod watch;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};
use cli::{Cli, Command};
use failure::Failure;

fn main() -> ExitCode {
    let cli = Cli::parse();
    log();
    // Lists of processes would show the name that `image` starts it by.
    let _ = rustix::thread::set_name(c"heft");
    match dispatch(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("heft: {failure}");
            ExitCode::from(failure.status)
        }
    }
}

/// Warnings go to standard error; `HEFT_LOG` chooses otherwise, in the syntax of `env_logger`.
fn log() {
    let filter = tracing_subscriber::EnvFilter::try_from_env("HEFT_LOG").unwrap_or_else(|_| {
        tracing_subscriber::EnvFilter::new("warn,iceoryx2=off,iceoryx2_log=off")
    });
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .without_time()
        .init();
}

fn dispatch(cli: Cli) -> Result<(), Failure> {
    if matches!(
        cli.command,
        None | Some(Command::Run(_) | Command::Service { .. })
    ) {
        // What a run makes is for its user alone.
        rustix::process::umask(rustix::fs::Mode::RWXG | rustix::fs::Mode::RWXO);
    }
    let Some(command) = cli.command else {
        return commands::demo::demo();
    };
    match command {
        Command::Run(args) => commands::run::run(&args),
        Command::Estimate(args) => commands::estimate::estimate(&args),
        Command::Serve(args) => commands::serve::serve(&args),
        Command::Replay(args) => commands::replay::replay(&args),
        Command::Evaluate(args) => commands::evaluate::evaluate(&args),
        Command::Calibrate(args) => commands::calibrate::calibrate(&args),
        Command::Recover { file, output } => commands::recover::recover(&file, output.as_deref()),
        Command::Report(args) => commands::report::report(&args),
        Command::Export { file, output } => commands::export::export(&file, &output),
        Command::Top { domain, once } => commands::top::top(domain.as_deref(), once),
        Command::Latency(args) => commands::latency::latency(&args),
        Command::Doctor { clean } => commands::doctor::doctor(clean),
        Command::Check {
            file,
            machine,
            print,
        } => commands::check::check(&file, machine, print),
        Command::Map {
            file,
            dbc,
            machine,
            output,
        } => commands::map::map(&file, &dbc, machine, output.as_deref()),
        Command::Schema {
            lang,
            machine,
            output_map,
        } => commands::schema::schema(lang, machine, output_map.as_deref()),
        Command::Tail(args) => commands::tail::tail(&args),
        Command::Weigh {
            file,
            description,
            json,
        } => commands::weigh::weigh(&file, &description, json.as_deref()),
        Command::Fleet { args } => fleet::fleet(&args),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "heft", &mut script);
            print!("{}", String::from_utf8_lossy(&script));
            Ok(())
        }
        Command::Package { folder } => commands::package::package(&folder),
        Command::Service {
            name,
            domain,
            restarts,
        } => service::serve(&name, &domain, restarts),
        Command::LimitsWorker { args } => std::process::exit(limits::worker_main(&args)),
    }
}

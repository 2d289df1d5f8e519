//! heft-fleet: receives, stores and shows the data of many machines. `heft fleet` is the same.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::{Parser, Subcommand};
use gateway::collector::full::FullArgs;
use gateway::collector::query::QueryArgs;
use gateway::collector::{CollectorArgs, full, query, run};
use gateway::site::{self, ServeArgs};
use gateway::{Failure, link};

/// Keeps and shows what many machines send.
///
/// Without a command: collects until it is ended, and shows all machines on a page of this host.
#[derive(Parser)]
#[command(name = "heft fleet", version = gateway::VERSION, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    collector: CollectorArgs,
}

#[derive(Subcommand)]
enum Command {
    /// Print the history as a table
    Query(QueryArgs),
    /// Print every estimate of one machine for a while
    Full(FullArgs),
    /// Estimate here, by `heft serve`, from the samples that machines send (`heft run ... --fleet-samples`)
    Serve(ServeArgs),
    /// Be a router of Zenoh, as `zenohd` is, for machines and collectors to meet
    Router {
        /// Where it listens: this host only, unless stated otherwise
        #[arg(long, value_name = "tcp/HOST:PORT")]
        listen: Option<String>,
        /// Keys, certificates, access: a configuration file of Zenoh
        #[arg(long, value_name = "FILE")]
        zenoh_config: Option<std::path::PathBuf>,
        /// Let anybody who reaches it write anything under any machine's name: for a network of its own only
        #[arg(long)]
        open: bool,
    },
}

fn main() -> ExitCode {
    let _process = gateway::log("heft-fleet");
    // Files are readable and writable by their user only.
    rustix::process::umask(rustix::fs::Mode::RWXG | rustix::fs::Mode::RWXO);
    let cli = Cli::parse();
    let stop = Arc::new(AtomicBool::new(false));
    gateway::exit("heft fleet", collect(&cli, &stop))
}

fn collect(cli: &Cli, stop: &Arc<AtomicBool>) -> Result<(), Failure> {
    gateway::on_signal(stop)?;
    match &cli.command {
        None => run(&cli.collector, stop),
        Some(Command::Query(args)) => query::query(args, &mut std::io::stdout().lock()),
        Some(Command::Full(args)) => full::full(args, &mut std::io::stdout().lock(), stop),
        Some(Command::Serve(args)) => site::serve(args, stop),
        Some(Command::Router {
            listen,
            zenoh_config,
            open,
        }) => {
            let listen = listen
                .as_deref()
                .or(zenoh_config.is_none().then_some(link::DEFAULT));
            let session = link::is_closed(listen, zenoh_config.is_some() || *open)
                .and_then(|()| link::router(listen, zenoh_config.as_deref()));
            let _session = session?;
            eprintln!("router: {}", listen.unwrap_or("as its configuration says"));
            while !stop.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(100));
            }
            Ok(())
        }
    }
}

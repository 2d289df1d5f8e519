//! The command line as a whole.

use clap::Parser;

use crate::commands::Command;

/// Weighs every bucket of an excavator or wheel loader, and estimates swing inertia and centre of gravity, while it works.
///
/// Each number has a 95 % interval and a verdict: trusted, or not and why. Without a command: the
/// demonstration. Both machines are simulated in real time for 28 s, and every load is printed beside the truth.
#[derive(Debug, Parser)]
#[command(name = "heft", version = crate::build::IDENTITY, max_term_width = 100)]
#[command(
    after_help = "Exit status: 0 done, 1 ran but the answer is no, 2 wrong use or bad input.\n\n\
        Environment:\n  \
        HEFT_LOG         what is logged to standard error, such as info or heft=debug (else RUST_LOG; else warnings)\n  \
        HEFT_LOG_FORMAT  text or json: a line each, with time, level, source, fields and process\n  \
        XDG_RUNTIME_DIR  a folder of this user in memory, for what a run shares (else /dev/shm)"
)]
pub struct Cli {
    /// What to do; the demonstration if absent.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The demonstration: process statistics too
    #[arg(long)]
    pub verbose: bool,
}

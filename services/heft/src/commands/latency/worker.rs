//! `heft limits-worker`: a link of a bare chain.

use clap::Args;

use crate::failure::Failure;

/// `heft limits-worker`
#[derive(Debug, Args)]
pub struct WorkerArgs {
    /// Arguments of a link of the chain
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub args: Vec<String>,
}

/// Runs that link until the chain ends.
pub fn worker(args: &WorkerArgs) -> Result<(), Failure> {
    std::process::exit(limits::worker_main(&args.args))
}

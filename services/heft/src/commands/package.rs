//! `heft package`: the files that a package installs beside the binary.

use std::path::PathBuf;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::Cli;
use crate::failure::Failure;

/// `heft package`
#[derive(Debug, Args)]
pub struct PackageArgs {
    /// The folder
    pub folder: PathBuf,
}

/// Writes a manual page per command, and completions for three shells.
pub fn package(args: &PackageArgs) -> Result<(), Failure> {
    let folder = &args.folder;
    let fail = |e| Failure::file("write", folder, &e);
    std::fs::create_dir_all(folder).map_err(fail)?;
    clap_mangen::generate_to(Cli::command(), folder).map_err(fail)?;
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
        clap_complete::generate_to(shell, &mut Cli::command(), "heft", folder).map_err(fail)?;
    }
    Ok(())
}

//! `heft package`: what a package installs beside the binary.

use std::path::Path;

use clap::CommandFactory;
use clap_complete::Shell;

use crate::cli::Cli;
use crate::failure::Failure;

/// Writes a manual page per command, and completions for three shells.
pub fn package(folder: &Path) -> Result<(), Failure> {
    let fail = |e| Failure::file("write", folder, &e);
    std::fs::create_dir_all(folder).map_err(fail)?;
    clap_mangen::generate_to(Cli::command(), folder).map_err(fail)?;
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
        clap_complete::generate_to(shell, &mut Cli::command(), "heft", folder).map_err(fail)?;
    }
    Ok(())
}

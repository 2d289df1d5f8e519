//! This program again, as a process of its own.

use std::process::Command;

/// What the kernel runs, whatever stands under its path by now.
const IMAGE: &str = "/proc/self/exe";

/// A command that runs this very program: an upgrade of the package replaces or removes the file that a
/// long run was started from, and its services must still be the ones that fit it.
pub fn command() -> Command {
    use std::os::unix::process::CommandExt;
    let mut command = Command::new(IMAGE);
    // As it was called, for whoever lists processes.
    if let Some(name) = std::env::args_os().next() {
        command.arg0(name);
    }
    command
}

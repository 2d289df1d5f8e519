//! Starts this program again, as a process of its own.

use std::process::Command;

/// The running executable, whatever file is under its path by now.
const IMAGE: &str = "/proc/self/exe";

/// A command that runs this very executable. An upgrade of the package replaces or removes the file that a
/// long run was started from, and its services must still match it.
pub fn command() -> Command {
    use std::os::unix::process::CommandExt;
    let mut command = Command::new(IMAGE);
    // The name under which it was called, for lists of processes.
    if let Some(name) = std::env::args_os().next() {
        command.arg0(name);
    }
    command
}

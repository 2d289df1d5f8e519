//! Standard output and error that may be full, or closed by whoever read them.
//!
//! The macros of the standard library panic then. These shadow them in every module: a command that
//! cannot say its answer says so on standard error and ends with status 1; what cannot be said on
//! standard error either is not said.

use std::fmt::Arguments;
use std::io::Write;

/// Writes to standard output, or ends the process.
pub fn say(text: Arguments) {
    let mut out = std::io::stdout().lock();
    if let Err(error) = out.write_fmt(text).and_then(|()| out.flush()) {
        give_up(&error);
    }
}

/// Passes an answer on that its reader may leave when he has seen enough; whether he goes on.
pub fn pass(answer: &[u8]) -> bool {
    let mut out = std::io::stdout().lock();
    match out.write_all(answer).and_then(|()| out.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => false,
        Err(error) => give_up(&error),
        Ok(()) => true,
    }
}

/// Says that an answer cannot be said, and ends the process.
fn give_up(error: &std::io::Error) -> ! {
    complain(format_args!(
        "heft: cannot write the answer: {error}\n  where: standard output\n  what to do: give it a reader that reads to the end, or a disk with room\n"
    ));
    std::process::exit(1);
}

/// Writes to standard error, if it can.
pub fn complain(text: Arguments) {
    let _ = std::io::stderr().lock().write_fmt(text);
}

macro_rules! print {
    ($($text:tt)*) => { $crate::out::say(format_args!($($text)*)) };
}
macro_rules! println {
    () => { $crate::out::say(format_args!("\n")) };
    ($($text:tt)*) => { $crate::out::say(format_args!("{}\n", format_args!($($text)*))) };
}
macro_rules! eprint {
    ($($text:tt)*) => { $crate::out::complain(format_args!($($text)*)) };
}
macro_rules! eprintln {
    () => { $crate::out::complain(format_args!("\n")) };
    ($($text:tt)*) => { $crate::out::complain(format_args!("{}\n", format_args!($($text)*))) };
}

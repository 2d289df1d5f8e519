//! Standard output and error that may be full, or closed by their readers.
//!
//! The macros of the standard library panic in that case. These shadow them in every module: a command that
//! cannot write its answer reports that on standard error and ends with status 1. A text that cannot be written to
//! standard error either is dropped.
//!
//! Names of files and columns come from outside. Control characters in them would steer the
//! terminal, so they are escaped ([`Plain`]). Text that heft draws itself goes through [`draw`].

use std::fmt::Arguments;
use std::io::{self, Write};

pub use recording::Plain;

/// Writes to standard output, or ends the process.
pub fn say(text: Arguments) {
    let mut out = std::io::stdout().lock();
    if let Err(error) = write!(out, "{}", Plain(text)).and_then(|()| out.flush()) {
        give_up(&error);
    }
}

/// Passes an answer on whose reader may leave early; returns whether it still reads.
pub fn pass(answer: &[u8]) -> bool {
    let mut out = std::io::stdout().lock();
    match out.write_all(answer).and_then(|()| out.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => false,
        Err(error) => give_up(&error),
        Ok(()) => true,
    }
}

/// Exit status of a program whose reader left (`| head`): as a shell shows one ended by SIGPIPE.
pub const READER_LEFT: u8 = 141;

/// Reports that an answer cannot be written, and ends the process. If the reader has left, without a message.
fn give_up(error: &std::io::Error) -> ! {
    if error.kind() == std::io::ErrorKind::BrokenPipe {
        std::process::exit(READER_LEFT.into());
    }
    complain(format_args!(
        "heft: cannot write the answer: {error}\n  where: standard output\n  what to do: give it a reader that reads to the end, or a disk with room\n"
    ));
    std::process::exit(1);
}

/// Writes to standard error, if it can.
pub fn complain(text: Arguments) {
    let _ = write!(std::io::stderr().lock(), "{}", Plain(text));
}

/// Standard error for the log, whose own colours stay: the log escapes control characters in its messages itself.
pub struct Log;

impl Write for Log {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(bytes);
        let steers = |c: char| recording::steers(c) && !c.is_control();
        let shown: String = text
            .chars()
            .map(|c| match steers(c) {
                true => c.escape_unicode().to_string(),
                false => c.to_string(),
            })
            .collect();
        io::stderr().write_all(shown.as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}

/// Draws a line on standard error that is redrawn: with its own control characters.
pub fn draw(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

macro_rules! print {
    ($($text:tt)*) => { $crate::out::say(format_args!($($text)*)) };
}
macro_rules! println {
    () => { $crate::out::say(format_args!("\n")) };
    ($($text:tt)*) => { $crate::out::say(format_args!("{}\n", format_args!($($text)*))) };
}
macro_rules! eprintln {
    () => { $crate::out::complain(format_args!("\n")) };
    ($($text:tt)*) => { $crate::out::complain(format_args!("{}\n", format_args!($($text)*))) };
}

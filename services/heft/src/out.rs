//! Standard output and error that may be full, or closed by whoever read them.
//!
//! The macros of the standard library panic then. These shadow them in every module: a command that
//! cannot say its answer says so on standard error and ends with status 1; what cannot be said on
//! standard error either is not said.
//!
//! Names of files and columns are the words of others. Control characters in them would steer the
//! terminal, so they are written out (`\u{1b}`). What heft draws itself goes by [`draw`].

use std::fmt::{self, Arguments, Display, Formatter};
use std::io::Write;

/// A text whose control characters are written out, but for line breaks and tabs.
pub struct Plain<T>(pub T);

impl<T: Display> Display for Plain<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        fmt::Write::write_fmt(&mut Writing(f), format_args!("{}", self.0))
    }
}

/// Writes on with control characters written out.
struct Writing<'a, 'b>(&'a mut Formatter<'b>);

impl fmt::Write for Writing<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let steers = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
        let mut rest = text;
        while let Some(at) = rest.find(steers) {
            let (before, from) = rest.split_at(at);
            self.0.write_str(before)?;
            let mut characters = from.chars();
            if let Some(c) = characters.next() {
                write!(self.0, "{}", c.escape_unicode())?;
            }
            rest = characters.as_str();
        }
        self.0.write_str(rest)
    }
}

/// Writes to standard output, or ends the process.
pub fn say(text: Arguments) {
    let mut out = std::io::stdout().lock();
    if let Err(error) = write!(out, "{}", Plain(text)).and_then(|()| out.flush()) {
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
    let _ = write!(std::io::stderr().lock(), "{}", Plain(text));
}

/// Draws a line on standard error that is drawn again: with its own control characters.
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

#[cfg(test)]
mod tests {
    use super::Plain;

    #[test]
    fn what_steers_a_terminal_is_written_out() {
        let name = "a\x1b[31mred\x07.csv";
        let shown = Plain(format_args!("{name}\tok\n\u{9b}2J ± m²")).to_string();
        assert_eq!(shown, "a\\u{1b}[31mred\\u{7}.csv\tok\n\\u{9b}2J ± m²");
    }
}

//! An input that ends when a signal comes. The lines that were read by then are answered, and the command ends in order. A line
//! of which only a part was read would be another number: it is left out.

use std::fs::File;
use std::io::{self, Read};
use std::os::fd::AsFd;

use recording::MAX_LINE;
use rustix::event::{PollFd, PollFlags, poll};

use crate::failure::Failure;
use crate::signals::Signals;

/// Bytes that are read at once.
const CHUNK: usize = 1 << 16;

/// Reads whole lines until the input ends or a signal comes.
pub struct UntilSignal {
    input: File,
    signals: Signals,
    bytes: Vec<u8>,
    /// Bytes that were passed on, and those that belong to whole lines.
    passed: usize,
    whole: usize,
    has_ended: bool,
}

impl UntilSignal {
    /// Reads `input`; a second signal ends the process at once.
    pub fn of(input: File) -> Result<Self, Failure> {
        Ok(Self {
            input,
            signals: Signals::catch_first()?,
            bytes: Vec::with_capacity(2 * CHUNK),
            passed: 0,
            whole: 0,
            has_ended: false,
        })
    }

    /// Waits for bytes, and takes them.
    fn take(&mut self) -> io::Result<()> {
        if !self.arrives()? {
            self.has_ended = true;
            return Ok(());
        }
        self.bytes.drain(..self.passed);
        self.passed = 0;
        let waiting = self.bytes.len();
        self.bytes.resize(waiting + CHUNK, 0);
        let read = self.input.read(&mut self.bytes[waiting..]);
        self.bytes
            .truncate(waiting + read.as_ref().map_or(0, |n| *n));
        let lines = self.bytes.iter().rposition(|b| *b == b'\n');
        // The last line may have no end, and a line that is too long is nobody's number.
        let is_last = matches!(read, Ok(0));
        self.whole = match lines {
            _ if is_last || self.bytes.len() > MAX_LINE + CHUNK => self.bytes.len(),
            lines => lines.map_or(0, |last| last + 1),
        };
        self.has_ended = is_last;
        read.map(drop)
    }

    /// Whether bytes arrive or the input ends, before a signal comes.
    fn arrives(&self) -> io::Result<bool> {
        while !self.signals.came() {
            let mut both = [
                PollFd::from_borrowed_fd(self.input.as_fd(), PollFlags::IN),
                PollFd::from_borrowed_fd(self.signals.as_fd(), PollFlags::IN),
            ];
            match poll(&mut both, None) {
                Err(rustix::io::Errno::INTR) => {}
                Err(error) => return Err(error.into()),
                Ok(_) if both[0].revents().is_empty() => {}
                Ok(_) => return Ok(!self.signals.came()),
            }
        }
        Ok(false)
    }
}

impl Read for UntilSignal {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while self.passed == self.whole && !self.has_ended {
            match self.take() {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                taken => taken?,
            }
        }
        let count = out.len().min(self.whole - self.passed);
        out[..count].copy_from_slice(&self.bytes[self.passed..self.passed + count]);
        self.passed += count;
        Ok(count)
    }
}

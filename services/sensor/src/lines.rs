//! Standard input as a source: lines of candump, or rows of a table, as they arrive.

use std::os::fd::OwnedFd;

use recording::{Error, LineDecoder, MAX_LINE, Map, Sensors};
use runtime::{Live, Polled, now_ns};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// Longest wait for a line.
const PATIENCE: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 20_000_000,
};
/// Longest delay of a line after it was written [ns]: only after it is silence certain.
const UNDER_WAY: i64 = 500_000_000;

/// Samples from a file descriptor.
#[derive(Debug)]
pub struct Lines<S: Sensors> {
    input: OwnedFd,
    stream: LineDecoder<S>,
    /// Bytes since the last whole line.
    rest: Vec<u8>,
    /// Whether the rest of a line that is too long is being dropped.
    is_skipping: bool,
    has_ended: bool,
    /// Whether a sample has come.
    has_row: bool,
    /// Whether the end was reported.
    is_over: bool,
    /// Why the input is unusable.
    refusal: Option<runtime::Error>,
    /// Whether time passes without input; not where samples come only as fast as they are taken.
    is_paced: bool,
}

impl<S: Sensors> Lines<S> {
    /// Reads lines from `input`.
    ///
    /// # Errors
    /// The map does not fit the machine.
    pub fn new(input: OwnedFd, map: Option<Map>, is_paced: bool) -> Result<Self, Error> {
        Ok(Self {
            input,
            stream: LineDecoder::new(map)?,
            rest: Vec::new(),
            is_skipping: false,
            has_ended: false,
            has_row: false,
            is_over: false,
            refusal: None,
            is_paced,
        })
    }

    /// Sets the time of the first frame to `seconds` instead of 0.
    pub fn begin_at(&mut self, seconds: f64) {
        self.stream.begin_at(seconds);
    }

    fn read(&mut self) {
        let now = i64::try_from(now_ns()).unwrap_or(i64::MAX);
        match poll(
            &mut [PollFd::new(&self.input, PollFlags::IN)],
            Some(&PATIENCE),
        ) {
            Ok(0) | Err(_) => {
                if self.is_paced {
                    self.stream.pass(now - UNDER_WAY);
                }
                return;
            }
            Ok(_) => {}
        }
        let mut bytes = [0; 4096];
        match rustix::io::read(&self.input, &mut bytes) {
            Ok(0) => {
                let rest = std::mem::take(&mut self.rest);
                self.take(&rest, now);
                self.stream.finish();
                for empty in self.stream.empty() {
                    tracing::warn!("standard input: {empty}");
                }
                self.has_ended = true;
            }
            Ok(count) => self.split(&bytes[..count], now),
            Err(rustix::io::Errno::INTR | rustix::io::Errno::AGAIN) => {}
            Err(error) => {
                self.refusal = Some(runtime::Error::new(
                    format!("cannot read: {error}"),
                    "standard input",
                    "check what writes to it",
                ));
            }
        }
    }

    fn split(&mut self, bytes: &[u8], now: i64) {
        for piece in bytes.split_inclusive(|b| *b == b'\n') {
            if !self.is_skipping {
                self.rest.extend_from_slice(piece);
            }
            if piece.ends_with(b"\n") {
                let line = std::mem::take(&mut self.rest);
                if !std::mem::take(&mut self.is_skipping) {
                    self.take(&line, now);
                }
                self.rest = line;
                self.rest.clear();
            } else if self.rest.len() > MAX_LINE {
                tracing::warn!("standard input: a line of more than {MAX_LINE} bytes was left out");
                self.is_skipping = true;
                self.rest.clear();
            }
        }
    }

    /// The end of the input. It is an error without any sample, and after lines that were mostly invalid.
    fn end(&mut self) -> Polled<S, S::Truth> {
        if std::mem::replace(&mut self.is_over, true) {
            return Polled::End;
        }
        if let Err(error) = self.stream.judge() {
            return Polled::Refused(refusal(error));
        }
        if self.has_row {
            return Polled::End;
        }
        Polled::Refused(runtime::Error::new(
            "the input ended without a sample",
            "standard input",
            "pipe lines of candump (with --map) or a table with its header into it",
        ))
    }

    fn take(&mut self, line: &[u8], now: i64) {
        if self.refusal.is_some() {
            return;
        }
        if let Err(error) = self.stream.take(line, now) {
            self.refusal = Some(refusal(error));
        }
    }
}

/// Converts the error to one of a source.
fn refusal(error: Error) -> runtime::Error {
    let Error {
        what,
        place,
        remedy,
        ..
    } = error;
    runtime::Error::new(what, place, remedy)
}

impl<S: Sensors> Live for Lines<S> {
    type Sensors = S;
    type Truth = S::Truth;

    fn poll(&mut self) -> Polled<S, S::Truth> {
        if let Some((sensors, truth)) = self.stream.row() {
            self.has_row = true;
            return Polled::Sample(sensors, truth);
        }
        if let Some(refusal) = self.refusal.take() {
            (self.has_ended, self.is_over) = (true, true);
            return Polled::Refused(refusal);
        }
        if self.has_ended {
            return self.end();
        }
        self.read();
        for remark in self.stream.take_remarks() {
            tracing::warn!("{remark}");
        }
        match self.stream.row() {
            Some((sensors, truth)) => {
                self.has_row = true;
                Polled::Sample(sensors, truth)
            }
            None => Polled::Nothing,
        }
    }
}

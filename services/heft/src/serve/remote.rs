//! A shard as the router sees it: a process, the samples sent since its last state, and the number of answered samples.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{BufReader, BufWriter, Write};
use std::os::unix::process::CommandExt;
use std::process::{Child, ChildStdin, ChildStdout, Stdio};
use std::sync::Mutex;
use std::thread::{Builder, Scope};
use std::time::Duration;

use super::frames::{self, FAULT, GONE, ROW, SAMPLE, STATE};
use super::rows::{self, Rows, lock};
use crate::failure::Failure;
use crate::image;

/// Number of samples between two states, and the bytes of the last state that add one: a state has some kB per machine.
const INTERVAL: (u64, usize) = (4096, 64);
/// Largest number of deaths in a row without an answer. One more ends the run: the samples themselves cause them.
const MOST_DEATHS: u32 = 5;

/// The input side of the process.
struct Input {
    child: Child,
    /// None after the last sample, or when the process has ended.
    pipe: Option<BufWriter<ChildStdin>>,
    /// Samples since the last state, as frames.
    unconfirmed: VecDeque<Vec<u8>>,
    /// Number of the first of them.
    first: u64,
    /// Number of them that were sent to the present process.
    sent: usize,
    /// Number of the sample at which the next state is requested.
    ask_at: u64,
    is_closed: bool,
}

/// The output side of the process.
#[derive(Default)]
struct Output {
    /// Number of samples that its last state includes.
    confirmed: u64,
    state: Vec<u8>,
    /// Number of answered samples.
    written: u64,
    /// Of these, the number that have no row because they were refused.
    refused: u64,
    deaths: u32,
    restarts: u32,
    /// Processor time of the processes that ended.
    processor: Duration,
    failure: Option<String>,
}

/// Totals over all shards.
#[derive(Default)]
pub struct Served {
    /// Number of samples that they answered.
    pub answered: u64,
    /// Of these, those that were refused.
    pub refused: u64,
    /// Number of processes that died and were replaced.
    pub replaced: u32,
    /// Their processor time; zero if the system does not report it.
    pub processor: Duration,
}

/// A shard.
pub struct RemoteShard<'a> {
    arguments: &'a [OsString],
    rows: &'a Rows,
    input: Mutex<Input>,
    output: Mutex<Output>,
    /// Output of the first process, until `listen` takes it. It has a mutex of its own: the holder of `input` may wait
    /// for the process, which may wait for a reader of its output.
    answers: Mutex<Option<ChildStdout>>,
}

/// A process with its input and its output.
struct Started {
    child: Child,
    pipe: BufWriter<ChildStdin>,
    answers: ChildStdout,
}

fn start(arguments: &[OsString]) -> Result<Started, Failure> {
    let mut command = image::command();
    // A process group of its own: Ctrl-C reaches only the feeding process, and the shard ends with its input.
    command.args(arguments).process_group(0);
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().map_err(|e| {
        Failure::input(
            format!("cannot start a process: {e}"),
            "this computer",
            "ask for fewer (--shards), or end others",
        )
    })?;
    let pipes = child.stdin.take().zip(child.stdout.take());
    let (pipe, answers) = pipes.ok_or_else(|| Failure::internal("no pipe"))?;
    Ok(Started {
        child,
        pipe: BufWriter::with_capacity(1 << 16, pipe),
        answers,
    })
}

impl<'a> RemoteShard<'a> {
    /// Starts the process.
    pub fn start(arguments: &'a [OsString], rows: &'a Rows) -> Result<Self, Failure> {
        let Started {
            child,
            pipe,
            answers,
        } = start(arguments)?;
        Ok(Self {
            arguments,
            rows,
            input: Mutex::new(Input {
                child,
                pipe: Some(pipe),
                unconfirmed: VecDeque::new(),
                first: 0,
                sent: 0,
                ask_at: INTERVAL.0,
                is_closed: false,
            }),
            output: Mutex::new(Output::default()),
            answers: Mutex::new(Some(answers)),
        })
    }

    /// Sends a sample.
    pub fn send(&self, number: u32, sample: &[u8]) {
        let (confirmed, state) = {
            let output = lock(&self.output);
            (output.confirmed, output.state.len())
        };
        let mut input = lock(&self.input);
        input.forget(confirmed);
        let mut frame = Vec::new();
        let _ = frames::write(&mut frame, SAMPLE, &[&number.to_le_bytes(), sample]); // into memory, and short
        input.unconfirmed.push_back(frame);
        input.pump(state);
    }

    /// Sends what is buffered.
    pub fn flush(&self) {
        let mut input = lock(&self.input);
        let flushed = input.pipe.as_mut().map(Write::flush);
        if let Some(Err(_)) = flushed {
            // The process has ended; the thread that reads its output replaces it.
            input.pipe = None;
        }
    }

    /// Ends the input: no more samples follow.
    pub fn close(&self) {
        let mut input = lock(&self.input);
        input.is_closed = true;
        input.pump(0);
    }

    /// Adds its counts to the totals.
    pub fn add_to(&self, totals: &mut Served) {
        let output = lock(&self.output);
        totals.answered += output.written;
        totals.refused += output.refused;
        totals.replaced += output.restarts;
        totals.processor += output.processor;
    }

    /// The failure that ended the shard.
    pub fn failure(&self) -> Option<Failure> {
        lock(&self.output).failure.clone().map(rows::failed)
    }

    /// Reads the answers in a thread of its own, and replaces the process when it dies.
    pub fn listen<'s>(&'a self, scope: &'s Scope<'s, 'a>) {
        let body = move || {
            let mut answers = lock(&self.answers).take();
            while let Some(pipe) = answers {
                let has_ended = self.take_answers(pipe);
                answers = self.replace(has_ended).unwrap_or_else(|failure| {
                    self.give_up(&failure);
                    None
                });
                if answers.is_some() {
                    // The new process receives the samples since the last state while this thread reads its answers.
                    let pump = move || lock(&self.input).pump(0);
                    if let Err(error) = Builder::new().spawn_scoped(scope, pump) {
                        self.give_up(&Failure::thread(error));
                        answers = None;
                    }
                }
            }
        };
        if let Err(error) = Builder::new().spawn_scoped(scope, body) {
            self.give_up(&Failure::thread(error));
        }
    }

    fn give_up(&self, failure: &Failure) {
        lock(&self.output).failure = Some(failure.to_string());
        lock(&self.input).pipe = None;
    }

    /// Reads the answers of a process until its output ends (true) or a failure (false).
    fn take_answers(&self, pipe: ChildStdout) -> bool {
        let mut pipe = BufReader::with_capacity(1 << 16, pipe);
        let mut bytes = Vec::new();
        let mut count = lock(&self.output).confirmed;
        loop {
            if pipe.buffer().is_empty()
                && let Err(why) = self.rows.flush()
            {
                return self.fail(&why);
            }
            // A truncated frame is the end too.
            let Ok(Some(kind)) = frames::read(&mut pipe, &mut bytes) else {
                return true;
            };
            match (kind, bytes.split_first_chunk()) {
                (ROW, Some((number, [f0, f1, f2, f3, row @ ..]))) => {
                    count += 1;
                    let mut output = lock(&self.output);
                    let is_new = output.answers(count);
                    let number = u32::from_le_bytes(*number);
                    let flags = u32::from_le_bytes([*f0, *f1, *f2, *f3]);
                    // A sample between two reported rows also has no row, but no flags either.
                    let is_refused = is_new && row.is_empty() && flags != 0;
                    output.refused += u64::from(is_refused);
                    drop(output);
                    if is_refused {
                        self.rows.refuse(number);
                    }
                    if is_new
                        && !row.is_empty()
                        && let Err(why) = self.rows.put(number, flags, row)
                    {
                        return self.fail(&why);
                    }
                }
                // It follows the last row of the machine.
                (GONE, Some((number, []))) => {
                    count += 1;
                    lock(&self.output).answers(count);
                    self.rows.forget(u32::from_le_bytes(*number));
                }
                (STATE, _) => {
                    let mut output = lock(&self.output);
                    output.confirmed = count;
                    std::mem::swap(&mut output.state, &mut bytes);
                }
                (FAULT, _) => return self.fail(&String::from_utf8_lossy(&bytes)),
                _ => return false,
            }
        }
    }

    fn fail(&self, why: &str) -> bool {
        lock(&self.output).failure = Some(why.to_owned());
        false
    }

    /// Replaces the process after its output has ended, if work is left. Returns the output of the new process.
    fn replace(&self, has_ended: bool) -> Result<Option<ChildStdout>, Failure> {
        let mut input = lock(&self.input);
        if !has_ended {
            input.pipe = None;
            let _ = input.child.kill();
        }
        let processor = runtime::processor_time_of(input.child.id());
        let ended = input.child.wait().map_err(Failure::internal)?;
        let mut output = lock(&self.output);
        output.processor += processor;
        if output.failure.is_some() {
            return Ok(None);
        }
        let asked = input.first + input.unconfirmed.len() as u64;
        if ended.success() && input.is_closed && output.written == asked {
            return Ok(None);
        }
        output.restarts += 1;
        output.deaths += 1;
        if output.deaths > MOST_DEATHS {
            return Err(Failure::internal(format!(
                "a shard died {} times in a row ({ended})",
                output.deaths
            )));
        }
        tracing::warn!("a shard ended ({ended}); another goes on with its machines");
        input.forget(output.confirmed);
        let Started {
            child,
            mut pipe,
            answers,
        } = start(self.arguments)?;
        if !output.state.is_empty() {
            // An error is ignored: if the process dies at once, its successor receives the state.
            let _ = frames::write(&mut pipe, STATE, &[&output.state]);
        }
        (input.child, input.pipe, input.sent) = (child, Some(pipe), 0);
        Ok(Some(answers))
    }
}

impl Output {
    /// Counts the answer of this number. Returns whether it is new, and not a repetition after a restart.
    fn answers(&mut self, count: u64) -> bool {
        let is_new = count > self.written;
        if is_new {
            (self.written, self.deaths) = (count, 0);
        }
        is_new
    }
}

impl Input {
    /// Removes the samples that the last state includes: they need not be sent again.
    fn forget(&mut self, confirmed: u64) {
        while self.first < confirmed && self.unconfirmed.pop_front().is_some() {
            self.first += 1;
            self.sent = self.sent.saturating_sub(1);
        }
    }

    /// Sends the samples that the process has not received, and requests its state at intervals; `state`: bytes of the last one.
    fn pump(&mut self, state: usize) {
        let Some(mut pipe) = self.pipe.take() else {
            return;
        };
        while let Some(frame) = self.unconfirmed.get(self.sent) {
            let number = self.first + self.sent as u64;
            let mut written = pipe.write_all(frame);
            if number >= self.ask_at {
                self.ask_at = number + INTERVAL.0 + (state / INTERVAL.1) as u64;
                written = written.and_then(|()| frames::write(&mut pipe, STATE, &[]));
            }
            self.sent += 1;
            if written.is_err() {
                // The process has ended; its successor receives all samples again.
                return;
            }
        }
        if !self.is_closed {
            self.pipe = Some(pipe);
        }
        // Otherwise the pipe is dropped: flushed and closed.
    }
}

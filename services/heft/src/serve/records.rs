//! Reads samples as messages: the name of a machine, then a sample as in recordings (protobuf), each preceded by its length
//! (varint). An empty message means that the machine has left: its state is removed.

use std::collections::HashMap;
use std::io::{self, BufRead, BufReader, Read};

use checks::Look;
use messages::{Message, Value};
use recording::payload::{decode, read_delimited};

use super::remote::RemoteShard;
use super::{LONGEST_NAME, MOST_MACHINES, Rows, Suspects, TOO_MANY, frames, shard_of, unreadable};
use crate::failure::Failure;

/// Largest sample \[bytes\].
const LARGEST: usize = 4096;
/// Messages that are reported when they are left out; the rest are only counted.
const REPORTED: u64 = 5;

/// Sends each sample to the shard of its machine.
pub struct Records<'a, 'b, L: Look> {
    input: &'a str,
    shards: &'a [RemoteShard<'a>],
    rows: &'a Rows,
    /// Number and shard of each present machine.
    machines: HashMap<String, (u32, usize)>,
    /// Number of machines so far, including those that have left.
    count: u32,
    suspects: &'a mut Suspects<'b, L>,
    samples: u64,
    refused: u64,
}

impl<'a, 'b, L: Look> Records<'a, 'b, L> {
    pub fn new(
        input: &'a str,
        shards: &'a [RemoteShard<'a>],
        rows: &'a Rows,
        suspects: &'a mut Suspects<'b, L>,
    ) -> Self {
        Self {
            input,
            shards,
            rows,
            machines: HashMap::new(),
            count: 0,
            suspects,
            samples: 0,
            refused: 0,
        }
    }

    /// Reads the whole input. Returns the number of samples and of messages that were left out.
    pub fn take_all(mut self, input: impl Read) -> Result<(u64, u64), Failure> {
        let mut input = BufReader::with_capacity(1 << 16, input);
        let (mut name, mut message, mut packed) = (Vec::new(), Vec::new(), Vec::new());
        loop {
            if input.buffer().is_empty() {
                // The next read may block: first send what is buffered.
                self.shards.iter().for_each(RemoteShard::flush);
                if let Some(failure) = self.shards.iter().find_map(RemoteShard::failure) {
                    return Err(failure);
                }
            }
            if !record(&mut input, &mut name, &mut message)
                .map_err(|e| unreadable(self.input, &e))?
            {
                return Ok((self.samples, self.refused));
            }
            let Some(name) = std::str::from_utf8(&name).ok().filter(|n| !n.is_empty()) else {
                self.refuse("names no machine");
                continue;
            };
            if message.is_empty() {
                if let Some((number, shard)) = self.machines.remove(name) {
                    self.suspects.forget(number);
                    self.shards[shard].send(number, &[]);
                }
                continue;
            }
            let Some(sample) = decode::<L::Sensors>(&message).filter(is_finite) else {
                self.refuse("is no sample");
                continue;
            };
            let Some((number, shard)) = self.place(name) else {
                self.refuse(TOO_MANY);
                continue;
            };
            self.suspects.see(number, name, &sample);
            frames::pack(&sample, &mut packed);
            self.samples += 1;
            self.shards[shard].send(number, &packed);
        }
    }

    fn place(&mut self, name: &str) -> Option<(u32, usize)> {
        if let Some(place) = self.machines.get(name) {
            return Some(*place);
        }
        if self.machines.len() == MOST_MACHINES {
            return None;
        }
        let place = (self.count, shard_of(name, self.shards.len()));
        self.count += 1;
        self.rows.add(name);
        self.machines.insert(name.to_owned(), place);
        Some(place)
    }

    fn refuse(&mut self, why: &str) {
        self.refused += 1;
        if self.refused <= REPORTED {
            tracing::warn!("a message {why}; left out");
        }
    }
}

/// Reads a name and a message; false at the end.
fn record(input: &mut impl BufRead, name: &mut Vec<u8>, message: &mut Vec<u8>) -> io::Result<bool> {
    if !read_delimited(input, LONGEST_NAME, name)? {
        return Ok(false);
    }
    if !read_delimited(input, LARGEST, message)? {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(true)
}

/// Whether every number in the message is finite.
fn is_finite<S: Message>(sample: &S) -> bool {
    let is_number = |i| !matches!(sample.get(i), Some(Value::F64(x)) if !x.is_finite());
    (0..S::FIELDS.len()).all(is_number)
}

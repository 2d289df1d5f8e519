//! Writes the rows of all machines, and counts them.

use std::collections::BTreeMap;
use std::io::{BufWriter, Stdout, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

use recording::Output;
use recording::payload::put_delimited;

use super::NAME;
use crate::failure::Failure;

/// Locks a mutex, even if a thread panicked while it held it.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Destination of rows.
pub enum Out {
    /// Standard output.
    Standard(BufWriter<Stdout>),
    /// A file that appears only when it is complete.
    File(Output),
}

impl Out {
    /// Standard output.
    pub fn standard() -> Self {
        Self::Standard(BufWriter::with_capacity(1 << 16, std::io::stdout()))
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), String> {
        match self {
            Self::Standard(out) => out.write_all(bytes).map_err(not_written),
            Self::File(out) => out.put(bytes).map_err(|e| e.to_string()),
        }
    }
}

/// Format of samples and estimates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// A table (CSV) with a column that names the machine.
    Table,
    /// The name of the machine, then the message as in recordings (protobuf), each preceded by its length (varint).
    Messages,
}

/// What is noted where the reader of the estimates has left.
const NOBODY_READS: &str = "nobody reads the estimates";

/// The failure that was noted in these words: without a message where the reader has left, as of every command.
pub(super) fn failed(words: String) -> Failure {
    match words.as_str() {
        NOBODY_READS => Failure::reader_left(),
        _ => Failure::reported(words),
    }
}

fn not_written(error: std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::BrokenPipe => NOBODY_READS.into(),
        _ => format!(
            "cannot write the estimates: {error}\n  where: standard output\n  what to do: make room, or write them elsewhere"
        ),
    }
}

/// A machine and the counts of its rows.
#[derive(Debug, Clone, Default)]
pub struct Member {
    /// Name, as it is written.
    pub name: String,
    /// Number of its rows.
    pub rows: u64,
    /// Number of rows with each of the counted flags.
    pub flagged: Vec<u64>,
    /// Number of its refused samples.
    pub refused: u64,
}

/// Machines by their numbers, and the number of machines so far.
#[derive(Default)]
struct Members {
    here: BTreeMap<u32, Member>,
    count: u32,
}

/// The rows of all machines; a table has one header.
pub struct Rows {
    out: Mutex<Out>,
    form: Form,
    members: Mutex<Members>,
    /// The counted flags of an estimate.
    flags: Vec<u32>,
}

impl Rows {
    /// Begins the output; a table with its header, in which `columns` follow the name of the machine.
    pub fn begin(
        mut out: Out,
        form: Form,
        columns: &str,
        flags: Vec<u32>,
    ) -> Result<Self, Failure> {
        if form == Form::Table {
            let header = format!("{NAME},{columns}\n");
            out.put(header.as_bytes()).map_err(failed)?;
        }
        Ok(Self {
            out: Mutex::new(out),
            form,
            members: Mutex::default(),
            flags,
        })
    }

    /// Adds a machine; its number is the number of machines so far.
    pub fn add(&self, name: &str) {
        let member = Member {
            name: match self.form {
                Form::Table => recording::csv::quoted(name),
                Form::Messages => name.to_owned(),
            },
            rows: 0,
            flagged: vec![0; self.flags.len()],
            refused: 0,
        };
        let mut members = lock(&self.members);
        let number = members.count;
        members.here.insert(number, member);
        members.count += 1;
    }

    /// Removes a machine that has left. Its number is not used again.
    pub fn forget(&self, number: u32) {
        lock(&self.members).here.remove(&number);
    }

    /// Counts a refused sample of a machine.
    pub fn refuse(&self, number: u32) {
        if let Some(member) = lock(&self.members).here.get_mut(&number) {
            member.refused += 1;
        }
    }

    /// Writes and counts a row of a machine.
    pub fn put(&self, number: u32, flags: u32, row: &[u8]) -> Result<(), String> {
        let mut members = lock(&self.members);
        let Some(member) = members.here.get_mut(&number) else {
            return Err(format!("a row of the unknown machine {number}"));
        };
        member.rows += 1;
        for (count, flag) in member.flagged.iter_mut().zip(&self.flags) {
            *count += u64::from(flags & flag != 0);
        }
        let mut out = lock(&self.out);
        match self.form {
            Form::Table => {
                for part in [member.name.as_bytes(), b",", row, b"\n"] {
                    out.put(part)?;
                }
                Ok(())
            }
            Form::Messages => {
                let mut record = Vec::with_capacity(member.name.len() + row.len() + 8);
                put_delimited(member.name.as_bytes(), &mut record);
                put_delimited(row, &mut record);
                out.put(&record)
            }
        }
    }

    /// Flushes standard output, which may be read live.
    pub fn flush(&self) -> Result<(), String> {
        match &mut *lock(&self.out) {
            Out::Standard(out) => out.flush().map_err(not_written),
            Out::File(_) => Ok(()),
        }
    }

    /// Ends the output. Returns the counts of each machine by its number.
    pub fn finish(self) -> Result<BTreeMap<u32, Member>, Failure> {
        match self
            .out
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
        {
            Out::Standard(mut out) => out.flush().map_err(|error| failed(not_written(error)))?,
            Out::File(out) => out.finish()?,
        }
        Ok(self
            .members
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
            .here)
    }
}

/// Whether a file with this beginning is such a table.
pub fn is_table(head: &[u8]) -> bool {
    head.starts_with(format!("{NAME},t,").as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_machine_that_has_gone_nothing_stays() {
        let rows = Rows::begin(Out::standard(), Form::Messages, "", Vec::new()).expect("begun");
        for name in ["a", "b"] {
            rows.add(name);
        }
        rows.forget(0);
        assert!(rows.put(0, 0, b"row").is_err(), "it is unknown");
        rows.add("c");
        let numbers: Vec<u32> = lock(&rows.members).here.keys().copied().collect();
        assert_eq!(numbers, [1, 2], "no number twice");
        let here = rows.finish().expect("written");
        assert_eq!(
            here.values().map(|m| m.name.as_str()).collect::<Vec<_>>(),
            ["b", "c"]
        );
    }
}

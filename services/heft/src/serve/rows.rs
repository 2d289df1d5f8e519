//! The rows of all machines: where they go, and what is counted of them.

use std::io::{BufWriter, Stdout, Write};
use std::sync::{Mutex, PoisonError};

use recording::Output;

use super::NAME;
use super::remote::lock;
use crate::failure::Failure;

/// Where rows go.
pub enum Out {
    /// Standard output.
    Standard(BufWriter<Stdout>),
    /// A file that appears when it is complete.
    File(Output),
}

impl Out {
    /// Standard output.
    pub fn standard() -> Self {
        Self::Standard(BufWriter::with_capacity(1 << 16, std::io::stdout()))
    }

    fn put(&mut self, text: &str) -> Result<(), String> {
        match self {
            Self::Standard(out) => out.write_all(text.as_bytes()).map_err(nobody_reads),
            Self::File(out) => out.put(text.as_bytes()).map_err(|e| e.to_string()),
        }
    }
}

fn nobody_reads(_: std::io::Error) -> String {
    "nobody reads the estimates".into()
}

/// A machine and what was counted of its rows.
#[derive(Debug, Clone, Default)]
pub struct Member {
    /// Its name, as a cell of a table.
    pub name: String,
    /// Rows of it.
    pub rows: u64,
    /// Those in which each of the flags was set.
    pub flagged: Vec<u64>,
}

/// The rows of all machines, below one header.
pub struct Rows {
    out: Mutex<Out>,
    members: Mutex<Vec<Member>>,
    /// Flags of an estimate that are counted.
    flags: Vec<u32>,
}

impl Rows {
    /// Begins with the header of the columns behind the machine's name.
    pub fn begin(mut out: Out, columns: &str, flags: Vec<u32>) -> Result<Self, Failure> {
        out.put(&format!("{NAME},{columns}\n"))
            .map_err(Failure::told)?;
        Ok(Self {
            out: Mutex::new(out),
            members: Mutex::default(),
            flags,
        })
    }

    /// Adds a machine; its number is how many there were.
    pub fn add(&self, name: &str) {
        lock(&self.members).push(Member {
            name: recording::csv::quoted(name),
            rows: 0,
            flagged: vec![0; self.flags.len()],
        });
    }

    /// A row of a machine.
    pub fn put(&self, number: u32, flags: u32, row: &str) -> Result<(), String> {
        let mut members = lock(&self.members);
        let Some(member) = members.get_mut(number as usize) else {
            return Err(format!("a row of the unknown machine {number}"));
        };
        member.rows += 1;
        for (count, flag) in member.flagged.iter_mut().zip(&self.flags) {
            *count += u64::from(flags & flag != 0);
        }
        let mut out = lock(&self.out);
        out.put(&member.name)?;
        out.put(",")?;
        out.put(row)?;
        out.put("\n")
    }

    /// Lets nothing wait in the buffer where somebody reads as it comes.
    pub fn flush(&self) -> Result<(), String> {
        match &mut *lock(&self.out) {
            Out::Standard(out) => out.flush().map_err(nobody_reads),
            Out::File(_) => Ok(()),
        }
    }

    /// Ends the table; what was counted of each machine.
    pub fn finish(self) -> Result<Vec<Member>, Failure> {
        match self
            .out
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
        {
            Out::Standard(mut out) => out.flush().map_err(Failure::internal)?,
            Out::File(out) => out.finish()?,
        }
        Ok(self
            .members
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner))
    }
}

/// Whether a file that begins like this is such a table.
#[must_use]
pub fn is_table(head: &[u8]) -> bool {
    head.starts_with(format!("{NAME},t,").as_bytes())
}

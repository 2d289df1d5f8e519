//! A shard: steps the machines whose samples it receives, one process per core. It sends its state on
//! request, so that another shard can continue from it.

use std::collections::BTreeMap;
use std::io::{BufReader, BufWriter, Write, stdin, stdout};

use config::Description;
use messages::Message;
use recording::csv::{Estimate, EstimateRows};
use steps::chain::{Chain, chain, last_answer};

use super::Form;
use super::frames::{self, FAULT, GONE, ROW, SAMPLE, STATE};

use crate::failure::Failure;

/// Buffer for the state of a step \[bytes\]; the largest takes some 3000.
const ROOM: usize = 1 << 16;

/// A machine in a shard.
struct Member {
    /// Its steps; the last one makes the estimate.
    chain: Chain,
    /// Time of its last row \[s\].
    reported: f64,
}

/// Machines by their numbers.
struct Shard<'a, E: Estimate> {
    description: &'a Description,
    method: &'a str,
    every: f64,
    form: Form,
    rows: &'a EstimateRows<E>,
    members: BTreeMap<u32, Member>,
}

/// Serves frames on standard input until it ends.
pub fn serve<S: Message, E: Estimate>(
    description: &Description,
    method: &str,
    every: f64,
    form: Form,
) -> Result<(), Failure> {
    let mut shard = Shard::<E> {
        description,
        method,
        every,
        form,
        rows: &EstimateRows::default(),
        members: BTreeMap::new(),
    };
    let mut input = BufReader::with_capacity(1 << 16, stdin().lock());
    let mut out = BufWriter::with_capacity(1 << 16, stdout().lock());
    let (mut bytes, mut row) = (Vec::new(), Vec::new());
    loop {
        if input.buffer().is_empty() && !arrives(out.flush())? {
            return Ok(());
        }
        let Some(kind) = frames::read(&mut input, &mut bytes).map_err(Failure::internal)? else {
            return arrives(out.flush()).map(drop);
        };
        let done = match (kind, bytes.split_first_chunk()) {
            (SAMPLE, Some((number, []))) => {
                shard.members.remove(&u32::from_le_bytes(*number));
                Ok(frames::write(&mut out, GONE, &[number]))
            }
            (SAMPLE, Some((number, sample))) => {
                row.clear();
                let answer = shard.answer::<S>(u32::from_le_bytes(*number), sample, &mut row);
                answer.map(|flags| {
                    frames::write(&mut out, ROW, &[number, &flags.to_le_bytes(), &row])
                })
            }
            (STATE, None) => shard
                .save()
                .map(|state| frames::write(&mut out, STATE, &[&state])),
            (STATE, _) => shard.restore(&bytes).map(Ok),
            _ => Err(Failure::internal("a shard was sent what it does not know")),
        };
        match done {
            Ok(written) => {
                if !arrives(written)? {
                    return Ok(());
                }
            }
            Err(failure) => {
                let reported = frames::write(&mut out, FAULT, &[failure.to_string().as_bytes()]);
                reported
                    .and_then(|()| out.flush())
                    .map_err(Failure::internal)?;
                return Err(failure);
            }
        }
    }
}

/// Whether the router still reads. If it has ended, the router itself reports why.
fn arrives(sent: std::io::Result<()>) -> Result<bool, Failure> {
    match sent {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(false),
        sent => sent.map(|()| true).map_err(Failure::internal),
    }
}

impl<E: Estimate> Shard<'_, E> {
    fn member(&mut self, number: u32) -> Result<&mut Member, Failure> {
        use std::collections::btree_map::Entry;
        match self.members.entry(number) {
            Entry::Occupied(member) => Ok(member.into_mut()),
            Entry::Vacant(place) => Ok(place.insert(Member {
                chain: chain(self.description, self.method)?,
                reported: f64::NEG_INFINITY,
            })),
        }
    }

    /// Appends the row of a sample's estimate, and returns its flags; no row where there is no estimate.
    fn answer<S: Message>(
        &mut self,
        number: u32,
        sample: &[u8],
        row: &mut Vec<u8>,
    ) -> Result<u32, Failure> {
        let (every, rows, form) = (self.every, self.rows, self.form);
        let member = self.member(number)?;
        let message = last_answer(&mut member.chain, frames::unpack::<S>(sample).envelope());
        let Some(estimate) = message.as_ref().and_then(E::inside) else {
            return Ok(0);
        };
        let time = estimate.stamp().time;
        // A clock that was set back restarts the period.
        if (member.reported..member.reported + every).contains(&time) {
            return Ok(0);
        }
        let flags = estimate.codes().flags;
        if flags & E::REFUSED != 0 {
            return Ok(flags);
        }
        member.reported = time;
        match form {
            Form::Table => {
                // The buffer is empty, so it is text; its capacity is reused.
                let mut text = String::from_utf8(std::mem::take(row)).unwrap_or_default();
                rows.put(estimate, &mut text);
                *row = text.into_bytes();
            }
            Form::Messages => recording::payload::encode(estimate, row),
        }
        Ok(flags)
    }

    /// The state for another shard: of each machine its number, the time of its last row, the number of its steps, and of each step
    /// length and state.
    fn save(&self) -> Result<Vec<u8>, Failure> {
        let mut bytes = Vec::new();
        let mut room = vec![0; ROOM];
        for (number, member) in &self.members {
            bytes.extend(number.to_le_bytes());
            bytes.extend(member.reported.to_le_bytes());
            bytes.extend((member.chain.len() as u32).to_le_bytes());
            for (_, step) in &member.chain {
                let length = step.save(&mut room).unwrap_or(0);
                bytes.extend((length as u32).to_le_bytes());
                bytes.extend_from_slice(&room[..length]);
            }
        }
        if bytes.len() > frames::LONGEST {
            return Err(Failure::input(
                format!(
                    "the state of {} machines is too large for one process",
                    self.members.len()
                ),
                "heft serve",
                "share them among more processes (--shards)",
            ));
        }
        Ok(bytes)
    }

    /// Continues from the state that another shard wrote.
    fn restore(&mut self, mut bytes: &[u8]) -> Result<(), Failure> {
        let broken = || Failure::internal("the state of a shard is broken");
        while !bytes.is_empty() {
            let number = u32::from_le_bytes(take(&mut bytes).ok_or_else(broken)?);
            let reported = f64::from_le_bytes(take(&mut bytes).ok_or_else(broken)?);
            let steps = u32::from_le_bytes(take(&mut bytes).ok_or_else(broken)?);
            let member = self.member(number)?;
            member.reported = reported;
            if steps as usize != member.chain.len() {
                return Err(broken());
            }
            for (_, step) in &mut member.chain {
                let length = u32::from_le_bytes(take(&mut bytes).ok_or_else(broken)?) as usize;
                let (state, rest) = bytes.split_at_checked(length).ok_or_else(broken)?;
                bytes = rest;
                // A step without a state has nothing to restore.
                if length > 0 && !step.restore(state) {
                    return Err(broken());
                }
            }
        }
        Ok(())
    }
}

fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (head, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*head)
}

//! The fleet in memory: the latest of every machine.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use messages::Envelope;

use super::alarm::State;
use super::intake::Taken;
use super::shown::{self, Quantity};
use crate::key::{MachineId, SITE_ESTIMATE};
use crate::label::Label;
use crate::status::Status;

/// A machine that said nothing for so long is not here.
pub const SILENT: Duration = Duration::from_secs(8);

/// All machines.
#[derive(Debug, Default)]
pub struct Fleet {
    /// By site and name.
    pub machines: BTreeMap<MachineId, Machine>,
}

/// What is missing of a machine's history.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Account {
    /// Messages that nobody has any more.
    pub lost: i64,
    /// Streams with a gap that may still close.
    pub gaps: u64,
}

/// The latest of a machine.
#[derive(Debug, Default)]
pub struct Machine {
    /// Kind: excavator, loader; empty before it was told.
    pub kind: String,
    /// Version of heft on it.
    pub version: String,
    /// What it says of itself.
    pub status: Option<Status>,
    /// When it last said so.
    pub heard: Option<Instant>,
    /// Its token is there.
    pub token: bool,
    /// Its clock minus ours [ms], as of the last status.
    pub clock_ms: i64,
    /// The latest message of each stream.
    pub latest: BTreeMap<String, (Label, Envelope)>,
    /// What was not taken, by reason.
    pub refused: BTreeMap<&'static str, u64>,
    /// See [`Account`].
    pub account: Account,
    /// What the alarms remember.
    pub alarms: State,
}

impl Machine {
    /// Whether it is here: it speaks, and its token has not gone.
    #[must_use]
    pub fn is_here(&self) -> bool {
        self.heard.is_some_and(|h| h.elapsed() < SILENT)
    }

    /// The message of a kind that is told first: that of the stream of the loads where there is one.
    #[must_use]
    pub fn main(&self, kind: &str) -> Option<&(Label, Envelope)> {
        let main = shown::main_channel(&self.kind)?;
        self.latest.get(&format!("{kind}/{main}"))
    }

    /// The quantity that it is about, as of its latest estimate; of the site's where it sends none itself.
    #[must_use]
    pub fn headline(&self) -> Option<Quantity> {
        let estimate = self.main("estimate").or_else(|| self.main(SITE_ESTIMATE));
        shown::headline(&estimate?.1)
    }
}

impl Fleet {
    fn machine(&mut self, id: &MachineId) -> &mut Machine {
        self.machines.entry(id.clone()).or_default()
    }

    /// Puts in a machine that the history knows.
    pub fn known(&mut self, id: &MachineId, kind: &str, version: &str) {
        let machine = self.machine(id);
        (machine.kind, machine.version) = (kind.to_owned(), version.to_owned());
    }

    /// After a start: nobody was heard yet.
    pub fn forget_when(&mut self) {
        self.machines.values_mut().for_each(|m| m.heard = None);
    }

    /// Takes in a message, old or new.
    pub fn message(&mut self, taken: &Taken) {
        let machine = self.machine(&taken.id);
        if machine.kind.is_empty() {
            machine.kind = shown::kind_of(&taken.envelope).to_owned();
        }
        let place = (taken.label.epoch, taken.label.number);
        let known = machine.latest.get(&taken.stream);
        if known.is_none_or(|(l, _)| (l.epoch, l.number) < place) {
            let latest = (taken.label.clone(), taken.envelope);
            machine.latest.insert(taken.stream.clone(), latest);
        }
    }

    /// Takes in what a machine says of itself.
    pub fn status(&mut self, id: &MachineId, status: Status) {
        let machine = self.machine(id);
        machine.heard = Some(Instant::now());
        machine.kind.clone_from(&status.kind);
        machine.version.clone_from(&status.version);
        machine.clock_ms = status.wall_ms as i64 - crate::wall_ms() as i64;
        machine.status = Some(status);
    }

    /// A token came or went.
    pub fn token(&mut self, id: &MachineId, is_there: bool) {
        let machine = self.machine(id);
        machine.token = is_there;
        if !is_there {
            machine.heard = None;
        }
    }

    /// Something was not taken.
    pub fn refused(&mut self, id: &MachineId, why: &'static str) {
        *self.machine(id).refused.entry(why).or_default() += 1;
    }

    /// Takes in what is missing of a machine.
    pub fn account(&mut self, id: &MachineId, account: Account) {
        self.machine(id).account = account;
    }

    /// The machines that are here, in order.
    #[must_use]
    pub fn here(&self) -> Vec<MachineId> {
        let here = self.machines.iter().filter(|(_, m)| m.is_here());
        here.map(|(id, _)| id.clone()).collect()
    }
}

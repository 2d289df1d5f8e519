//! The fleet in memory: the latest data of every machine.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use messages::Envelope;

use super::alarm_state::State;
use super::intake::StreamMessage;
use super::shown::{self, Quantity};
use super::strangers::{Contact, leave};
use crate::MACHINES;
use crate::key::{MachineId, SITE_ESTIMATE};
use crate::label::Label;
use crate::status::Status;

/// Silence after which a machine counts as absent.
pub const SILENT: Duration = Duration::from_secs(8);

/// All machines.
#[derive(Debug, Default)]
pub struct Fleet {
    /// By site and name.
    pub machines: BTreeMap<MachineId, Machine>,
    /// Number of messages refused because the table of machines is full.
    pub turned_away: u64,
    /// Start of the reception.
    pub begun: Option<Instant>,
    /// Why the history cannot be written, and since when.
    pub unkept: Option<(String, Instant)>,
}

/// Missing messages of a machine's history.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Account {
    /// Number of messages that are lost permanently.
    pub lost: i64,
    /// Streams with a gap that may still close.
    pub gaps: u64,
    /// Whole runs that the machine has counted and that the collector never received.
    pub unheard: u64,
}

/// The latest data of a machine.
#[derive(Debug, Default)]
pub struct Machine {
    /// Kind: excavator, loader; empty before it was reported.
    pub kind: String,
    /// Version of heft on it.
    pub version: String,
    /// Index of its run among all runs of all machines, in the order of first contact with the collector.
    pub run: i64,
    /// Times of first and last contact; `None` where only the history knows the machine.
    pub times: Option<Contact>,
    /// Its latest status.
    pub status: Option<Status>,
    /// Time of the latest status.
    pub heard: Option<Instant>,
    /// By its status, its latest run ended in order.
    pub ended: bool,
    /// By its status, its latest run was killed or failed.
    pub broke_off: bool,
    /// Its token is present.
    pub token: bool,
    /// Its clock minus ours [ms], as of the last status.
    pub clock_ms: i64,
    /// The latest message of each stream.
    pub latest: BTreeMap<String, (Label, Envelope)>,
    /// Place of the run of each stream's latest message.
    runs: BTreeMap<String, i64>,
    /// Refused messages, by reason.
    pub refused: BTreeMap<String, u64>,
    /// Missing and lost messages.
    pub account: Account,
    /// State of the alarms.
    pub alarms: State,
}

impl Machine {
    /// Whether contact with it has lasted only a moment.
    pub fn is_stranger(&self) -> bool {
        self.times.is_some_and(|t| t.is_stranger())
    }

    /// Whether it is present: it sends, and its token has not disappeared.
    pub fn is_here(&self) -> bool {
        self.heard.is_some_and(|h| h.elapsed() < SILENT)
    }

    /// The latest message of a kind on the headline channel: that of the loads where there is one.
    pub fn main(&self, kind: &str) -> Option<&(Label, Envelope)> {
        let main = shown::main_channel(&self.kind)?;
        self.latest.get(&format!("{kind}/{main}"))
    }

    /// The headline quantity of the latest estimate; the site's estimate where the machine sends none.
    pub fn headline(&self) -> Option<Quantity> {
        let estimate = self.main("estimate").or_else(|| self.main(SITE_ESTIMATE));
        shown::headline(&estimate?.1)
    }
}

impl Fleet {
    fn machine(&mut self, id: &MachineId) -> &mut Machine {
        if !self.machines.contains_key(id) && self.machines.len() >= MACHINES {
            let times = self
                .machines
                .iter()
                .filter_map(|(id, m)| Some((id, m.times?)));
            for other in leave(times, MACHINES) {
                self.machines.remove(&other);
            }
            if self.machines.len() >= MACHINES {
                // Machines that only the history knows have been silent since the start.
                self.machines.retain(|_, m| m.times.is_some());
            }
        }
        self.machines.entry(id.clone()).or_default()
    }

    /// The entry of a machine, with contact now.
    fn heard(&mut self, id: &MachineId) -> &mut Machine {
        let machine = self.machine(id);
        machine.times.get_or_insert_with(Contact::now).again();
        machine
    }

    /// Adds a machine from the history.
    pub fn known(&mut self, id: &MachineId, kind: &str, version: &str, ended: bool) {
        let machine = self.machine(id);
        machine.ended = ended;
        (machine.kind, machine.version) = (kind.to_owned(), version.to_owned());
    }

    /// Clears the times of contact, after the history is read: there has been no contact with any machine yet.
    pub fn forget_when(&mut self) {
        for machine in self.machines.values_mut() {
            (machine.heard, machine.times) = (None, None);
        }
    }

    /// Takes in a message, old or new; `run`: place of its run among all.
    pub fn message(&mut self, taken: &StreamMessage, run: i64) {
        let machine = self.heard(&taken.id);
        if machine.kind.is_empty() {
            machine.kind = shown::kind_of(&taken.envelope).to_owned();
        }
        let place = (run, taken.label.number);
        let known = machine.latest.get(&taken.stream);
        let of = machine.runs.get(&taken.stream).copied().unwrap_or(0);
        if known.is_none_or(|(l, _)| (of, l.number) < place) {
            machine.runs.insert(taken.stream.clone(), run);
            let latest = (taken.label.clone(), taken.envelope);
            machine.latest.insert(taken.stream.clone(), latest);
        }
    }

    /// Takes in a machine's status; `run`: place of its run among all. Of two runs that report at the same time the later one is
    /// shown, because the gateway of the earlier run stays for a while.
    pub fn status(&mut self, id: &MachineId, status: Status, run: i64) {
        let machine = self.heard(id);
        if run < machine.run && machine.is_here() {
            return;
        }
        machine.run = run;
        machine.heard = Some(Instant::now());
        (machine.ended, machine.broke_off) = (status.ended, status.broke_off);
        machine.kind.clone_from(&status.kind);
        machine.version.clone_from(&status.version);
        machine.clock_ms = status.wall_ms as i64 - crate::wall_ms() as i64;
        machine.status = Some(status);
    }

    /// Notes the appearance or disappearance of a token.
    pub fn token(&mut self, id: &MachineId, is_there: bool) {
        if is_there {
            self.heard(id).token = true;
        } else if let Some(machine) = self.machines.get_mut(id) {
            (machine.token, machine.heard) = (false, None);
        }
    }

    /// Counts a refused message.
    pub fn refused(&mut self, id: &MachineId, why: &str, messages: u64) {
        let refused = &mut self.heard(id).refused;
        *refused.entry(why.to_owned()).or_default() += messages;
    }

    /// Sets the account of missing messages.
    pub fn account(&mut self, id: &MachineId, account: Account) {
        if let Some(machine) = self.machines.get_mut(id) {
            machine.account = account;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::alarm::{AlarmArgs, look};
    use super::*;

    #[test]
    fn tokens_of_made_up_names_are_bounded_and_raise_nothing() {
        let mut fleet = Fleet::default();
        let id = |i: usize| MachineId::new("north", &format!("made-up-{i}")).expect("names");
        fleet.token(&id(0), false);
        assert!(fleet.machines.is_empty(), "who goes was here");
        for i in 0..MACHINES {
            fleet.known(&id(i), "excavator", "0.1", true);
        }
        for i in MACHINES..2 * MACHINES + 10 {
            fleet.token(&id(i), true);
        }
        assert!(fleet.machines.len() <= MACHINES, "{}", fleet.machines.len());
        assert!(fleet.machines.contains_key(&id(2 * MACHINES + 9)));
        let args = AlarmArgs {
            untrusted_after: 30.0,
        };
        assert_eq!(look(&mut fleet, &args), []);
    }
}

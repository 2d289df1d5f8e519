//! Missing messages of a stream. The store knows up to which number each stream is complete (`good`). Messages behind a gap are
//! not complete until the machine, or the site for its own estimates, has answered. What is still missing then is counted as
//! lost.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use rusqlite::params;

use super::{IsHere, Store};
use crate::collector::ask::Question;
use crate::collector::intake::{Answer, is_of_site};
use crate::collector::live::Account;
use crate::key::MachineId;
use crate::label::{Label, lost, lost_behind};

/// Age below which a gap may still close by itself, from Zenoh's cache.
const GRACE: Duration = Duration::from_secs(5);
/// Pause between two requests for the same gap; it doubles up to the longest.
const PAUSE: Duration = Duration::from_secs(2);
const LONGEST_PAUSE: Duration = Duration::from_secs(60);
/// Time without a reply after which a request is repeated. It also serves a finished run, whose gateway stays for 20 s. It
/// doubles at each attempt, for a machine that must read a long recording first.
const PATIENCE: Duration = Duration::from_secs(5);
const LONGEST_PATIENCE: Duration = Duration::from_secs(60);
/// Unanswered requests to a site after which its messages count as lost: a site stores nothing beyond its process.
const SITE_ATTEMPTS: u32 = 5;

/// A stream of one run.
pub(super) struct Stream {
    pub machine: MachineId,
    pub name: String,
    pub run: i64,
    /// Everything up to this number is stored or counted as lost.
    pub good: i64,
    /// The latest number known to exist.
    pub head: i64,
    /// The latest number stored.
    pub newest: i64,
    pub lost: i64,
    pub per_period: f64,
    /// Whether this state is written to the file.
    pub is_written: bool,
    /// Time since which something is missing.
    gap: Option<Instant>,
    asked: bool,
    next: Instant,
    pause: Duration,
    patience: Duration,
    /// Successive requests without an answer.
    unanswered: u32,
    is_of_site: bool,
}

impl Store {
    /// Moves `good` over the messages that follow without a gap.
    pub(super) fn advance(&mut self, id: i64) -> rusqlite::Result<()> {
        let Some(stream) = self.streams.get_mut(&id) else {
            return Ok(());
        };
        let mut query = self.sql.prepare_cached(
            "SELECT number, after FROM message WHERE stream = ? AND number > ? ORDER BY number",
        )?;
        let mut rows = query.query(params![id, stream.good])?;
        while let Some(row) = rows.next()? {
            let after: Option<i64> = row.get(1)?;
            if !stream.follows(after) {
                break;
            }
            stream.good = row.get(0)?;
        }
        Ok(())
    }

    /// Requests to send to the machines that are present, and to their site: gaps that did not close by themselves. Each
    /// answering side has one request at a time, in rotation, so an unresponsive one delays no other.
    pub fn questions(&mut self, is_here: &IsHere<'_>, most: usize) -> Vec<Question> {
        let now = Instant::now();
        self.waiting.clear();
        for (id, stream) in &mut self.streams {
            if stream.good >= stream.head {
                (stream.gap, stream.pause) = (None, PAUSE);
                continue;
            }
            let since = *stream.gap.get_or_insert(now);
            if !stream.asked && now >= stream.next && now.duration_since(since) >= GRACE {
                self.waiting.push(*id);
            }
        }
        let last = self.last_asked;
        let behind = self.waiting.partition_point(|id| *id <= last);
        self.waiting.rotate_left(behind);
        self.next_questions(is_here, most)
    }

    /// As [`Self::questions`], from the streams that were due at the last check: after an answer.
    pub fn next_questions(&mut self, is_here: &IsHere<'_>, most: usize) -> Vec<Question> {
        let mut questions = Vec::new();
        for id in std::mem::take(&mut self.waiting) {
            let Some(stream) = self.streams.get_mut(&id) else {
                continue;
            };
            let who = stream.who_answers();
            if questions.len() == most || self.under_way.values().any(|w| *w == who) {
                self.waiting.push(id);
                continue;
            }
            if stream.good < stream.head && (stream.is_of_site || is_here(&stream.machine)) {
                stream.asked = true;
                self.under_way.insert(id, who);
                self.last_asked = id;
                questions.push(Question {
                    stream: id,
                    id: stream.machine.clone(),
                    name: stream.name.clone(),
                    run: stream.run,
                    after: stream.good,
                    upto: stream.head,
                    patience: stream.patience,
                });
            }
        }
        questions
    }

    /// Counts as lost what an unresponsive site has not sent.
    ///
    /// # Errors
    /// The disk cannot be written.
    pub fn settle(&mut self) -> rusqlite::Result<()> {
        let is_due = |s: &Stream| s.is_of_site && s.unanswered >= SITE_ATTEMPTS;
        let due = self.streams.iter().filter(|(_, s)| is_due(s));
        let due: Vec<i64> = due.map(|(id, _)| *id).collect();
        due.into_iter()
            .try_for_each(|id| self.answered(id, Answer::Over))
    }

    /// Takes in the end of a request: what the answering side does not have is lost.
    ///
    /// # Errors
    /// The disk cannot be written.
    pub fn answered(&mut self, id: i64, answer: Answer) -> rusqlite::Result<()> {
        self.under_way.remove(&id);
        let Some(stream) = self.streams.get_mut(&id) else {
            return Ok(());
        };
        stream.asked = false;
        if answer == Answer::None {
            stream.patience = (stream.patience * 2).min(LONGEST_PATIENCE);
            stream.unanswered += 1;
        } else {
            stream.unanswered = 0;
        }
        let upto = match answer {
            Answer::Whole(served) => served.upto.min(stream.head),
            Answer::Over => stream.head,
            Answer::None => stream.good,
        };
        if upto <= stream.good {
            stream.next = Instant::now() + stream.pause;
            stream.pause = (stream.pause * 2).min(LONGEST_PAUSE);
            return Ok(());
        }
        stream.pause = PAUSE;
        stream.is_written = false;
        let mut query = self
            .sql
            .prepare_cached("SELECT number, after FROM message WHERE stream = ? AND number > ? AND number <= ? ORDER BY number")?;
        let mut rows = query.query(params![id, stream.good, upto])?;
        let label = |number: i64, after| Label {
            machine: String::new(),
            run: 0,
            number: number as u64,
            after,
            wall_ms: 0,
        };
        while let Some(row) = rows.next()? {
            let number = row.get(0)?;
            let next = label(number, row.get(1)?);
            let least = u64::from(stream.is_of_site && !stream.follows(next.after));
            stream.lose(lost(stream.good, &next, stream.per_period).max(least));
            stream.good = number;
        }
        if upto > stream.good {
            // The machine has announced this number and does not have it any more.
            stream.lose(lost_behind(stream.good, upto, stream.per_period));
            stream.good = upto;
        }
        drop(rows);
        drop(query);
        self.advance(id)
    }

    /// Missing and lost messages, by machine.
    pub fn account(&self) -> BTreeMap<MachineId, Account> {
        let mut all: BTreeMap<MachineId, Account> = BTreeMap::new();
        for stream in self.streams.values() {
            let account = all.entry(stream.machine.clone()).or_default();
            account.lost = account.lost.saturating_add(stream.lost);
            account.gaps += u64::from(stream.good < stream.head);
        }
        let unheard = self.unheard();
        for (id, owner) in &self.machines {
            if let Some(runs) = unheard.get(&owner.id).filter(|runs| **runs > 0) {
                all.entry(id.clone()).or_default().unheard = *runs;
            }
        }
        all
    }
}

impl Stream {
    pub fn new(machine: MachineId, name: String, run: i64) -> Self {
        Self {
            machine,
            is_of_site: is_of_site(&name),
            name,
            run,
            good: -1,
            head: -1,
            newest: -1,
            lost: 0,
            per_period: 0.0,
            is_written: false,
            gap: None,
            asked: false,
            next: Instant::now(),
            pause: PAUSE,
            patience: PATIENCE,
            unanswered: 0,
        }
    }

    /// The side that answers requests: the machine, or its site, which is represented by an empty machine name.
    fn who_answers(&self) -> MachineId {
        let mut who = self.machine.clone();
        if self.is_of_site {
            who.machine.clear();
        }
        who
    }

    /// Whether nothing is missing before a message whose predecessor is `after`. A site that joins a running run has no estimates
    /// before its first one.
    pub fn follows(&self, after: Option<i64>) -> bool {
        match after {
            Some(after) => after <= self.good,
            None => self.is_of_site && self.good < 0,
        }
    }

    fn lose(&mut self, messages: u64) {
        let messages = i64::try_from(messages).unwrap_or(i64::MAX);
        self.lost = self.lost.saturating_add(messages);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status::{self, Status};

    const STREAMS: [&str; 3] = ["estimate/inertia_rls", "estimate/inertia_ukf", "health/ukf"];

    fn machine(name: &str) -> MachineId {
        MachineId::new("north", name).expect("names")
    }

    /// A history in which each stream of these machines has had a gap for a long time.
    fn history(folder: &std::path::Path, machines: &[&str]) -> Store {
        let mut store = Store::open(&folder.join("fleet.sqlite")).expect("a history");
        let stream = |name: &str| {
            let (head, per_period) = (9, 1.0);
            (name.to_owned(), status::Stream { head, per_period })
        };
        for name in machines {
            let status = Status {
                streams: STREAMS.map(stream).into(),
                ..Status::default()
            };
            store.status(&machine(name), &status).expect("room");
        }
        let long_ago = Instant::now().checked_sub(GRACE);
        let streams = store.streams.values_mut();
        streams.for_each(|stream| stream.gap = long_ago);
        store
    }

    fn names(questions: &[Question]) -> Vec<&str> {
        questions.iter().map(|q| q.id.machine.as_str()).collect()
    }

    #[test]
    fn a_machine_that_does_not_answer_holds_up_no_other() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut store = history(folder.path(), &["mute", "honest"]);
        let asked = store.questions(&|_| true, 3);
        assert_eq!(names(&asked), ["mute", "honest"], "one each");
        // The next request to the honest machine follows at once.
        let whole = |q: &Question| {
            Answer::Whole(crate::question::AnswerSummary {
                upto: q.upto,
                ..Default::default()
            })
        };
        store
            .answered(asked[1].stream, whole(&asked[1]))
            .expect("room");
        let next = store.next_questions(&|_| true, 2);
        assert_eq!(names(&next), ["honest"]);
        assert_ne!(next[0].name, asked[1].name);
        store
            .answered(next[0].stream, whole(&next[0]))
            .expect("room");
        let last = store.questions(&|_| true, 2);
        assert_eq!(names(&last), ["honest"]);
        assert_eq!(store.account()[&machine("honest")].gaps, 1);
    }

    #[test]
    fn where_places_are_few_the_machines_are_asked_in_turn() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut store = history(folder.path(), &["a", "b", "c"]);
        let mut order = Vec::new();
        for _ in 0..6 {
            let asked = store.questions(&|_| true, 1);
            order.extend(asked.iter().map(|q| q.id.machine.clone()));
            store.answered(asked[0].stream, Answer::None).expect("room");
            store
                .streams
                .values_mut()
                .for_each(|s| s.next = Instant::now());
        }
        // By stream, in turn; no machine is asked a second time before all were asked.
        assert_eq!(order, ["a", "a", "a", "b", "b", "b"]);
        let here = |id: &MachineId| id.machine == "a";
        assert_eq!(names(&store.questions(&here, 9)), ["a"]);
    }
}

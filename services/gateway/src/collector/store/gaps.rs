//! What is missing of a stream. The store knows up to where each is whole (`good`); what lies behind a gap waits there
//! until the machine has answered, or the site for what it makes itself, and then what is still missing is counted as lost.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use rusqlite::params;

use super::Store;
use crate::collector::ask::Question;
use crate::collector::intake::{Answer, is_of_site};
use crate::collector::live::Account;
use crate::key::MachineId;
use crate::label::{Label, lost, lost_behind};

/// A gap younger than this may close by itself, from Zenoh's cache.
const GRACE: Duration = Duration::from_secs(5);
/// Pause between two questions about the same gap; it doubles up to the longest.
const PAUSE: Duration = Duration::from_secs(2);
const LONGEST_PAUSE: Duration = Duration::from_secs(60);
/// A question of which nothing was heard for so long is asked again, also of a run that is over: its gateway stays for
/// 20 s. A machine that must read a long recording first gets twice the time at each attempt.
const PATIENCE: Duration = Duration::from_secs(5);
const LONGEST_PATIENCE: Duration = Duration::from_secs(60);
/// Questions to a site without an answer, after which it has gone for good: it keeps nothing beyond its process.
const SITE_ATTEMPTS: u32 = 5;

/// A stream of one run.
pub(super) struct Stream {
    pub machine: MachineId,
    pub name: String,
    pub run: i64,
    /// Everything up to this number is here or counted as lost.
    pub good: i64,
    /// The latest that is known of, here or not.
    pub head: i64,
    /// The latest that is here.
    pub newest: i64,
    pub lost: i64,
    pub per_period: f64,
    /// Written to the file.
    pub is_written: bool,
    /// Since when something is missing.
    gap: Option<Instant>,
    asked: bool,
    next: Instant,
    pause: Duration,
    patience: Duration,
    /// Questions in a row without an answer.
    unanswered: u32,
    is_of_site: bool,
}

impl Store {
    /// Moves `good` over everything that follows without a gap.
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

    /// What to ask the machines that are here, and their site: gaps that did not close by themselves.
    pub fn questions(&mut self, here: &[MachineId], most: usize) -> Vec<Question> {
        let now = Instant::now();
        let mut questions = Vec::new();
        for (id, stream) in &mut self.streams {
            if stream.good >= stream.head {
                (stream.gap, stream.pause) = (None, PAUSE);
                continue;
            }
            let since = *stream.gap.get_or_insert(now);
            let is_due = !stream.asked && now >= stream.next && now.duration_since(since) >= GRACE;
            let is_here = || stream.is_of_site || here.binary_search(&stream.machine).is_ok();
            if is_due && questions.len() < most && is_here() {
                stream.asked = true;
                questions.push(Question {
                    stream: *id,
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

    /// Counts as lost what a site that does not answer has not sent.
    ///
    /// # Errors
    /// The disk takes no more.
    pub fn settle(&mut self) -> rusqlite::Result<()> {
        let is_due = |s: &Stream| s.is_of_site && s.unanswered >= SITE_ATTEMPTS;
        let due = self.streams.iter().filter(|(_, s)| is_due(s));
        let due: Vec<i64> = due.map(|(id, _)| *id).collect();
        due.into_iter()
            .try_for_each(|id| self.answered(id, Answer::Over))
    }

    /// Takes in the end of a question: what the machine does not have is lost.
    ///
    /// # Errors
    /// The disk takes no more.
    pub fn answered(&mut self, id: i64, answer: Answer) -> rusqlite::Result<()> {
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
            // The machine spoke of that one, and has it no more.
            stream.lose(lost_behind(stream.good, upto, stream.per_period));
            stream.good = upto;
        }
        drop(rows);
        drop(query);
        self.advance(id)
    }

    /// What is missing and what is lost, by machine.
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

    /// Whether nothing is missing between what is here and a message that names `after` as the one before it. Where a site
    /// has joined a run on its way, nothing of its own was before.
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

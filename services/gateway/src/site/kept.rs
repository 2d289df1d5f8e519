//! Recent answers of a site, for collectors that request what did not arrive.
//!
//! An answer is sent once, and congestion may drop it. The next answer names it, so a collector detects the gap and requests it
//! here. After the last answer of a run none follows, so that one is repeated, in pauses that double, until the run is old. The
//! store is bounded; the collector counts dropped answers as lost.

use std::collections::{HashMap, VecDeque};
use std::sync::mpsc::{Receiver, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use zenoh::query::Query;
use zenoh::{Session, Wait};

use crate::key::{MachineId, ROOT};
use crate::label::{Label, lost};
use crate::lock;
use crate::question::{AnswerSummary, Asked, MOST, OVER, WAITING, end};

/// Bytes stored for all machines: some minutes of a thousand machines at one estimate a second.
const BYTES: usize = 64 << 20;
/// Approximate memory of an answer beside its message [bytes].
const OVERHEAD: usize = 150;
/// Pause before the last answer of a run is repeated; it doubles up to the longest.
const PAUSE: Duration = Duration::from_secs(1);
const LONGEST_PAUSE: Duration = Duration::from_secs(60);
/// Silence after which a run is old.
const OLD: Duration = Duration::from_secs(600);

/// An answer as it was published.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Answer {
    pub label: Label,
    pub payload: Vec<u8>,
}

/// The stored answers.
#[derive(Default)]
pub(super) struct Kept(Mutex<State>);

#[derive(Default)]
struct State {
    answers: VecDeque<Arc<Answer>>,
    bytes: usize,
    /// The last answer of each machine and run.
    last: HashMap<(String, u64), Last>,
}

struct Last {
    answer: Arc<Answer>,
    since: Instant,
    next: Instant,
    pause: Duration,
}

impl Kept {
    fn state(&self) -> MutexGuard<'_, State> {
        lock(&self.0)
    }

    /// Stores an answer; drops the oldest ones beyond the bound.
    pub fn keep(&self, answer: Arc<Answer>, now: Instant) {
        let state = &mut *self.state();
        state.bytes += answer.payload.len() + OVERHEAD;
        state.answers.push_back(Arc::clone(&answer));
        while state.bytes > BYTES
            && let Some(gone) = state.answers.pop_front()
        {
            state.bytes -= gone.payload.len() + OVERHEAD;
        }
        let run = (answer.label.machine.clone(), answer.label.run);
        let last = Last {
            answer,
            since: now,
            next: now + PAUSE,
            pause: PAUSE,
        };
        state.last.insert(run, last);
    }

    /// The last answers that are due for repetition.
    pub fn due(&self, now: Instant) -> Vec<Arc<Answer>> {
        let state = &mut *self.state();
        state
            .last
            .retain(|_, last| now.duration_since(last.since) < OLD);
        let due = state.last.values_mut().filter(|last| last.next <= now);
        due.map(|last| {
            last.pause = (last.pause * 2).min(LONGEST_PAUSE);
            last.next = now + last.pause;
            Arc::clone(&last.answer)
        })
        .collect()
    }

    /// The requested answers in order, and their summary; `None` if no answer of the run is stored.
    fn between(&self, machine: &str, asked: Asked) -> Option<(Vec<Arc<Answer>>, AnswerSummary)> {
        let state = self.state();
        let is_of_run = |a: &&Arc<Answer>| {
            a.label.machine == machine && i64::try_from(a.label.run) == Ok(asked.run)
        };
        let mut of_run = state.answers.iter().filter(is_of_run).peekable();
        of_run.peek()?;
        let wanted = asked.after.saturating_add(1)..=asked.upto;
        let mut found: Vec<Arc<Answer>> = of_run
            .filter(|a| wanted.contains(&(a.label.number as i64)))
            .cloned()
            .collect();
        let is_whole = found.len() as u64 <= MOST;
        found.truncate(MOST as usize);
        let mut summary = AnswerSummary {
            upto: asked.after,
            messages: found.len() as u64,
            lost: 0,
        };
        for answer in &found {
            summary.lost += lost(summary.upto, &answer.label, 0.0);
            summary.upto = answer.label.number as i64;
        }
        if is_whole {
            summary.upto = asked.upto.max(asked.after);
        }
        Some((found, summary))
    }
}

/// Answers requests for a stream of a site's machines until the returned value is dropped.
pub(super) fn declare(
    session: &Session,
    site: &str,
    stream: &str,
    kept: &Arc<Kept>,
) -> zenoh::Result<impl Sized + use<>> {
    let (questions, waiting) = sync_channel(WAITING);
    let its = Arc::clone(kept);
    std::thread::spawn(move || serve(&its, &waiting));
    let callback = move |query| {
        // A request beyond the bound ends without an answer, and is repeated.
        let _ = questions.try_send(query);
    };
    let key = format!("{ROOT}/{site}/*/{stream}");
    session.declare_queryable(key).callback(callback).wait()
}

fn serve(kept: &Kept, questions: &Receiver<Query>) {
    for query in questions {
        let id = MachineId::of(query.key_expr().as_str()).map(|(id, _)| id);
        if let (Some(id), Some(asked)) = (id, Asked::of(&query)) {
            answer(kept, &query, &id, asked);
        }
    }
}

fn answer(kept: &Kept, query: &Query, id: &MachineId, asked: Asked) {
    let Some((answers, summary)) = kept.between(&id.machine, asked) else {
        let _ = query.reply_err(OVER).wait();
        return;
    };
    for answer in answers {
        let reply = query.reply(query.key_expr().clone(), answer.payload.clone());
        let sent = reply.attachment(answer.label.to_string()).wait();
        if sent.is_err() {
            // Without the summary the request counts as unanswered.
            return;
        }
    }
    end(query, &summary);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(machine: &str, run: u64, number: u64, after: i64, bytes: usize) -> Arc<Answer> {
        let label = Label {
            machine: machine.to_owned(),
            run,
            number,
            after: Some(after),
            wall_ms: 0,
        };
        Arc::new(Answer {
            label,
            payload: vec![0; bytes],
        })
    }

    fn numbers(answers: &[Arc<Answer>]) -> Vec<u64> {
        answers.iter().map(|a| a.label.number).collect()
    }

    fn asked(run: i64, after: i64, upto: i64) -> Asked {
        Asked { run, after, upto }
    }

    #[test]
    fn what_is_asked_for_is_found_and_what_has_made_way_is_counted() {
        let (kept, now) = (Kept::default(), Instant::now());
        for number in 0..10 {
            kept.keep(answer("ex-1", 7, number, number as i64 - 1, 9), now);
            kept.keep(answer("ex-2", 7, number, number as i64 - 1, 9), now);
        }
        let (found, summary) = kept.between("ex-1", asked(7, 2, 5)).expect("the run");
        assert_eq!(numbers(&found), [3, 4, 5]);
        assert_eq!((summary.upto, summary.messages, summary.lost), (5, 3, 0));
        assert!(kept.between("ex-1", asked(8, 2, 5)).is_none());
        assert!(kept.between("ex-3", asked(7, 2, 5)).is_none());
        // Two such answers fill the store.
        for number in 10..12 {
            kept.keep(
                answer("ex-1", 7, number, number as i64 - 1, BYTES / 2 - OVERHEAD),
                now,
            );
        }
        let (found, summary) = kept.between("ex-1", asked(7, 2, 11)).expect("the run");
        assert_eq!(numbers(&found), [10, 11]);
        assert_eq!(
            (summary.upto, summary.lost),
            (11, 1),
            "a gap is one at least"
        );
        assert!(kept.between("ex-2", asked(7, 2, 5)).is_none());
        assert!(kept.state().bytes <= BYTES);
    }

    #[test]
    fn the_last_answer_of_a_run_is_repeated_until_it_is_old() {
        let (kept, begun) = (Kept::default(), Instant::now());
        let at = |seconds: f64| begun + Duration::from_secs_f64(seconds);
        kept.keep(answer("ex-1", 7, 0, -1, 9), begun);
        kept.keep(answer("ex-1", 7, 1, 0, 9), at(0.5));
        assert!(kept.due(at(1.2)).is_empty(), "another came since");
        assert_eq!(numbers(&kept.due(at(1.6))), [1]);
        assert!(kept.due(at(3.5)).is_empty());
        assert_eq!(numbers(&kept.due(at(3.7))), [1]);
        let times = (4..1000).filter(|s| !kept.due(at(f64::from(*s))).is_empty());
        assert_eq!(times.count(), 12, "after 4, 8, 16, 32 s, then each 60 s");
        assert!(kept.state().last.is_empty());
    }
}

//! Requests for missing messages, to machines and, for their estimates, to sites.
//!
//! They are sent by a separate thread: Zenoh may end a request on the thread that sends it. The end is reported through a queue
//! that only the collector's thread empties, so that thread makes no call to Zenoh while it works.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use zenoh::cancellation::CancellationToken;
use zenoh::query::ConsolidationMode;
use zenoh::{Session, Wait};

use super::intake::{Answer, Event, Intake};
use crate::key::MachineId;
use crate::lock;
use crate::question::{AnswerSummary, END, OVER};

/// Requests under way at a time.
const AT_A_TIME: usize = 8;
/// Timeout of a request.
const LIMIT: Duration = Duration::from_secs(60);
/// Period of the check for unanswered requests.
const LOOK: Duration = Duration::from_millis(500);

/// A request for the messages of a stream between two numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    /// Number of the stream in the store.
    pub stream: i64,
    /// The machine.
    pub id: MachineId,
    /// `KIND/NAME`.
    pub name: String,
    /// Id of the run.
    pub run: i64,
    /// Everything up to this number is stored.
    pub after: i64,
    /// Latest number known to exist.
    pub upto: i64,
    /// Time without a reply after which the request is cancelled.
    pub patience: Duration,
}

/// Queues requests and counts those under way.
pub struct Asker {
    questions: SyncSender<Question>,
    under_way: usize,
}

impl Asker {
    pub(super) fn new(session: Session, intake: Arc<Intake>) -> Self {
        let (questions, waiting) = sync_channel(AT_A_TIME);
        std::thread::spawn(move || ask_all(&session, &intake, &waiting));
        Self {
            questions,
            under_way: 0,
        }
    }

    /// Number of requests that may be sent now.
    pub(super) fn room(&self) -> usize {
        AT_A_TIME.saturating_sub(self.under_way)
    }

    /// Notes the end of a question.
    pub(super) fn answered(&mut self) {
        self.under_way = self.under_way.saturating_sub(1);
    }

    /// Queues a request, within [`Self::room`]. Its end is always reported as [`Event::Answered`]. Does not block.
    pub(super) fn ask(&mut self, question: Question) {
        self.under_way += 1;
        if self.questions.try_send(question).is_err() {
            tracing::error!("a question to a machine found no place; please report this");
        }
    }
}

/// Sends queued requests and cancels unanswered ones until the [`Asker`] is dropped.
fn ask_all(session: &Session, intake: &Arc<Intake>, questions: &Receiver<Question>) {
    let mut under_way: Vec<UnderWay> = Vec::new();
    loop {
        match questions.recv_timeout(LOOK) {
            Ok(question) => under_way.extend(ask(session, intake, &question)),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        under_way.retain(|question| Arc::strong_count(&question.heard) > 1);
        for silent in under_way.iter().filter(|q| q.is_silent()) {
            let _ = silent.end.cancel().wait();
        }
    }
}

/// A request as its sending thread sees it.
struct UnderWay {
    /// Time of the last reply; the callback holds the second reference until the request has ended.
    heard: Arc<Mutex<Instant>>,
    patience: Duration,
    end: CancellationToken,
}

impl UnderWay {
    fn is_silent(&self) -> bool {
        let heard = lock(&self.heard);
        heard.elapsed() > self.patience
    }
}

fn ask(session: &Session, intake: &Arc<Intake>, question: &Question) -> Option<UnderWay> {
    let Question {
        run, after, upto, ..
    } = question;
    let key = question.id.key(&question.name);
    let selector = format!("{key}?run={run};after={after};upto={upto}");
    let heard = Arc::new(Mutex::new(Instant::now()));
    let end = CancellationToken::default();
    let open = Open {
        stream: question.stream,
        intake: Arc::clone(intake),
        answer: Mutex::new(Answer::None),
        heard: Arc::clone(&heard),
    };
    let asked = session
        .get(selector)
        .timeout(LIMIT)
        .consolidation(ConsolidationMode::None)
        .cancellation_token(end.clone())
        .callback(move |reply| open.take(&reply))
        .wait();
    if let Err(error) = asked {
        tracing::warn!("cannot ask a machine: {error}");
        return None;
    }
    Some(UnderWay {
        heard,
        patience: question.patience,
        end,
    })
}

/// A request as its callback sees it; dropped with the callback when it has ended.
struct Open {
    stream: i64,
    intake: Arc<Intake>,
    answer: Mutex<Answer>,
    heard: Arc<Mutex<Instant>>,
}

impl Open {
    fn take(&self, reply: &zenoh::query::Reply) {
        *lock(&self.heard) = Instant::now();
        let said = match reply.result() {
            Ok(sample) if sample.attachment().is_some_and(|a| a.to_bytes() == END) => {
                let served = serde_json::from_slice::<AnswerSummary>(&sample.payload().to_bytes());
                served.map_or(Answer::None, Answer::Whole)
            }
            Ok(sample) => return self.intake.answer(sample),
            Err(error) if error.payload().to_bytes().starts_with(OVER.as_bytes()) => Answer::Over,
            Err(_) => Answer::None,
        };
        *lock(&self.answer) = said;
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        let answer = *lock(&self.answer);
        self.intake.say(Event::Answered(self.stream, answer));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wait after which an event counts as missing.
    const LONGEST: Duration = Duration::from_secs(60);

    #[test]
    fn a_question_that_zenoh_refuses_ends_and_holds_up_nobody_though_the_queue_is_full() {
        let session = crate::link::router(Some("tcp/127.0.0.1:0"), None).unwrap();
        let (events, waiting) = sync_channel(1);
        let intake = Arc::new(Intake::new(events));
        intake.say(Event::Answered(1, Answer::None));
        session.close().wait().unwrap();
        let mut asker = Asker::new(session, intake);
        let (done, is_done) = sync_channel(1);
        std::thread::spawn(move || {
            for stream in 2..5 {
                asker.ask(Question {
                    stream,
                    id: MachineId::new("north", "ex-1").unwrap(),
                    name: "estimate/inertia_ukf".into(),
                    run: 1,
                    after: 0,
                    upto: 1,
                    patience: LIMIT,
                });
            }
            done.send(asker).unwrap();
        });
        let asker = is_done.recv_timeout(LONGEST);
        assert!(asker.is_ok(), "the thread that asks is not held up");
        for wanted in 1..5 {
            let event = waiting.recv_timeout(LONGEST);
            assert!(matches!(event, Ok(Event::Answered(stream, Answer::None)) if stream == wanted));
        }
    }
}

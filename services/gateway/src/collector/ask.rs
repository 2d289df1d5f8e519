//! Questions to machines for what did not arrive.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use zenoh::query::ConsolidationMode;
use zenoh::{Session, Wait};

use super::intake::{Answer, Event, Intake};
use crate::key::MachineId;
use crate::machine::{END, Served};

/// Questions at a time.
const AT_A_TIME: usize = 8;
/// A machine must have answered by then.
const LIMIT: Duration = Duration::from_secs(60);

/// A question: what there is between two numbers of a stream.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    /// Number of the stream in the store.
    pub stream: i64,
    /// Whose.
    pub id: MachineId,
    /// `KIND/NAME`.
    pub name: String,
    /// Which run.
    pub run: i64,
    /// Everything up to this number is here.
    pub after: i64,
    /// This much there is at least.
    pub upto: i64,
}

/// Asks.
pub struct Asker {
    session: Session,
    intake: Arc<Intake>,
    under_way: usize,
}

impl Asker {
    pub(super) fn new(session: Session, intake: Arc<Intake>) -> Self {
        Self {
            session,
            intake,
            under_way: 0,
        }
    }

    /// Questions that may be asked now.
    pub(super) fn room(&self) -> usize {
        AT_A_TIME.saturating_sub(self.under_way)
    }

    /// Notes the end of a question.
    pub(super) fn answered(&mut self) {
        self.under_way = self.under_way.saturating_sub(1);
    }

    /// Asks. The end is told as [`Event::Answered`], whatever it is.
    pub(super) fn ask(&mut self, question: Question) {
        self.under_way += 1;
        let Question {
            run, after, upto, ..
        } = question;
        let selector = format!(
            "{}?run={run};after={after};upto={upto}",
            question.id.key(&question.name)
        );
        let open = Open {
            stream: question.stream,
            intake: Arc::clone(&self.intake),
            answer: Mutex::new(Answer::None),
        };
        let asked = self
            .session
            .get(selector)
            .timeout(LIMIT)
            .consolidation(ConsolidationMode::None)
            .callback(move |reply| open.take(&reply))
            .wait();
        if let Err(error) = asked {
            tracing::warn!("cannot ask a machine: {error}");
        }
    }
}

/// A question under way; dropped with the callback when it has ended.
struct Open {
    stream: i64,
    intake: Arc<Intake>,
    answer: Mutex<Answer>,
}

impl Open {
    fn take(&self, reply: &zenoh::query::Reply) {
        let said = match reply.result() {
            Ok(sample) if sample.attachment().is_some_and(|a| a.to_bytes() == END) => {
                let served = serde_json::from_slice::<Served>(&sample.payload().to_bytes());
                served.map_or(Answer::None, Answer::Whole)
            }
            Ok(sample) => return self.intake.answer(sample),
            Err(error)
                if error
                    .payload()
                    .to_bytes()
                    .starts_with(b"that was another run") =>
            {
                Answer::Over
            }
            Err(_) => Answer::None,
        };
        *self.answer.lock().unwrap_or_else(PoisonError::into_inner) = said;
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        let answer = *self.answer.lock().unwrap_or_else(PoisonError::into_inner);
        self.intake.say(Event::Answered(self.stream, answer));
    }
}

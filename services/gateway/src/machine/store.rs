//! Store and forward: what did not arrive is selected again from the machine's own recording.
//!
//! What a question says: [`crate::question`]. The recording is bounded by `heft run --keep`; what it has dropped is
//! counted here, and by the collector.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, sync_channel};

use messages::Message;
use messages::channels::{Channel, Visitor};
use recording::Reader;
use zenoh::query::Query;
use zenoh::{Session, Wait};

use super::{Shared, full};
use crate::downsample::Selection;
use crate::label::{lost, lost_behind};
use crate::question::{AnswerSummary, Asked, MOST, OVER, WAITING, end};
use crate::schema;

/// Answers all questions to the machine until what is returned is dropped. They share a queryable: a router compares what is
/// declared with every key that it knows.
pub(super) fn declare(
    session: &Session,
    shared: &Arc<Shared>,
) -> zenoh::Result<impl Sized + use<>> {
    let (questions, waiting) = sync_channel(WAITING);
    let its = Arc::clone(shared);
    std::thread::spawn(move || serve(&its, &waiting));
    let key = shared.id.key("*/*");
    let schemas = schema::answers(key.trim_end_matches("/*/*"));
    let full = full::control(shared)?;
    let callback = move |query| {
        schemas(&query);
        full(&query);
        // Beyond the bound the question ends without an answer, and is asked again.
        let _ = questions.try_send(query);
    };
    session.declare_queryable(key).callback(callback).wait()
}

fn serve(shared: &Shared, questions: &Receiver<Query>) {
    // Off the path in its use of the processor too.
    let _ = rustix::process::nice(10);
    for query in questions {
        let key = query.key_expr().as_str().to_owned();
        let Some((_, what)) = crate::key::MachineId::of(&key) else {
            continue;
        };
        if let Some(stream) = shared.streams.iter().position(|s| s.name == what) {
            answer(shared, &query, stream);
        }
    }
}

fn answer(shared: &Shared, query: &Query, stream: usize) {
    let key = query.key_expr().clone();
    let Some(Asked { run, after, upto }) = Asked::of(query) else {
        return;
    };
    if run != shared.plan.run as i64 {
        let _ = query.reply_err(OVER).wait();
        return;
    }
    let Ok(reader) = Reader::open(&shared.plan.recording) else {
        let _ = query.reply_err("the recording cannot be read").wait();
        return;
    };
    let reading = StoredReader {
        shared,
        stream,
        after,
        upto,
        reader: &reader,
        channel: shared.streams[stream].channel,
        send: &mut |selected: Selection| {
            let reply = query.reply(key.clone(), selected.payload);
            reply.attachment(selected.label.to_string()).wait().is_ok()
        },
    };
    let served = shared.streams[stream].channel.payload.visit(reading);
    shared.served.fetch_add(served.messages, Ordering::Relaxed);
    // What another collector asks for again, or the same one after an answer that did not arrive, is lost once.
    if shared.counted[stream].fetch_max(served.upto, Ordering::Relaxed) <= after {
        shared.lost.fetch_add(served.lost, Ordering::Relaxed);
    }
    end(query, &served);
}

/// Selects from the recording what a question asks for.
struct StoredReader<'a> {
    shared: &'a Shared,
    stream: usize,
    after: i64,
    upto: i64,
    reader: &'a Reader,
    channel: &'static Channel,
    send: &'a mut dyn FnMut(Selection) -> bool,
}

impl Visitor for StoredReader<'_> {
    type Output = AnswerSummary;

    fn visit<M: Message>(self) -> AnswerSummary {
        let mut served = AnswerSummary {
            upto: self.after,
            ..AnswerSummary::default()
        };
        let Ok(messages) = self.reader.stream::<M>(self.channel.name) else {
            return served;
        };
        let per_period = self.shared.streams[self.stream].per_period;
        let mut downsampler = self.shared.downsampler();
        let mut last = self.after;
        let mut is_full = false;
        for message in messages {
            downsampler.take(self.channel, &message, &mut |selected| {
                let number = selected.label.number as i64;
                if selected.stream != self.stream
                    || number <= self.after
                    || number > self.upto
                    || is_full
                {
                    return;
                }
                let missing = lost(last, &selected.label, per_period);
                is_full = served.messages == MOST || !(self.send)(selected);
                if !is_full {
                    served.messages += 1;
                    served.lost += missing;
                    last = number;
                }
            });
            if is_full {
                break;
            }
        }
        // Behind the last message of a live recording more may be on its way to the disk.
        let is_whole = !is_full
            && (downsampler.seen(self.stream) >= self.upto
                || self.shared.ended.load(Ordering::Relaxed));
        served.upto = last;
        if is_whole && self.upto > last {
            served.lost += lost_behind(last, self.upto, per_period);
            served.upto = self.upto;
        }
        served
    }
}

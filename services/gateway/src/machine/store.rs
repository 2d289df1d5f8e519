//! Store and forward: messages that did not arrive are selected again from the machine's own recording.
//!
//! Form of a request: [`crate::question`]. `heft run --keep` bounds the recording; messages that it has dropped are counted here,
//! and by the collector.
//!
//! A request is not answered from the recording's beginning each time: see [`Ends`].

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::os::fd::AsRawFd;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, sync_channel};

use messages::Message;
use messages::channels::Visitor;
use recording::Reader;
use zenoh::query::Query;
use zenoh::{Session, Wait};

use super::{Shared, full};
use crate::downsample::{Downsampler, Selection};
use crate::label::{lost, lost_behind};
use crate::question::{AnswerSummary, Asked, MOST, OVER, WAITING, end};
use crate::schema;

/// Answers all requests to the machine until the returned value is dropped. They share a queryable: a router compares each
/// declaration with every key that it knows.
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
        // A request beyond the bound ends without an answer, and is repeated.
        let _ = questions.try_send(query);
    };
    session.declare_queryable(key).callback(callback).wait()
}

fn serve(shared: &Shared, questions: &Receiver<Query>) {
    // Low priority, so that it does not delay the estimators.
    let _ = rustix::process::nice(10);
    let mut ends = Ends::default();
    for query in questions {
        let key = query.key_expr().as_str().to_owned();
        let Some((_, what)) = crate::key::MachineId::of(&key) else {
            continue;
        };
        if let Some(stream) = shared.streams.iter().position(|s| s.name == what) {
            answer(shared, &query, stream, &mut ends);
        }
    }
}

fn answer(shared: &Shared, query: &Query, stream: usize, ends: &mut Ends) {
    let key = query.key_expr().clone();
    let Some(asked) = Asked::of(query) else {
        return;
    };
    if asked.run != shared.plan.run as i64 {
        let _ = query.reply_err(OVER).wait();
        return;
    }
    let reading = StoredReader {
        shared,
        stream,
        asked,
        ends,
        send: &mut |selected: Selection| {
            let reply = query.reply(key.clone(), selected.payload);
            reply.attachment(selected.label.to_string()).wait().is_ok()
        },
    };
    let Some(served) = shared.streams[stream].channel.payload.visit(reading) else {
        let _ = query.reply_err("the recording cannot be read").wait();
        return;
    };
    shared.served.fetch_add(served.messages, Ordering::Relaxed);
    // A loss counts once, also if another collector requests it again, or the same one after a lost answer.
    if shared.counted[stream].fetch_max(served.upto, Ordering::Relaxed) <= asked.after {
        shared.lost.fetch_add(served.lost, Ordering::Relaxed);
    }
    end(query, &served);
}

/// State of the selection at the end of finished parts, by channel and number of the part. An answer resumes from the last state
/// before the requested messages. So its cost is in proportion to the age of the gap, not to the length of the run.
#[derive(Default)]
struct Ends(HashMap<&'static str, BTreeMap<u32, Downsampler>>);

impl Ends {
    /// The first part to read for messages after number `after` of a stream, and the state to resume from.
    fn before(&self, channel: &str, stream: usize, after: i64) -> Option<(u32, &Downsampler)> {
        let mut its = self.0.get(channel)?.iter().rev();
        let (part, state) = its.find(|(_, state)| state.seen(stream) <= after)?;
        Some((part + 1, state))
    }

    /// Stores the state at the end of a part; old states are thinned out to two for each doubling of the distance.
    fn keep(&mut self, channel: &'static str, part: u32, state: &Downsampler) {
        let its = self.0.entry(channel).or_default();
        its.insert(part, state.clone());
        let newest = its.last_key_value().map_or(part, |(newest, _)| *newest);
        its.retain(|part, _| {
            let distance = (newest - *part).max(1);
            part.is_multiple_of(1 << distance.ilog2().saturating_sub(1))
        });
    }
}

/// The files of a recording in order of their numbers. Dropped files are absent.
fn parts(recording: &Path) -> Vec<(u32, PathBuf)> {
    let folder = recording.parent().unwrap_or(Path::new("."));
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let files = files.map(|entry| entry.path());
    let mut parts: Vec<(u32, PathBuf)> = files
        .filter(|file| recording::is_part_of(recording, file))
        .map(|file| (recording::part_number(&file), file))
        .collect();
    parts.sort_unstable();
    parts
}

/// Opens one part, by its descriptor: the path of the first part stands for the whole recording.
fn open(part: &Path) -> Option<Reader> {
    let file = File::open(part).ok()?;
    Reader::open(format!("/proc/self/fd/{}", file.as_raw_fd())).ok()
}

/// Selects the requested messages from the recording; `None` if it cannot be read.
struct StoredReader<'a> {
    shared: &'a Shared,
    stream: usize,
    asked: Asked,
    ends: &'a mut Ends,
    send: &'a mut dyn FnMut(Selection) -> bool,
}

impl Visitor for StoredReader<'_> {
    type Output = Option<AnswerSummary>;

    fn visit<M: Message>(self) -> Option<AnswerSummary> {
        let Asked { after, upto, .. } = self.asked;
        let (channel, per_period) = {
            let stream = &self.shared.streams[self.stream];
            (stream.channel, stream.per_period)
        };
        let known = self.ends.before(channel.name, self.stream, after);
        let (first, mut downsampler) = known.map_or_else(
            || (0, self.shared.downsampler()),
            |(part, state)| (part, state.clone()),
        );
        let mut served = AnswerSummary {
            upto: after,
            ..AnswerSummary::default()
        };
        let (mut last, mut is_full, mut is_found, mut is_read) = (after, false, false, false);
        let parts = parts(&self.shared.plan.recording);
        for (i, (part, file)) in parts.iter().enumerate().filter(|(_, p)| p.0 >= first) {
            // Checked before it is opened: an open file may grow meanwhile.
            let is_finished = i + 1 < parts.len() && !recording::is_being_written(file);
            let Some(reader) = open(file) else { continue };
            is_read = true;
            let Ok(messages) = reader.stream::<M>(channel.name) else {
                continue;
            };
            for message in messages {
                downsampler.take(channel, &message, &mut |selected| {
                    let number = selected.label.number as i64;
                    if selected.stream != self.stream || number <= after || is_full || is_found {
                        return;
                    }
                    is_found = number >= upto;
                    if number > upto {
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
                if is_full || is_found {
                    break;
                }
            }
            if is_full || is_found {
                break;
            }
            if is_finished {
                self.ends.keep(channel.name, *part, &downsampler);
            }
        }
        // After the last message of a live recording, more may be on its way to the disk.
        let is_whole = !is_full
            && (downsampler.seen(self.stream) >= upto || self.shared.over.load(Ordering::Relaxed));
        served.upto = last;
        if is_whole && upto > last {
            served.lost += lost_behind(last, upto, per_period);
            served.upto = upto;
        }
        (is_read || first > 0).then_some(served)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use messages::channels::EXCAVATOR_INERTIA_UKF as CHANNEL;
    use messages::{ExcavatorEstimate, Machine};
    use recording::{Metadata, Writer};
    use steps::stages::Pipeline;

    use super::*;
    use crate::key::MachineId;
    use crate::machine::Plan;

    const STREAM: &str = "estimate/inertia_ukf";
    /// Samples of a part, ten a second.
    const PART: u64 = 1000;
    const PARTS: u32 = 6;

    fn shared(folder: &Path) -> Shared {
        let plan = Plan {
            machine: "excavator".into(),
            rate: 10.0,
            recording: folder.join("run.mcap"),
            run: 7,
            run_count: 0,
            version: String::new(),
        };
        let streams = crate::downsample::streams(Pipeline::of(Machine::Excavator), 10.0, 1.0);
        let id = MachineId::new("north", "ex-1").expect("names");
        Shared::new(id, plan, 1.0, streams)
    }

    fn record(shared: &Shared) {
        for part in 0..PARTS {
            let file = recording::part(&shared.plan.recording, part + 1);
            let mut writer = Writer::create(file, &Metadata::new()).expect("a part");
            for i in (0..PART).map(|i| u64::from(part) * PART + i) {
                let mut estimate = ExcavatorEstimate::default();
                (estimate.stamp.sequence, estimate.stamp.time) = (i, i as f64 * 0.1);
                writer.write(&CHANNEL, &estimate).expect("room");
            }
            writer.finish().expect("room");
        }
    }

    /// Numbers of each message, and of the one before it.
    type Found = Vec<(u64, Option<i64>)>;

    fn ask(
        shared: &Shared,
        ends: &mut Ends,
        after: i64,
        upto: i64,
    ) -> Option<(AnswerSummary, Found)> {
        let found = RefCell::new(Vec::new());
        let stream = shared.streams.iter().position(|s| s.name == STREAM);
        let reading = StoredReader {
            shared,
            stream: stream.expect("it"),
            asked: Asked {
                run: 7,
                after,
                upto,
            },
            ends,
            send: &mut |selected| {
                let place = (selected.label.number, selected.label.after);
                found.borrow_mut().push(place);
                true
            },
        };
        let served = CHANNEL.payload.visit(reading)?;
        Some((served, found.into_inner()))
    }

    #[test]
    fn an_answer_goes_on_where_an_earlier_one_was_and_reads_nothing_before_nor_behind() {
        let folder = tempfile::tempdir().expect("a folder");
        let shared = shared(folder.path());
        record(&shared);
        let mut ends = Ends::default();
        // The requested messages end in the second part: the third is not read.
        let (served, found) = ask(&shared, &mut ends, -1, 1490).expect("a recording");
        assert_eq!((served.upto, served.messages, served.lost), (1490, 150, 0));
        assert_eq!(found[..2], [(0, Some(-1)), (10, Some(0))]);
        let of_it = |ends: &Ends| ends.0[CHANNEL.name].keys().copied().collect::<Vec<_>>();
        assert_eq!(of_it(&ends), [1], "the third part was not read");
        let (_, whole) = ask(&shared, &mut ends, 1490, 5990).expect("a recording");
        assert_eq!(whole.len(), 450);
        // Parts before that of the gap are not read again: here they are deleted.
        for part in 1..=4 {
            std::fs::remove_file(recording::part(&shared.plan.recording, part)).expect("it");
        }
        let (served, found) = ask(&shared, &mut ends, 4990, 5990).expect("a recording");
        assert_eq!((served.upto, served.lost), (5990, 0));
        assert_eq!(found, whole[350..], "with what was before each");
        std::fs::remove_file(recording::part(&shared.plan.recording, 6)).expect("it");
        std::fs::remove_file(recording::part(&shared.plan.recording, 5)).expect("it");
        assert_eq!(ask(&shared, &mut Ends::default(), -1, 10), None);
    }

    #[test]
    fn some_ends_of_a_long_run_are_stored_and_more_of_the_latest() {
        let folder = tempfile::tempdir().expect("a folder");
        let shared = shared(folder.path());
        let mut ends = Ends::default();
        let state = shared.downsampler();
        for newest in 1..=1000_u32 {
            ends.keep(CHANNEL.name, newest, &state);
            // The channels are independent.
            ends.keep("another", newest + 7, &state);
            let parts: Vec<u32> = ends.0[CHANNEL.name].keys().copied().collect();
            assert!(parts.len() <= 3 * newest.ilog2() as usize + 3, "{parts:?}");
            for gap in 1..newest {
                let from = parts.iter().rfind(|part| **part <= gap).copied();
                let read = newest - from.unwrap_or(0);
                assert!(read <= 2 * (newest - gap) + 1, "{gap} of {newest}: {read}");
            }
        }
    }
}

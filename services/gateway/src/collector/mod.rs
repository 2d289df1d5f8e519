//! The collector: receives the messages of all machines, stores them, requests the missing ones, and shows the result.
//!
//! Zenoh's threads check and queue messages; one thread writes them to SQLite and decides what to request; another serves the
//! page from the same file. Two collectors are independent of each other.
//!
//! Only the streams that Zenoh numbers have an advanced subscriber. For messages without numbers, an advanced subscriber orders
//! by the router's time stamps: it silently drops a message with an earlier stamp that arrives later, whatever its sender. Of
//! 7200 messages that crossed at a router, it lost 3 to 9 (`tests/crossing.rs`).

mod alarm;
mod alarm_state;
mod ask;
pub mod full;
mod intake;
mod live;
mod machine_page;
mod page;
mod parameters;
pub mod query;
mod shown;
mod store;
mod strangers;
mod table;

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use zenoh::Wait;
use zenoh::sample::SampleKind;
use zenoh_ext::{AdvancedSubscriberBuilderExt, RecoveryConfig};

pub use alarm::AlarmArgs;
pub(crate) use intake::decode;

use crate::key::MachineId;
use crate::key::{ESTIMATES, STATUS, STREAMS, TOKENS};
use crate::link::LinkArgs;
use crate::{Failure, lock};
use ask::Question;
use intake::{Event, Intake};
use live::Fleet;
use store::{IsHere, Store, StoreOutcome};

/// Events that may wait for the disk.
const QUEUE: usize = 65_536;
/// Longest time that a message waits for its transaction.
const COMMIT: Duration = Duration::from_millis(200);
/// Messages of one transaction.
const BATCH: usize = 20_000;

/// Period of the attempts to write again after a failure of the disk.
const TRY: Duration = Duration::from_secs(2);
/// Least time between two log lines on machines for which there was no room.
const ROOM: Duration = Duration::from_secs(60);

/// Reason for refusing a run.
const RUNS: &str = "begins runs too fast";

/// Default address of the page: this host only.
pub const PAGE: &str = "127.0.0.1:8450";

/// What a collector is given.
#[derive(Debug, Clone, clap::Args)]
pub struct CollectorArgs {
    /// The router
    #[command(flatten)]
    pub link: LinkArgs,
    /// The history (SQLite)
    #[arg(long, default_value = "fleet.sqlite", value_name = "FILE")]
    pub db: PathBuf,
    /// Where the page is shown: an address of this host; a port alone will do
    #[arg(long, default_value = PAGE, value_name = "ADDR", value_parser = page_address)]
    pub page: SocketAddr,
    /// Days of history that are stored; or a time such as 12h
    #[arg(long, default_value_t = 90.0, value_name = "DAYS", value_parser = days)]
    pub keep: f64,
    /// What is an alarm
    #[command(flatten)]
    pub alarms: AlarmArgs,
}

/// Address of the page.
fn page_address(text: &str) -> Result<SocketAddr, String> {
    view::live::address(text, PAGE)
}

/// Parses a duration [days]; a bare number is in days.
fn days(text: &str) -> Result<f64, String> {
    counted(text, 86_400.0)
}

/// Parses a duration in multiples of `unit` [s], the unit of a bare number; at most a million, which means for ever.
fn counted(text: &str, unit: f64) -> Result<f64, String> {
    let count = view::duration::of(text, Some(unit))? / unit;
    (count <= 1e6)
        .then_some(count)
        .ok_or_else(|| "at most 1000000".into())
}

/// Collects until `stop` is set.
///
/// # Errors
/// The history, the page's address or the router's name cannot be used.
pub fn run(args: &CollectorArgs, stop: &AtomicBool) -> Result<(), Failure> {
    if !args.page.ip().is_loopback() {
        return Err(crate::error(
            format!("{} is no address of this host alone", args.page),
            "--page",
            "give a port alone; for others put a web server with accounts and TLS before it",
        )
        .into());
    }
    // Another start may succeed: a full disk may have room by then.
    let unreadable = |e| Failure::passing(store::failed(&e, &args.db));
    let store = Store::open(&args.db).map_err(unreadable)?;
    let fleet = store.fleet().map_err(unreadable)?;
    let fleet = Arc::new(Mutex::new(fleet));
    let server = page::serve(args.page, Arc::clone(&fleet), args.db.clone())?;
    eprintln!("fleet: http://{}", server.address());
    let stops = || stop.load(Ordering::Relaxed);
    let Some(session) = crate::link::client_unless(&args.link, &[], stops)? else {
        return Ok(());
    };
    let (events, waiting) = sync_channel(QUEUE);
    let intake = Arc::new(Intake::new(events));
    let failed = |e: zenoh::Error| {
        crate::error(
            format!("Zenoh refuses: {e}"),
            &args.link.connect,
            "please report this",
        )
    };
    let its = Arc::clone(&intake);
    let _estimates = session
        .declare_subscriber(ESTIMATES)
        .callback(move |sample| its.message(&sample))
        .recovery(RecoveryConfig::default().heartbeat())
        .wait()
        .map_err(failed)?;
    let its = Arc::clone(&intake);
    let _streams = session
        .declare_subscriber(STREAMS)
        .callback(move |sample| its.message_without_number(&sample))
        .wait()
        .map_err(failed)?;
    let its = Arc::clone(&intake);
    let _status = session
        .declare_subscriber(STATUS)
        .callback(move |sample| its.status(&sample))
        .wait()
        .map_err(failed)?;
    let its = Arc::clone(&intake);
    let _tokens = session
        .liveliness()
        .declare_subscriber(TOKENS)
        .history(true)
        .callback(move |sample| its.token(&sample, sample.kind() == SampleKind::Put))
        .wait()
        .map_err(failed)?;
    let _schemas = crate::schema::serve(&session, crate::key::ROOT).map_err(failed)?;
    let asker = ask::Asker::new(session.clone(), Arc::clone(&intake));
    let mut collector = Collector {
        store,
        fleet: &fleet,
        intake,
        asker,
        args,
        refused: BTreeMap::new(),
        said: (0, Instant::now() - ROOM),
    };
    let result = collector.work(&waiting, stop);
    // The receiver is gone before the session closes, so that Zenoh's threads cannot block on a full queue.
    drop(waiting);
    let _ = session.close().wait();
    result.map_err(Failure::passing)
}

struct Collector<'a> {
    store: Store,
    fleet: &'a Mutex<Fleet>,
    intake: Arc<Intake>,
    asker: ask::Asker,
    args: &'a CollectorArgs,
    /// Refused messages that are not written yet.
    refused: BTreeMap<(MachineId, &'static str), u64>,
    /// Number of messages without room at the last log line, and its time.
    said: (u64, Instant),
}

impl Collector<'_> {
    fn work(&mut self, events: &Receiver<Event>, stop: &AtomicBool) -> Result<(), String> {
        lock(self.fleet).begun = Some(Instant::now());
        let mut looked = Instant::now();
        let mut cleaned = Instant::now();
        while !stop.load(Ordering::Relaxed) {
            let first = match events.recv_timeout(COMMIT) {
                Ok(event) => Some(event),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            };
            let mut done = Ok(());
            if let Some(first) = first {
                // Collects more events for the same transaction: its cost does not depend on their number.
                std::thread::sleep(COMMIT / 4);
                done = self.take(std::iter::once(first).chain(events.try_iter()).take(BATCH));
            }
            if done.is_ok() && looked.elapsed() >= Duration::from_secs(1) {
                looked = Instant::now();
                done = self.look();
            }
            if done.is_ok() && cleaned.elapsed() >= Duration::from_secs(3600) {
                cleaned = Instant::now();
                done = self.store.forget(self.args.keep);
            }
            if let Err(why) = done {
                self.wait_for_the_disk(store::failed(&why, &self.args.db), events, stop);
            }
        }
        Ok(())
    }

    /// Continues the display while the disk cannot be written. Messages are not stored meanwhile. Afterwards the history is read
    /// again from the file, and what is missing is requested as after a lost connection.
    fn wait_for_the_disk(&mut self, why: String, events: &Receiver<Event>, stop: &AtomicBool) {
        tracing::error!("nothing is kept until the disk takes it again: {why}");
        self.store.roll_back();
        lock(self.fleet).unkept = Some((why, Instant::now()));
        let mut tried = Instant::now();
        while !stop.load(Ordering::Relaxed) {
            for event in events
                .recv_timeout(COMMIT)
                .into_iter()
                .chain(events.try_iter())
            {
                let mut fleet = lock(self.fleet);
                match event {
                    Event::Status(id, status) => {
                        let run = fleet.machines.get(&id).map_or(0, |m| m.run);
                        fleet.status(&id, *status, run);
                    }
                    Event::Token(id, is_there) => fleet.token(&id, is_there),
                    Event::Answered(..) => self.asker.answered(),
                    Event::Message(_) | Event::Refused(..) => {}
                }
            }
            if tried.elapsed() < TRY {
                continue;
            }
            tried = Instant::now();
            let again = Store::open(&self.args.db).and_then(|s| s.probe().map(|()| s));
            if let Ok(store) = again {
                self.store = store;
                lock(self.fleet).unkept = None;
                tracing::warn!("the disk takes the history again; what is missing is asked for");
                return;
            }
        }
    }

    fn take(&mut self, events: impl Iterator<Item = Event>) -> rusqlite::Result<()> {
        self.store.begin()?;
        let mut fleet = lock(self.fleet);
        let mut refused = |fleet: &mut Fleet, id: MachineId, why| {
            fleet.refused(&id, why, 1);
            *self.refused.entry((id, why)).or_default() += 1;
        };
        let mut has_answer = false;
        for event in events {
            match event {
                Event::Message(message) => match self.store.insert(&message)? {
                    StoreOutcome::New(run) => fleet.message(&message, run),
                    StoreOutcome::Known => {}
                    StoreOutcome::Refused => refused(&mut fleet, message.id, RUNS),
                },
                Event::Status(id, status) => match self.store.status(&id, &status)? {
                    Some(run) => fleet.status(&id, *status, run),
                    None => refused(&mut fleet, id, RUNS),
                },
                Event::Token(id, is_there) => fleet.token(&id, is_there),
                Event::Refused(id, why) => refused(&mut fleet, id, why),
                Event::Answered(stream, answer) => {
                    has_answer = true;
                    self.asker.answered();
                    self.store.answered(stream, answer)?;
                }
            }
        }
        drop(fleet);
        self.store.commit()?;
        if has_answer {
            self.ask(Store::next_questions);
        }
        Ok(())
    }

    /// Once a second: alarms, accounts, requests.
    fn look(&mut self) -> rusqlite::Result<()> {
        let mut fleet = lock(self.fleet);
        let raised = alarm::look(&mut fleet, &self.args.alarms);
        fleet.turned_away = self.intake.turned_away();
        self.refused
            .retain(|(id, _), _| fleet.machines.contains_key(id));
        for (id, state) in self.store.account() {
            fleet.account(&id, state);
        }
        drop(fleet);
        for line in alarm::lines(&raised) {
            tracing::warn!("{line}");
        }
        self.store.begin()?;
        for alarm in raised {
            self.store.alarm(&alarm)?;
        }
        for ((id, why), messages) in std::mem::take(&mut self.refused) {
            self.store.refused(&id, why, messages)?;
        }
        self.store.commit()?;
        let turned_away = self.intake.turned_away();
        if turned_away > self.said.0 && self.said.1.elapsed() >= ROOM {
            self.said = (turned_away, Instant::now());
            tracing::warn!(
                "{turned_away} messages of machines beyond {} were not taken",
                crate::MACHINES
            );
        }
        self.ask(Store::questions);
        self.store.settle()
    }

    /// Sends requests from `of`, as many as may be under way.
    fn ask(&mut self, of: impl FnOnce(&mut Store, &IsHere<'_>, usize) -> Vec<Question>) {
        let room = self.asker.room();
        let fleet = lock(self.fleet);
        let is_here = |id: &MachineId| fleet.machines.get(id).is_some_and(live::Machine::is_here);
        let questions = of(&mut self.store, &is_here, room);
        drop(fleet);
        for question in questions {
            self.asker.ask(question);
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::CollectorArgs;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        args: CollectorArgs,
    }

    #[test]
    fn what_is_no_time_deletes_nothing_and_ends_nothing() {
        let parse = |option: &str| {
            let words = ["heft fleet", "--connect", "tcp/127.0.0.1:7447", option];
            Cli::try_parse_from(words).map(|cli| cli.args)
        };
        for time in ["nan", "-1", "inf", "x", "1e7"] {
            for option in ["--keep", "--untrusted-after"] {
                assert!(
                    parse(&format!("{option}={time}")).is_err(),
                    "{option} {time}"
                );
            }
        }
        assert!(parse("--keep=7.5").is_ok_and(|args| args.keep == 7.5));
    }
}

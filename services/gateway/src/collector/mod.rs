//! The collector: takes what all machines send, keeps it, asks for what is missing, and shows it.
//!
//! Zenoh's threads check what comes and queue it; one thread writes it to SQLite and decides what to ask for;
//! another serves the page from the same file. Two collectors do not know of each other.

mod alarm;
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
mod table;

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use zenoh::Wait;
use zenoh::sample::SampleKind;
use zenoh_ext::{AdvancedSubscriberBuilderExt, RecoveryConfig};

pub use alarm::AlarmArgs;
pub(crate) use intake::decode;

use crate::key::{STATUS, STREAMS, TOKENS};
use crate::link::LinkArgs;
use intake::{Event, Intake};
use live::Fleet;
use store::Store;

/// Events that may wait for the disk.
const QUEUE: usize = 65_536;
/// Longest time that a message waits for its transaction.
const COMMIT: Duration = Duration::from_millis(200);
/// Messages of one transaction.
const BATCH: usize = 20_000;

/// Where the page is unless told otherwise: this host only.
pub const PAGE: &str = "127.0.0.1:8450";

/// What a collector is told.
#[derive(Debug, Clone, clap::Args)]
pub struct CollectorArgs {
    /// The router
    #[command(flatten)]
    pub link: LinkArgs,
    /// The history (SQLite)
    #[arg(long, default_value = "fleet.sqlite", value_name = "FILE")]
    pub db: PathBuf,
    /// Where the page is shown: an address of this host
    #[arg(long, default_value = PAGE, value_name = "ADDR")]
    pub page: SocketAddr,
    /// Days of history that are kept
    #[arg(long, default_value_t = 90.0, value_name = "DAYS")]
    pub keep: f64,
    /// What is an alarm
    #[command(flatten)]
    pub alarms: AlarmArgs,
}

/// Collects until `stop` is set.
///
/// # Errors
/// The history, the page's address or the router's name cannot be used.
pub fn run(args: &CollectorArgs, stop: &AtomicBool) -> Result<(), String> {
    if !args.page.ip().is_loopback() {
        return Err(crate::error(
            format!("{} is no address of this host alone", args.page),
            "--page",
            "give 127.0.0.1:PORT; for others put a web server with accounts and TLS before it",
        ));
    }
    let mut store = Store::open(&args.db)?;
    let fleet = Arc::new(Mutex::new(store.fleet()?));
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
    let _streams = session
        .declare_subscriber(STREAMS)
        .callback(move |sample| its.message(&sample))
        .recovery(RecoveryConfig::default().heartbeat())
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
        store: &mut store,
        fleet: &fleet,
        asker,
        args,
    };
    let result = collector.work(&waiting, stop);
    let _ = session.close().wait();
    result
}

struct Collector<'a> {
    store: &'a mut Store,
    fleet: &'a Mutex<Fleet>,
    asker: ask::Asker,
    args: &'a CollectorArgs,
}

impl Collector<'_> {
    fn work(&mut self, events: &Receiver<Event>, stop: &AtomicBool) -> Result<(), String> {
        let mut looked = Instant::now();
        let mut cleaned = Instant::now();
        while !stop.load(Ordering::Relaxed) {
            let first = match events.recv_timeout(COMMIT) {
                Ok(event) => Some(event),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            };
            if let Some(first) = first {
                // Leave time for more to come: a transaction costs the disk, not the message.
                std::thread::sleep(COMMIT / 4);
                self.take(std::iter::once(first).chain(events.try_iter()).take(BATCH))?;
            }
            if looked.elapsed() >= Duration::from_secs(1) {
                looked = Instant::now();
                self.look()?;
            }
            if cleaned.elapsed() >= Duration::from_secs(3600) {
                cleaned = Instant::now();
                self.store.forget(self.args.keep)?;
            }
        }
        Ok(())
    }

    fn take(&mut self, events: impl Iterator<Item = Event>) -> Result<(), String> {
        self.store.begin()?;
        let mut fleet = self.fleet.lock().unwrap_or_else(PoisonError::into_inner);
        for event in events {
            match event {
                Event::Message(message) => {
                    if self.store.insert(&message)? {
                        fleet.message(&message);
                    }
                }
                Event::Status(id, status) => {
                    self.store.status(&id, &status)?;
                    fleet.status(&id, *status);
                }
                Event::Token(id, is_there) => fleet.token(&id, is_there),
                Event::Refused(id, why) => fleet.refused(&id, why),
                Event::Answered(stream, answer) => {
                    self.asker.answered();
                    self.store.answered(stream, answer)?;
                }
            }
        }
        drop(fleet);
        self.store.commit()
    }

    /// Once a second: what is missing, what is wrong.
    fn look(&mut self) -> Result<(), String> {
        let mut fleet = self.fleet.lock().unwrap_or_else(PoisonError::into_inner);
        let raised = alarm::look(&mut fleet, &self.args.alarms);
        let here = fleet.here();
        for (id, state) in self.store.account() {
            fleet.account(&id, state);
        }
        drop(fleet);
        for alarm in raised {
            tracing::warn!("{alarm}");
            self.store.alarm(&alarm)?;
        }
        let room = self.asker.room();
        for question in self.store.questions(&here, room) {
            self.asker.ask(question);
        }
        self.store.settle()
    }
}

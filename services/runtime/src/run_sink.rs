//! Drives a [`Sink`]: every channel of a machine, drained before it is half full.

use std::time::Duration;

use messages::Credit;
use messages::channels::{CREDIT, Channel};

use crate::clock::now_ns;
use crate::telemetry::Event;
use crate::{Error, Output, Sink, Taps, Worker};

/// Longest time between two visits in samples: a quarter of the depth of a channel.
const VISIT_SAMPLES: u64 = 128;
/// Time between two visits when a lossless source waits for it.
const QUICK_VISIT: Duration = Duration::from_micros(500);

/// Hands every message on `channels` to `sink`; with `lossless` the source is notified how far it got.
///
/// # Errors
/// A channel cannot be opened.
pub fn run_sink<S: Sink + 'static>(
    mut worker: Worker,
    channels: &[&'static Channel],
    lossless: bool,
    mut sink: S,
) -> Result<(), Error> {
    let mut taps = match worker.setup.identity.restarts {
        0 => Taps::open(&worker.ports, channels)?,
        _ => Taps::open_for(&worker.ports, channels, &sink)?,
    };
    let mut credit = worker.ports.output::<Credit>(&CREDIT)?;
    if worker.begin().is_none() {
        return Ok(());
    }
    let mut reported = 0;
    let pause = if lossless {
        QUICK_VISIT
    } else {
        sink.visit()
            .min(Duration::from_nanos(worker.setup.period_ns * VISIT_SAMPLES))
    };
    while !worker.requests.wants_exit() {
        let draining = worker.requests.take_drain();
        let begun = now_ns();
        worker.reporter.begin();
        let visit = taps.drain(&mut sink);
        if visit.taken > 0 {
            sink.visited();
        }
        sink.look();
        worker.reporter.end();
        let step_ns = (now_ns() - begun) / visit.taken.max(1);
        for i in 0..visit.taken {
            let lost = if i == 0 { visit.lost } else { 0 };
            worker.reporter.sample(Event {
                age_ns: 0,
                step_ns,
                lost,
                late: false,
            });
        }
        worker.reporter.fault(sink.fault());
        if lossless && taps.through() > reported {
            reported = taps.through();
            tell(&worker, &mut credit, reported);
        }
        if draining {
            sink.drain();
            worker.control.say("drained");
        }
        worker.bell.wait_at_most(pause);
    }
    sink.drain();
    Ok(())
}

/// Tells the source how many samples have passed through every channel.
fn tell(worker: &Worker, credit: &mut Output<Credit>, through: u64) {
    let mut message = Credit {
        through,
        ..Credit::default()
    };
    message.stamp.sequence = through;
    credit.send(&message);
    worker.ring();
}

//! Drives a [`Sink`]: every channel of a machine, drained before it is half full.

use std::time::Duration;

use messages::Credit;
use messages::channels::{CREDIT, Channel};

use crate::clock::now_ns;
use crate::telemetry::Event;
use crate::{Error, Output, Sink, Taps, Worker};

/// Longest time between two visits, in samples: a quarter of the depth of a channel.
const VISIT_SAMPLES: u64 = 128;
/// Time between two visits when a lossless source waits for the sink.
const QUICK_VISIT: Duration = Duration::from_micros(500);

/// Passes every message on `channels` to `sink`; with `lossless` it reports its progress to the source. Returns the sink
/// after the run has ended and the sink has taken everything.
///
/// # Errors
/// A channel cannot be opened.
pub fn run_sink<S: Sink + 'static>(
    mut worker: Worker,
    channels: &[&'static Channel],
    lossless: bool,
    mut sink: S,
) -> Result<S, Error> {
    let mut taps = match worker.setup.identity.restarts {
        0 => Taps::open(&worker.ports, channels)?,
        _ => Taps::open_for(&worker.ports, channels, &sink)?,
    };
    let mut credit = worker.ports.output::<Credit>(&CREDIT)?;
    if worker.begin().is_none() {
        return Ok(sink);
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
        visit(&mut worker, &mut taps, &mut sink);
        if lossless && taps.through() > reported {
            reported = taps.through();
            report(&worker, &mut credit, reported);
        }
        if draining {
            take_rest(&mut sink, |sink| visit(&mut worker, &mut taps, sink));
            worker.control.say("drained");
        }
        worker.bell.wait_at_most(pause);
    }
    // A process that was too slow to drain in time has sent more since.
    take_rest(&mut sink, |sink| visit(&mut worker, &mut taps, sink));
    Ok(sink)
}

/// Takes the waiting messages, as far as the sink has room; returns their number.
fn visit<S: Sink + 'static>(worker: &mut Worker, taps: &mut Taps<S>, sink: &mut S) -> u64 {
    let begun = now_ns();
    worker.reporter.begin();
    let visit = taps.drain(sink);
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
    visit.taken
}

/// Takes all waiting messages. A slow sink has no room for them at once, so it is drained between the visits.
fn take_rest<S: Sink>(sink: &mut S, mut visit: impl FnMut(&mut S) -> u64) {
    loop {
        sink.drain();
        if visit(sink) == 0 {
            break;
        }
    }
}

/// Reports to the source how many samples have passed through every channel.
fn report(worker: &Worker, credit: &mut Output<Credit>, through: u64) {
    let mut message = Credit {
        through,
        ..Credit::default()
    };
    message.stamp.sequence = through;
    credit.send(&message);
    worker.ring();
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::Message;

    /// A sink with room for three messages until it is drained.
    #[derive(Default)]
    struct Slow {
        waiting: u64,
        permanent: u64,
    }

    impl Sink for Slow {
        fn accept<M: Message>(&mut self, _: &'static Channel, _: &M) {
            self.waiting += 1;
        }
        fn has_room(&self) -> bool {
            self.waiting < 3
        }
        fn fault(&self) -> u32 {
            0
        }
        fn drain(&mut self) {
            self.permanent += std::mem::take(&mut self.waiting);
        }
    }

    #[test]
    fn a_slow_sink_has_made_everything_permanent_when_it_reports_that_it_is_drained() {
        let (mut sink, mut sent) = (Slow::default(), 10);
        // Full when the drain is requested.
        sink.waiting = 3;
        take_rest(&mut sink, |sink| {
            let before = sent;
            while sink.has_room() && sent > 0 {
                sink.accept(&CREDIT, &Credit::default());
                sent -= 1;
            }
            before - sent
        });
        assert_eq!((sent, sink.waiting, sink.permanent), (0, 0, 13));
    }
}

//! Drives a [`Sink`]: every channel of a machine, drained before it is half full.

use std::time::Duration;

use messages::channels::{CREDIT, Channel};
use messages::{Credit, Message};

use crate::clock::now_ns;
use crate::telemetry::Event;
use crate::{Error, Output, Taps, Worker};

/// Takes every message of a machine.
pub trait Sink {
    /// Asked when it is started again: the number of the first sample of a channel that it lacks. From there on it is
    /// handed also what was sent before it came, as far as the writers still hold it, and what they do not hold counts as lost. `None`: it is handed what
    /// is sent from now on.
    fn lacks_from(&self, _channel: &Channel) -> Option<u64> {
        None
    }
    /// Takes one message.
    fn accept<M: Message>(&mut self, channel: &'static Channel, message: &M);
    /// Told that `samples` of a channel were overwritten before they could be taken, because this
    /// process came too late; counted in sequence numbers, so those that nobody sent are among them.
    fn overwritten(&mut self, _channel: &'static Channel, _samples: u64) {}
    /// Told that a visit to the channels is over, in which it took something.
    fn visited(&mut self) {}
    /// Told at every visit, whether there was something to take or not.
    fn look(&mut self) {}
    /// Whether it can take more without losing any.
    fn has_room(&self) -> bool;
    /// Its fault, see [`messages::fault`].
    fn fault(&self) -> u32;
    /// Makes everything that it has taken permanent.
    fn drain(&mut self);
    /// Longest time between two visits to the channels.
    fn visit(&self) -> Duration {
        VISIT
    }
}

/// Longest time between two visits. The logger is not on the path of any estimate, so no sample wakes
/// it; a wish of the supervisor does.
const VISIT: Duration = Duration::from_millis(200);
/// The same at most so many samples long: a quarter of the depth of a channel.
const VISIT_SAMPLES: u64 = 128;
/// The same when a lossless source waits for it.
const QUICK_VISIT: Duration = Duration::from_micros(500);

/// Hands every message on `channels` to `sink`; with `lossless` the source is told how far it got.
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
    let mut told = 0;
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
        if lossless && taps.through() > told {
            told = taps.through();
            tell(&worker, &mut credit, told);
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

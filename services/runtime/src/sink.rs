//! Drives a [`Sink`]: every channel of a machine, drained on a timer.

use std::time::Duration;

use messages::channels::{CREDIT, Channel, Rate, Visitor};
use messages::{Credit, Message};

use crate::clock::now_ns;
use crate::telemetry::Event;
use crate::{Error, Input, Output, Ports, Worker};

/// Takes every message of a machine.
pub trait Sink {
    /// Takes one message.
    fn accept<M: Message>(&mut self, channel: &'static Channel, message: &M);
    /// Whether it can take more without losing any.
    fn has_room(&self) -> bool;
    /// Its fault, see [`messages::fault`].
    fn fault(&self) -> u32;
    /// Makes everything that it has taken permanent.
    fn drain(&mut self);
}

/// Time between two visits. The logger is not on the path of any estimate, so it is not woken.
const VISIT: Duration = Duration::from_millis(20);
/// The same when a lossless source waits for it.
const QUICK_VISIT: Duration = Duration::from_micros(500);

/// A channel with its type hidden.
trait Tap<S: Sink> {
    /// Hands every waiting message to the sink; returns messages taken and lost.
    fn drain(&mut self, sink: &mut S) -> (u64, u64);
    /// Samples that have passed, for channels that carry every sample.
    fn through(&self) -> Option<u64>;
}

struct TypedTap<M: Message> {
    channel: &'static Channel,
    input: Input<M>,
    through: u64,
}

impl<M: Message, S: Sink> Tap<S> for TypedTap<M> {
    fn drain(&mut self, sink: &mut S) -> (u64, u64) {
        let (mut taken, mut lost) = (0, 0);
        while sink.has_room() {
            let Some((message, gap)) = self.input.receive() else {
                break;
            };
            self.through = self.through.max(message.stamp().sequence + 1);
            sink.accept(self.channel, &message);
            taken += 1;
            lost += gap;
        }
        // Several processes write `health`; their numbers interleave and say nothing of loss.
        if self.channel.rate == Rate::Sensors {
            (taken, lost)
        } else {
            (taken, 0)
        }
    }

    fn through(&self) -> Option<u64> {
        (self.channel.rate == Rate::Sensors).then_some(self.through)
    }
}

struct Open<'a> {
    ports: &'a Ports,
    channel: &'static Channel,
}

impl Open<'_> {
    fn tap<S: Sink, M: Message>(self) -> Result<Box<dyn Tap<S>>, Error> {
        let input = self.ports.input::<M>(self.channel, self.channel.depth)?;
        input.connect();
        Ok(Box::new(TypedTap {
            channel: self.channel,
            input,
            through: 0,
        }))
    }
}

struct OpenFor<'a, S>(Open<'a>, std::marker::PhantomData<S>);

impl<S: Sink + 'static> Visitor for OpenFor<'_, S> {
    type Output = Result<Box<dyn Tap<S>>, Error>;
    fn visit<M: Message>(self) -> Self::Output {
        self.0.tap::<S, M>()
    }
}

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
    let mut taps = Vec::new();
    for &channel in channels.iter().filter(|c| c.name != CREDIT.name) {
        let open = Open {
            ports: &worker.ports,
            channel,
        };
        taps.push(
            channel
                .payload
                .visit(OpenFor::<S>(open, std::marker::PhantomData))?,
        );
    }
    let credit = worker.ports.output::<Credit>(&CREDIT)?;
    if worker.begin().is_none() {
        return Ok(());
    }
    let mut told = 0;
    while !worker.wishes.wants_exit() {
        let draining = worker.wishes.take_drain();
        let begun = now_ns();
        let (mut taken, mut lost) = (0, 0);
        for tap in &mut taps {
            let (t, l) = tap.drain(&mut sink);
            taken += t;
            lost += l;
        }
        for i in 0..taken {
            let step_ns = (now_ns() - begun) / taken;
            let lost = if i == 0 { lost } else { 0 };
            worker.reporter.sample(Event {
                age_ns: 0,
                step_ns,
                lost,
                late: false,
            });
        }
        worker.reporter.fault(sink.fault());
        if lossless {
            told = tell(&worker, &credit, &taps, told);
        }
        if draining {
            sink.drain();
            worker.control.say("drained");
        }
        std::thread::park_timeout(if lossless { QUICK_VISIT } else { VISIT });
    }
    sink.drain();
    Ok(())
}

/// Tells the source how many samples have passed through every channel.
fn tell<S: Sink>(
    worker: &Worker,
    credit: &Output<Credit>,
    taps: &[Box<dyn Tap<S>>],
    told: u64,
) -> u64 {
    let through = taps.iter().filter_map(|t| t.through()).min().unwrap_or(0);
    if through > told {
        let mut message = Credit {
            through,
            ..Credit::default()
        };
        message.stamp.sequence = through;
        credit.send(&message);
        worker.ring();
    }
    through
}

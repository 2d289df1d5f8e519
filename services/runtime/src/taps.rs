//! Every channel of a machine, read by one process: the logger, the supervisor, a dashboard.

use std::marker::PhantomData;

use messages::Message;
use messages::channels::{CREDIT, Channel, Rate, Visitor};

use crate::{Error, Input, Ports, Sink};

/// Readers of several channels that pass their messages to one sink.
pub struct Taps<S: Sink>(Vec<Box<dyn Tap<S>>>);

/// Result of a visit to the channels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Visit {
    /// Messages taken.
    pub taken: u64,
    /// Samples that were overwritten before they could be taken.
    pub lost: u64,
}

impl<S: Sink + 'static> Taps<S> {
    /// Opens `channels`, except the credit channel, which only a source reads.
    ///
    /// # Errors
    /// A channel does not exist or has too many readers.
    pub fn open(ports: &Ports, channels: &[&'static Channel]) -> Result<Self, Error> {
        Self::open_from(ports, channels, |_| None)
    }

    /// The same for a sink that may lack earlier samples, see [`Sink::lacks_from`].
    pub(crate) fn open_for(
        ports: &Ports,
        channels: &[&'static Channel],
        sink: &S,
    ) -> Result<Self, Error> {
        Self::open_from(ports, channels, |channel| sink.lacks_from(channel))
    }

    fn open_from(
        ports: &Ports,
        channels: &[&'static Channel],
        first: impl Fn(&Channel) -> Option<u64>,
    ) -> Result<Self, Error> {
        channels
            .iter()
            .filter(|channel| channel.name != CREDIT.name)
            .map(|&channel| {
                channel.payload.visit(Open {
                    ports,
                    channel,
                    first: first(channel).filter(|_| carries_every_sample(channel)),
                    sink: PhantomData,
                })
            })
            .collect::<Result<_, _>>()
            .map(Self)
    }

    /// Starts counting at `sequence`: samples missing before the first message count as lost.
    pub fn count_from(&mut self, sequence: u64) {
        for tap in &mut self.0 {
            tap.count_from(sequence);
        }
    }

    /// Passes every waiting message to the sink.
    pub fn drain(&mut self, sink: &mut S) -> Visit {
        let mut sum = Visit::default();
        for tap in &mut self.0 {
            let visit = tap.drain(sink);
            sum.taken += visit.taken;
            sum.lost += visit.lost;
        }
        sum
    }

    /// Number of samples that have passed through every channel that carries each of them.
    pub fn through(&self) -> u64 {
        self.0
            .iter()
            .filter_map(|tap| tap.through())
            .min()
            .unwrap_or(0)
    }
}

/// A channel with its type erased.
trait Tap<S: Sink> {
    fn drain(&mut self, sink: &mut S) -> Visit;
    fn through(&self) -> Option<u64>;
    fn count_from(&mut self, sequence: u64);
}

struct TypedTap<M: Message> {
    channel: &'static Channel,
    input: Input<M>,
    /// Number of the first sample that the sink lacks.
    first: u64,
    through: u64,
}

/// Several processes write `health`; their numbers interleave and do not show loss.
fn carries_every_sample(channel: &Channel) -> bool {
    channel.rate == Rate::Sensors
}

impl<M: Message, S: Sink> Tap<S> for TypedTap<M> {
    fn drain(&mut self, sink: &mut S) -> Visit {
        let mut visit = Visit::default();
        while sink.has_room() {
            let Some((message, lost)) = self.input.receive() else {
                break;
            };
            let sequence = message.stamp().sequence;
            if sequence < self.first {
                continue;
            }
            // A restarted source may go back in its numbers; those samples are new.
            self.first = 0;
            self.through = self.through.max(sequence + 1);
            sink.accept(self.channel, &*message);
            visit.taken += 1;
            visit.lost += if carries_every_sample(self.channel) {
                lost
            } else {
                0
            };
        }
        // Only a full buffer overwrites samples: before this visit, or while it took the oldest.
        if visit.lost > 0 && visit.taken >= self.channel.depth as u64 {
            sink.overwritten(self.channel, visit.lost);
        }
        visit
    }

    fn through(&self) -> Option<u64> {
        carries_every_sample(self.channel).then_some(self.through)
    }

    fn count_from(&mut self, sequence: u64) {
        if carries_every_sample(self.channel) {
            self.input.count_from(sequence);
        }
    }
}

struct Open<'a, S> {
    ports: &'a Ports,
    channel: &'static Channel,
    first: Option<u64>,
    sink: PhantomData<S>,
}

impl<S: Sink + 'static> Visitor for Open<'_, S> {
    type Output = Result<Box<dyn Tap<S>>, Error>;

    fn visit<M: Message>(self) -> Self::Output {
        let input = match self.first {
            Some(first) => self.ports.input_from::<M>(self.channel, first)?,
            None => self.ports.input::<M>(self.channel, self.channel.depth)?,
        };
        input.connect();
        let first = self.first.unwrap_or(0);
        Ok(Box::new(TypedTap {
            channel: self.channel,
            input,
            first,
            through: first,
        }))
    }
}

//! Channels, as iceoryx2 publish-subscribe services with an event beside each.

use std::any::Any;
use std::mem::MaybeUninit;
use std::time::Duration;

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::sample_mut_uninit::SampleMutUninit;
use iceoryx2::service::port_factory::event;
use messages::channels::{Channel, Rate, Visitor};
use messages::{Envelope, Message};

use crate::Error;

/// Largest number of readers of a channel: stages, logger, supervisor, dashboards, and other programs. A writer
/// visits all places, used or not, with every message.
const MAX_SUBSCRIBERS: usize = 10;

/// Largest number of writers of a channel: the living ones, and dead ones that are not yet cleaned up. A reader visits
/// all places, as above; only `health` has more than one writer at a time.
fn max_publishers(channel: &Channel) -> usize {
    match channel.rate {
        Rate::Sensors => 4,
        Rate::Hz(_) => 16,
    }
}

/// Number of messages of a channel that its writer still holds after every reader has taken them, for a logger that is
/// restarted. Only channels of samples need it, whose messages have unique numbers.
fn held(channel: &Channel) -> usize {
    match channel.rate {
        Rate::Sensors => channel.depth,
        Rate::Hz(_) => 0,
    }
}

/// Largest number of processes that have a channel open.
const MAX_NODES: usize = 40;

/// This process as iceoryx2 knows it.
#[derive(Debug)]
pub struct Ports {
    node: Node<ipc::Service>,
}

/// Holds a channel open; its type is erased because every channel has another type.
pub struct ChannelOwner {
    _service: Box<dyn Any>,
}

impl Ports {
    /// Announces this process under `name` in the domain it has entered.
    ///
    /// # Errors
    /// iceoryx2 cannot make its files.
    pub fn new(name: &str) -> Result<Self, Error> {
        let node_name = NodeName::new(name).map_err(|e| Error::ipc("name a node", name, e))?;
        let node = NodeBuilder::new()
            .name(&node_name)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|e| Error::ipc("start a node", name, e))?;
        Ok(Self { node })
    }

    /// Creates a channel and its event; the supervisor does this and holds them.
    ///
    /// # Errors
    /// The channel exists already or shared memory is exhausted.
    pub fn create(&self, channel: &Channel) -> Result<ChannelOwner, Error> {
        channel.payload.visit(Create {
            ports: self,
            channel,
        })
    }

    /// Opens a channel to write.
    ///
    /// # Errors
    /// The supervisor has not created it, or it has too many writers.
    pub fn output<M: Message>(&self, channel: &Channel) -> Result<Output<M>, Error> {
        let failed = |e: &dyn std::fmt::Debug| Error::ipc("open to write", channel.name, e);
        let service = self
            .node
            .service_builder(&service_name(channel)?)
            .publish_subscribe::<M>()
            .open()
            .map_err(|e| failed(&e))?;
        let publisher = service
            .publisher_builder()
            .max_loaned_samples(2)
            .create()
            .map_err(|e| failed(&e))?;
        let event = self.event(channel)?;
        let notifier = event.notifier_builder().create().map_err(|e| failed(&e))?;
        Ok(Output {
            loaned: None,
            publisher,
            notifier,
        })
    }

    /// Opens a channel to write its messages in envelopes and to notify its listeners, for a writer that is on no path
    /// of an estimate. A message of another channel is not sent.
    ///
    /// # Errors
    /// As [`Ports::output`].
    pub fn teller(&self, channel: &Channel) -> Result<Teller, Error> {
        channel.payload.visit(Tell {
            ports: self,
            channel,
        })
    }

    /// Opens a channel to read the messages sent from now on, holding at most `depth` samples.
    ///
    /// # Errors
    /// The supervisor has not created it, or it has too many readers.
    pub fn input<M: Message>(&self, channel: &Channel, depth: usize) -> Result<Input<M>, Error> {
        self.subscribe(channel, depth.min(channel.depth), 0)
    }

    /// Opens a channel to read from sample `first` on, including earlier samples that its writer still
    /// holds. They arrive with the writer's next message.
    ///
    /// # Errors
    /// As [`Ports::input`].
    pub(crate) fn input_from<M: Message>(
        &self,
        channel: &Channel,
        first: u64,
    ) -> Result<Input<M>, Error> {
        let mut input = self.subscribe(channel, channel.depth, held(channel))?;
        input.count_from(first);
        Ok(input)
    }

    fn subscribe<M: Message>(
        &self,
        channel: &Channel,
        depth: usize,
        before: usize,
    ) -> Result<Input<M>, Error> {
        let failed = |e: &dyn std::fmt::Debug| Error::ipc("open to read", channel.name, e);
        let service = self
            .node
            .service_builder(&service_name(channel)?)
            .publish_subscribe::<M>()
            .open()
            .map_err(|e| failed(&e))?;
        let subscriber = service
            .subscriber_builder()
            .buffer_size(depth)
            .history_request(before)
            .create()
            .map_err(|e| failed(&e))?;
        Ok(Input {
            subscriber,
            gaps: Gaps::default(),
        })
    }

    /// Opens the event of a channel, for a reader that has no bell.
    ///
    /// # Errors
    /// The supervisor has not created it, or it has too many listeners.
    pub fn listener(&self, channel: &Channel) -> Result<EventListener, Error> {
        let failed = |e: &dyn std::fmt::Debug| Error::ipc("listen to", channel.name, e);
        let event = self.event(channel)?;
        let listener = event.listener_builder().create().map_err(|e| failed(&e))?;
        Ok(EventListener(listener))
    }

    /// The event beside a channel.
    fn event(&self, channel: &Channel) -> Result<event::PortFactory<ipc::Service>, Error> {
        self.node
            .service_builder(&service_name(channel)?)
            .event()
            .open()
            .map_err(|e| Error::ipc("open the event", channel.name, e))
    }

    /// Frees the resources of dead processes in the channels of this domain. May wait for other processes without
    /// limit, see [`Cleaner`](crate::Cleaner).
    pub(crate) fn clean_up_after_the_dead(&self) {
        self.node.try_cleanup_dead_nodes();
    }
}

fn service_name(channel: &Channel) -> Result<ServiceName, Error> {
    channel
        .name
        .try_into()
        .map_err(|e| Error::ipc("name a channel", channel.name, e))
}

struct Create<'a> {
    ports: &'a Ports,
    channel: &'a Channel,
}

impl Visitor for Create<'_> {
    type Output = Result<ChannelOwner, Error>;

    fn visit<M: Message>(self) -> Self::Output {
        let failed = |e: &dyn std::fmt::Debug| Error::ipc("create", self.channel.name, e);
        let data = self
            .ports
            .node
            .service_builder(&service_name(self.channel)?)
            .publish_subscribe::<M>()
            .max_publishers(max_publishers(self.channel))
            .max_subscribers(MAX_SUBSCRIBERS)
            .max_nodes(MAX_NODES)
            .subscriber_max_buffer_size(self.channel.depth)
            .subscriber_max_borrowed_samples(2)
            .history_size(held(self.channel))
            .enable_safe_overflow(true)
            .create()
            .map_err(|e| failed(&e))?;
        let event = self
            .ports
            .node
            .service_builder(&service_name(self.channel)?)
            .event()
            .max_notifiers(max_publishers(self.channel))
            .max_listeners(MAX_SUBSCRIBERS)
            .max_nodes(MAX_NODES)
            .create()
            .map_err(|e| failed(&e))?;
        Ok(ChannelOwner {
            _service: Box::new((data, event)),
        })
    }
}

/// Sends a message in its envelope; false if it could not be sent.
pub type Teller = Box<dyn FnMut(&Envelope) -> bool>;

struct Tell<'a> {
    ports: &'a Ports,
    channel: &'a Channel,
}

impl Visitor for Tell<'_> {
    type Output = Result<Teller, Error>;

    fn visit<M: Message>(self) -> Self::Output {
        let mut output = self.ports.output::<M>(self.channel)?;
        Ok(Box::new(move |envelope| {
            let is_sent = M::inside(envelope).is_some_and(|message| output.send(message));
            output.notify();
            is_sent
        }))
    }
}

/// The writing end of a channel.
pub struct Output<M: Message> {
    // Declared first, dropped first: it belongs to the publisher.
    loaned: Option<SampleMutUninit<ipc::Service, MaybeUninit<M>, ()>>,
    publisher: Publisher<ipc::Service, M, ()>,
    notifier: Notifier<ipc::Service>,
}

impl<M: Message> Output<M> {
    /// Sends a message to every reader; a reader that is too far behind loses its oldest one.
    /// False if it could not be sent.
    pub fn send(&mut self, message: &M) -> bool {
        self.prepare();
        self.loaned
            .take()
            .is_some_and(|sample| sample.write_payload(*message).send().is_ok())
    }

    /// Allocates the memory of the next message ahead of time: after a message has been sent, no process
    /// waits.
    pub fn prepare(&mut self) {
        if self.loaned.is_none() {
            self.loaned = self.publisher.loan_uninit().ok();
        }
    }

    /// Wakes readers that listen to the iceoryx2 event; 0.03 µs while there are none.
    pub fn notify(&self) {
        let _ = self.notifier.notify();
    }

    /// Connects to the readers that exist now, so that the first message does not have to.
    pub fn connect(&self) {
        let _ = self.publisher.update_connections();
    }
}

/// Listener to the event of a channel: the wake-up for programs that the supervisor did not start and
/// that have no [`Bell`](crate::Bell).
#[derive(Debug)]
pub struct EventListener(Listener<ipc::Service>);

impl EventListener {
    /// Blocks until a message was announced since the last wait, or for `timeout`. Wakes may be
    /// spurious.
    pub fn wait(&self, timeout: Duration) {
        // After any error the reader looks for messages and waits again.
        let _ = self.0.timed_wait(|_| {}, timeout);
    }
}

/// A message in shared memory.
pub type Received<M> = Sample<ipc::Service, M, ()>;

/// The reading end of a channel.
#[derive(Debug)]
pub struct Input<M: Message> {
    subscriber: Subscriber<ipc::Service, M, ()>,
    gaps: Gaps,
}

impl<M: Message> Input<M> {
    /// The next message and the number of messages lost before it; `None` where there is none. The message
    /// stays in the writer's memory, and is released when dropped.
    pub fn receive(&mut self) -> Option<(Received<M>, u64)> {
        let message = self.subscriber.receive().ok().flatten()?;
        let lost = self.gaps.count(message.stamp().sequence);
        Some((message, lost))
    }

    /// Starts counting at `sequence`: samples missing before the first message count as lost.
    pub(crate) fn count_from(&mut self, sequence: u64) {
        self.gaps.next = Some(sequence);
    }

    /// Connects to the writers that exist now.
    pub fn connect(&self) {
        let _ = self.subscriber.update_connections();
    }
}

/// Counts the gaps in a sequence.
#[derive(Debug, Default)]
struct Gaps {
    next: Option<u64>,
}

impl Gaps {
    /// Number of sequence numbers missing before `sequence`. The first number may have any value; one that was
    /// received before (the writer was restarted) is no gap.
    fn count(&mut self, sequence: u64) -> u64 {
        let lost = self.next.map_or(0, |next| sequence.saturating_sub(next));
        self.next = Some(
            self.next
                .map_or(sequence + 1, |next| next.max(sequence + 1)),
        );
        lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_counted_once() {
        let mut gaps = Gaps::default();
        let lost: Vec<u64> = [5, 6, 9, 9, 7, 10].iter().map(|&n| gaps.count(n)).collect();
        assert_eq!(lost, [0, 0, 2, 0, 0, 0]);
    }
}

//! What takes every message of a machine.

use std::time::Duration;

use messages::channels::Channel;
use messages::{Message, fault};

/// Longest time between two visits. The logger is not on the path of any estimate, so no sample wakes
/// it; a wish of the supervisor does.
const VISIT: Duration = Duration::from_millis(200);

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
    /// Is notified that `samples` of a channel were overwritten before they could be taken, because this
    /// process came too late; counted in sequence numbers, so those that nobody sent are among them.
    fn overwritten(&mut self, _channel: &'static Channel, _samples: u64) {}
    /// Is notified that a visit to the channels is over, in which it took something.
    fn visited(&mut self) {}
    /// Is called at every visit, whether there was something to take or not.
    fn look(&mut self) {}
    /// Whether it can take more without losing any.
    fn has_room(&self) -> bool {
        true
    }
    /// Its fault, see [`messages::fault`].
    fn fault(&self) -> u32 {
        fault::NONE
    }
    /// Makes everything that it has taken permanent.
    fn drain(&mut self) {}
    /// Longest time between two visits to the channels.
    fn visit(&self) -> Duration {
        VISIT
    }
}

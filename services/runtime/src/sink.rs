//! Interface of a sink, which takes every message of a machine.

use std::time::Duration;

use messages::channels::Channel;
use messages::{Message, fault};

/// Longest time between two visits. The logger is not on the path of any estimate, so samples do not wake
/// it; requests of the supervisor do.
const VISIT: Duration = Duration::from_millis(200);

/// Takes every message of a machine.
pub trait Sink {
    /// After a restart: number of the first sample of a channel that the sink lacks. It then also receives earlier
    /// samples from there on, as far as the writers still hold them; the others count as lost. `None`: it receives only new
    /// samples.
    fn lacks_from(&self, _channel: &Channel) -> Option<u64> {
        None
    }
    /// Takes one message.
    fn accept<M: Message>(&mut self, channel: &'static Channel, message: &M);
    /// Notifies the sink that `samples` of a channel were overwritten before they could be taken, because this
    /// process came too late. Counted in sequence numbers, so numbers that were never sent are included.
    fn overwritten(&mut self, _channel: &'static Channel, _samples: u64) {}
    /// Notifies the sink of the end of a visit that has taken messages.
    fn visited(&mut self) {}
    /// Called at every visit, with or without messages.
    fn look(&mut self) {}
    /// Whether it can take more messages without losing any.
    fn has_room(&self) -> bool {
        true
    }
    /// Its fault, see [`messages::fault`].
    fn fault(&self) -> u32 {
        fault::NONE
    }
    /// Makes every message that it has taken permanent.
    fn drain(&mut self) {}
    /// Longest time between two visits to the channels.
    fn visit(&self) -> Duration {
        VISIT
    }
}

//! Sends loads to other programs.

use messages::Stamp;
use runtime::Teller;
use steps::loads::LoadCounter;

/// Loads are reported so often in the time of the data \[s\]; a clock that goes back counts as due.
const PERIOD: f64 = 0.1;

/// Tells what is known of the loads beside an estimate, when that is due or something has changed.
pub struct LoadsTeller {
    send: Teller,
    /// Time of the latest message \[s\].
    last: f64,
    /// Number of the next one: a reader counts what it missed.
    next: u64,
    /// A load or a truck has changed since the latest message.
    has_changed: bool,
}

impl LoadsTeller {
    /// Tells nothing yet.
    pub fn new(send: Teller) -> Self {
        Self {
            send,
            last: f64::NEG_INFINITY,
            next: 0,
            has_changed: false,
        }
    }

    /// A load or a truck has changed: the next estimate is reported.
    pub fn note_change(&mut self) {
        self.has_changed = true;
    }

    /// Tells what is known beside the estimate of this stamp.
    pub fn tell(&mut self, counter: &LoadCounter, stamp: &Stamp, simulated: bool) {
        // A little early counts as due: times are sums of rounded steps.
        let is_early = (0.0..PERIOD * 0.999).contains(&(stamp.time - self.last));
        if is_early && !self.has_changed {
            return;
        }
        let stamp = Stamp {
            sequence: self.next,
            ..*stamp
        };
        let mut message = steps::loads::message(counter, &stamp);
        if simulated {
            message.mark_simulated();
        }
        (self.last, self.next, self.has_changed) = (stamp.time, self.next + 1, false);
        (self.send)(&message);
    }
}

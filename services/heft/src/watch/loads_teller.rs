//! Sends loads to other programs.

use messages::Stamp;
use runtime::Teller;
use steps::loads::LoadCounter;

/// Period of the reports of loads in the time of the data \[s\]; a report is due if the clock goes back.
const PERIOD: f64 = 0.1;

/// Reports the loads beside an estimate, when that is due or a load has changed.
pub struct LoadsTeller {
    send: Teller,
    /// Time of the latest message \[s\].
    last: f64,
    /// Number of the next message: a reader counts the missed ones by it.
    next: u64,
    /// A load or a truck has changed since the latest message.
    has_changed: bool,
}

impl LoadsTeller {
    /// Has sent nothing yet.
    pub fn new(send: Teller) -> Self {
        Self {
            send,
            last: f64::NEG_INFINITY,
            next: 0,
            has_changed: false,
        }
    }

    /// Notes that a load or a truck has changed: it is reported with the next estimate.
    pub fn note_change(&mut self) {
        self.has_changed = true;
    }

    /// Reports the loads beside the estimate of this stamp, if due.
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

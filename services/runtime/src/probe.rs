//! A reader that only records the arrival times of messages. For latency it stands for the controller at the end of the
//! chain.

use std::time::Duration;

use messages::Message;
use messages::channels::Channel;

use crate::clock::now_ns;
use crate::telemetry::Event;
use crate::{Error, Worker};

/// Times at which a message passed each stage, relative to its measurement \[ns\].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Arrival {
    /// Number of the sample.
    pub sequence: u64,
    /// Published by the sensor process.
    pub sensor_ns: u64,
    /// Published by the filter stage; 0 if none.
    pub filter_ns: u64,
    /// Published by the estimator.
    pub estimate_ns: u64,
    /// Received here.
    pub received_ns: u64,
}

/// Wake-up of a probe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wake {
    /// Its bell, as every process that the supervisor starts.
    Bell,
    /// The iceoryx2 event of the channel, as for an external program.
    Event,
}

/// Longest wait for an event, so that a request of the supervisor is noticed in time.
const LOOK: Duration = Duration::from_millis(20);

/// Records up to `capacity` arrivals on `channel` until the supervisor ends it.
///
/// # Errors
/// The channel cannot be opened.
pub fn run_probe<M: Message>(
    mut worker: Worker,
    channel: &Channel,
    capacity: usize,
    wake: Wake,
) -> Result<Vec<Arrival>, Error> {
    let mut input = worker.ports.input::<M>(channel, channel.depth)?;
    input.connect();
    let listener = match wake {
        Wake::Bell => None,
        Wake::Event => Some(worker.ports.listener(channel)?),
    };
    let mut arrivals = Vec::with_capacity(capacity);
    let Some(begin) = worker.begin() else {
        return Ok(arrivals);
    };
    input.count_from(begin.first);
    input.connect();
    while !worker.requests.wants_exit() {
        match &listener {
            None => worker.wait(),
            Some(listener) => listener.wait(LOOK),
        }
        let draining = worker.requests.take_drain();
        while let Some((message, lost)) = input.receive() {
            let now = now_ns();
            let measured = message.stamp().measured_ns;
            if arrivals.len() < capacity {
                arrivals.push(arrival(&*message, now));
            }
            let age_ns = now.saturating_sub(measured);
            worker.reporter.sample(Event {
                age_ns,
                step_ns: 0,
                lost,
                late: false,
            });
        }
        if draining {
            worker.control.say("drained");
        }
    }
    Ok(arrivals)
}

fn arrival<M: Message>(message: &M, now: u64) -> Arrival {
    let (stamp, hops) = (message.stamp(), message.hops());
    let since = |ns: u64| ns.saturating_sub(stamp.measured_ns);
    Arrival {
        sequence: stamp.sequence,
        sensor_ns: since(hops.sensor_ns),
        filter_ns: since(hops.filter_ns),
        estimate_ns: since(hops.estimate_ns),
        received_ns: since(now),
    }
}

//! Drives a [`Live`] source: its samples come at unknown times.

use messages::Message;
use messages::channels::ChannelOf;

use crate::clock::now_ns;
use crate::requests::Begin;
use crate::source::{Pace, Sender, finish, is_ending};
use crate::telemetry::Event;
use crate::{Error, Worker};

/// Result of polling a live source.
#[derive(Debug)]
pub enum Polled<S, T> {
    /// A sample, with what is known of the truth behind it.
    Sample(S, T),
    /// Nothing yet.
    Nothing,
    /// The end: no more samples follow.
    End,
    /// The input is unusable: the run ends with this error.
    Refused(Error),
}

/// A source without a pace of its own: a bus, a pipe.
pub trait Live {
    /// Sensor samples.
    type Sensors: Message;
    /// Truth of the samples; empty where none is known.
    type Truth: Message;

    /// The next sample; waits for at most some 20 ms. `stamp.time` is filled in, and
    /// `stamp.measured_ns` where the source knows it.
    fn poll(&mut self) -> Polled<Self::Sensors, Self::Truth>;

    /// Number of samples lost before this source could take them, since the last call.
    fn take_lost(&mut self) -> u64 {
        0
    }
}

/// Sends every sample of the source on `sensors` and `truth`, for `duration` \[s\] if there is
/// one. `make` opens the source at the start of the run, from the begin request and the number of restarts of the
/// source.
///
/// # Errors
/// A channel cannot be opened.
pub fn run_live<L: Live>(
    mut worker: Worker,
    sensors: &ChannelOf<L::Sensors>,
    truth: &ChannelOf<L::Truth>,
    pace: Pace,
    duration: Option<f64>,
    make: impl FnOnce(Begin, u32) -> L,
) -> Result<(), Error> {
    let mut sender = Sender::<L::Sensors, L::Truth>::open(&worker, sensors, truth)?;
    let Some(begin) = worker.begin() else {
        return Ok(());
    };
    sender.connect();
    let epoch = worker.setup.identity.restarts;
    let mut source = make(begin, epoch);
    let mut sequence = begin.first;
    let end_ns = duration.map_or(u64::MAX, |s| {
        begin.start_ns.saturating_add((s * 1e9) as u64)
    });
    while !is_ending(&worker) && now_ns() < end_ns {
        worker.reporter.begin();
        let polled = source.poll();
        worker.reporter.end();
        let (mut measured, mut true_values) = match polled {
            Polled::Sample(measured, true_values) => (measured, true_values),
            Polled::Nothing => continue,
            Polled::End => break,
            Polled::Refused(error) => {
                worker.control.say(&format!("refused {error}"));
                break;
            }
        };
        if pace == Pace::Lossless && !sender.wait_for_turn(&worker, pace, sequence, 0) {
            break;
        }
        let now = now_ns();
        let stamp = measured.stamp_mut();
        (stamp.sequence, stamp.epoch) = (sequence, epoch);
        if stamp.measured_ns == 0 {
            stamp.measured_ns = now;
        }
        let age_ns = now.saturating_sub(stamp.measured_ns);
        *true_values.stamp_mut() = *stamp;
        sender.send(&mut worker, measured, true_values);
        worker.reporter.sample(Event {
            age_ns,
            step_ns: 0,
            lost: source.take_lost(),
            late: false,
        });
        sequence += 1;
    }
    finish(&worker);
    Ok(())
}

//! Drives a [`Source`]: at its own pace on the clock, or as fast as the readers take its samples.

use std::time::Duration;

use messages::channels::{CREDIT, ChannelOf};
use messages::{Credit, Message, fault};

use crate::clock::{now_ns, sleep_until};
use crate::requests::Begin;
use crate::step::Source;
use crate::telemetry::Event;
use crate::{Error, Input, Output, Worker};

/// Pace of a source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// At the times of the samples.
    RealTime,
    /// As fast as the readers take them, without loss.
    Lossless,
}

/// Number of samples that may be under way before they reach the logger: less than any depth.
const WINDOW: u64 = 256;
/// Time without progress after which the source continues [ns]. A reader that died took the samples in its buffer along;
/// the readers count the loss.
const GIVE_UP_NS: u64 = 2_000_000_000;
/// Longest single sleep [ns], so that a request of the supervisor is noticed in time.
const NAP_NS: u64 = 20_000_000;

/// Sends every sample of `source` on `sensors` and `truth`.
///
/// # Errors
/// A channel cannot be opened.
pub fn run_source<S: Source>(
    mut worker: Worker,
    sensors: &ChannelOf<S::Sensors>,
    truth: &ChannelOf<S::Truth>,
    pace: Pace,
    mut source: S,
) -> Result<(), Error> {
    let mut sender = Sender::<S::Sensors, S::Truth>::open(&worker, sensors, truth)?;
    let Some(Begin {
        first, start_ns, ..
    }) = worker.begin()
    else {
        return Ok(());
    };
    sender.connect();
    let epoch = worker.setup.identity.restarts;
    let mut timeline = Timeline::default();
    let mut catches_up = pace == Pace::RealTime && first > 0;
    loop {
        worker.reporter.begin();
        let next = source.next();
        worker.reporter.end();
        let Some((mut measured, mut true_values)) = next else {
            break;
        };
        let stamp = measured.stamp();
        let offset = timeline.offset(stamp.time);
        if stamp.sequence < first {
            continue;
        }
        let deadline = due(start_ns, offset);
        if !sender.wait_for_turn(&worker, pace, stamp.sequence, deadline) {
            break;
        }
        let now = now_ns();
        // After a restart, samples that are overdue are lost instead of sent late.
        catches_up &= now > deadline + NAP_NS;
        if catches_up {
            continue;
        }
        for stamp in [measured.stamp_mut(), true_values.stamp_mut()] {
            stamp.measured_ns = now;
            stamp.epoch = epoch;
        }
        true_values.stamp_mut().sequence = measured.stamp().sequence;
        true_values.stamp_mut().time = measured.stamp().time;
        sender.send(&mut worker, measured, true_values);
        worker.reporter.sample(Event {
            age_ns: now_ns() - now,
            step_ns: 0,
            lost: 0,
            late: false,
        });
    }
    finish(&worker);
    Ok(())
}

pub(crate) struct Sender<S: Message, T: Message> {
    sensors: Output<S>,
    truth: Output<T>,
    credit: Input<Credit>,
    /// Number of samples that have passed through every channel, up to the logger; and up to which the source has stopped waiting.
    through: u64,
    given_up: u64,
}

impl<S: Message, T: Message> Sender<S, T> {
    pub(crate) fn open(
        worker: &Worker,
        sensors: &ChannelOf<S>,
        truth: &ChannelOf<T>,
    ) -> Result<Self, Error> {
        Ok(Self {
            sensors: worker.ports.output::<S>(sensors)?,
            truth: worker.ports.output::<T>(truth)?,
            credit: worker.ports.input::<Credit>(&CREDIT, CREDIT.depth)?,
            through: 0,
            given_up: 0,
        })
    }

    pub(crate) fn connect(&mut self) {
        self.sensors.connect();
        self.truth.connect();
    }

    /// Waits until sample `sequence`, due at `deadline`, may be sent; false if the run ends
    /// meanwhile.
    pub(crate) fn wait_for_turn(
        &mut self,
        worker: &Worker,
        pace: Pace,
        sequence: u64,
        deadline: u64,
    ) -> bool {
        match pace {
            Pace::RealTime => wait_for_time(worker, deadline),
            Pace::Lossless => self.wait_for_credit(worker, sequence),
        }
    }

    fn wait_for_credit(&mut self, worker: &Worker, sequence: u64) -> bool {
        let mut progress = (self.through, now_ns());
        loop {
            if is_ending(worker) {
                return false;
            }
            while let Some((credit, _)) = self.credit.receive() {
                self.through = self.through.max(credit.through);
            }
            let through = self.through.min(worker.requests.seen());
            if sequence < through.max(self.given_up) + WINDOW {
                return true;
            }
            if through > progress.0 {
                progress = (through, now_ns());
            }
            let waited = now_ns() - progress.1;
            if waited > GIVE_UP_NS {
                self.given_up = sequence + 1;
                return true;
            }
            // The process that would ring may be the dead one.
            let rest = Duration::from_nanos(GIVE_UP_NS - waited);
            worker.bell.wait_at_most(rest + Duration::from_millis(1));
        }
    }

    pub(crate) fn send(&mut self, worker: &mut Worker, mut measured: S, true_values: T) {
        measured.hops_mut().sensor_ns = now_ns();
        if !self.sensors.send(&measured) {
            worker.reporter.fault(fault::SEND);
        }
        worker.ring();
        self.truth.send(&true_values);
        self.sensors.notify();
        self.sensors.prepare();
    }
}

/// Longest step between two rows that is waited for [s]; a longer one is a clock that was set.
const LONGEST_PAUSE: f64 = 3600.0;

/// Due times of rows from their time stamps, which may be missing or of a clock that was set.
#[derive(Debug, Default)]
struct Timeline {
    origin: Option<f64>,
    /// Offset of the previous row [s].
    last: f64,
}

impl Timeline {
    /// Time since the first row [s]. A row without a time is due with the previous one, and so is the first after the clock was set.
    fn offset(&mut self, time: f64) -> f64 {
        if !time.is_finite() {
            return self.last;
        }
        let offset = time - *self.origin.get_or_insert(time);
        if (offset - self.last).abs() <= LONGEST_PAUSE {
            self.last = offset;
        } else {
            self.origin = Some(time - self.last);
        }
        self.last
    }
}

fn due(start_ns: u64, offset: f64) -> u64 {
    // A row whose time goes back is due at once.
    start_ns.saturating_add((offset.max(0.0) * 1e9) as u64)
}

fn wait_for_time(worker: &Worker, deadline: u64) -> bool {
    loop {
        if is_ending(worker) {
            return false;
        }
        let now = now_ns();
        if now >= deadline {
            return true;
        }
        sleep_until(deadline.min(now + NAP_NS));
    }
}

pub(crate) fn is_ending(worker: &Worker) -> bool {
    worker.requests.wants_exit() || worker.requests.wants_drain()
}

/// Reports the end, and waits for the exit request: readers may still be draining.
pub(crate) fn finish(worker: &Worker) {
    worker.control.say("ended");
    while !worker.requests.wants_exit() {
        if worker.requests.take_drain() {
            worker.control.say("drained");
        }
        worker.bell.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_without_a_time_and_a_clock_that_is_set_hold_up_nothing() {
        let mut timeline = Timeline::default();
        let times = [f64::NAN, 12.3, 12.4, 1.7e9, 1.7e9 + 0.1, 12.7, 1e300, 12.8];
        let offsets = times.map(|time| timeline.offset(time));
        for (offset, expected) in offsets
            .into_iter()
            .zip([0.0, 0.0, 0.1, 0.1, 0.2, 0.2, 0.2, 0.2])
        {
            assert!((offset - expected).abs() < 1e-6, "{offsets:?}");
        }
        assert_eq!(due(u64::MAX - 5, 1.0), u64::MAX);
    }

    #[test]
    fn a_pause_of_the_recorder_is_a_pause() {
        let mut timeline = Timeline::default();
        let offsets = [5.0, 5.1, 305.0, 304.0].map(|time| timeline.offset(time));
        assert!((offsets[2] - 300.0).abs() < 1e-9 && (offsets[3] - 299.0).abs() < 1e-9);
    }
}

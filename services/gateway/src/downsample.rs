//! Selection of the messages to send. The same rule applies to the channels of a running machine and to its recording, so a
//! repeated message has the same content and number.
//!
//! | stream | message |
//! |---|---|
//! | `estimate/CHANNEL` | the first estimate of each second, and each at which the verdict changes (ten a second at most) |
//! | `loads/CHANNEL` | the estimate that reports a swing or a drive |
//! | `ledger/MACHINE` | the account of bucket, loads and trucks: the first of each ten seconds, and each with a change of load, stage or truck |
//! | `health/PROCESS` | the first report of each second |
//! | `events/PROCESS` | the report at which state, fault or restarts differ from the one before |

use std::sync::Arc;

use messages::channels::{Channel, HEALTH};
use messages::{Envelope, Health, Message};
use steps::stages::Pipeline;
use view::estimate::Estimate;

use crate::label::{LIFE, Label};
use crate::load::Loads;
use crate::track::{Continuity, Mark, Track};

/// Rate of health reports [1/s].
const HEALTH_RATE: f64 = 1.0 / 0.3;

/// Rate of the accounts of loads [1/s].
const LEDGER_RATE: f64 = 10.0;
/// Period in which one of them is sent [s].
const LEDGER_PERIOD: f64 = 10.0;

/// A stream of messages of one machine.
#[derive(Debug, Clone)]
pub struct StreamInfo {
    /// `KIND/NAME`.
    pub name: String,
    /// The channel that its messages are selected from.
    pub channel: &'static Channel,
    /// Samples between two messages, 0 where there is no period.
    pub per_period: f64,
    kind: Kind,
    /// Position of the process in the table of processes.
    process: u32,
}

impl StreamInfo {
    /// Whether it carries estimates at a fixed rate.
    pub fn is_estimate(&self) -> bool {
        self.kind == Kind::Estimate
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Estimate,
    Loads,
    Ledger,
    Health,
    Events,
}

impl Kind {
    const fn word(self) -> &'static str {
        match self {
            Self::Estimate => "estimate",
            Self::Loads => "loads",
            Self::Ledger => "ledger",
            Self::Health => "health",
            Self::Events => "events",
        }
    }
}

/// The streams of a machine whose sensors deliver `rate` samples a second, with `hz` estimates a second sent.
pub fn streams(pipeline: &Pipeline, rate: f64, hz: f64) -> Vec<StreamInfo> {
    let of = |kind: Kind, channel: &'static Channel, name: &str, per_period| StreamInfo {
        name: format!("{}/{name}", kind.word()),
        channel,
        per_period,
        kind,
        process: 0,
    };
    let mut all = Vec::new();
    for channel in pipeline.estimates() {
        all.push(of(Kind::Estimate, channel, channel.last_name(), rate / hz));
    }
    if let Some(channel) = pipeline.main_output() {
        all.push(of(Kind::Loads, channel, channel.last_name(), 0.0));
    }
    // Each machine has a ledger message of its own, so the stream's name identifies the machine.
    let (ledger, machine) = (
        steps::loads::channel(pipeline.machine),
        pipeline.machine.name(),
    );
    all.push(of(
        Kind::Ledger,
        ledger,
        machine,
        LEDGER_RATE * LEDGER_PERIOD,
    ));
    for (process, stage) in (0..).zip(pipeline.stages) {
        for (kind, per_period) in [(Kind::Health, HEALTH_RATE), (Kind::Events, 0.0)] {
            let stream = of(kind, &HEALTH, stage.name, per_period);
            all.push(StreamInfo { process, ..stream });
        }
    }
    all
}

/// A message that is sent.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection {
    /// Position of its stream in [`streams`].
    pub stream: usize,
    /// Machine, run and number.
    pub label: Label,
    /// The message as recordings encode it.
    pub payload: Vec<u8>,
}

macro_rules! machines {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// The detectors of loads of each kind of machine.
        #[derive(Debug, Default, Clone)]
        struct Stretches { $( $module: Loads<messages::$estimate>, )* }

        impl Downsampler {
            /// Takes the next message of a channel and passes on what is to be sent.
            pub fn take<M: Message>(
                &mut self,
                channel: &Channel,
                message: &M,
                out: &mut impl FnMut(Selection),
            ) {
                match message.envelope() {
                    $( Envelope::$estimate(e) => self.estimate(channel, &e, |t| &mut t.stretches.$module, out), )*
                    Envelope::Health(health) => self.health(&health, out),
                    Envelope::ExcavatorLoads(m) => self.ledger(&m, [m.load, m.stage, m.truck], out),
                    Envelope::LoaderLoads(m) => self.ledger(&m, [m.load, m.stage, m.truck], out),
                    // Neither estimates nor health: not sent.
                    _ => {}
                }
            }
        }
    };
}

messages::machines!(machines);

/// Selects messages.
#[derive(Debug, Clone)]
pub struct Downsampler {
    streams: Arc<[StreamInfo]>,
    tracks: Vec<Track>,
    stretches: Stretches,
    machine: String,
    run: u64,
    hz: f64,
    /// Wall clock minus monotonic clock [ns].
    wall_offset_ns: i64,
}

impl Downsampler {
    /// A selection for the run `run` of `machine`, with `hz` estimates a second.
    pub fn new(
        streams: Vec<StreamInfo>,
        machine: &str,
        run: u64,
        hz: f64,
        wall_offset_ns: i64,
    ) -> Self {
        Self {
            tracks: vec![Track::default(); streams.len()],
            streams: streams.into(),
            stretches: Stretches::default(),
            machine: machine.to_owned(),
            run,
            hz,
            wall_offset_ns,
        }
    }

    /// Number of the latest message of a stream, -1 for none.
    pub fn head(&self, stream: usize) -> i64 {
        self.tracks.get(stream).map_or(-1, |t| t.selected)
    }

    /// Number of the latest sample that a stream was selected from, -1 for none.
    pub fn seen(&self, stream: usize) -> i64 {
        self.tracks.get(stream).map_or(-1, |t| t.seen)
    }

    fn estimate<E: Estimate>(
        &mut self,
        channel: &Channel,
        estimate: &E,
        loads: impl Fn(&mut Self) -> &mut Loads<E>,
        out: &mut impl FnMut(Selection),
    ) {
        let number = estimate.stamp().sequence;
        let verdicts = E::PARAMETERS.iter().fold(0, |bits, p| bits | p.trusted);
        let mark = [estimate.flags() & verdicts, 0, 0];
        // Times are sums of rounded steps, so a time may lie slightly before its period.
        let bucket = (estimate.stamp().time * self.hz + 1e-6).floor() as i64;
        for i in 0..self.streams.len() {
            if self.streams[i].channel.name != channel.name {
                continue;
            }
            let seen = self.tracks[i].see(number, false);
            if seen == Continuity::Before {
                continue;
            }
            if self.streams[i].kind == Kind::Estimate {
                if self.tracks[i].is_due(number, bucket, mark) {
                    self.send(i, number, estimate, out);
                }
                continue;
            }
            if seen == Continuity::Gap {
                loads(self).forget();
            }
            if let Some(load) = loads(self).take(estimate) {
                self.send(i, load.stamp().sequence, &load, out);
            }
        }
    }

    /// Accounts have consecutive numbers of their own. `mark`: load, stage, truck.
    fn ledger<M: Message>(&mut self, message: &M, mark: Mark, out: &mut impl FnMut(Selection)) {
        let number = message.stamp().sequence;
        let bucket = (message.stamp().time / LEDGER_PERIOD + 1e-6).floor() as i64;
        for i in 0..self.streams.len() {
            let is_ledger = self.streams[i].kind == Kind::Ledger;
            if is_ledger
                && self.tracks[i].see(number, false) != Continuity::Before
                && self.tracks[i].is_due(number, bucket, mark)
            {
                self.send(i, number, message, out);
            }
        }
    }

    fn health(&mut self, health: &Health, out: &mut impl FnMut(Selection)) {
        let number = health_number(health);
        let is_first = health.stamp.sequence == 0;
        let bucket = (health.stamp.time + 1e-6).floor() as i64;
        for i in 0..self.streams.len() {
            let (kind, process) = (self.streams[i].kind, self.streams[i].process);
            let mark = match kind {
                Kind::Health => [0; 3],
                Kind::Events => [health.state, health.fault, health.restarts],
                _ => continue,
            };
            if process != health.process
                || self.tracks[i].see(number, is_first) == Continuity::Before
            {
                continue;
            }
            let track = &mut self.tracks[i];
            let is_sent = match kind {
                Kind::Events => track.has_changed(number, bucket, mark),
                _ => track.is_due(number, bucket, mark),
            };
            if is_sent {
                self.send(i, number, health, out);
            }
        }
    }

    fn send<M: Message>(
        &mut self,
        stream: usize,
        number: u64,
        message: &M,
        out: &mut impl FnMut(Selection),
    ) {
        let mut payload = Vec::with_capacity(256);
        recording::payload::encode(message, &mut payload);
        let measured = message.stamp().measured_ns as i64;
        let wall_ms = measured.saturating_add(self.wall_offset_ns).max(0) as u64 / 1_000_000;
        let label = Label {
            machine: self.machine.clone(),
            run: self.run,
            number,
            after: self.tracks[stream].select(number),
            wall_ms,
        };
        out(Selection {
            stream,
            label,
            payload,
        });
    }
}

/// Number of a health report in its streams: restarts of the process in the high bits, because it then counts from 0.
pub fn health_number(health: &Health) -> u64 {
    u64::from(health.restarts & 0xffff) << LIFE | health.stamp.sequence & ((1 << LIFE) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::channels::{EXCAVATOR_INERTIA_UKF as CHANNEL, EXCAVATOR_LOADS};
    use messages::{ExcavatorEstimate, ExcavatorLoads, Machine, excavator_bits as x};

    fn downsampler() -> Downsampler {
        let streams = streams(Pipeline::of(Machine::Excavator), 100.0, 1.0);
        Downsampler::new(streams, "ex-17", 7, 1.0, 0)
    }

    fn estimate(i: u64) -> ExcavatorEstimate {
        let mut estimate = ExcavatorEstimate {
            flags: if (150..250).contains(&i) {
                x::TRUSTED
            } else {
                0
            },
            ..Default::default()
        };
        (estimate.stamp.sequence, estimate.stamp.time) = (i, i as f64 * 0.01);
        estimate
    }

    fn selected(
        downsampler: &mut Downsampler,
        numbers: impl Iterator<Item = u64>,
    ) -> Vec<(u64, Option<i64>)> {
        let mut found = Vec::new();
        for i in numbers {
            downsampler.take(&CHANNEL, &estimate(i), &mut |s: Selection| {
                found.push((s.label.number, s.label.after));
            });
        }
        found
    }

    #[test]
    fn each_second_and_each_change_of_verdict_is_sent_and_names_the_one_before() {
        let found = selected(&mut downsampler(), 0..350);
        let expected = [
            (0, Some(-1)),
            (100, Some(0)),
            (150, Some(100)),
            (200, Some(150)),
            (250, Some(200)),
            (300, Some(250)),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn behind_missed_samples_the_message_before_is_not_known() {
        let found = selected(&mut downsampler(), (0..120).chain(190..320));
        assert_eq!(found[..3], [(0, Some(-1)), (100, Some(0)), (190, None)]);
        assert_eq!(found[3], (200, Some(190)));
        // A selection that starts midway sends a subset, and does not know the message before its first one.
        let joined = selected(&mut downsampler(), 130..320);
        assert_eq!(
            joined,
            [
                (150, None),
                (200, Some(150)),
                (250, Some(200)),
                (300, Some(250))
            ]
        );
    }

    #[test]
    fn a_verdict_that_flickers_does_not_flood() {
        let mut downsampler = downsampler();
        let mut sent = 0;
        for i in 0..1000 {
            let mut message = estimate(i);
            message.flags = if i % 2 == 0 { x::TRUSTED } else { 0 };
            downsampler.take(&CHANNEL, &message, &mut |_| sent += 1);
        }
        assert!(
            sent <= 10 * (1 + crate::track::CHANGES as usize + 1),
            "{sent}"
        );
    }

    #[test]
    fn every_change_of_a_processes_state_is_an_event_however_many_there_are() {
        let mut downsampler = downsampler();
        let mut events = 0;
        for i in 0..400_u64 {
            // The state changes every four seconds.
            let mut health = Health {
                state: (i / 13 % 2) as u32,
                ..Health::default()
            };
            (health.stamp.sequence, health.stamp.time) = (i, i as f64 * 0.3);
            let streams = downsampler.streams.clone();
            downsampler.take(&HEALTH, &health, &mut |s: Selection| {
                events += u32::from(streams[s.stream].kind == Kind::Events);
            });
        }
        assert_eq!(events, 400 / 13 + 1);
    }

    #[test]
    fn of_loads_each_change_is_sent_and_one_in_ten_seconds() {
        let mut downsampler = downsampler();
        let mut found = Vec::new();
        for i in 0..250_u64 {
            let mut message = ExcavatorLoads {
                load: u32::from(i >= 42),
                stage: u32::from(i >= 77),
                truck: 1,
                ..Default::default()
            };
            (message.stamp.sequence, message.stamp.time) = (i, i as f64 * 0.1);
            downsampler.take(&EXCAVATOR_LOADS, &message, &mut |s: Selection| {
                found.push((s.label.number, s.label.after));
            });
        }
        let expected = [
            (0, Some(-1)),
            (42, Some(0)),
            (77, Some(42)),
            (100, Some(77)),
            (200, Some(100)),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn events_are_changes_and_a_restart_is_one() {
        let mut downsampler = downsampler();
        let mut found = Vec::new();
        let mut say = |sequence: u64, restarts: u32, state: u32| {
            let mut health = Health {
                process: 3,
                state,
                restarts,
                ..Default::default()
            };
            (health.stamp.sequence, health.stamp.time) = (sequence, sequence as f64 * 0.3);
            let names = downsampler.streams.clone();
            downsampler.take(&HEALTH, &health, &mut |s: Selection| {
                if names[s.stream].name == "events/ukf" {
                    found.push((s.label.number, s.label.after));
                }
            });
        };
        (0..10).for_each(|i| say(i, 0, u32::from(i > 2)));
        (0..3).for_each(|i| say(i, 1, 1));
        assert_eq!(found, [(0, Some(-1)), (3, Some(0)), (1 << 40, Some(3))]);
    }
}

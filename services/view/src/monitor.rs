//! The latest state of everything that runs, for the live page and the terminal dashboard; its size is bounded at any rate.

use std::any::Any;
use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use estimation::consistency::MOST_NIS;
use messages::channels::Channel;
use messages::{Health, Machine, Message};
use recording::csv::Estimate as _;

use crate::estimate::Estimate;
use crate::posture::{self, Posture};

/// Most values of a sparkline.
const TREND: usize = 240;
/// Period of the values of a sparkline.
pub(crate) const TREND_PERIOD: Duration = Duration::from_millis(100);

/// Counts events and measures their rate once a second.
#[derive(Debug, Clone, Copy)]
pub struct Meter {
    since: Instant,
    counted: u64,
    rate: f64,
}

impl Meter {
    fn new(now: Instant, count: u64) -> Self {
        Self {
            since: now,
            counted: count,
            rate: 0.0,
        }
    }

    fn update(&mut self, now: Instant, count: u64) {
        let elapsed = now.saturating_duration_since(self.since).as_secs_f64();
        if count < self.counted {
            *self = Self::new(now, count);
        } else if elapsed >= 1.0 {
            self.rate = (count - self.counted) as f64 / elapsed;
            (self.since, self.counted) = (now, count);
        }
    }
}

/// State of a channel.
#[derive(Debug, Clone, Copy)]
pub struct ChannelState {
    /// Messages received.
    pub count: u64,
    /// Messages that never arrived (gaps in the sequence).
    pub lost: u64,
    /// Time of the last message.
    pub seen: Instant,
    last_sequence: u64,
    meter: Meter,
}

impl ChannelState {
    /// Messages a second.
    pub fn rate(&self) -> f64 {
        self.meter.rate
    }
}

/// State of a process.
#[derive(Debug, Clone, Copy)]
pub struct ProcessState {
    /// Its last health report.
    pub health: Health,
    /// Time of the report.
    pub seen: Instant,
    meter: Meter,
}

impl ProcessState {
    /// Samples a second.
    pub fn rate(&self) -> f64 {
        self.meter.rate
    }
}

/// State of an estimator.
#[derive(Debug, Clone)]
pub struct Tracked<E> {
    /// Its last estimate.
    pub last: E,
    /// Exponential mean of the normalised innovation squared, over the window of the verdict.
    pub nis_mean: f64,
    /// Last trusted estimate of each headline parameter.
    pub trusted: Vec<Option<E>>,
    /// The headline parameters over the last 24 s, for sparklines.
    pub trend: VecDeque<Vec<f64>>,
    trend_time: Instant,
}

impl<E: Estimate> Tracked<E> {
    fn new(estimate: &E, now: Instant) -> Self {
        let mut tracked = Self {
            last: *estimate,
            nis_mean: 1.0,
            trusted: E::headlines().map(|_| None).collect(),
            trend: VecDeque::new(),
            trend_time: now,
        };
        tracked.trust(estimate);
        tracked.remember(now);
        tracked
    }

    fn trust(&mut self, estimate: &E) {
        for (last, parameter) in self.trusted.iter_mut().zip(E::headlines()) {
            if estimate.flags() & parameter.trusted != 0 {
                *last = Some(*estimate);
            }
        }
    }

    fn update(&mut self, estimate: &E, now: Instant) {
        self.last = *estimate;
        self.trust(estimate);
        if estimate.nis() > 0.0 {
            let weight = 1.0 / E::INNOVATION.window as f64;
            self.nis_mean += weight * (estimate.nis().min(MOST_NIS) - self.nis_mean);
        }
        if now.saturating_duration_since(self.trend_time) >= TREND_PERIOD {
            self.remember(now);
        }
    }

    fn remember(&mut self, now: Instant) {
        if self.trend.len() == TREND {
            self.trend.pop_front();
        }
        self.trend
            .push_back(E::headlines().map(|p| p.value(&self.last)).collect());
        self.trend_time = now;
    }
}

/// The estimators and the truth of one machine.
#[derive(Debug, Clone, Default)]
pub struct MachineState<E: Estimate> {
    /// By the name of the channel.
    pub estimators: BTreeMap<&'static str, Tracked<E>>,
    /// The last truth, where it is known.
    pub truth: Option<E::Truth>,
}

impl<E: Estimate> MachineState<E> {
    fn estimate(&mut self, channel: &Channel, estimate: &E, now: Instant) {
        self.estimators
            .entry(channel.name)
            .and_modify(|tracked| tracked.update(estimate, now))
            .or_insert_with(|| Tracked::new(estimate, now));
    }
}

macro_rules! machines {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// The state of each machine.
        #[derive(Debug, Clone, Default)]
        #[allow(missing_docs, reason = "each is of the machine of its name")]
        pub struct Machines { $( pub $module: MachineState<messages::$estimate>, )* }

        impl Machines {
            /// Takes an estimate or a truth; returns whether it is an estimate of a row that was not refused.
            fn push(&mut self, channel: &Channel, message: &dyn Any, now: Instant) -> bool {
                $(
                    if let Some(estimate) = message.downcast_ref::<messages::$estimate>() {
                        self.$module.estimate(channel, estimate, now);
                        return !estimate.is_refused();
                    }
                    if let Some(truth) = message.downcast_ref() {
                        self.$module.truth = Some(*truth);
                    }
                )*
                false
            }

            /// Passes each machine to `shows`.
            pub(crate) fn each<S: Each>(&self, mut shows: S) -> [S::Output; Machine::ALL.len()] {
                [$( shows.of(&self.$module) ),*]
            }
        }
    };
}

messages::machines!(machines);

/// An operation on each machine.
pub(crate) trait Each {
    type Output;
    fn of<E: Estimate>(&mut self, state: &MachineState<E>) -> Self::Output;
}

/// The latest state of everything.
#[derive(Debug, Clone, Default)]
pub struct Monitor {
    /// Names of the processes, by [`Health::process`].
    pub names: Vec<String>,
    /// By the name of the channel.
    pub channels: BTreeMap<&'static str, ChannelState>,
    /// By their position in the table of processes.
    pub processes: BTreeMap<u32, ProcessState>,
    /// The state of each machine.
    pub machines: Machines,
    /// Posture of each machine, by its name; only if its samples are seen.
    pub postures: BTreeMap<&'static str, Posture>,
    /// Time of the newest estimate, by the data \[s\].
    pub time: f64,
    /// Whether the samples are the simulator's.
    pub is_simulated: bool,
}

impl Monitor {
    /// A monitor with the processes' `names`.
    pub fn new(names: Vec<String>) -> Self {
        Self {
            names,
            ..Self::default()
        }
    }

    /// Takes a message.
    pub fn push<M: Message>(&mut self, channel: &Channel, message: &M, now: Instant) {
        self.count(channel, message, now);
        self.is_simulated |= message.is_simulated();
        if let Some(machine) = channel.name.strip_suffix("/sensors") {
            posture::take(self.postures.entry(machine).or_default(), message);
        }
        let time = message.stamp().time;
        let message: &dyn Any = message;
        if let Some(h) = message.downcast_ref::<Health>() {
            self.process(h, now);
        } else if self.machines.push(channel, message, now) {
            self.time = time;
        }
    }

    /// Name of process `index`.
    pub fn name(&self, index: u32) -> String {
        let known = usize::try_from(index).ok().and_then(|i| self.names.get(i));
        known.cloned().unwrap_or_else(|| format!("process {index}"))
    }

    fn count<M: Message>(&mut self, channel: &Channel, message: &M, now: Instant) {
        let sequence = message.stamp().sequence;
        let state = self
            .channels
            .entry(channel.name)
            .or_insert_with(|| ChannelState {
                count: 0,
                lost: 0,
                seen: now,
                last_sequence: sequence.wrapping_sub(1),
                meter: Meter::new(now, 0),
            });
        // Several processes write to `health`, each with its own sequence, so gaps are not counted there.
        if channel.name.contains('/') && sequence > state.last_sequence {
            state.lost += sequence - state.last_sequence - 1;
        }
        state.last_sequence = sequence;
        state.count += 1;
        state.seen = now;
        state.meter.update(now, state.count);
    }

    fn process(&mut self, health: &Health, now: Instant) {
        let fresh = ProcessState {
            health: *health,
            seen: now,
            meter: Meter::new(now, health.steps),
        };
        let state = self.processes.entry(health.process).or_insert(fresh);
        (state.health, state.seen) = (*health, now);
        state.meter.update(now, health.steps);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ExcavatorEstimate, LoaderEstimate, Stamp, channels};

    #[test]
    fn rate_and_loss_come_from_arrivals_and_sequence() {
        let start = Instant::now();
        let mut monitor = Monitor::new(Vec::new());
        for n in (0..150u64).filter(|n| n % 10 != 9) {
            let estimate = LoaderEstimate {
                stamp: Stamp {
                    sequence: n,
                    ..Default::default()
                },
                ..Default::default()
            };
            monitor.push(
                &channels::LOADER_CG_UKF,
                &estimate,
                start + Duration::from_millis(10 * n),
            );
        }
        let state = monitor.channels["loader/cg_ukf"];
        assert_eq!(
            (state.count, state.lost),
            (135, 14),
            "the last gap is still open"
        );
        assert!(
            (state.rate() - 90.0).abs() < 2.0,
            "{} Hz of 90",
            state.rate()
        );
    }

    #[test]
    fn a_restarted_process_counts_from_zero() {
        let start = Instant::now();
        let mut monitor = Monitor::new(vec!["sensor".into()]);
        for (second, steps) in [(0, 0), (1, 1000), (2, 2000), (3, 10), (4, 1010)] {
            let health = Health {
                steps,
                ..Default::default()
            };
            monitor.push(
                &channels::HEALTH,
                &health,
                start + Duration::from_secs(second),
            );
        }
        assert!((monitor.processes[&0].rate() - 1000.0).abs() < 1e-9);
        assert_eq!(
            (monitor.name(0), monitor.name(7)),
            ("sensor".into(), "process 7".into())
        );
    }

    #[test]
    fn memory_stays_bounded() {
        let start = Instant::now();
        let mut monitor = Monitor::new(Vec::new());
        for n in 0..10_000 {
            let at = start + Duration::from_millis(100 * n);
            monitor.push(
                &channels::EXCAVATOR_INERTIA_UKF,
                &ExcavatorEstimate::default(),
                at,
            );
        }
        assert_eq!(
            monitor.machines.excavator.estimators["excavator/inertia_ukf"]
                .trend
                .len(),
            TREND
        );
    }
}

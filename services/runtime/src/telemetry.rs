//! Telemetry: from the stepping thread through a lock-free ring to a thread that counts, warns and
//! publishes `health`. The stepping thread never logs, locks or waits.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use hdrhistogram::Histogram;
use messages::channels::HEALTH;
use messages::{Health, State, fault};
use rtrb::{Consumer, Producer, RingBuffer};

use crate::clock::now_ns;
use crate::pulse::{Pulse, Turn};
use crate::{Output, Ports};

/// Number of observation periods whose events the ring holds, and its least and largest length: 0.4 s at 10 kHz.
const RING: (f64, usize, usize) = (1.3, 256, 4096);
const PERIOD: Duration = Duration::from_millis(300);
/// Number of periods without a sample after which one is missed.
const QUIET: u32 = 4;

/// Report of the stepping thread on one sample.
#[derive(Debug, Clone, Copy)]
pub struct Event {
    /// Age of the sample when the answer was published [ns].
    pub age_ns: u64,
    /// Duration of the step alone [ns].
    pub step_ns: u64,
    /// Samples lost before this one.
    pub lost: u64,
    /// Whether the sample came later than one period.
    pub late: bool,
}

/// Samples that are counted without an event of their own.
#[derive(Debug, Clone, Copy, Default)]
struct Unsent {
    steps: u64,
    lost: u64,
    late: u64,
}

/// Identity of this process, for the `health` channel.
#[derive(Debug, Clone, Copy)]
pub struct Identity {
    /// Position in the table of processes.
    pub process: u32,
    /// Restarts before this one.
    pub restarts: u32,
    /// Name, for the log.
    pub name: &'static str,
}

/// End of the stepping thread.
#[derive(Debug)]
pub struct Reporter {
    // Declared first, dropped first: the half that is dropped last frees the buffer, and that
    // must not be the stepping thread.
    events: Producer<(Event, Unsent)>,
    /// Samples that found the ring full, and the number of lost and late ones among them.
    unsent: Unsent,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Shared {
    fault: AtomicU32,
    realtime: AtomicBool,
    turn: Turn,
    /// Whether the run has begun, so that every reader of the run listens.
    has_begun: AtomicBool,
    end: AtomicBool,
    /// Samples that were unsent at the end.
    rest: std::sync::Mutex<Unsent>,
}

impl Reporter {
    /// Starts the telemetry thread, which is silent until [`Reporter::run_begins`]. The calling thread is the stepping
    /// thread, with one sample in every `period_ns`.
    pub fn start(identity: Identity, period_ns: u64) -> Self {
        let (looks, least, most) = RING;
        let events = looks * PERIOD.as_nanos() as f64 / period_ns.max(1) as f64;
        let (events, consumer) = RingBuffer::new((events as usize).clamp(least, most));
        let shared = Arc::new(Shared::default());
        let its = Arc::clone(&shared);
        let pulse = Pulse::of(rustix::thread::gettid());
        let span = tracing::Span::current();
        let thread = std::thread::Builder::new()
            .name("telemetry".into())
            .spawn(move || span.in_scope(|| report(identity, consumer, &its, pulse)))
            .ok();
        Self {
            events,
            unsent: Unsent::default(),
            shared,
            thread,
        }
    }

    /// Reports a sample. If the ring is full its times are dropped, and it is counted with the next one:
    /// telemetry never holds up a step.
    pub fn sample(&mut self, event: Event) {
        match self.events.push((event, self.unsent)) {
            Ok(()) => self.unsent = Unsent::default(),
            Err(_) => {
                self.unsent.steps += 1;
                self.unsent.lost += event.lost;
                self.unsent.late += u64::from(event.late);
            }
        }
    }

    /// Permits the first report. Before, a reader that starts at the same time might miss it.
    pub fn run_begins(&self) {
        self.shared.has_begun.store(true, Ordering::Release);
        if let Some(thread) = &self.thread {
            thread.thread().unpark();
        }
    }

    /// Marks the start of a piece of work, which must end soon.
    pub fn begin(&self) {
        self.shared.turn.begin();
    }

    /// Marks its end.
    pub fn end(&self) {
        self.shared.turn.end();
    }

    /// Reports a fault, by its code.
    pub fn fault(&self, code: u32) {
        self.shared.fault.store(code, Ordering::Relaxed);
    }

    /// Reports whether the real-time class is in force.
    pub fn realtime(&self, fifo: bool) {
        self.shared.realtime.store(fifo, Ordering::Relaxed);
    }
}

impl Drop for Reporter {
    fn drop(&mut self) {
        // The steps are over: a lock delays no step.
        if let Ok(mut rest) = self.shared.rest.lock() {
            *rest = self.unsent;
        }
        self.shared.end.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            let _ = thread.join();
        }
    }
}

/// Counts of one process since its start.
struct Counts {
    health: Health,
    steps: Histogram<u64>,
    ages: Histogram<u64>,
}

impl Counts {
    fn new(identity: Identity) -> Option<Self> {
        // 1 ns to 100 s within 1 %, in 30 kB each; values beyond are counted as 100 s.
        let histogram = || Histogram::new_with_bounds(1, 100_000_000_000, 2).ok();
        let health = Health {
            process: identity.process,
            pid: std::process::id(),
            restarts: identity.restarts,
            ..Health::default()
        };
        Some(Self {
            health,
            steps: histogram()?,
            ages: histogram()?,
        })
    }

    fn add(&mut self, event: Event, unsent: Unsent) {
        self.health.steps += 1;
        self.health.late += u64::from(event.late);
        self.health.lost += event.lost;
        self.add_unsent(unsent);
        self.steps.saturating_record(event.step_ns);
        self.ages.saturating_record(event.age_ns);
    }

    fn add_unsent(&mut self, unsent: Unsent) {
        self.health.steps += unsent.steps;
        self.health.late += unsent.late;
        self.health.lost += unsent.lost;
    }

    fn message(&mut self, sequence: u64) -> Health {
        let health = &mut self.health;
        health.stamp.sequence = sequence;
        health.stamp.measured_ns = now_ns();
        health.stamp.time = health.stamp.measured_ns as f64 * 1e-9;
        health.hops.sensor_ns = health.stamp.measured_ns;
        health.step_p50_ns = self.steps.value_at_quantile(0.5);
        health.step_p99_ns = self.steps.value_at_quantile(0.99);
        health.step_max_ns = self.steps.max();
        health.age_p50_ns = self.ages.value_at_quantile(0.5);
        health.age_p99_ns = self.ages.value_at_quantile(0.99);
        health.age_p999_ns = self.ages.value_at_quantile(0.999);
        health.age_max_ns = self.ages.max();
        *health
    }
}

fn report(
    identity: Identity,
    mut events: Consumer<(Event, Unsent)>,
    shared: &Shared,
    mut pulse: Pulse,
) {
    let Some(mut counts) = Counts::new(identity) else {
        return;
    };
    let mut output = open(identity);
    while !shared.has_begun.load(Ordering::Acquire) && !shared.end.load(Ordering::Acquire) {
        std::thread::park();
    }
    let mut quiet = 0;
    for sequence in 0.. {
        let ending = shared.end.load(Ordering::Acquire);
        let before = (counts.health.steps, counts.health.lost);
        while let Ok((event, unsent)) = events.pop() {
            counts.add(event, unsent);
        }
        if let Some(rest) = shared.rest.lock().ok().filter(|_| ending) {
            counts.add_unsent(*rest);
        }
        quiet = if counts.health.steps == before.0 {
            quiet + 1
        } else {
            0
        };
        let lost = counts.health.lost - before.1;
        if lost > 0 {
            counts.health.fault = fault::LOST;
            tracing::warn!(lost, "samples lost before this process");
        }
        if quiet == QUIET && counts.health.steps > 0 && !ending {
            counts.health.fault = fault::DEADLINE;
            tracing::warn!("no sample for a second");
        }
        match shared.fault.swap(fault::NONE, Ordering::Relaxed) {
            fault::NONE => {}
            code => counts.health.fault = code,
        }
        counts.health.realtime = u32::from(shared.realtime.load(Ordering::Relaxed));
        let state = if pulse.hangs(&shared.turn) {
            State::Hanging
        } else {
            state(ending, quiet, counts.health.steps)
        };
        counts.health.state = state as u32;
        if let Some(output) = &mut output {
            output.send(&counts.message(sequence));
            output.notify();
        }
        if ending {
            break;
        }
        rest(&shared.end);
    }
}

/// Sleeps for a period or until the end. Other wake-ups do not shorten the period: two observations in immediate succession
/// would find every thread at the same piece of work.
fn rest(end: &AtomicBool) {
    let due = Instant::now() + PERIOD;
    loop {
        let left = due.saturating_duration_since(Instant::now());
        if left.is_zero() || end.load(Ordering::Acquire) {
            return;
        }
        std::thread::park_timeout(left);
    }
}

fn open(identity: Identity) -> Option<Output<Health>> {
    let opened = Ports::new(identity.name).and_then(|ports| ports.output::<Health>(&HEALTH));
    opened
        .inspect_err(|error| {
            tracing::warn!(%error, "health is not published");
        })
        .ok()
}

fn state(ending: bool, quiet: u32, steps: u64) -> State {
    match (ending, quiet, steps) {
        (true, _, _) => State::Ended,
        (_, _, 0) => State::Starting,
        (_, 0..QUIET, _) => State::Running,
        _ => State::Waiting,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_looks_are_a_period_apart_though_somebody_woke_the_thread_before() {
        std::thread::current().unpark();
        let begun = Instant::now();
        rest(&AtomicBool::new(false));
        assert!(begun.elapsed() >= PERIOD);
    }
}

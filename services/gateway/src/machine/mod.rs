//! The gateway: a process beside a pipeline that reads its channels, as the logger does, and sends a selection.
//!
//! Three threads. The first drains the channels on a timer and pushes the selection into a bounded queue. The second passes it to
//! Zenoh, and the third answers requests from the recording. No estimator waits for any of them: what does not fit the queue is
//! counted, and requested later.

mod full;
mod plan;
mod publish;
mod samples;
mod store;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use messages::Message;
use messages::channels::Channel;
use rtrb::{Producer, RingBuffer};
use runtime::{Cleaner, Domain, Ports, Sink, Taps};

use crate::downsample::{Downsampler, Selection, StreamInfo};
use crate::key::MachineId;
use crate::link::LinkArgs;
use crate::{Failure, error, wall_ms};
pub use full::LONGEST;
pub use plan::Plan;
pub use publish::{publisher, publishes};

/// Messages that may wait for Zenoh: ten minutes of a machine.
const QUEUE: usize = 8192;
/// Longest time between two visits to the channels, and most samples between them.
const VISIT: Duration = Duration::from_millis(100);
const VISIT_SAMPLES: f64 = 128.0;
/// Period of the check whether the run goes on.
const LOOK: Duration = Duration::from_secs(1);

/// What a gateway is given.
#[derive(Debug, Clone, clap::Args)]
pub struct GatewayArgs {
    /// The domain of the run
    #[arg(long)]
    pub domain: String,
    /// The router
    #[command(flatten)]
    pub link: LinkArgs,
    /// The site
    #[arg(long)]
    pub site: String,
    /// Name of the machine, one of its own within the site
    #[arg(long)]
    pub machine_id: String,
    /// Estimates a second, beside those at which the verdict changes
    #[arg(long, default_value_t = 1.0, value_name = "HZ")]
    pub rate: f64,
    /// Send every sample of the sensors too, for a site that estimates by itself
    #[arg(long)]
    pub samples: bool,
    /// For how many seconds a run that is over goes on answering for what did not arrive
    #[arg(long, default_value_t = 20.0, value_name = "TIME", value_parser = view::duration::seconds)]
    pub linger: f64,
}

/// State shared by the threads.
#[derive(Debug)]
struct Shared {
    id: MachineId,
    plan: Plan,
    hz: f64,
    wall_offset_ns: i64,
    streams: Vec<StreamInfo>,
    heads: Vec<AtomicI64>,
    /// Number up to which losses were counted, by stream.
    counted: Vec<AtomicI64>,
    since_ms: u64,
    overwritten: AtomicU64,
    dropped: AtomicU64,
    sent: AtomicU64,
    served: AtomicU64,
    lost: AtomicU64,
    samples_sent: AtomicU64,
    /// Samples that were not handed to Zenoh.
    samples_lost: AtomicU64,
    /// The run is over: no further messages follow.
    over: AtomicBool,
    /// The run was killed or failed: its supervisor is gone, or gave up.
    broke_off: AtomicBool,
    leave: AtomicBool,
    /// End of a request for all samples [ns of the monotonic clock].
    full_until: AtomicU64,
}

impl Shared {
    fn new(id: MachineId, plan: Plan, hz: f64, streams: Vec<StreamInfo>) -> Self {
        let none = || streams.iter().map(|_| AtomicI64::new(-1)).collect();
        Self {
            id,
            hz,
            wall_offset_ns: wall_ms() as i64 * 1_000_000 - runtime::now_ns() as i64,
            heads: none(),
            counted: none(),
            streams,
            since_ms: wall_ms(),
            overwritten: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
            sent: AtomicU64::new(0),
            served: AtomicU64::new(0),
            lost: AtomicU64::new(0),
            samples_sent: AtomicU64::new(0),
            samples_lost: AtomicU64::new(0),
            over: AtomicBool::new(false),
            broke_off: AtomicBool::new(false),
            leave: AtomicBool::new(false),
            full_until: AtomicU64::new(0),
            plan,
        }
    }

    /// The wall clock at a time of the monotonic clock [ms since 1970].
    fn wall_ms(&self, measured_ns: u64) -> u64 {
        let wall = (measured_ns as i64).saturating_add(self.wall_offset_ns);
        wall.max(0) as u64 / 1_000_000
    }

    fn downsampler(&self) -> Downsampler {
        let machine = &self.id.machine;
        let run = self.plan.run;
        Downsampler::new(
            self.streams.clone(),
            machine,
            run,
            self.hz,
            self.wall_offset_ns,
        )
    }
}

/// Runs the gateway of a run until the run ends, or `stop` is set. `gave_up`: the supervisor reports that the run failed.
///
/// # Errors
/// There is no such run, or an argument cannot be used.
pub fn run(args: &GatewayArgs, stop: &AtomicBool, gave_up: &AtomicBool) -> Result<(), Failure> {
    let id = machine_id(args)?;
    // Shared memory may have room again at the next start.
    let passing = |e: runtime::Error| Failure::passing(e.to_string());
    let domain = Domain::new(&args.domain).map_err(passing)?;
    let plan = Plan::read(&domain)?;
    domain.enter().map_err(passing)?;
    let ports = Ports::new("gateway").map_err(passing)?;
    let streams = crate::downsample::streams(plan.pipeline()?, plan.rate, args.rate);
    let sensors = args.samples.then(|| plan.sensors()).transpose()?;
    let channels = channels(&streams, sensors);
    let shared = Arc::new(Shared::new(id, plan, args.rate, streams));
    // Frees the channel slots that a killed gateway held.
    if !Cleaner::start().is_ok_and(|mut cleaner| cleaner.clean_up(Duration::from_secs(1))) {
        tracing::warn!("what the dead held in the channels is not free yet");
    }
    // The channels come first: messages wait in the queue while Zenoh connects.
    let mut taps = Taps::open(&ports, &channels).map_err(passing)?;
    let (mut reader, waiting) = Reader::new(&shared, sensors);
    let publisher = publish::start(args.link.clone(), Arc::clone(&shared), waiting, sensors);
    let is_over = || stop.load(Ordering::Relaxed) || publisher.is_finished();
    let is_finished = read(&domain, &mut taps, &mut reader, is_over);
    drop((taps, ports));
    // If this gateway ends first, it does not report an end of the run.
    if !is_over() {
        let is_in_order = is_finished && !gave_up.load(Ordering::Relaxed);
        shared.broke_off.store(!is_in_order, Ordering::Relaxed);
        shared.over.store(true, Ordering::Release);
    }
    let over = Instant::now();
    while !is_over() && over.elapsed().as_secs_f64() < args.linger {
        std::thread::sleep(VISIT);
    }
    shared.leave.store(true, Ordering::Relaxed);
    let published = publisher.join().map_err(|_| {
        Failure::passing(error(
            "a thread of the gateway failed",
            "heft-gateway",
            "please report this",
        ))
    })?;
    Ok(published?)
}

/// Checks the name of the machine and the rate.
fn machine_id(args: &GatewayArgs) -> Result<MachineId, String> {
    let id = MachineId::new(&args.site, &args.machine_id).ok_or_else(|| {
        error(
            format!(
                "`{}` and `{}` cannot name a site and a machine",
                args.site, args.machine_id
            ),
            "--site, --machine-id",
            "use 1 to 64 letters, digits, dots, hyphens and underscores",
        )
    })?;
    if !(0.01..=1000.0).contains(&args.rate) {
        return Err(error(
            format!("{} estimates a second", args.rate),
            "--rate",
            "0.01 to 1000",
        ));
    }
    Ok(id)
}

/// The channels of the streams, each once, then that of the sensors.
fn channels(streams: &[StreamInfo], sensors: Option<&'static Channel>) -> Vec<&'static Channel> {
    let mut channels: Vec<&'static Channel> = Vec::new();
    for stream in streams {
        if !channels.iter().any(|c| c.name == stream.channel.name) {
            channels.push(stream.channel);
        }
    }
    channels.extend(sensors);
    channels
}

/// Reads the channels until the run is over; returns whether its supervisor has finished it.
fn read(
    domain: &Domain,
    taps: &mut Taps<Reader>,
    reader: &mut Reader,
    is_over: impl Fn() -> bool,
) -> bool {
    let shared = Arc::clone(&reader.shared);
    let visit = Duration::from_secs_f64(VISIT_SAMPLES / shared.plan.rate.max(1.0));
    let visit = VISIT.min(visit);
    let mut looked = Instant::now();
    loop {
        let is_due = looked.elapsed() >= LOOK;
        if is_due {
            looked = Instant::now();
        }
        // Checked before the channels are read, so that messages sent between the last visit and the end are read too. A domain
        // that is not alive belongs to a killed supervisor; a supervisor that finishes its run removes the plan first.
        let is_dead = is_due && !domain.is_alive();
        let is_finished = !domain.plan_file().exists();
        let goes_on = !is_over() && !is_finished && !is_dead;
        let lost = taps.drain(reader).lost;
        shared.overwritten.fetch_add(lost, Ordering::Relaxed);
        for (i, head) in shared.heads.iter().enumerate() {
            head.store(reader.downsampler.head(i), Ordering::Relaxed);
        }
        if !goes_on {
            return is_finished;
        }
        std::thread::sleep(visit);
    }
}

/// Takes the messages of the channels.
struct Reader {
    downsampler: Downsampler,
    queue: Producer<Selection>,
    full: Producer<full::Sample>,
    /// The channel whose samples are all sent.
    sensors: Option<&'static Channel>,
    samples: Producer<samples::Sample>,
    shared: Arc<Shared>,
}

impl Reader {
    /// The reader, and the consumers of its queues.
    fn new(shared: &Arc<Shared>, sensors: Option<&'static Channel>) -> (Self, publish::Outbox) {
        let (queue, selected) = RingBuffer::new(QUEUE);
        let (full, full_waiting) = RingBuffer::new(full::QUEUE);
        let (samples, samples_waiting) = RingBuffer::new(samples::QUEUE);
        let reader = Self {
            downsampler: shared.downsampler(),
            queue,
            full,
            sensors,
            samples,
            shared: Arc::clone(shared),
        };
        let waiting = publish::Outbox {
            selected,
            full: full_waiting,
            samples: samples_waiting,
        };
        (reader, waiting)
    }
}

impl Sink for Reader {
    fn accept<M: Message>(&mut self, channel: &'static Channel, message: &M) {
        if self.sensors.is_some_and(|s| s.name == channel.name) {
            // A sample that does not fit shows as a gap in the numbers.
            let _ = self.samples.push(samples::Sample::of(message));
            return;
        }
        let (queue, shared) = (&mut self.queue, &self.shared);
        self.downsampler.take(channel, message, &mut |selected| {
            if queue.push(selected).is_err() {
                shared.dropped.fetch_add(1, Ordering::Relaxed);
            }
        });
        if self.shared.full_until.load(Ordering::Relaxed) > runtime::now_ns() {
            full::push(&mut self.full, channel, message);
        }
    }
}

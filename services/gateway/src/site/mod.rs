//! `heft fleet serve`: estimates at the site, from the unmodified samples of machines.
//!
//! ```text
//! heft/v1/SITE/MACHINE/sample/CHANNEL ──▶ checks ──▶ `heft serve KIND --messages` ──▶ heft/v1/SITE/MACHINE/site/CHANNEL
//! ```
//! `heft serve` is a separate process, which shares the machines among processes, one a core, and replaces one that dies. Its
//! name for a machine is the machine's name with the id of the run, so that a new run begins without a state. A sample is passed
//! on at most once. A lost one is counted here, the estimators see the missing time, and the label of the first estimate after
//! the gap states it. An estimate is sent once, and again on request: `kept`.

mod answers;
mod child;
mod intake;
mod kept;
mod machine;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

use messages::Machine;
use messages::channels::Channel;
use steps::stages::Pipeline;
use zenoh::Wait;

use crate::key::{MachineId, ROOT, SITE_ESTIMATE};
use crate::link::{LinkArgs, client_unless};
use crate::{Failure, error};
use answers::Answers;
use intake::Intake;
use kept::Kept;

/// Batches of samples that may wait for `heft serve`.
const QUEUE: usize = 4096;
/// Period of the printed counts.
const LOOK: Duration = Duration::from_secs(10);

/// `heft fleet serve`
#[derive(Debug, Clone, clap::Args)]
pub struct ServeArgs {
    /// The kind of the machines: excavator, loader
    pub kind: String,
    /// The router
    #[command(flatten)]
    pub link: LinkArgs,
    /// The site whose machines are served
    #[arg(long)]
    pub site: String,
    /// Method; the headline one if absent
    #[arg(long)]
    pub method: Option<String>,
    /// At most one estimate per machine in this time of its clock, such as 1 (s) or 500ms; every one if 0
    #[arg(long, value_name = "TIME", default_value_t = 1.0, value_parser = view::duration::seconds)]
    pub every: f64,
    /// The program heft; beside this one, or in the search path, if absent
    #[arg(long, value_name = "FILE")]
    pub heft: Option<PathBuf>,
    /// What else `heft serve` is given, such as --config FILE, --shards N
    #[arg(last = true)]
    pub rest: Vec<String>,
}

/// The channel that is read, and the channel of its estimates.
struct Channels {
    sensors: &'static Channel,
    estimate: &'static Channel,
}

impl Channels {
    fn of(args: &ServeArgs) -> Result<Self, String> {
        let kinds = Machine::ALL.map(|m| m.name()).join(", ");
        let machine = Machine::from_name(&args.kind).ok_or_else(|| {
            let what = format!("there is no machine `{}`", args.kind);
            error(what, "heft fleet serve", format!("choose one of {kinds}"))
        })?;
        let pipeline = Pipeline::of(machine);
        let stage = match &args.method {
            Some(method) => pipeline.with_method(method),
            None => pipeline.stage(pipeline.main),
        };
        let estimate = stage.and_then(|s| s.output()).ok_or_else(|| {
            let what = format!(
                "there is no method `{}`",
                args.method.clone().unwrap_or_default()
            );
            error(what, "--method", "`heft serve --help` names them")
        })?;
        let sensors = pipeline
            .sensors()
            .ok_or_else(|| error("it has no sensors", &args.kind, "report this"))?;
        Ok(Self { sensors, estimate })
    }
}

/// Serves until `stop` is set.
///
/// # Errors
/// An argument cannot be used, or `heft serve` ends by itself.
pub fn serve(args: &ServeArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let channels = Channels::of(args)?;
    if MachineId::new(&args.site, "any").is_none() {
        let remedy = "use 1 to 64 letters, digits, dots, hyphens and underscores";
        return Err(error("this cannot name a site", "--site", remedy).into());
    }
    let (mut child, input, output) = child::start(args)?;
    let stops = || stop.load(Ordering::Relaxed);
    let publishes = format!("{ROOT}/{}/*/{SITE_ESTIMATE}/*", args.site);
    let Some(session) = client_unless(&args.link, &[&publishes], stops)? else {
        return child::end(child);
    };
    let failed = |e: zenoh::Error| {
        let what = format!("Zenoh refuses: {e}");
        error(what, &args.link.connect, "please report this")
    };
    let (batches, waiting) = sync_channel(QUEUE);
    let intake = Arc::new(Intake::new(channels.sensors, batches));
    let key = format!("{ROOT}/{}/*/sample/{}", args.site, channels.sensors.name);
    let its = Arc::clone(&intake);
    let subscriber = session.declare_subscriber(key);
    let subscriber = subscriber.callback(move |sample| its.batch(&sample)).wait();
    let subscriber = subscriber.map_err(failed)?;
    let writer = std::thread::spawn(move || child::feed(input, &waiting));
    let (stream, kept) = (
        answers::stream(channels.estimate),
        Arc::new(Kept::default()),
    );
    let questions = kept::declare(&session, &args.site, &stream, &kept).map_err(failed)?;
    let its = (Arc::clone(&intake), Arc::clone(&kept));
    let answers = Answers::new(&session, &args.site, channels.estimate, its.0, its.1);
    let reader = std::thread::spawn(move || answers.publish(output));
    let mut looked = Instant::now();
    while !stops() && !reader.is_finished() && !writer.is_finished() {
        std::thread::sleep(Duration::from_millis(100));
        answers::say_again(&session, &args.site, &stream, &kept);
        if looked.elapsed() >= LOOK {
            looked = Instant::now();
            intake.forget_silent();
            intake.tell();
        }
    }
    // No further samples enter; those in `heft serve` are still answered.
    let has_ended = !stops() && child.try_wait().is_ok_and(|ended| ended.is_some());
    let _ = subscriber.undeclare().wait();
    intake.close();
    let joined = (writer.join(), reader.join());
    intake.tell();
    for line in intake.losses() {
        eprintln!("{line}");
    }
    drop(questions);
    let _ = session.close().wait();
    child::end(child)?;
    let remedy = "see what it said above; start `heft fleet serve` again";
    let failed = |what| Failure::passing(error(what, "heft fleet serve", remedy));
    match joined {
        (Ok(()), Ok(Ok(()))) if has_ended => Err(failed("`heft serve` has ended")),
        (Ok(()), Ok(Ok(()))) => Ok(()),
        (Ok(()), Ok(Err(why))) => Err(Failure::passing(why)),
        _ => Err(failed("a thread failed")),
    }
}

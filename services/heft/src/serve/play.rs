//! Many machines in one run: simulated ones with consecutive seeds, or one for each recording. One thread per shard sends the
//! samples of its machines in the order of their times.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use checks::Look;
use config::Description;
use recording::Sensors;

use super::remote::RemoteShard;
use super::rows::{Member, Rows};
use super::{Findings, Served, Suspects, frames, with_shards};
use crate::failure::Failure;
use crate::plan::Plan;
use crate::signals::Signals;
use crate::sources::{self, AnySource};

/// Longest single sleep: bounds the delay of a signal that ends the run.
const NAP: Duration = Duration::from_millis(100);

/// The machines of a run.
pub struct Machines<'a> {
    /// Plan that all machines share.
    pub plan: &'a Plan,
    /// Description of each machine.
    pub description: &'a Description,
    /// The recording of each machine; empty if they are simulated.
    pub inputs: Vec<PathBuf>,
    /// Number of machines.
    pub count: usize,
}

impl Machines<'_> {
    /// The plan of one machine.
    pub fn plan(&self, number: usize) -> Plan {
        Plan {
            seed: self.plan.seed.wrapping_add(number as u64),
            input: self.inputs.get(number).cloned(),
            ..self.plan.clone()
        }
    }

    /// Name of one machine: its recording, or the seed that reproduces it in a run of its own.
    fn name(&self, number: usize) -> String {
        match self.inputs.get(number) {
            Some(input) => input.display().to_string(),
            None => self.plan.seed.wrapping_add(number as u64).to_string(),
        }
    }
}

/// Result of a run.
pub struct Played {
    /// The machines, in their order.
    pub members: Vec<Member>,
    /// Number of samples sent to shards.
    pub samples: u64,
    /// Number of samples sent more than one period after they were due.
    pub late: u64,
    /// Totals over all shards.
    pub served: Served,
    /// Findings on the samples of recordings.
    pub findings: Findings,
    /// Processor time of this process: sources and sending.
    pub own: Duration,
    /// Duration of the run.
    pub took: Duration,
}

/// Plays the machines to shards started with these arguments, until their sources end or the user stops the run.
pub fn play<L: Look + Send>(
    machines: &Machines,
    make: impl Fn(&Plan) -> Result<AnySource<L::Sensors>, Failure> + Sync,
    rows: Rows,
    shards: usize,
    arguments: &[OsString],
    signals: &Signals,
) -> Result<Played, Failure> {
    let (begun, before) = (Instant::now(), runtime::processor_time());
    (0..machines.count).for_each(|n| rows.add(&machines.name(n)));
    let failed = AtomicBool::new(false);
    let map = sources::map(machines.plan.map.as_deref())?;
    let feed = |first: usize, shard: &RemoteShard| {
        let stops = || signals.came() || failed.load(Ordering::Relaxed);
        let numbers = (first..machines.count).step_by(shards);
        // Creating a source takes milliseconds, and all of them up to a minute: a stop must take effect in between.
        let players = numbers.take_while(|_| !stops());
        let players = players.map(|n| {
            make(&machines.plan(n)).map(|source| Player::new(n, machines.name(n), source))
        });
        let players = players.collect::<Result<Vec<_>, _>>();
        failed.fetch_or(players.is_err(), Ordering::Relaxed);
        let suspects = Suspects::<L>::new(machines.description, map.as_ref());
        let suspects = (!machines.inputs.is_empty()).then_some(suspects);
        Ok(Feed::new(machines.plan, shard, players?, suspects).run(stops))
    };
    let (fed, served) = with_shards(shards, arguments, &rows, |all| {
        std::thread::scope(|scope| {
            let threads = all.iter().enumerate();
            let threads = threads.map(|(first, shard)| {
                let thread = std::thread::Builder::new();
                let begun = thread.spawn_scoped(scope, move || feed(first, shard));
                failed.fetch_or(begun.is_err(), Ordering::Relaxed);
                begun.map_err(Failure::thread)
            });
            let threads = threads.collect::<Result<Vec<_>, _>>()?;
            let ended = threads.into_iter().map(|thread| {
                let ended = thread.join();
                ended.map_err(|_| Failure::internal("a source panicked"))?
            });
            ended.collect::<Result<Vec<Fed<L>>, Failure>>()
        })
    })?;
    let members = rows.finish()?;
    let (mut samples, mut late, mut findings) = (0, 0, Findings::default());
    for fed in fed {
        (samples, late) = (samples + fed.samples, late + fed.late);
        if let Some(suspects) = fed.suspects {
            findings.merge(suspects.finish(&members));
        }
    }
    Ok(Played {
        members: members.into_values().collect(),
        samples,
        late,
        served,
        findings,
        own: runtime::processor_time().saturating_sub(before),
        took: begun.elapsed(),
    })
}

/// A machine and its next sample.
struct Player<S: Sensors> {
    number: u32,
    name: String,
    source: AnySource<S>,
    /// Time of its first sample \[s\].
    origin: Option<f64>,
    sample: S,
}

impl<S: Sensors> Player<S> {
    fn new(number: usize, name: String, source: AnySource<S>) -> Self {
        Self {
            number: number as u32,
            name,
            source,
            origin: None,
            sample: S::default(),
        }
    }

    /// Takes the next sample. Returns when it is due, relative to the first one.
    fn advance(&mut self) -> Option<Duration> {
        let (mut sample, _) = self.source.next()?;
        sample.stamp_mut().machine = self.number;
        let time = sample.stamp().time;
        let since = time - *self.origin.get_or_insert(time);
        self.sample = sample;
        // A sample with a time before the first one is due at once.
        Some(Duration::try_from_secs_f64(since).unwrap_or_default())
    }
}

/// Sends the samples of some machines to their shard.
struct Feed<'a, 'b, L: Look> {
    shard: &'a RemoteShard<'a>,
    players: Vec<Player<L::Sensors>>,
    /// Time and index of the next sample of each player, the earliest first.
    turns: BinaryHeap<Reverse<(Duration, usize)>>,
    /// Sampling period; none if the samples are sent without waiting for the clock.
    period: Option<Duration>,
    /// Checks of the machines of recordings; none if they are simulated.
    suspects: Option<Suspects<'b, L>>,
}

/// Number of samples that a feed sent, and of those among them that were late.
struct Fed<'a, L: Look> {
    samples: u64,
    late: u64,
    suspects: Option<Suspects<'a, L>>,
}

impl<'a, 'b, L: Look> Feed<'a, 'b, L> {
    fn new(
        plan: &Plan,
        shard: &'a RemoteShard<'a>,
        mut players: Vec<Player<L::Sensors>>,
        suspects: Option<Suspects<'b, L>>,
    ) -> Self {
        let turns = players.iter_mut().enumerate();
        let turns = turns.filter_map(|(at, player)| Some(Reverse((player.advance()?, at))));
        Self {
            shard,
            turns: turns.collect(),
            players,
            period: (!plan.lossless).then(|| Duration::from_secs_f64(1.0 / plan.rate)),
            suspects,
        }
    }

    /// Sends all samples at their times.
    fn run(mut self, stops: impl Fn() -> bool) -> Fed<'b, L> {
        let begun = Instant::now();
        let (mut samples, mut late, mut bytes) = (0, 0, Vec::new());
        let stops = || stops() || self.shard.failure().is_some();
        while let Some(Reverse((due, at))) = self.turns.pop() {
            while self.period.is_some() && begun.elapsed() < due && !stops() {
                self.shard.flush();
                std::thread::sleep(due.saturating_sub(begun.elapsed()).min(NAP));
            }
            if stops() {
                break;
            }
            let player = &mut self.players[at];
            if let Some(suspects) = &mut self.suspects {
                suspects.see(player.number, &player.name, &player.sample);
            }
            frames::pack(&player.sample, &mut bytes);
            self.shard.send(player.number, &bytes);
            samples += 1;
            let is_late = self.period.is_some_and(|p| begun.elapsed() > due + p);
            late += u64::from(is_late);
            self.turns
                .extend(player.advance().map(|due| Reverse((due, at))));
        }
        self.shard.flush();
        Fed {
            samples,
            late,
            suspects: self.suspects,
        }
    }
}

//! Checks of samples before they go to `heft serve`: size, rate, that they belong to the machine in their key, that their numbers
//! increase. A hostile machine can falsify only its own data, at a limited rate.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::mpsc::{SyncSender, TrySendError};
use std::time::{Duration, Instant};

use messages::channels::{Channel, Visitor};
use messages::{Message, Stamp, Value};
use recording::payload::{decode, take_delimited};
use zenoh::sample::Sample;

use super::machine::{Counts, Machine, One, forget, name};
use crate::key::MachineId;
use crate::label::Label;
use crate::{MACHINES, lock};

/// Largest message [bytes]: above the size that a gateway sends.
const LARGEST: usize = 80_000;
/// Silence after which a machine is forgotten.
const SILENT: Duration = Duration::from_secs(600);

/// Properties of an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Answered {
    /// Time of measurement, by the machine's wall clock [ms since 1970].
    pub wall_ms: u64,
    /// Whether samples are missing between the estimate before and this one.
    pub is_after_gap: bool,
}

/// Checks messages and passes them on.
pub struct Intake {
    channel: &'static Channel,
    batches: Mutex<Option<SyncSender<Vec<u8>>>>,
    machines: Mutex<BTreeMap<String, Machine>>,
}

impl Intake {
    pub(super) fn new(channel: &'static Channel, batches: SyncSender<Vec<u8>>) -> Self {
        Self {
            channel,
            batches: Mutex::new(Some(batches)),
            machines: Mutex::default(),
        }
    }

    /// Takes a message under a machine's key.
    pub(super) fn batch(&self, sample: &Sample) {
        let Some((id, _)) = MachineId::of(sample.key_expr().as_str()) else {
            return;
        };
        let attachment = sample.attachment().map(|a| a.to_bytes());
        let label = attachment.and_then(|a| Label::parse(&a));
        // A message that is too large is not even copied.
        let payload = (sample.payload().len() <= LARGEST).then(|| sample.payload().to_bytes());
        self.take(&id, label, payload.as_deref());
    }

    fn take(&self, id: &MachineId, label: Option<Label>, payload: Option<&[u8]>) {
        let label = label.filter(|l| l.machine == id.machine);
        let samples = payload.and_then(|p| samples(self.channel, p));
        let mut machines = lock(&self.machines);
        if machines.len() >= MACHINES && !machines.contains_key(&id.machine) {
            return;
        }
        let now = Instant::now();
        let machine = machines.entry(id.machine.clone());
        let machine = machine.or_insert_with(|| Machine::new(now));
        let (Some(label), Some(samples)) = (label, samples) else {
            machine.counts.refused += 1;
            return;
        };
        let mut records = Vec::with_capacity(payload.map_or(0, <[u8]>::len) * 2);
        let Some(count) = machine.admit(now, &label, &samples, &mut records) else {
            machine.counts.refused += 1;
            return;
        };
        let sent = lock(&self.batches).as_ref().map(|b| b.try_send(records));
        match sent {
            Some(Ok(())) => machine.counts.samples += count,
            Some(Err(TrySendError::Full(_))) => {
                machine.counts.late += count;
                machine.cut(label.run);
            }
            Some(Err(TrySendError::Disconnected(_))) | None => {}
        }
    }

    /// Notes an estimate; `None` for an unknown run, or one that is over.
    pub(super) fn answered(&self, machine: &str, run: u64, stamp: &Stamp) -> Option<Answered> {
        let mut machines = lock(&self.machines);
        let machine = machines.get_mut(machine)?;
        let run = machine.runs.iter_mut().find(|r| r.id == run)?;
        let is_after_gap = run.passes_gap(i64::try_from(stamp.sequence).ok()?);
        let measured_ms = i64::try_from(stamp.measured_ns / 1_000_000).ok()?;
        let wall_ms = measured_ms.saturating_add(run.wall_offset_ms);
        machine.counts.estimates += 1;
        Some(Answered {
            wall_ms: u64::try_from(wall_ms).unwrap_or(0),
            is_after_gap,
        })
    }

    /// Whether a machine is known.
    pub(super) fn knows(&self, machine: &str) -> bool {
        lock(&self.machines).contains_key(machine)
    }

    /// Forgets machines that have been silent for long.
    pub(super) fn forget_silent(&self) {
        let mut gone = Vec::new();
        lock(&self.machines).retain(|machine, m| {
            let stays = m.heard.elapsed() < SILENT;
            if !stays {
                for run in &m.runs {
                    forget(&name(machine, run.id), &mut gone);
                }
            }
            stays
        });
        if let Some(batches) = &*lock(&self.batches)
            && !gone.is_empty()
        {
            // If it does not fit, `heft serve` retains their states.
            let _ = batches.try_send(gone);
        }
    }

    /// Ends the input of `heft serve`.
    pub(super) fn close(&self) {
        lock(&self.batches).take();
    }

    /// Prints the sums of the counts over all machines.
    pub(super) fn tell(&self) {
        let machines = lock(&self.machines);
        let sum = |of: fn(&Counts) -> u64| {
            let counts = machines.values().map(|m| of(&m.counts));
            counts.fold(0, u64::saturating_add)
        };
        eprintln!(
            "serve: {} machines, {} samples, {} estimates; {} samples missing, {} too late for `heft serve`, {} messages refused",
            machines.len(),
            sum(|c| c.samples),
            sum(|c| c.estimates),
            sum(|c| c.missing),
            sum(|c| c.late),
            sum(|c| c.refused)
        );
    }

    /// A line for each machine of which something was lost or refused.
    pub(super) fn losses(&self) -> Vec<String> {
        let machines = lock(&self.machines);
        let some = machines.iter().filter(|(_, m)| {
            let c = m.counts;
            c.missing > 0 || c.late > 0 || c.refused > 0
        });
        let line = |(name, m): (&String, &Machine)| {
            let c = m.counts;
            format!(
                "serve: {name}: {} samples, {} missing, {} too late, {} messages refused",
                c.samples, c.missing, c.late, c.refused
            )
        };
        some.map(line).collect()
    }
}

/// The samples of a message, if all of it decodes as the channel's type and every number is finite.
fn samples<'a>(channel: &Channel, mut payload: &'a [u8]) -> Option<Vec<One<'a>>> {
    struct Look<'a>(&'a [u8]);
    impl<'a> Visitor for Look<'a> {
        type Output = Option<One<'a>>;
        fn visit<M: Message>(self) -> Self::Output {
            let message = decode::<M>(self.0)?;
            let is_number = |i| !matches!(message.get(i), Some(Value::F64(x)) if !x.is_finite());
            let stamp = message.stamp();
            i64::try_from(stamp.sequence).ok()?;
            (0..M::FIELDS.len()).all(is_number).then_some(One {
                number: stamp.sequence,
                measured_ns: stamp.measured_ns,
                bytes: self.0,
            })
        }
    }
    let mut found = Vec::new();
    while !payload.is_empty() {
        let bytes = take_delimited(&mut payload).filter(|b| !b.is_empty())?;
        found.push(channel.payload.visit(Look(bytes))?);
    }
    (!found.is_empty()).then_some(found)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, sync_channel};

    use messages::ExcavatorSensors;
    use messages::channels::EXCAVATOR_SENSORS;
    use recording::payload::put_delimited;

    use super::super::machine::{RUNS, run_of};
    use super::*;

    fn intake() -> (Intake, Receiver<Vec<u8>>) {
        let (batches, waiting) = sync_channel(1000);
        (Intake::new(&EXCAVATOR_SENSORS, batches), waiting)
    }

    fn batch(numbers: impl IntoIterator<Item = u64>, velocity: f64) -> Vec<u8> {
        let mut batch = Vec::new();
        for number in numbers {
            let mut sample = ExcavatorSensors {
                swing_velocity: velocity,
                valid: 1,
                columns: 1,
                ..ExcavatorSensors::default()
            };
            sample.stamp.sequence = number;
            let mut bytes = Vec::new();
            recording::payload::encode(&sample, &mut bytes);
            put_delimited(&bytes, &mut batch);
        }
        batch
    }

    fn label(machine: &str, run: u64) -> Option<Label> {
        Label::parse(format!("{machine} {run} 9 -1 5").as_bytes())
    }

    fn id() -> MachineId {
        MachineId::new("north", "ex-1").expect("names")
    }

    /// Names of the runs in records, in order; with a minus where a run is forgotten.
    fn names(records: &[u8]) -> Vec<String> {
        let (mut rest, mut names) = (records, Vec::new());
        while !rest.is_empty() {
            let name = take_delimited(&mut rest).expect("a name");
            let is_empty = take_delimited(&mut rest).expect("a message").is_empty();
            let sign = if is_empty { "-" } else { "" };
            names.push(format!("{sign}{}", String::from_utf8_lossy(name)));
        }
        names
    }

    #[test]
    fn samples_go_on_once_and_what_is_missing_between_them_is_counted() {
        let (intake, waiting) = intake();
        for numbers in [4..7, 5..9, 12..13] {
            intake.take(&id(), label("ex-1", 1), Some(&batch(numbers, 0.1)));
        }
        let all: Vec<_> = waiting.try_iter().map(|r| names(&r).len()).collect();
        assert_eq!(all, [3, 2, 1]);
        let counts = lock(&intake.machines)["ex-1"].counts;
        assert_eq!((counts.samples, counts.missing), (6, 3));
        assert_eq!(intake.losses().len(), 1);
    }

    #[test]
    fn runs_are_apart_and_none_ends_another() {
        let (intake, waiting) = intake();
        let take =
            |run, numbers| intake.take(&id(), label("ex-1", run), Some(&batch(numbers, 0.1)));
        // The ids carry no order, and a forged one in between changes nothing.
        take(7, 0..1);
        take(2, 0..1);
        let counts = || lock(&intake.machines)["ex-1"].counts;
        assert_eq!(counts().refused, 1, "so soon");
        std::thread::sleep(RUNS);
        take(2, 0..1);
        take(7, 1..2);
        take(2, 1..2);
        assert_eq!((counts().refused, counts().missing), (1, 0));
        let all: Vec<_> = waiting.try_iter().flat_map(|r| names(&r)).collect();
        assert_eq!(all, ["ex-1 7", "ex-1 2", "ex-1 7", "ex-1 2"]);
        assert_eq!(run_of("ex-1 2"), Some(("ex-1", 2)));
        let stamp = Stamp {
            measured_ns: 3_000_000,
            ..Stamp::default()
        };
        assert_eq!(intake.answered("ex-1", 1, &stamp), None);
        let wall_ms = intake.answered("ex-1", 2, &stamp).map(|a| a.wall_ms);
        assert_eq!(wall_ms, Some(8));
    }

    #[test]
    fn the_first_estimate_after_each_gap_in_the_samples_is_marked() {
        let (batches, waiting) = sync_channel(3);
        let intake = Intake::new(&EXCAVATOR_SENSORS, batches);
        let take = |numbers| intake.take(&id(), label("ex-1", 1), Some(&batch(numbers, 0.1)));
        take(0..3);
        take(5..9);
        take(12..15);
        // No room: these are late, and the next ones follow a gap.
        take(15..17);
        assert_eq!(waiting.try_iter().count(), 3);
        take(17..20);
        let gaps = [0, 2, 5, 6, 13, 14, 18, 19].map(|sequence| {
            let stamp = Stamp {
                sequence,
                ..Stamp::default()
            };
            intake
                .answered("ex-1", 1, &stamp)
                .expect("the run")
                .is_after_gap
        });
        assert_eq!(gaps, [false, false, true, false, true, false, true, false]);
        // A site that joins a running run has not seen what was before.
        let (joined, _waiting) = self::intake();
        joined.take(&id(), label("ex-1", 1), Some(&batch(7..9, 0.1)));
        let stamp = Stamp {
            sequence: 7,
            ..Stamp::default()
        };
        let first = joined.answered("ex-1", 1, &stamp);
        assert!(first.expect("the run").is_after_gap);
    }

    #[test]
    fn what_is_no_sample_of_the_machine_is_refused_whole() {
        let (intake, waiting) = intake();
        let good = batch(0..2, 0.1);
        let cut = &good[..good.len() - 1];
        let lies: [(Option<Label>, Option<&[u8]>); 6] = [
            (None, Some(&good)),
            (label("ex-2", 1), Some(&good)),
            (label("ex-1", 1), None),
            (label("ex-1", 1), Some(cut)),
            (label("ex-1", 1), Some(&[])),
            (label("ex-1", 1), Some(&batch(0..1, f64::NAN))),
        ];
        let count = lies.len() as u64;
        for (label, payload) in lies {
            intake.take(&id(), label, payload);
        }
        assert_eq!(lock(&intake.machines)["ex-1"].counts.refused, count);
        assert!(waiting.try_recv().is_err());
    }

    #[test]
    fn a_flood_is_thinned() {
        let (intake, waiting) = intake();
        for i in 0..200 {
            let numbers = i * 100..(i + 1) * 100;
            intake.take(&id(), label("ex-1", 1), Some(&batch(numbers, 0.1)));
        }
        let taken: usize = waiting.try_iter().map(|r| names(&r).len()).sum();
        assert!((10_000..15_000).contains(&taken), "{taken}");
        let counts = lock(&intake.machines)["ex-1"].counts;
        assert_eq!(counts.refused, 200 - taken as u64 / 100);
    }
}

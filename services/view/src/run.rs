//! A run in memory: the data of the report.

use std::collections::BTreeSet;

use messages::channels::{self, Channel};
use messages::{Health, Message, SwingMotion};
use recording::{Reader, Sensors};
use steps::stages::Pipeline;

use crate::counted;
use crate::estimate::{Estimate, method};
use crate::loads::Account;

/// The estimates of one estimator in order of time.
#[derive(Debug, Clone)]
pub struct Estimator<E> {
    /// Name of the channel, for example `excavator/inertia_rls`.
    pub channel: String,
    /// Its estimates.
    pub estimates: Vec<E>,
    /// Numbers of the estimates that a thinned run retains as extremes: a plot needs them, a score leaves them out.
    pub extremes: BTreeSet<u64>,
}

impl<E: Estimate> Estimator<E> {
    /// The method of the last estimate.
    pub fn method(&self) -> &'static str {
        method(&self.estimates)
    }
}

/// The part of a run for one machine.
#[derive(Debug, Clone, Default)]
pub struct MachineRun<E: Estimate> {
    /// Its estimators that have estimates.
    pub estimators: Vec<Estimator<E>>,
    /// The truth, empty if unknown.
    pub truth: Vec<E::Truth>,
}

impl<E: Estimate> MachineRun<E> {
    /// The estimator to report first: the one with the most trusted estimates, the last of several equal ones.
    pub fn primary(&self) -> Option<&Estimator<E>> {
        let trusted = |e: &&Estimator<E>| e.estimates.iter().filter(|e| e.trusted()).count();
        self.estimators.iter().max_by_key(trusted)
    }

    /// The truth of each estimate, by the number of the sample.
    pub fn truth_of<'a>(&'a self, estimates: &[E]) -> Vec<Option<&'a E::Truth>> {
        let mut rest = self.truth.as_slice();
        let mut find = |estimate: &E| {
            let wanted = estimate.stamp().sequence;
            let ahead = rest
                .iter()
                .take_while(|t| t.stamp().sequence < wanted)
                .count();
            rest = &rest[ahead..];
            rest.first().filter(|t| t.stamp().sequence == wanted)
        };
        estimates.iter().map(&mut find).collect()
    }
}

/// A run: a recording, or what `heft estimate` has just computed.
#[derive(Debug, Clone, Default)]
pub struct Run {
    /// Names and values in the order of the recording: version, configuration, host...
    pub metadata: Vec<(String, String)>,
    /// The part of each machine.
    pub parts: Parts,
    /// The measurements.
    pub inputs: Vec<Input>,
    /// The excavator's filter stage.
    pub motion: Vec<SwingMotion>,
    /// The last health report of each process, in the order of the table of processes.
    pub health: Vec<Health>,
    /// Names of the processes, by [`Health::process`].
    pub processes: Vec<String>,
    /// Estimators that are only partly in memory, because the run is long.
    pub thinned: Vec<Thinned>,
    /// Its loads; `None` if they cannot be counted.
    pub loads: Option<Account>,
    /// Damage found in the recording, in words.
    pub damage: Vec<String>,
}

/// An estimator whose estimates were thinned: retained are the first of each stretch, and those with the highest and lowest value
/// of the first headline quantity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Thinned {
    /// Name of the channel.
    pub channel: String,
    /// Samples per stretch.
    pub stretch: u64,
    /// Estimates in the recording.
    pub received: u64,
    /// Samples that never arrived, see [`lost`].
    pub lost: u64,
}

/// Estimates of a channel beyond which they are thinned.
const HELD: u64 = 60_000;
/// Filtered motions that are read, for the whiteness test.
const MOTIONS: usize = 60_000;

impl Run {
    /// Reads a recording.
    ///
    /// # Errors
    /// The recording is damaged, or a channel carries another type than its name requires.
    pub fn from_recording(reader: &Reader) -> Result<Self, recording::Error> {
        let metadata = reader.metadata();
        let processes = metadata.get("processes").map_or_else(Vec::new, |names| {
            names
                .split([',', ' '])
                .filter(|n| !n.is_empty())
                .map(str::to_owned)
                .collect()
        });
        let mut thinned = Vec::new();
        let mut last_health = std::collections::BTreeMap::new();
        for health in reader.stream::<Health>(channels::HEALTH.name)? {
            last_health.insert(health.process, health);
        }
        let motions = reader.stream(channels::EXCAVATOR_MOTION.name)?;
        Ok(Self {
            loads: counted::read(reader)?,
            parts: Parts::read(reader, &mut thinned)?,
            inputs: inputs_of_all(reader)?,
            motion: motions.take(MOTIONS).collect(),
            health: last_health.into_values().collect(),
            thinned,
            // All of it has been read by now, except the rest of the motion.
            damage: reader
                .lacks()
                .all()
                .into_iter()
                .map(str::to_owned)
                .collect(),
            metadata: metadata
                .iter()
                .map(|(k, v)| (k.clone(), v.clone()))
                .collect(),
            processes,
        })
    }

    /// Metadata value called `name`.
    pub fn metadata(&self, name: &str) -> Option<&str> {
        let mut pairs = self.metadata.iter();
        pairs.find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }

    /// Name of process `index`.
    pub fn process_name(&self, index: u32) -> String {
        let known = usize::try_from(index)
            .ok()
            .and_then(|i| self.processes.get(i));
        known.cloned().unwrap_or_else(|| format!("process {index}"))
    }
}

/// A measured signal over time, NaN where a sample lacks it.
#[derive(Debug, Clone)]
pub struct Input {
    /// Name, as in the CSV.
    pub name: &'static str,
    /// Unit, as in [`messages::Field::unit`].
    pub unit: &'static str,
    /// Times and values; in a long run every 2nd, 4th, 8th sample.
    pub points: Vec<(f64, f64)>,
}

/// The signals of a machine's sensors that have values.
fn inputs<S: Sensors>(reader: &Reader) -> Result<Vec<Input>, recording::Error> {
    let measured: Vec<_> = recording::measured::<S>().collect();
    let valid = S::index("valid");
    let mut inputs: Vec<Input> = measured
        .iter()
        .map(|(index, _)| Input {
            name: S::FIELDS[*index].name,
            unit: S::FIELDS[*index].unit,
            points: Vec::new(),
        })
        .collect();
    let mut every = 1;
    for (n, sample) in reader.stream::<S>(S::SENSORS.name)?.enumerate() {
        if n % every != 0 {
            continue;
        }
        let there = valid.and_then(|i| sample.get(i));
        let there = there.map_or(0, |v| v.as_f64() as u32);
        for (input, (index, bit)) in inputs.iter_mut().zip(&measured) {
            let value = sample.get(*index).filter(|_| there & bit != 0);
            let value = value.map_or(f64::NAN, |v| v.as_f64());
            input.points.push((sample.stamp().time, value));
        }
        if inputs.first().is_some_and(|i| i.points.len() as u64 > HELD) {
            every *= 2;
            for input in &mut inputs {
                let mut place = 0;
                input.points.retain(|_| {
                    place += 1;
                    place % 2 == 1
                });
            }
        }
    }
    inputs.retain(|input| input.points.iter().any(|p| p.1.is_finite()));
    Ok(inputs)
}

macro_rules! parts {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// The part of each machine; empty for all but the run's own.
        #[derive(Debug, Clone, Default)]
        #[allow(missing_docs, reason = "each is of the machine of its name")]
        pub struct Parts { $( pub $module: MachineRun<messages::$estimate>, )* }

        impl Parts {
            fn read(reader: &Reader, thinned: &mut Vec<Thinned>) -> Result<Self, recording::Error> {
                Ok(Self { $( $module: machine(reader, messages::$sensors::TRUTH, thinned)?, )* })
            }
        }

        fn inputs_of_all(reader: &Reader) -> Result<Vec<Input>, recording::Error> {
            Ok([$( inputs::<messages::$sensors>(reader)? ),*].concat())
        }
    };
}

messages::machines!(parts);

fn machine<E: Estimate>(
    reader: &Reader,
    truth: &Channel,
    thinned: &mut Vec<Thinned>,
) -> Result<MachineRun<E>, recording::Error> {
    let mut run = MachineRun::default();
    // Counting first is unnecessary for a small recording.
    let few = reader.size() < 100 * HELD;
    let counts = if few {
        Default::default()
    } else {
        reader.counts()
    };
    for channel in Pipeline::of(E::MACHINE).estimates() {
        let stretch = counts.get(channel.name).map_or(1, |n| n.div_ceil(HELD / 3));
        let mut lost = Losses::default();
        let mut received = 0;
        let all = reader.stream::<E>(channel.name)?.inspect(|e| {
            received += 1;
            lost.add(e);
        });
        let (estimates, extremes) = if stretch < 4 {
            (all.collect(), BTreeSet::new())
        } else {
            thin(all, stretch)
        };
        if stretch >= 4 {
            thinned.push(Thinned {
                channel: channel.name.to_owned(),
                stretch,
                received,
                lost: lost.count,
            });
        }
        if !estimates.is_empty() {
            run.estimators.push(Estimator {
                channel: channel.name.to_owned(),
                estimates,
                extremes,
            });
        }
    }
    let truths = reader.stream::<E::Truth>(truth.name)?;
    if thinned.is_empty() {
        run.truth = truths.collect();
    } else {
        // The truth of the retained estimates only.
        let kept = run.estimators.iter().flat_map(|e| &e.estimates);
        let kept: BTreeSet<u64> = kept.map(|e| e.stamp().sequence).collect();
        run.truth = truths
            .filter(|t| kept.contains(&t.stamp().sequence))
            .collect();
    }
    Ok(run)
}

/// The first estimate of each stretch, and those with the lowest and highest value of the first headline quantity; and the
/// numbers of the latter.
fn thin<E: Estimate>(estimates: impl Iterator<Item = E>, stretch: u64) -> (Vec<E>, BTreeSet<u64>) {
    let value = |e: &E| E::headlines().next().map_or(f64::NAN, |p| p.value(e));
    let in_order = |ends: [Option<(u64, E)>; 2]| {
        let mut both: Vec<(u64, E)> = ends.into_iter().flatten().collect();
        both.sort_by_key(|(n, _)| *n);
        both.dedup_by_key(|(n, _)| *n);
        both.into_iter().map(|(_, e)| e)
    };
    let (mut kept, mut firsts): (Vec<E>, BTreeSet<u64>) = Default::default();
    let mut low: Option<(u64, E)> = None;
    let mut high: Option<(u64, E)> = None;
    for (n, estimate) in (0_u64..).zip(estimates) {
        let now = value(&estimate);
        if n.is_multiple_of(stretch) {
            kept.extend(in_order([low.take(), high.take()]));
            firsts.insert(estimate.stamp().sequence);
            kept.push(estimate);
        } else if now.is_finite() {
            if low.as_ref().is_none_or(|(_, e)| now < value(e)) {
                low = Some((n, estimate));
            }
            if high.as_ref().is_none_or(|(_, e)| now > value(e)) {
                high = Some((n, estimate));
            }
        }
    }
    kept.extend(in_order([low, high]));
    let all = kept.iter().map(|e| e.stamp().sequence);
    let extremes = all.filter(|n| !firsts.contains(n)).collect();
    (kept, extremes)
}

/// Samples that never arrived, by the gaps of the sequence between restarts of the source.
pub fn lost<M: Message>(messages: &[M]) -> u64 {
    let mut lost = Losses::default();
    messages.iter().for_each(|m| lost.add(m));
    lost.count
}

/// Counts losses message by message.
#[derive(Debug, Default)]
struct Losses {
    /// Machine and number of the last one.
    last: Option<(u32, u64)>,
    count: u64,
}

impl Losses {
    fn add<M: Message>(&mut self, message: &M) {
        let (machine, number) = (message.stamp().machine, message.stamp().sequence);
        if let Some((_, before)) = self.last.filter(|last| last.0 == machine) {
            let missing = number.saturating_sub(before).saturating_sub(1);
            self.count = self.count.saturating_add(missing);
        }
        self.last = Some((machine, number));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ExcavatorEstimate, ExcavatorTruth, Stamp};

    fn stamp(sequence: u64) -> Stamp {
        Stamp {
            sequence,
            ..Default::default()
        }
    }

    #[test]
    fn gaps_in_the_sequence_are_losses() {
        let seen = [0, 1, 4, 5, 9].map(|n| Health {
            stamp: stamp(n),
            ..Default::default()
        });
        assert_eq!(lost(&seen), 5);
        assert_eq!(lost::<Health>(&[]), 0);
    }

    #[test]
    fn a_thinned_stretch_keeps_its_first_its_highest_and_its_lowest() {
        use messages::excavator_bits as bits;
        let estimate = |n: u64| ExcavatorEstimate {
            stamp: stamp(n),
            inertia: match n {
                137 | 970 => 9e3,
                152 => 1e3,
                _ => 5e3,
            },
            // The third stretch begins with a value that is absent.
            estimated: if n == 201 { 0 } else { bits::INERTIA },
            ..Default::default()
        };
        let (kept, extremes) = thin((0..1000).map(estimate), 100);
        assert!(kept.len() <= 30);
        assert!([137, 152, 970].iter().all(|n| extremes.contains(n)));
        assert_eq!(
            kept.len() - extremes.len(),
            10,
            "a score has one of each stretch"
        );
        let kept: Vec<u64> = kept.iter().map(|e| e.stamp.sequence).collect();
        assert!(kept.windows(2).all(|w| w[0] < w[1]), "in order");
        assert!(
            [0, 100, 137, 152, 202, 900, 970]
                .iter()
                .all(|n| kept.contains(n)),
            "{kept:?}"
        );
    }

    #[test]
    fn truth_is_matched_by_sample_number() {
        let truth = [1, 2, 4].map(|n| ExcavatorTruth {
            stamp: stamp(n),
            ..Default::default()
        });
        let estimates = [0, 2, 3, 4, 5].map(|n| ExcavatorEstimate {
            stamp: stamp(n),
            ..Default::default()
        });
        let run = MachineRun {
            estimators: Vec::new(),
            truth: truth.to_vec(),
        };
        let found = run
            .truth_of(&estimates)
            .into_iter()
            .map(|t| t.map(|t| t.stamp.sequence));
        assert_eq!(
            found.collect::<Vec<_>>(),
            [None, Some(2), None, Some(4), None]
        );
    }
}

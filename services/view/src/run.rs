//! A run in memory: what the report is made of.

use messages::channels;
use messages::{
    ExcavatorEstimate, ExcavatorSensors, Health, Kind, LoaderEstimate, LoaderSensors, Message,
    SwingMotion,
};
use recording::Reader;
use steps::stages::Pipeline;

use crate::estimate::Estimate;

/// The estimates of one estimator, in the order of their time.
#[derive(Debug, Clone)]
pub struct Estimator<E> {
    /// Name of the channel, for example `excavator/inertia_rls`.
    pub channel: String,
    /// What it published.
    pub estimates: Vec<E>,
}

impl<E: Estimate> Estimator<E> {
    /// The method of the last estimate.
    #[must_use]
    pub fn method(&self) -> &'static str {
        self.estimates
            .last()
            .map_or("no estimate", Estimate::method_name)
    }
}

/// The part of a run that concerns one machine.
#[derive(Debug, Clone)]
pub struct MachineRun<E: Estimate> {
    /// Its estimators, those without an estimate left out.
    pub estimators: Vec<Estimator<E>>,
    /// The truth, empty where it is not known.
    pub truth: Vec<E::Truth>,
}

impl<E: Estimate> Default for MachineRun<E> {
    fn default() -> Self {
        Self {
            estimators: Vec::new(),
            truth: Vec::new(),
        }
    }
}

impl<E: Estimate> MachineRun<E> {
    /// The estimator to tell about first: the one that trusted its estimates longest, of equals
    /// the last.
    #[must_use]
    pub fn primary(&self) -> Option<&Estimator<E>> {
        let trusted = |e: &&Estimator<E>| e.estimates.iter().filter(|e| e.trusted()).count();
        self.estimators.iter().max_by_key(trusted)
    }

    /// The truth of each estimate, by the number of the sample.
    #[must_use]
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
    /// The excavator's part, empty for a loader.
    pub excavator: MachineRun<ExcavatorEstimate>,
    /// The loader's part, empty for an excavator.
    pub loader: MachineRun<LoaderEstimate>,
    /// What the sensors measured.
    pub inputs: Vec<Input>,
    /// The excavator's filter stage.
    pub motion: Vec<SwingMotion>,
    /// What the processes said of themselves.
    pub health: Vec<Health>,
    /// Names of the processes, by [`Health::process`].
    pub processes: Vec<String>,
}

impl Run {
    /// Reads a recording.
    ///
    /// # Errors
    /// The recording is damaged, or a channel carries another type than its name says.
    pub fn from_recording(reader: &Reader) -> Result<Self, recording::Error> {
        let metadata = reader.metadata();
        let processes = metadata.get("processes").map_or_else(Vec::new, |names| {
            names
                .split([',', ' '])
                .filter(|n| !n.is_empty())
                .map(str::to_owned)
                .collect()
        });
        Ok(Self {
            excavator: MachineRun {
                estimators: estimators(reader)?,
                truth: reader.messages(channels::EXCAVATOR_TRUTH.name)?,
            },
            loader: MachineRun {
                estimators: estimators(reader)?,
                truth: reader.messages(channels::LOADER_TRUTH.name)?,
            },
            inputs: [
                inputs::<ExcavatorSensors>(reader, channels::EXCAVATOR_SENSORS.name)?,
                inputs::<LoaderSensors>(reader, channels::LOADER_SENSORS.name)?,
            ]
            .concat(),
            motion: reader.messages(channels::EXCAVATOR_MOTION.name)?,
            health: reader.messages(channels::HEALTH.name)?,
            metadata: metadata
                .iter()
                .map(|(k, v)| (k.clone(), v.clone()))
                .collect(),
            processes,
        })
    }

    /// Metadata value called `name`.
    #[must_use]
    pub fn metadata(&self, name: &str) -> Option<&str> {
        let mut pairs = self.metadata.iter();
        pairs.find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }

    /// Name of process `index`.
    #[must_use]
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
    /// Time and value.
    pub points: Vec<(f64, f64)>,
}

/// The signals of a channel of sensors, those without any value left out.
fn inputs<S: Message>(reader: &Reader, channel: &str) -> Result<Vec<Input>, recording::Error> {
    let samples: Vec<S> = reader.messages(channel)?;
    let valid = S::index("valid");
    let bits = |s: &S| {
        valid
            .and_then(|i| s.get(i))
            .map_or(0, |v| v.as_f64() as u32)
    };
    let numbers = S::FIELDS.iter().enumerate().skip(messages::HEAD);
    let measured = numbers.filter(|(_, field)| field.kind == Kind::F64);
    let input = |(bit, (index, field)): (usize, (usize, &messages::Field))| {
        let value = |s: &S| match s.get(index) {
            Some(value) if bits(s) >> bit & 1 == 1 => value.as_f64(),
            _ => f64::NAN,
        };
        Input {
            name: field.name,
            unit: field.unit,
            points: samples.iter().map(|s| (s.stamp().time, value(s))).collect(),
        }
    };
    let all = measured.enumerate().map(input);
    Ok(all
        .filter(|input| input.points.iter().any(|p| p.1.is_finite()))
        .collect())
}

fn estimators<E: Estimate>(reader: &Reader) -> Result<Vec<Estimator<E>>, recording::Error> {
    let mut found = Vec::new();
    for channel in Pipeline::of(E::MACHINE).estimates() {
        let estimates = reader.messages(channel.name)?;
        if !estimates.is_empty() {
            found.push(Estimator {
                channel: channel.name.to_owned(),
                estimates,
            });
        }
    }
    Ok(found)
}

/// Samples that never arrived, by the gaps of the sequence within each life of the source.
#[must_use]
pub fn lost<M: Message>(messages: &[M]) -> u64 {
    let gap = |pair: &[M]| {
        let (a, b) = (pair[0].stamp(), pair[1].stamp());
        let ahead = b.sequence.saturating_sub(a.sequence).saturating_sub(1);
        if a.machine == b.machine { ahead } else { 0 }
    };
    messages.windows(2).map(gap).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ExcavatorTruth, Stamp};

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

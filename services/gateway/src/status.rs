//! The status of a machine, once a second, under `heft/v1/SITE/MACHINE/status`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Largest status that is read \[bytes\].
pub const LARGEST: usize = 8192;
/// Most streams of a machine.
const STREAMS: usize = 64;

/// The status as JSON, because it is no message of the pipeline.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// The machine; must be the one that the key names.
    pub machine: String,
    /// Kind of machine: excavator, loader.
    pub kind: String,
    /// Version of heft on it.
    pub version: String,
    /// The run: a random id.
    pub run: u64,
    /// Number of runs that the machine has counted, including this one; 0 if it cannot count them.
    #[serde(default)]
    pub count: u64,
    /// The machine's wall clock, by which its messages are stamped [ms since 1970].
    pub wall_ms: u64,
    /// The run ended in order.
    pub ended: bool,
    /// The run was killed or failed: its supervisor was killed, or gave up.
    #[serde(default)]
    pub broke_off: bool,
    /// Its streams by `KIND/NAME`.
    pub streams: BTreeMap<String, Stream>,
    /// Counts of its gateway.
    pub counts: Counts,
}

/// Progress of a stream.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Stream {
    /// Number of the latest message, -1 for none.
    pub head: i64,
    /// Samples between two messages, 0 where there is no period.
    pub per_period: f64,
}

/// Counts of a gateway since its start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// Start of the gateway [ms since 1970]; it distinguishes several starts in a run.
    pub since_ms: u64,
    /// Samples that were overwritten in the channels before the gateway took them.
    pub overwritten: u64,
    /// Messages handed to Zenoh.
    pub sent: u64,
    /// Messages dropped because the queue to Zenoh was full.
    pub dropped: u64,
    /// Messages sent again from the recording.
    pub served: u64,
    /// Requested messages that the recording does not hold any more.
    pub lost: u64,
    /// Samples of the sensors handed to Zenoh.
    #[serde(default)]
    pub samples_sent: u64,
    /// Samples that were not handed to Zenoh.
    #[serde(default)]
    pub samples_lost: u64,
}

impl Status {
    /// Parses a status; `None` if it is malformed, or exceeds a bound.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        let status: Self = (bytes.len() <= LARGEST)
            .then(|| serde_json::from_slice(bytes).ok())
            .flatten()?;
        let short = |text: &String| text.len() <= 100 && !text.contains(|c: char| c.is_control());
        let texts = [&status.machine, &status.kind, &status.version];
        let numbers = [status.run, status.count, status.wall_ms];
        (status.streams.len() <= STREAMS
            && texts.into_iter().chain(status.streams.keys()).all(short)
            && numbers.iter().all(|n| i64::try_from(*n).is_ok())
            && status.streams.values().all(|s| {
                s.head >= -1 && s.per_period.is_finite() && (0.0..1e6).contains(&s.per_period)
            }))
        .then_some(status)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_status_reads_back_and_what_is_out_of_bounds_does_not() {
        let status = Status {
            machine: "ex-17".into(),
            ..Default::default()
        };
        let bytes = |s: &Status| serde_json::to_vec(s).expect("plain data");
        assert_eq!(Status::parse(&bytes(&status)), Some(status.clone()));
        let mut bad = status.clone();
        bad.version = "x".repeat(101);
        assert_eq!(Status::parse(&bytes(&bad)), None);
        bad = status.clone();
        bad.streams.insert(
            "a/b".into(),
            Stream {
                head: -2,
                per_period: 0.0,
            },
        );
        assert_eq!(Status::parse(&bytes(&bad)), None);
        bad = status;
        bad.run = u64::MAX;
        assert_eq!(Status::parse(&bytes(&bad)), None);
        assert_eq!(Status::parse(&[b' '; LARGEST + 1]), None);
        assert_eq!(Status::parse(b"{}"), None);
    }
}

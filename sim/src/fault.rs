//! Faults on request: errors of sensors and their wiring.
//!
//! A fault acts on one channel (a column of the input file, or [`ROW`] for whole samples), in a window of
//! time, on every sample in it or on a random share. As text, `CHANNEL:KIND[=VALUE][,p=SHARE][,from=S][,to=S]`:
//!
//! | text | what |
//! |---|---|
//! | `swing_velocity:missing,p=0.1` | one sample in ten is an empty cell |
//! | `swing_velocity:nan,p=0.01` | not a number |
//! | `swing_velocity:outlier=0.3,p=0.02` | plus or minus 0.3 rad/s on one sample in fifty |
//! | `swing_velocity:saturation=0.8` | stops at plus or minus 0.8 |
//! | `swing_velocity:bias=0.01`, `swing_torque:scale=1.02` | offset, gain |
//! | `front_wheel_speed:quantum=0.05` | rounded to multiples of 0.05 |
//! | `boom_angle:hold,from=6,to=7` | repeats its last value |
//! | `swing_torque:missing` | no such column |
//! | `row:missing,from=8.1,to=8.15` | a gap: the samples do not exist |

use crate::noise::Noise;
use std::fmt;

/// The channel name that stands for the whole sample.
pub const ROW: &str = "row";

/// Streams of [`Noise::channel`] from here on belong to faults.
const FIRST_STREAM: u64 = 1000;

/// Effect on a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// No value.
    Missing,
    /// A value that is not a number.
    NotANumber,
    /// This amount is added, or subtracted, at random.
    Outlier(f64),
    /// The value stays within plus or minus this limit.
    Saturation(f64),
    /// This amount is added.
    Bias(f64),
    /// The value is multiplied by this factor.
    Scale(f64),
    /// The value is rounded to a multiple of this step.
    Quantum(f64),
    /// The last value before the fault is repeated.
    Hold,
}

/// One fault of one channel. Faults of the same channel act in the order of the list.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Name of the column, or [`ROW`].
    pub channel: String,
    /// Its effect.
    pub kind: FaultKind,
    /// Share of the affected samples, 0 to 1.
    pub probability: f64,
    /// Beginning of its window \[s\].
    pub from: f64,
    /// End of its window, exclusive \[s\].
    pub to: f64,
}

/// Reason why a fault is impossible: an unknown text or channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InvalidFault(String);

impl fmt::Display for InvalidFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for InvalidFault {}

impl Fault {
    /// A fault on every sample of a channel.
    pub fn always(channel: &str, kind: FaultKind) -> Self {
        Self {
            channel: channel.into(),
            kind,
            probability: 1.0,
            from: f64::NEG_INFINITY,
            to: f64::INFINITY,
        }
    }

    /// A fault on a random share of the samples of a channel.
    pub fn random(channel: &str, kind: FaultKind, probability: f64) -> Self {
        Self {
            probability,
            ..Self::always(channel, kind)
        }
    }

    /// A fault on every sample with `from <= time < to`.
    pub fn between(channel: &str, kind: FaultKind, from: f64, to: f64) -> Self {
        Self {
            from,
            to,
            ..Self::always(channel, kind)
        }
    }

    /// Reads the text form of the module's table.
    pub fn parse(text: &str) -> Result<Self, InvalidFault> {
        let invalid = |why: &str| InvalidFault(format!("fault `{text}`: {why}"));
        let (channel, rest) = text
            .split_once(':')
            .ok_or_else(|| invalid("expected CHANNEL:KIND[=VALUE][,p=SHARE][,from=S][,to=S]"))?;
        let mut parts = rest.split(',').map(str::trim);
        let kind =
            FaultKind::parse(parts.next().unwrap_or_default()).map_err(|why| invalid(&why))?;
        let mut fault = Self::always(channel.trim(), kind);
        for part in parts {
            let (key, value) = part
                .split_once('=')
                .ok_or_else(|| invalid("expected KEY=VALUE"))?;
            let value = number(value).map_err(|why| invalid(&why))?;
            match key {
                "p" if (0.0..=1.0).contains(&value) => fault.probability = value,
                "p" => return Err(invalid("p is a share, 0 to 1")),
                "from" => fault.from = value,
                "to" => fault.to = value,
                _ => return Err(invalid("known keys are p, from, to")),
            }
        }
        Ok(fault)
    }

    fn active(&self, time: f64) -> bool {
        self.from <= time && time < self.to
    }
}

impl FaultKind {
    fn parse(text: &str) -> Result<Self, String> {
        let (name, value) = match text.split_once('=') {
            Some((name, value)) => (name, Some(number(value)?)),
            None => (text, None),
        };
        match (name, value) {
            ("missing", None) => Ok(Self::Missing),
            ("nan", None) => Ok(Self::NotANumber),
            ("hold", None) => Ok(Self::Hold),
            ("outlier", Some(size)) => Ok(Self::Outlier(size)),
            ("saturation", Some(limit)) if limit >= 0.0 => Ok(Self::Saturation(limit)),
            ("bias", Some(bias)) => Ok(Self::Bias(bias)),
            ("scale", Some(scale)) => Ok(Self::Scale(scale)),
            ("quantum", Some(quantum)) if quantum > 0.0 => Ok(Self::Quantum(quantum)),
            _ => Err("kinds are missing, nan, hold, outlier=SIZE, saturation=LIMIT (not negative), bias=B, scale=F, quantum=Q (positive)".into()),
        }
    }

    fn apply(self, value: Option<f64>, last: Option<f64>, sign: f64) -> Option<f64> {
        match self {
            Self::Missing => None,
            Self::NotANumber => Some(f64::NAN),
            Self::Outlier(size) => value.map(|v| v + sign * size),
            Self::Saturation(limit) => value.map(|v| v.clamp(-limit, limit)),
            Self::Bias(bias) => value.map(|v| v + bias),
            Self::Scale(scale) => value.map(|v| v * scale),
            Self::Quantum(quantum) => value.map(|v| (v / quantum).round() * quantum),
            Self::Hold => last,
        }
    }
}

fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{text}` is not a number")),
    }
}

/// Applies the faults of a run. It does not allocate after its construction.
#[derive(Clone, Debug)]
pub struct Injector {
    active: Vec<Active>,
}

#[derive(Clone, Debug)]
struct Active {
    /// Index into the table of channels; none for whole samples.
    channel: Option<usize>,
    fault: Fault,
    noise: Noise,
    /// Last value before the fault.
    last: Option<f64>,
}

impl Injector {
    /// The faults of a run over the columns `channels`; [`Self::apply`] takes an index into them.
    ///
    /// # Errors
    /// A fault names a channel that is neither a column nor [`ROW`], or applies a fault of values to whole samples.
    pub fn new(faults: &[Fault], channels: &[&str], seed: u64) -> Result<Self, InvalidFault> {
        let active = faults.iter().zip(FIRST_STREAM..).map(|(fault, stream)| {
            let channel = channels.iter().position(|name| *name == fault.channel);
            match (channel, fault.channel == ROW, fault.kind) {
                (Some(_), _, _) | (None, true, FaultKind::Missing) => {}
                (None, true, _) => {
                    return Err(InvalidFault(format!("a {ROW} can only be missing")));
                }
                (None, false, _) => return Err(unknown_channel(&fault.channel, channels)),
            }
            Ok(Active {
                channel,
                fault: fault.clone(),
                noise: Noise::channel(seed, stream),
                last: None,
            })
        });
        Ok(Self {
            active: active.collect::<Result<_, _>>()?,
        })
    }

    /// Whether the sample at `time` is lost as a whole. Call it once per sample.
    pub fn loses_row(&mut self, time: f64) -> bool {
        let mut lost = false;
        for active in self.active.iter_mut().filter(|a| a.channel.is_none()) {
            lost |= active.hits(time);
        }
        lost
    }

    /// The faulty value for `value` on a channel. Call it once per sample and channel.
    pub fn apply(&mut self, channel: usize, time: f64, value: Option<f64>) -> Option<f64> {
        let mut value = value;
        for active in self
            .active
            .iter_mut()
            .filter(|a| a.channel == Some(channel))
        {
            if active.hits(time) {
                let sign = if active.noise.chance(0.5) { 1.0 } else { -1.0 };
                value = active.fault.kind.apply(value, active.last, sign);
            } else {
                active.last = value;
            }
        }
        value
    }
}

impl Active {
    fn hits(&mut self, time: f64) -> bool {
        self.fault.active(time)
            && (self.fault.probability >= 1.0 || self.noise.chance(self.fault.probability))
    }
}

fn unknown_channel(name: &str, channels: &[&str]) -> InvalidFault {
    InvalidFault(format!(
        "no channel `{name}`; channels are {}, {ROW}",
        channels.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn injector(texts: &[&str]) -> Injector {
        let faults: Vec<_> = texts.iter().map(|t| Fault::parse(t).unwrap()).collect();
        Injector::new(&faults, &["a", "b"], 1).unwrap()
    }

    #[test]
    fn a_fault_reaches_its_channel_in_its_window_only() {
        let mut faults = injector(&["b:bias=0.5,from=1,to=2"]);
        assert_eq!(faults.apply(0, 1.0, Some(3.0)), Some(3.0));
        assert_eq!(faults.apply(1, 0.99, Some(3.0)), Some(3.0));
        assert_eq!(faults.apply(1, 1.0, Some(3.0)), Some(3.5));
        assert_eq!(faults.apply(1, 2.0, Some(3.0)), Some(3.0));
    }

    #[test]
    fn a_share_is_that_share_of_the_samples() {
        let mut faults = injector(&["a:missing,p=0.1"]);
        let lost = (0..10_000)
            .filter(|k| faults.apply(0, f64::from(*k), Some(1.0)).is_none())
            .count();
        // Five standard deviations of a binomial count: 5 sqrt(10000 * 0.1 * 0.9) = 150.
        assert!(lost.abs_diff(1000) < 150, "{lost}");
    }

    #[test]
    fn faults_of_a_channel_act_in_the_order_of_the_list() {
        let mut faults = injector(&["a:scale=2", "a:bias=1", "a:saturation=4"]);
        assert_eq!(faults.apply(0, 0.0, Some(1.0)), Some(3.0));
        assert_eq!(faults.apply(0, 0.0, Some(-9.0)), Some(-4.0));
    }

    #[test]
    fn a_held_sensor_repeats_its_last_good_value() {
        let mut faults = injector(&["a:hold,from=1"]);
        assert_eq!(faults.apply(0, 0.5, Some(7.0)), Some(7.0));
        assert_eq!(faults.apply(0, 1.5, Some(8.0)), Some(7.0));
    }

    #[test]
    fn outliers_go_both_ways_and_nan_is_a_value() {
        let mut faults = injector(&["a:outlier=0.3", "b:nan"]);
        let hits: Vec<_> = (0..50).map(|_| faults.apply(0, 0.0, Some(0.0))).collect();
        assert!(hits.contains(&Some(0.3)) && hits.contains(&Some(-0.3)));
        assert!(faults.apply(1, 0.0, Some(0.0)).is_some_and(f64::is_nan));
    }

    #[test]
    fn a_gap_loses_whole_samples() {
        let mut faults = injector(&["row:missing,from=8.1,to=8.15"]);
        assert_eq!(
            [8.09, 8.1, 8.14, 8.15].map(|t| faults.loses_row(t)),
            [false, true, true, false]
        );
    }

    #[test]
    fn what_cannot_be_is_refused_with_the_reason() {
        for text in [
            "a",
            "a:melts",
            "a:bias",
            "a:bias=x",
            "a:missing,p=2",
            "a:missing,often=1",
        ] {
            assert!(Fault::parse(text).is_err(), "{text}");
        }
        let unknown = Injector::new(&[Fault::always("c", FaultKind::Hold)], &["a", "b"], 1);
        assert_eq!(
            unknown.unwrap_err().to_string(),
            "no channel `c`; channels are a, b, row"
        );
        assert!(Injector::new(&[Fault::always(ROW, FaultKind::Bias(1.0))], &["a"], 1).is_err());
    }
}

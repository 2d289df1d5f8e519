//! Bounds of an endless recording: `--split 10min`, `--keep 20GB`, `--min-free 1GB`.

use std::time::Duration;

use clap::Args;
use serde::{Deserialize, Serialize};
use view::duration;

/// A time or an amount of data.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Bound {
    /// Duration.
    Time(Duration),
    /// Number of bytes.
    Bytes(u64),
}

/// Bounds of the recording
#[derive(Debug, Clone, Default, PartialEq, Args, Serialize, Deserialize)]
pub struct LimitArgs {
    /// Begin a new part of the recording after this time or size: 10min, 1h, 100MB
    #[arg(long, value_name = "TIME|SIZE", value_parser = bound)]
    pub split: Option<Bound>,
    /// Remove the oldest recordings of the folder beyond this size or age: 20GB, 7d
    #[arg(long, value_name = "SIZE|TIME", value_parser = bound, requires = "split")]
    pub keep: Option<Bound>,
    /// Stop recording, not estimating, while the disk has less room than this: 1GB
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub min_free: Option<u64>,
}

impl LimitArgs {
    /// The same as the logger takes them.
    pub fn of_logger(&self) -> logger::Limits {
        let time = |bound| match bound {
            Some(Bound::Time(time)) => Some(time),
            _ => None,
        };
        let bytes = |bound| match bound {
            Some(Bound::Bytes(bytes)) => Some(bytes),
            _ => None,
        };
        logger::Limits {
            split_after: time(self.split),
            split_bytes: bytes(self.split),
            keep_for: time(self.keep),
            keep_bytes: bytes(self.keep),
            min_free: self.min_free,
            group: None,
        }
    }
}

/// Units, and their value in bytes.
const SIZES: &[(&str, f64)] = &[("kB", 1e3), ("MB", 1e6), ("GB", 1e9), ("TB", 1e12)];

fn bound(text: &str) -> Result<Bound, String> {
    if let Some(time) = duration::of(text, None).ok().filter(|time| *time >= 1.0) {
        return Ok(Bound::Time(Duration::from_secs_f64(time)));
    }
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = &text[number.len()..];
    let factor = SIZES
        .iter()
        .find(|(name, _)| name.eq_ignore_ascii_case(unit));
    let number = number.trim().parse::<f64>().ok();
    let bytes = number
        .zip(factor)
        .map(|(number, (_, factor))| number * factor);
    let bytes = bytes.filter(|bytes| (1e4..=1e18).contains(bytes));
    bytes
        .map(|bytes| Bound::Bytes(bytes as u64))
        .ok_or_else(|| wrong(text))
}

fn size(text: &str) -> Result<u64, String> {
    match bound(text)? {
        Bound::Bytes(bytes) => Ok(bytes),
        Bound::Time(_) => Err("give a size, such as 1GB".into()),
    }
}

fn wrong(text: &str) -> String {
    format!("\"{text}\" is neither a time (30s, 10min, 1h, 7d) nor a size (100MB, 20GB)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_sizes_are_distinguished_by_their_unit() {
        assert_eq!(bound("10min"), Ok(Bound::Time(Duration::from_secs(600))));
        assert_eq!(bound("1.5 h"), Ok(Bound::Time(Duration::from_secs(5400))));
        assert_eq!(bound("7d"), Ok(Bound::Time(Duration::from_secs(604_800))));
        assert_eq!(bound("100MB"), Ok(Bound::Bytes(100_000_000)));
        assert_eq!(size("20GB"), Ok(20_000_000_000));
        for wrong in [
            "",
            "10",
            "MB",
            "-1h",
            "10 parsecs",
            "nanmin",
            "1e300GB",
            "0s",
            "1 kB",
        ] {
            assert!(bound(wrong).is_err(), "{wrong}");
        }
        assert!(size("10min").is_err());
    }
}

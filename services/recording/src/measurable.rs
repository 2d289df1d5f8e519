//! Numbers beyond the range of any sensor.

use crate::Sensors;
use messages::Value;

/// Index and bit of a signal, and its largest value that is a measurement.
pub type Measured = (usize, u32, f64);

/// Largest measurement of any signal, in SI units: five times the largest pressure.
const LIMIT: f64 = 1e9;

/// Message on a signal with this number of rows beyond its range.
pub fn words(signal: &str, count: usize) -> String {
    format!(
        "{signal} is larger than any measurement in {count} rows, where it counts as missing: check its unit and scale, and what the logger writes where a sample is missing"
    )
}

/// The measured signals of a machine; `largest` gives the limit above which the estimators take a value for missing.
pub fn measured<S: Sensors>(largest: impl Fn(&str) -> Option<f64>) -> Vec<Measured> {
    let measured = crate::measured::<S>().map(|(index, bit)| {
        let limit = largest(S::FIELDS[index].name).map_or(LIMIT, |limit| limit.min(LIMIT));
        (index, bit, limit)
    });
    measured.collect()
}

/// Bits of the numbers of a sample that are larger than any measurement.
pub fn beyond<S: Sensors>(sample: &S, measured: &[Measured]) -> u32 {
    let valid = sample.bits_of("valid");
    let large = measured.iter().filter(|(index, _, limit)| {
        let number = sample.get(*index).map_or(0.0, Value::as_f64);
        number.abs() > *limit
    });
    large.fold(0, |bits, (_, bit, _)| bits | bit) & valid
}

//! Numbers that no sensor of a machine says.

use messages::Value;
use recording::Sensors;

/// Beyond this, in SI units, nothing is a measurement: five times the largest pressure.
const LIMIT: f64 = 1e9;

/// Bits of the numbers of a sample that are larger than any measurement; `measured` are those of [`recording::measured`], looked up
/// once.
pub fn beyond<S: Sensors>(sample: &S, measured: &[(usize, u32)]) -> u32 {
    let valid = sample.bits_of("valid");
    let large = measured.iter().filter(|(index, _)| {
        let number = sample.get(*index).map_or(0.0, Value::as_f64);
        number.abs() > LIMIT
    });
    large.fold(0, |bits, (_, bit)| bits | bit) & valid
}

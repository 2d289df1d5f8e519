//! Calibration of a simulated machine at work, as by `heft calibrate`: from two recordings of swings and slow lifts, one of them
//! with a weighed load.

use calibrate::excavator::{self as calibration, Input, Options};
use estimation::Quantity;
use estimation::excavator::keys::Description;
use estimation::excavator::{Method, Settings};
use sim::excavator::{Effects, Size, Work};
use sim::noise::Noise;

use super::estimators::Setup;
use crate::Error;

/// Length of a recording: 150 s at 100 Hz.
const ROWS: usize = 15_000;
/// The weighed load, in rated payloads, and the relative accuracy of its weighing.
const LOAD: f64 = 0.7;
const SCALE: f64 = 0.01;
/// Stream of the scale's error.
const STREAM: u64 = 340;

/// The settings of the calibrated machine, `None` if the calibration is refused; `before`: the description stated by a user.
pub fn settings(
    (size, effects, seed): (Size, Effects, u64),
    before: &Description,
) -> Result<Option<Settings>, Error> {
    // A user calibrates on level ground.
    let level = Effects {
        slope: 0.0,
        ..effects
    };
    let load = LOAD * size.rated;
    let weighed = load * (1.0 + SCALE * Noise::channel(seed, STREAM).normal());
    let settings = Settings::of(before);
    let setup = Setup::working("to calibrate", Method::PostureTorque, settings);
    let inputs = [(0.0, 0.0), (load, weighed)].map(|(load, weighed)| Input {
        name: format!("{load:.0} kg"),
        samples: Work::trial(size, level, seed, load)
            .with_gauges(seed)
            .take(ROWS)
            .map(|row| setup.sample(&row))
            .collect(),
        payload: Some(Quantity {
            value: weighed,
            std: SCALE * weighed,
        }),
    });
    let outcome = calibration::calibrate(&inputs, &Options::of(before)).map_err(Error::refused)?;
    if !outcome.faults.is_empty() {
        eprintln!("seed {seed}: {}", outcome.faults.join("; "));
        return Ok(None);
    }
    let found = outcome.description(before, &[]);
    Ok(found.map(|(description, _)| Settings::of(&description)))
}

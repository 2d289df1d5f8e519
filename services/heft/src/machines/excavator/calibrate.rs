//! `heft calibrate excavator`.

use calibrate::excavator::{self as machine, Input};
use estimation::Quantity;

use crate::commands::calibrate::args::CalibrateArgs;
use crate::commands::calibrate::inputs::{names, origin, samples};
use crate::commands::calibrate::outcome::{finish, interrupt, tell_progress, unknown_key};
use crate::commands::calibrate::stated::stated;
use crate::failure::Failure;
use crate::sources;

/// Relative standard deviation of a load that is stated without one: of a weighbridge.
const WEIGHED: f64 = 0.005;

/// The excavator's own parameters from recordings.
pub(super) fn calibrate(args: &CalibrateArgs, d: &config::Excavator) -> Result<(), Failure> {
    let map = sources::map(args.map.as_deref())?;
    let loads = stated(args, &args.payload, "--payload")?;
    let mut inputs = Vec::new();
    for ((file, name), payload) in args.files.iter().zip(names(&args.files)).zip(loads) {
        let rows = samples::<messages::ExcavatorSensors>(file, map.as_ref(), d.sensors.rate)?;
        inputs.push(Input {
            name,
            samples: rows.iter().map(steps::excavator::sample).collect(),
            payload: payload.map(|load| match load.std > 0.0 {
                true => load,
                false => Quantity {
                    std: WEIGHED * load.value,
                    ..load
                },
            }),
        });
    }
    // A fit takes time, and a recording may be gone by its end.
    let origin = origin(args)?;
    let stop = interrupt()?;
    let outcome = machine::calibrate(
        &inputs,
        &machine::Options {
            description: d,
            free: (!args.free.is_empty()).then_some(args.free.as_slice()),
            stop: &stop,
            progress: &tell_progress,
        },
    )
    .map_err(unknown_key)?;
    let written = outcome.description(d, &origin).map(|(_, text)| text);
    finish(args, &outcome.summary(), written)
}

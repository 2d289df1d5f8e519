//! `heft calibrate loader`.

use calibrate::loader::{self as machine, StatedLoad};
use estimation::{GRAVITY, Quantity};

use crate::commands::calibrate::args::CalibrateArgs;
use crate::commands::calibrate::inputs::{names, origin, samples};
use crate::commands::calibrate::outcome::{finish, interrupt, tell_progress, unknown_key};
use crate::commands::calibrate::stated::{out_and_back, position, scales, stated};
use crate::commands::weigh::{SCALE_STD, reference};
use crate::failure::Failure;
use crate::sources;

/// Least plausible mass of a loader \[kg\].
const LIGHTEST: f64 = 1.0;

/// The loader's own parameters from recordings.
pub(super) fn calibrate(args: &CalibrateArgs, d: &config::Loader) -> Result<(), Failure> {
    let map = sources::map(args.map.as_deref())?;
    let masses = stated(args, &args.mass, "--mass")?;
    if masses.iter().flatten().any(|m| m.value < LIGHTEST) {
        return Err(Failure::input(
            "the mass of the whole machine is stated as nothing",
            "--mass",
            "write what it weighs, in kg; --payload is the load in the bucket",
        ));
    }
    let payloads = stated(args, &args.payload, "--payload")?;
    let scales = weighed(args, d)?;
    let mut inputs = Vec::new();
    let files = args.files.iter().zip(names(&args.files)).zip(masses);
    for (i, ((file, name), mass)) in files.enumerate() {
        let rows = samples::<messages::LoaderSensors>(file, map.as_ref(), d.sensors.rate)?;
        inputs.push(machine::Input {
            name,
            samples: rows.iter().map(steps::loader::sample).collect(),
            stated: StatedLoad {
                mass: mass.or(scales[i + 1].mass),
                ..scales[i + 1]
            },
            payload: payloads[i],
        });
    }
    // A fit takes time, and a recording may be gone by its end.
    let origin = origin(args)?;
    let stop = interrupt()?;
    let outcome = machine::calibrate(
        &inputs,
        &machine::Options {
            description: d,
            weighed: scales[0],
            out_and_back: &out_and_back(args)?,
            slices: args.report.is_some(),
            free: (!args.free.is_empty()).then_some(args.free.as_slice()),
            stop: &stop,
            progress: &tell_progress,
        },
    )
    .map_err(unknown_key)?;
    let written = outcome.description(d, &origin).map(|(_, text)| text);
    finish(args, &outcome.summary(), written)
}

/// Loads weighed on axle scales: of the machine as described, then of the machine in each file; `SCALES` or `FILE=SCALES`.
fn weighed(args: &CalibrateArgs, d: &config::Loader) -> Result<Vec<StatedLoad>, Failure> {
    let mut all = vec![StatedLoad::default(); args.files.len() + 1];
    for text in &args.weigh {
        let (file, scales) = scales(text);
        let at = match file {
            None => 0,
            Some(file) => 1 + position(args, file, "--weigh", text)?,
        };
        let reference = reference(scales, d)?;
        if all[at] != StatedLoad::default() {
            return Err(Failure::input(
                "two axle weighings are stated for the same machine",
                format!("--weigh {text}"),
                "state one for the empty machine, and one for each recording",
            ));
        }
        // The readings are in newtons.
        let mass = reference.level_load.map(|load| Quantity {
            value: load / GRAVITY,
            std: SCALE_STD * load / GRAVITY,
        });
        all[at] = StatedLoad {
            mass,
            ..StatedLoad::weighed(&reference, SCALE_STD)
        };
    }
    Ok(all)
}

//! `heft weigh`: the static reference of the centre of gravity, from axle weights on level and tilted ground.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::Args;
use config::{Description, Tables};
use estimation::loader::weigh::{Reading, Reference, Weighing};
use estimation::{GRAVITY, HALF_WIDTH_95, Quantity};
use messages::Machine;

use crate::args::{DescriptionArgs, description, states};
use crate::build::IDENTITY;
use crate::failure::Failure;
use crate::results;

/// Accuracy of a wheel scale, as a share of its reading.
pub const SCALE_STD: f64 = 0.005;

/// `heft weigh`
#[derive(Debug, Args)]
pub struct WeighArgs {
    /// CSV with the columns pitch, in rad, front up positive, front_load and rear_load, in N
    pub file: PathBuf,
    /// What is known of the loader
    #[command(flatten)]
    pub description: DescriptionArgs,
    /// Write the result as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// `heft weigh`
pub fn weigh(args: &WeighArgs) -> Result<(), Failure> {
    let Description::Loader(mut loader) = description(Some(Machine::Loader), &args.description)?
    else {
        return Err(Failure::internal("the loader's description is none"));
    };
    let is_stated = |key| states(Machine::Loader, &args.description, key);
    let is_sized = args.description.class.is_some() || is_stated("machine.mass")?;
    let mut reference = reference(&args.file, &loader)?;
    if !is_stated("machine.wheelbase")? {
        if !is_sized {
            loader.set(&format!("machine.mass={:?}", reference.load / GRAVITY))?;
            reference = self::reference(&args.file, &loader)?;
        }
        guess_wheelbase(&mut reference, loader.machine.wheelbase);
    }
    print!("{}", text(&reference));
    if let Some(path) = &args.json {
        results::json(path, &[&args.file], "weigh", IDENTITY, &to_json(&reference))?;
    }
    Ok(())
}

/// Relative standard deviation of a wheelbase that is estimated from the mass.
const GUESSED: f64 = 0.05;

/// Adds the uncertainty of a wheelbase that is not stated, with a note.
fn guess_wheelbase(found: &mut Reference, wheelbase: f64) {
    let mass = found.load / GRAVITY / 1000.0;
    eprintln!(
        "note: nobody states the wheelbase: {wheelbase:.2} m ± {:.0} % is usual at this mass (the scales show {mass:.1} t); state yours: \
         --set machine.wheelbase=METRES",
        100.0 * GUESSED
    );
    found.cg_distance = widened(found.cg_distance);
    found.cg_height = found.cg_height.map(widened);
}

/// Adds the uncertainty of the assumed wheelbase, to which the quantity is proportional.
fn widened(q: Quantity) -> Quantity {
    let guessed = GUESSED * q.value;
    Quantity {
        std: (q.std * q.std + guessed * guessed).sqrt(),
        ..q
    }
}

/// Ratio of the axle loads' sum to the described mass \[kg\] that means kilograms: newtons give about 9.81.
const AS_KILOGRAMS: RangeInclusive<f64> = 0.6..=1.7;

/// The reference by the weighings in a file.
pub fn reference(file: &Path, described: &config::Loader) -> Result<Reference, Failure> {
    let refused = |e: estimation::loader::weigh::WeighError| {
        Failure::input(
            e,
            file.display(),
            "weigh both axles on level ground, and again on ground tilted by several degrees; a row of units below the names may say deg and kN",
        )
    };
    let mut weighing = Weighing::new(described.machine.wheelbase, SCALE_STD).map_err(refused)?;
    for [pitch, front_load, rear_load] in recording::csv::read_weighings(file)? {
        weighing
            .add(&Reading {
                pitch,
                front_load,
                rear_load,
            })
            .map_err(refused)?;
    }
    let reference = weighing.reference().map_err(refused)?;
    let (load, mass) = (reference.load, described.machine.mass);
    if AS_KILOGRAMS.contains(&(load / mass)) {
        let weight = mass * GRAVITY;
        return Err(Failure::input(
            format!(
                "front_load and rear_load seem to be in kg: together they are {load:.0}, and a machine of {mass:.0} kg weighs {weight:.0} N"
            ),
            file.display(),
            "give newtons (kg times 9.81); or state the mass of your machine: --set machine.mass=KG",
        ));
    }
    let below = |height: Quantity| height.value + HALF_WIDTH_95 * height.std < 0.0;
    if let Some(height) = reference.cg_height.filter(|height| below(*height)) {
        return Err(Failure::input(
            format!(
                "by these weights the centre of gravity lies {:.2} m below the ground",
                -height.value
            ),
            file.display(),
            "give pitch its sign: front up is positive, and makes the front axle lighter; or exchange front_load and rear_load",
        ));
    }
    Ok(reference)
}

fn line(name: &str, quantity: Quantity, unit: &str) -> String {
    format!(
        "{name:<36} {:.4} ± {:.4}{unit}\n",
        quantity.value, quantity.std
    )
}

fn text(r: &Reference) -> String {
    let mut out = line("front-axle load fraction", r.cg_ratio, "");
    out += &line("front axle to centre of gravity", r.cg_distance, " m");
    out += &match r.cg_height {
        Some(height) => line("height of the centre of gravity", height, " m"),
        None => {
            "height of the centre of gravity      unknown: all readings are at the same pitch\n"
                .into()
        }
    };
    out + &format!(
        "from {} reading{}; ± is one standard deviation\n",
        r.readings,
        if r.readings == 1 { "" } else { "s" }
    )
}

fn to_json(r: &Reference) -> serde_json::Value {
    serde_json::json!({
        "cg_ratio": r.cg_ratio.value,
        "cg_ratio_std": r.cg_ratio.std,
        "cg_distance": r.cg_distance.value,
        "cg_distance_std": r.cg_distance.std,
        "cg_height": r.cg_height.map(|q| q.value),
        "cg_height_std": r.cg_height.map(|q| q.std),
        "load": r.load,
        "readings": r.readings,
    })
}

//! `heft calibrate`: identifies the machine's own parameters from recordings, with intervals.

pub mod args;
mod each;
pub mod inputs;
pub mod outcome;
mod page;
pub mod stated;

pub use self::args::CalibrateArgs;
use config::Description;
use messages::Machine;

use crate::args::{described, description, is_of_heft};
use crate::failure::Failure;
use crate::machines;

/// `heft calibrate`
pub fn calibrate(args: &CalibrateArgs) -> Result<(), Failure> {
    if args.each {
        return each::calibrate(args);
    }
    inputs::check_distinct(&args.files)?;
    check_machine(args)?;
    outcome::check_outputs(args)?;
    let description = before(args)?;
    (machines::entry(args.machine).calibrate)(args, &description)
}

/// The prior description: the machine file of the arguments, else that of the first recording, as for `heft estimate`.
fn before(args: &CalibrateArgs) -> Result<Description, Failure> {
    let Some(first) = args.files.first() else {
        return description(Some(args.machine), &args.description);
    };
    if is_of_heft(first)
        && let Some(its) = recording::Reader::open(first)?.machine()
        && its != args.machine
    {
        return Err(Failure::input(
            format!("this is a recording of the {its}"),
            first.display(),
            format!("`heft calibrate {its}` calibrates it"),
        ));
    }
    described(Some(args.machine), &args.description, first)
}

/// Refuses for an excavator what is stated of loaders only: it would be ignored.
fn check_machine(args: &CalibrateArgs) -> Result<(), Failure> {
    let of_loaders = [
        ("--mass", &args.mass),
        ("--weigh", &args.weigh),
        ("--out-and-back", &args.there_and_back),
    ];
    let stated = of_loaders.into_iter().find(|(_, given)| !given.is_empty());
    match (args.machine, stated) {
        (Machine::Loader, _) | (Machine::Excavator, None) => Ok(()),
        (Machine::Excavator, Some((option, given))) => Err(Failure::input(
            format!("{option} is of a loader"),
            format!("{option} {}", given.join(", ")),
            "state what was in the bucket of an excavator: --payload FILE=KG±KG",
        )),
    }
}

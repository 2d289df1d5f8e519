//! `heft calibrate`: identifies the machine's own parameters from recordings, with intervals.

pub mod args;
mod each;
pub mod inputs;
pub mod outcome;
mod page;
pub mod stated;

pub use self::args::CalibrateArgs;
use config::Description;

use crate::args::{described, description};
use crate::failure::Failure;
use crate::machines;

/// `heft calibrate`
pub fn calibrate(args: &CalibrateArgs) -> Result<(), Failure> {
    if args.each {
        return each::calibrate(args);
    }
    inputs::check_distinct(&args.files)?;
    outcome::check_outputs(args)?;
    let description = before(args)?;
    (machines::entry(args.machine).calibrate)(args, &description)
}

/// The prior description: the machine file of the arguments, else that of the first recording, as for `heft estimate`.
fn before(args: &CalibrateArgs) -> Result<Description, Failure> {
    let Some(first) = args.files.first() else {
        return description(Some(args.machine), &args.description);
    };
    let found = described(Some(args.machine), &args.description, first)?;
    if found.machine() == args.machine {
        return Ok(found);
    }
    Err(Failure::input(
        format!("this is a recording of the {}", found.machine()),
        first.display(),
        format!("heft calibrate {} ...", found.machine()),
    ))
}

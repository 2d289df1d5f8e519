//! `heft calibrate`: the machine's own parameters from recordings, with intervals.

pub mod args;
mod each;
pub mod inputs;
pub mod outcome;
mod page;
pub mod stated;

pub use self::args::CalibrateArgs;
use crate::args::description;
use crate::failure::Failure;
use crate::machines;

/// `heft calibrate`
pub fn calibrate(args: &CalibrateArgs) -> Result<(), Failure> {
    if args.each {
        return each::calibrate(args);
    }
    outcome::check_outputs(args)?;
    let description = description(args.machine, &args.description)?;
    machines::entry(args.machine).calibrate(args, &description)
}

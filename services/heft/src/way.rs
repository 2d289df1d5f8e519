//! The chain of stages from a sample to an estimate, in this process.

use config::Description;
use messages::Machine;
use messages::channels::Channel;
use steps::Error;
use steps::stages::{AnyStep, Pipeline};

/// The requested method, or that of the headline estimate.
pub fn method(machine: Machine, asked: Option<&str>) -> &str {
    let pipeline = Pipeline::of(machine);
    let main = pipeline.stage(pipeline.main);
    let usual = main.and_then(|s| s.methods().first().copied());
    asked.or(usual).unwrap_or_default()
}

/// The stages up to a method's estimate, each with the channel that it writes.
pub type Way = Vec<(&'static Channel, Box<dyn AnyStep>)>;

/// Builds the stages up to the estimate of a method.
pub fn way(description: &Description, method: &str) -> Result<Way, Error> {
    let pipeline = Pipeline::of(description.machine());
    let stage = pipeline.with_method(method);
    let stage = stage.ok_or_else(|| pipeline.unknown(method))?;
    let rows = pipeline.way_to(stage).into_iter();
    rows.map(|row| Ok((row.output(), row.start(description, method)?)))
        .collect()
}

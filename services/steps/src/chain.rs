//! The steps from a sample to an estimate, all in one process.

use config::Description;
use messages::channels::Channel;
use messages::{Envelope, Machine};

use crate::Error;
use crate::stages::{AnyStep, Pipeline};

/// The steps up to the estimate of a method, upstream first, each with the channel that it writes.
pub type Chain = Vec<(&'static Channel, Box<dyn AnyStep>)>;

/// The requested method, or that of the headline estimate.
pub fn method(machine: Machine, asked: Option<&str>) -> &str {
    let pipeline = Pipeline::of(machine);
    let main = pipeline.stage(pipeline.main);
    let usual = main.and_then(|s| s.methods().first().copied());
    asked.or(usual).unwrap_or_default()
}

/// Builds the steps up to the estimate of a method.
///
/// # Errors
/// No process of this machine offers the method, or the description is impossible for it.
pub fn chain(description: &Description, method: &str) -> Result<Chain, Error> {
    let pipeline = Pipeline::of(description.machine());
    let stage = pipeline.with_method(method);
    let stage = stage.ok_or_else(|| pipeline.unknown(method))?;
    let rows = pipeline.path_to(stage).into_iter();
    rows.map(|row| Ok((row.output(), row.start(description, method)?)))
        .collect()
}

/// Passes a sample through the steps: the answer of the last one; none if a step takes no such message.
pub fn last_answer(chain: &mut Chain, sample: Envelope) -> Option<Envelope> {
    let mut steps = chain.iter_mut();
    steps.try_fold(sample, |message, (_, step)| step.answer(&message))
}

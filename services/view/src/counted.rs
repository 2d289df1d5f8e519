//! The loads of a recording, counted as by `heft loads`.

use messages::channels::Channel;
use messages::{Machine, Message};
use recording::{Error, Reader, Sensors};
use steps::loads::{LoadCounter, Options};
use steps::stages::Pipeline;

use crate::estimate::Estimate;
use crate::loads::{Account, Truths};

macro_rules! read {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// Counts the loads of a recording; `None` if it has no description or no estimates.
        pub(crate) fn read(reader: &Reader) -> Result<Option<Account>, Error> {
            let text = reader.metadata().get("description");
            let Some(counter) = text.and_then(|t| LoadCounter::of_text(t, Options::default())) else {
                return Ok(None);
            };
            match counter.machine() {
                $( Machine::$machine => count::<messages::$sensors, messages::$estimate>(reader, counter), )*
            }
        }
    };
}

messages::machines!(read);

/// Takes samples and estimates in order, each sample before its estimate.
fn count<S: Sensors, E: Estimate>(
    reader: &Reader,
    counter: LoadCounter,
) -> Result<Option<Account>, Error> {
    let pipeline = Pipeline::of(E::MACHINE);
    let recorded = reader.channels();
    let is_recorded = |c: &&'static Channel| recorded.contains(&c.name);
    let headline = pipeline.main_output().filter(is_recorded);
    let Some(channel) = headline.or(pipeline.estimates().find(is_recorded)) else {
        return Ok(None);
    };
    let mut samples = reader.stream::<S>(S::SENSORS.name)?.peekable();
    let mut counter = counter.remembering_all();
    let mut trucks = Vec::new();
    for estimate in reader.stream::<E>(channel.name)? {
        let is_due = |s: &S| s.stamp().sequence <= estimate.stamp().sequence;
        while let Some(sample) = samples.next_if(is_due) {
            trucks.extend(counter.see(&sample.envelope()).truck);
        }
        trucks.extend(counter.see(&estimate.envelope()).truck);
    }
    trucks.extend(counter.finish().truck);
    let mut truths = Truths::default();
    if let Some(payload) = E::PARAMETERS.iter().find(|p| p.is_load) {
        for truth in reader.stream::<E::Truth>(S::TRUTH.name)? {
            truths.know(truth.stamp().time, payload.truth(&truth));
        }
    }
    Ok(Some(Account::of("", &counter, trucks, &truths)))
}

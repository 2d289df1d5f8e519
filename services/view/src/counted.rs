//! The loads of a recording, counted as `heft loads` counts them.

use std::cmp::Ordering;

use messages::Machine;
use recording::{Error, Reader, Sensors};
use steps::loads::{LoadCounter, Options};

use crate::estimate::Estimate;
use crate::loads::Account;
use crate::run::{MachineRun, Parts};

macro_rules! read {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// Counts the loads of a recording; `None` where it has no description or no estimates.
        pub(crate) fn read(reader: &Reader, parts: &Parts) -> Result<Option<Account>, Error> {
            let text = reader.metadata().get("description");
            let Some(counter) = text.and_then(|t| LoadCounter::of_text(t, Options::default())) else {
                return Ok(None);
            };
            match counter.machine() {
                $( Machine::$machine => count::<messages::$sensors, _>(reader, counter, &parts.$module), )*
            }
        }
    };
}

messages::machines!(read);

/// Takes samples and estimates in the order of their time, each sample before its estimate.
fn count<S: Sensors, E: Estimate>(
    reader: &Reader,
    mut counter: LoadCounter,
    part: &MachineRun<E>,
) -> Result<Option<Account>, Error> {
    let channels = || part.estimators.iter().map(|e| e.channel.as_str());
    let headline = channels().find(|c| steps::loads::counts(E::MACHINE, c));
    let Some(channel) = headline.or(channels().next_back()) else {
        return Ok(None);
    };
    let mut samples = reader.stream::<S>(S::SENSORS.name)?.peekable();
    let mut trucks = Vec::new();
    for estimate in reader.stream::<E>(channel)? {
        let time = estimate.stamp().time;
        // A sample whose time is NaN holds up none.
        let is_due = |s: &S| s.stamp().time.partial_cmp(&time) != Some(Ordering::Greater);
        while let Some(sample) = samples.next_if(is_due) {
            trucks.extend(counter.see(&sample.envelope()).truck);
        }
        trucks.extend(counter.see(&estimate.envelope()).truck);
    }
    trucks.extend(counter.finish().truck);
    Ok(Some(Account::of("", &counter, trucks)))
}

use std::collections::BTreeMap;
use std::path::Path;

use messages::channels::{
    Channel, EXCAVATOR_SENSORS, EXCAVATOR_TRUTH, LOADER_SENSORS, LOADER_TRUTH,
};
use messages::{ExcavatorSensors, ExcavatorTruth, LoaderSensors, LoaderTruth, Message};

use crate::signal::{Excavator, Loader, Machine, Row};
use crate::{Error, Map, Reader, can, csv};

/// Reads the samples of an excavator from a table (`.csv`), a recording (`.mcap`) or a CAN log
/// (`.log`, which needs a map).
///
/// # Errors
/// The file cannot be read or lacks something; the error says what and where.
pub fn load_excavator(
    path: impl AsRef<Path>,
    map: Option<&Map>,
) -> Result<Vec<(ExcavatorSensors, ExcavatorTruth)>, Error> {
    load::<Excavator>(path.as_ref(), map, [&EXCAVATOR_SENSORS, &EXCAVATOR_TRUTH])
}

/// Reads the samples of a wheel loader, as [`load_excavator`] does.
///
/// # Errors
/// As [`load_excavator`].
pub fn load_loader(
    path: impl AsRef<Path>,
    map: Option<&Map>,
) -> Result<Vec<(LoaderSensors, LoaderTruth)>, Error> {
    load::<Loader>(path.as_ref(), map, [&LOADER_SENSORS, &LOADER_TRUTH])
}

fn load<M: Machine>(
    path: &Path,
    map: Option<&Map>,
    channels: [&Channel; 2],
) -> Result<Vec<Row<M>>, Error> {
    let place = || path.display().to_string();
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match (ending.as_deref(), map) {
        (Some("csv" | "txt"), _) => csv::read::<M>(path, map),
        (Some("log"), Some(map)) => can::read::<M>(path, map),
        (Some("mcap"), None) => recorded::<M>(path, channels),
        (Some("log"), None) => Err(Error::new(
            "a CAN log needs a signal map",
            place(),
            "give one with --map; it names the DBC file and the signals",
        )),
        (Some("mcap"), Some(_)) => Err(Error::new(
            "a recording of heft takes no signal map",
            place(),
            "leave out --map",
        )),
        _ => Err(Error::new(
            "the kind of file cannot be told from its name",
            place(),
            "give a file that ends in .csv, .mcap or .log",
        )),
    }
}

fn recorded<M: Machine>(path: &Path, channels: [&Channel; 2]) -> Result<Vec<Row<M>>, Error> {
    let reader = Reader::open(path)?;
    let [sensors, truth] = channels;
    let sensors: Vec<M::Sensors> = reader.messages(sensors.name)?;
    if sensors.is_empty() {
        return Err(Error::new(
            format!("the recording has no samples of a {}", M::NAME),
            path.display().to_string(),
            format!("it has the channels {}", reader.channels().join(", ")),
        ));
    }
    let truth: Vec<M::Truth> = reader.messages(truth.name)?;
    let mut truth: BTreeMap<_, _> = truth.into_iter().map(|t| (identity(&t), t)).collect();
    let rows = sensors.into_iter().map(|s| {
        let truth = truth.remove(&identity(&s)).unwrap_or_default();
        (s, truth)
    });
    Ok(rows.collect())
}

/// Machine, restart of the source, number: what sample and truth have in common.
fn identity<M: Message>(message: &M) -> (u32, u32, u64) {
    let stamp = message.stamp();
    (stamp.machine, stamp.epoch, stamp.sequence)
}

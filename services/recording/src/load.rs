use std::path::Path;

use messages::{ExcavatorSensors, ExcavatorTruth, LoaderSensors, LoaderTruth, Message};

use crate::signal::{Excavator, Loader, Machine};
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
    Ok(open::<Excavator>(path, map)?.rows()?.collect())
}

/// Reads the samples of a wheel loader, as [`load_excavator`] does.
///
/// # Errors
/// As [`load_excavator`].
pub fn load_loader(
    path: impl AsRef<Path>,
    map: Option<&Map>,
) -> Result<Vec<(LoaderSensors, LoaderTruth)>, Error> {
    Ok(open::<Loader>(path, map)?.rows()?.collect())
}

/// Samples of a machine with their truth. Those of a recording are read one after the other, so that
/// its length does not matter.
pub struct Samples<S, T>(Source<S, T>);

enum Source<S, T> {
    Table(Vec<(S, T)>),
    Recording(Box<Reader>, [&'static str; 2]),
}

impl<S: Message, T: Message> Samples<S, T> {
    /// Sample by sample.
    ///
    /// # Errors
    /// The recording carries something else under these names.
    pub fn rows(&self) -> Result<Box<dyn Iterator<Item = (S, T)> + '_>, Error> {
        let (reader, [sensors, truth]) = match &self.0 {
            Source::Table(rows) => return Ok(Box::new(rows.iter().copied())),
            Source::Recording(reader, channels) => (reader, *channels),
        };
        let mut truth = reader.stream::<T>(truth)?.peekable();
        Ok(Box::new(reader.stream::<S>(sensors)?.map(move |sample| {
            let place = identity(&sample);
            while truth.next_if(|t| identity(t) < place).is_some() {}
            let its = truth.next_if(|t| identity(t) == place);
            (sample, its.unwrap_or_default())
        })))
    }

    /// The recording that they come from, if they do.
    #[must_use]
    pub fn recording(&self) -> Option<&Reader> {
        match &self.0 {
            Source::Table(_) => None,
            Source::Recording(reader, _) => Some(reader),
        }
    }

    /// Has `told` called with the share that is read (0 to 1).
    pub fn on_progress(&mut self, told: impl Fn(f64) + 'static) {
        if let Source::Recording(reader, _) = &mut self.0 {
            reader.on_progress(told);
        }
    }
}

/// Opens the samples of a machine: a table (`.csv`), a recording (`.mcap` or its folder) or a CAN log
/// (`.log`, which needs a map).
///
/// # Errors
/// The file cannot be read or lacks something; the error says what and where.
pub fn open<M: Machine>(
    path: impl AsRef<Path>,
    map: Option<&Map>,
) -> Result<Samples<M::Sensors, M::Truth>, Error> {
    let path = path.as_ref();
    let place = || path.display().to_string();
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let ending = if path.is_dir() {
        Some("mcap".into())
    } else {
        ending
    };
    match (ending.as_deref(), map) {
        (Some("csv" | "txt"), _) => Ok(Samples(Source::Table(csv::read::<M>(path, map)?))),
        (Some("log"), Some(map)) => Ok(Samples(Source::Table(can::read::<M>(path, map)?))),
        (Some("mcap"), None) => recorded::<M>(path),
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

fn recorded<M: Machine>(path: &Path) -> Result<Samples<M::Sensors, M::Truth>, Error> {
    let reader = Reader::open(path)?;
    let names = [M::SENSORS.name, M::TRUTH.name];
    if reader.stream::<M::Sensors>(names[0])?.next().is_none() {
        return Err(Error::new(
            format!("the recording has no samples of a {}", M::NAME),
            path.display().to_string(),
            format!("it has the channels {}", reader.channels().join(", ")),
        ));
    }
    Ok(Samples(Source::Recording(Box::new(reader), names)))
}

/// Machine, restart of the source, number: what sample and truth have in common.
fn identity<M: Message>(message: &M) -> (u32, u32, u64) {
    let stamp = message.stamp();
    (stamp.machine, stamp.epoch, stamp.sequence)
}

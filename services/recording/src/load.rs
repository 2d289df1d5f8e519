use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

use messages::Message;

use crate::signal::{Row, Sensors};
use crate::topics::TopicRows;
use crate::{Error, Finding, Kind, Lacks, Map, Quoted, Reader, can, csv, kind};

/// Reads the samples of a machine from a table, a recording or a CAN log, which needs a map.
///
/// # Errors
/// The file cannot be read, is damaged or lacks data; the error states what and where. Of a recording that was cut
/// off, the rows before the cut are returned.
pub fn load<S: Sensors>(path: impl AsRef<Path>, map: Option<&Map>) -> Result<Vec<Row<S>>, Error> {
    let samples = open::<S>(path, map)?;
    let rows = samples.rows()?.collect();
    samples.check()?;
    let lacks = samples.lacks();
    let remarks = lacks.remarks().chain(lacks.cut_off.as_deref());
    remarks.for_each(|lack| tracing::warn!("{lack}"));
    let damage = lacks.damage;
    if !damage.is_empty() {
        return Err(Error::new(
            "the recording is damaged",
            damage.join("; "),
            "`heft recover` writes a copy of what is whole; decide whether that is enough",
        ));
    }
    Ok(rows)
}

/// Samples of a machine with their truth, read one by one, so that memory does not grow with the length of
/// the file.
pub struct Samples<S, T> {
    source: Source<S, T>,
    /// Why reading ended early.
    error: RefCell<Option<Error>>,
    progress: Option<Box<dyn Fn(f64)>>,
    /// Missing and damaged contents of a file; of a table they are known at its end.
    lacks: Noted,
    /// Reads a table again, in search of a column by which it is of several machines or recordings.
    several: Option<Box<dyn Fn() -> Option<Finding>>>,
}

type Noted = Rc<RefCell<Lacks>>;

enum Source<S, T> {
    File(Box<dyn Fn() -> Result<FileRows<S, T>, Error>>, u64),
    Recording(Box<Reader>, [&'static str; 2]),
}

/// Returns the next row of a file, with the number of bytes read.
type FileRows<S, T> = Box<dyn FnMut() -> Result<Option<((S, T), u64)>, Error>>;

/// Rows at the begin of a table in which one of several machines is searched: 40 s at 100 Hz.
const LOOKED_AT: usize = 1 << 12;

/// Rows between two reports of progress.
const PROGRESS_EVERY: u64 = 1 << 12;

impl<S: Message, T: Message> Samples<S, T> {
    fn of(source: Source<S, T>) -> Self {
        Self {
            source,
            error: RefCell::default(),
            progress: None,
            lacks: Rc::default(),
            several: None,
        }
    }

    /// The samples one by one. They end early if the file cannot be read further: see [`Samples::check`].
    ///
    /// # Errors
    /// The file cannot be opened, or the channels of the recording have other types.
    pub fn rows(&self) -> Result<Box<dyn Iterator<Item = (S, T)> + '_>, Error> {
        let (reader, [sensors, truth]) = match &self.source {
            Source::File(open, length) => return Ok(Box::new(self.of_file(open()?, *length))),
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

    fn of_file(&self, mut next: FileRows<S, T>, length: u64) -> impl Iterator<Item = (S, T)> {
        let tell = |share: f64| {
            if let Some(progress) = &self.progress {
                progress(share);
            }
        };
        let mut count = 0;
        std::iter::from_fn(move || match next() {
            Ok(Some((row, read))) => {
                count += 1;
                if count % PROGRESS_EVERY == 0 {
                    tell((read as f64 / length.max(1) as f64).min(0.999));
                }
                Some(row)
            }
            end => {
                tell(1.0);
                *self.error.borrow_mut() = end.err();
                None
            }
        })
    }

    /// Checks that all rows were read.
    ///
    /// # Errors
    /// The file could not be read to its end.
    pub fn check(&self) -> Result<(), Error> {
        self.error.borrow_mut().take().map_or(Ok(()), Err)
    }

    /// Missing and damaged contents of the file, as far as the rows were read.
    pub fn lacks(&self) -> Lacks {
        self.recording()
            .map_or_else(|| self.lacks.borrow().clone(), Reader::lacks)
    }

    /// What parts a table whose times are out of order into several machines or recordings. The file is read again.
    pub fn several(&self) -> Option<Finding> {
        self.several.as_ref().and_then(|find| find())
    }

    /// The recording that they come from, if any.
    pub fn recording(&self) -> Option<&Reader> {
        match &self.source {
            Source::File(..) => None,
            Source::Recording(reader, _) => Some(reader),
        }
    }

    /// Calls `progress` with the share that is read (0 to 1).
    pub fn on_progress(&mut self, progress: impl Fn(f64) + 'static) {
        match &mut self.source {
            Source::File(..) => self.progress = Some(Box::new(progress)),
            Source::Recording(reader, _) => reader.on_progress(progress),
        }
    }
}

/// Opens the samples of a machine: a table, a recording (or its folder) or a CAN log, which needs a map.
///
/// # Errors
/// The file cannot be read or lacks data; the error states what and where.
pub fn open<S: Sensors>(
    path: impl AsRef<Path>,
    map: Option<&Map>,
) -> Result<Samples<S, S::Truth>, Error> {
    let path = path.as_ref();
    let place = || path.display().to_string();
    match (Kind::of(path)?, map) {
        (Kind::Table, Some(map)) if map.columns.is_empty() => Err(Error::new(
            "the signal map names no columns, and this is a table",
            place(),
            match map.has_can() {
                true => {
                    "give a log of candump: `can_logconvert FILE OUT.log` (pip install python-can) makes one of frames; or name columns under [columns]"
                }
                false => {
                    "name them under [columns] (`heft map FILE` writes a first map), or leave out --map"
                }
            },
        )),
        (Kind::Table, _) => table::<S>(path, map),
        (Kind::Log, Some(map)) => log::<S>(path, map),
        (Kind::Recording, None) => recorded::<S>(path),
        (Kind::Log, None) => Err(kind::no_map(&place())),
        (Kind::Recording, Some(map)) if map.has_topics() => topics::<S>(path, map),
        (Kind::Recording, Some(_)) => Err(Error::new(
            "the signal map names no topics",
            place(),
            "leave out --map for a recording of heft; name topics under [topics.signals] for one of others",
        )),
    }
}

fn table<S: Sensors>(path: &Path, map: Option<&Map>) -> Result<Samples<S, S::Truth>, Error> {
    if let Some(found) = csv::several::<S>(path, map, (csv::By::Values, LOOKED_AT)) {
        return Err(Error::new(
            found.what,
            path.display().to_string(),
            found.remedy,
        ));
    }
    let (its_path, map) = (path.to_owned(), map.cloned());
    let (again, its_map) = (its_path.clone(), map.clone());
    let several = move || csv::several::<S>(&again, its_map.as_ref(), (csv::By::Times, usize::MAX));
    let samples = of_file(path, move |found| {
        let mut rows = csv::TableRows::<S>::open(&its_path, map.as_ref())?;
        Ok(Box::new(move || {
            let row = rows.row()?;
            if row.is_none() {
                let mut found = found.borrow_mut();
                found.cut_off = rows.cut_off().map(str::to_owned);
                found.empty = rows.empty();
            }
            Ok(row.map(|row| (row, rows.read())))
        }))
    });
    Ok(Samples {
        several: Some(Box::new(several)),
        ..samples?
    })
}

fn topics<S: Sensors>(path: &Path, map: &Map) -> Result<Samples<S, S::Truth>, Error> {
    let (its_path, map, length) = (path.to_owned(), map.clone(), length(path));
    of_file(path, move |found| {
        let mut rows = TopicRows::<S>::open(&its_path, &map)?;
        found.borrow_mut().clone_from(&rows.lacks);
        Ok(Box::new(move || Ok(rows.row().map(|row| (row, length)))))
    })
}

fn log<S: Sensors>(path: &Path, map: &Map) -> Result<Samples<S, S::Truth>, Error> {
    let (its_path, map) = (path.to_owned(), map.clone());
    of_file(path, move |found| {
        let mut log = can::Log::<S>::open(&its_path, &map)?;
        Ok(Box::new(move || {
            let row = log.row()?;
            if row.is_none() {
                found.borrow_mut().clone_from(&log.lacks);
            }
            Ok(row.map(|row| (row, log.read)))
        }))
    })
}

/// The samples of a file that `open` opens; its reader notes there what is missing.
fn of_file<S: Message, T: Message>(
    path: &Path,
    open: impl Fn(Noted) -> Result<FileRows<S, T>, Error> + 'static,
) -> Result<Samples<S, T>, Error> {
    let lacks = Noted::default();
    let noted = Rc::clone(&lacks);
    let open = move || open(Rc::clone(&noted));
    // Errors in the header are reported at once.
    drop(open()?);
    Ok(Samples {
        lacks,
        ..Samples::of(Source::File(Box::new(open), length(path)))
    })
}

/// Bytes of a file; 0 if that is unknown.
fn length(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(0, |m| m.len())
}

fn recorded<S: Sensors>(path: &Path) -> Result<Samples<S, S::Truth>, Error> {
    let reader = Reader::open(path)?;
    let names = [S::SENSORS.name, S::TRUTH.name];
    if reader.stream::<S>(names[0])?.next().is_none() {
        return Err(without_samples::<S>(&reader, path));
    }
    Ok(Samples::of(Source::Recording(Box::new(reader), names)))
}

fn without_samples<S: Sensors>(reader: &Reader, path: &Path) -> Error {
    let (lacks, place) = (reader.lacks(), path.display().to_string());
    if reader.is_being_written() {
        return Error::new(
            format!("nothing of the {} is on disk yet", S::MACHINE),
            place,
            "wait until its run has written some",
        );
    }
    // A recording of heft that was cut off before its first chunk was on disk.
    let is_ours = reader.metadata().contains_key("machine") || reader.channels().is_empty();
    if is_ours && !lacks.all().is_empty() {
        return Error::new(
            format!(
                "the recording is damaged, and what is left has no samples of the {}",
                S::MACHINE
            ),
            lacks.all().join(", "),
            "take another copy of it, if there is one",
        );
    }
    Error::new(
        format!("the recording has no samples of the {}", S::MACHINE),
        place,
        format!(
            "it has {}; name topics and fields of it in a map: heft map {} > map.toml",
            reader.channels().join(", "),
            Quoted(path.display())
        ),
    )
}

/// Machine, restart of the source, number: the identity that sample and truth have in common.
fn identity<M: Message>(message: &M) -> (u32, u32, u64) {
    let stamp = message.stamp();
    (stamp.machine, stamp.epoch, stamp.sequence)
}

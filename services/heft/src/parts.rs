//! Recordings as commands open them, and the parts that a run leaves. A logger that was killed and
//! restarted begins a new file, so that the data on disk cannot be harmed. At the end of
//! the run the parts become one recording.

use std::cell::Cell;
use std::fs;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use messages::channels::{Channel, Visitor};
use messages::{Carries, Envelope, Message};
use recording::{Lacks, Reader};
use rustix::fs::{CWD, RenameFlags, renameat_with};

use crate::failure::Failure;
use crate::group;
use crate::out;

/// Opens a recording or its folder, and reports its state. It is never written to.
pub fn open(path: &Path) -> Result<Reader, Failure> {
    let mut reader = Reader::open(path)?;
    let files = reader.files().count();
    if path.is_dir() {
        note_others(path, &reader);
    }
    if files > 1 {
        eprintln!("{}: read with its {files} parts", path.display());
    }
    if reader.is_being_written() {
        eprintln!("{}: it is being written; read up to here", path.display());
    }
    reader.on_progress(progress());
    Ok(reader)
}

fn note_others(folder: &Path, reader: &Reader) {
    let Some(first) = reader.files().next() else {
        return;
    };
    let others = recording::recordings(folder).len().saturating_sub(1);
    let name = first.display();
    match others {
        0 => {}
        1 => eprintln!("{name}: the newest of two recordings in the folder"),
        _ => eprintln!(
            "{name}: the newest of {} recordings in the folder",
            others + 1
        ),
    }
}

/// A line on the terminal while a long recording is read.
pub fn progress() -> impl Fn(f64) {
    const PATIENCE: Duration = Duration::from_secs(1);
    const PERIOD: Duration = Duration::from_millis(200);
    let shown = Cell::new(Instant::now() + PATIENCE);
    let is_shown = Cell::new(false);
    move |share| {
        if !std::io::stderr().is_terminal() {
            return;
        }
        let now = Instant::now();
        if share >= 1.0 && is_shown.take() {
            out::draw("\r\x1b[2K");
        } else if share < 1.0 && now >= shown.get() {
            shown.set(now + PERIOD);
            is_shown.set(true);
            out::draw(&format!("\r\x1b[2Kreading {:.0} %", 100.0 * share));
        }
    }
}

/// The messages of a channel in order, whatever their type.
pub fn envelopes<'a>(
    reader: &'a Reader,
    channel: &'a Channel,
) -> Result<Box<dyn Iterator<Item = Envelope> + 'a>, recording::Error> {
    struct Read<'a>(&'a Reader, &'a str);

    impl<'a> Visitor for Read<'a> {
        type Output = Result<Box<dyn Iterator<Item = Envelope> + 'a>, recording::Error>;

        fn visit<M: Message>(self) -> Self::Output {
            let messages = self.0.stream::<M>(self.1)?;
            Ok(Box::new(messages.map(|message| message.envelope())))
        }
    }

    channel.payload.visit(Read(reader, channel.name))
}

/// Fails on a recording that is damaged, or whose end is missing; called after it was read.
pub fn check_whole(reader: &Reader) -> Result<(), Failure> {
    let lacks = reader.lacks();
    check_undamaged(&lacks)?;
    check_end(&lacks, || last_time(reader))
}

/// Time of the last sample \[s\].
fn last_time(reader: &Reader) -> Option<f64> {
    let sensors = messages::channels::all().filter(|c| c.payload.carries() == Carries::Sensors);
    let times = sensors.filter_map(|channel| envelopes(reader, channel).ok());
    let times = times.flat_map(|samples| samples.map(|sample| sample.stamp().time));
    times.filter(|time| time.is_finite()).reduce(f64::max)
}

/// Fails on a damaged input. The error names each place of the damage, and a missing end.
pub fn check_undamaged(lacks: &Lacks) -> Result<(), Failure> {
    if lacks.damage.is_empty() {
        return Ok(());
    }
    let places: Vec<_> = lacks.damage.iter().chain(&lacks.cut_off).cloned().collect();
    Err(Failure::answer_is_no(format!(
        "the recording is damaged; everything else in it was read\n  where: {}\n  what to do: `heft recover` writes a copy of what is whole",
        places.join("\n         ")
    )))
}

/// Fails on an input that ends too early, as after a logger was switched off or a run was killed. `last`: time of the last row.
pub fn check_end(lacks: &Lacks, last: impl FnOnce() -> Option<f64>) -> Result<(), Failure> {
    let Some(cut) = &lacks.cut_off else {
        return Ok(());
    };
    let read = last().map_or(String::new(), |time| format!(", up to t = {time:.2} s"));
    Err(Failure::answer_is_no(format!(
        "the end of the input is missing; what is before it was read{read}\n  where: {cut}\n  \
         what to do: copy the file again; if it ends there too, its writer wrote no more"
    )))
}

/// Fails on a recording without samples and estimates, which has nothing to show.
pub fn check_content(reader: &Reader) -> Result<(), Failure> {
    let shows = |c: &Channel| matches!(c.payload.carries(), Carries::Sensors | Carries::Estimate);
    for channel in messages::channels::all().filter(|c| shows(c)) {
        if reader.channels().contains(&channel.name) && envelopes(reader, channel)?.next().is_some()
        {
            return Ok(());
        }
    }
    Err(Failure::answer_is_no(format!(
        "the recording holds no samples and no estimates\n  where: {}\n  what to do: look at the summary of the run that made it, or record again",
        reader
            .files()
            .next()
            .map_or(String::new(), |f| f.display().to_string())
    )))
}

/// The name of a run's recording, see [`recording::reserve`]. An empty file is removed.
pub struct Reserved(pub PathBuf);

impl Drop for Reserved {
    fn drop(&mut self) {
        if fs::metadata(&self.0).is_ok_and(|m| m.is_file() && m.len() == 0) {
            let _ = fs::remove_file(&self.0);
        }
    }
}

/// At the end of a run: joins a recording in parts. Parts that cannot be joined are still read as one.
pub fn finish(recording: &Path, group: Option<u32>) -> Result<(), Failure> {
    // Nothing was written, or it was removed, which the logger reports.
    if fs::metadata(recording).map_or(!recording::exists(recording), |m| m.len() == 0) {
        return Ok(());
    }
    join(recording)?;
    group.map_or(Ok(()), |group| group::share(recording, group))
}

/// Joins the parts of a finished recording whose logger was restarted into one file; a recording of
/// one part stays. Unreadable parts stay unchanged, and so do all parts if this is
/// interrupted: readers find the parts.
fn join(recording: &Path) -> Result<(), Failure> {
    let reader = Reader::open(recording)?;
    let parts: Vec<PathBuf> = reader.files().map(Path::to_owned).collect();
    // One of the parts may be from before a crash of this run, but none is of another run: see `reserve`.
    let is_split = reader.metadata().contains_key("split");
    if parts.len() < 2 || is_split {
        return Ok(());
    }
    let joined = recording.with_extension("joined.mcap");
    recording::join(&reader, &joined)?;
    drop(reader);
    let fail = |e: rustix::io::Errno| Failure::file("join the parts of", recording, &e.into());
    // In one step: at every moment there is either the first part or the whole under its name.
    renameat_with(CWD, &joined, CWD, recording, RenameFlags::EXCHANGE).map_err(fail)?;
    for file in parts.iter().filter(|p| *p != recording).chain([&joined]) {
        fs::remove_file(file).map_err(|e| Failure::file("remove", file, &e))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::ExcavatorSensors;
    use messages::channels::EXCAVATOR_SENSORS;
    use recording::{Metadata, Writer};

    fn write(file: &Path, numbers: std::ops::Range<u64>) {
        let mut writer = Writer::create(file, &Metadata::new()).unwrap();
        for number in numbers {
            let mut message = ExcavatorSensors::default();
            message.stamp.sequence = number;
            message.stamp.measured_ns = 1_000 + number;
            writer.write(&EXCAVATOR_SENSORS, &message).unwrap();
        }
        writer.finish().unwrap();
    }

    fn numbers(file: &Path) -> Vec<u64> {
        let reader = Reader::open(file).unwrap();
        let messages = reader.stream::<ExcavatorSensors>("excavator/sensors");
        messages.unwrap().map(|m| m.stamp.sequence).collect()
    }

    #[test]
    fn parts_are_read_as_one_recording_and_become_one() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("run.mcap");
        for range in [0..10, 12..20, 25..30] {
            write(&recording::next_part(&file), range);
        }
        let expected: Vec<u64> = (0..10).chain(12..20).chain(25..30).collect();
        assert_eq!(numbers(&file), expected);
        assert_eq!(numbers(folder.path()), expected);
        join(&file).unwrap();
        assert_eq!(numbers(&file), expected);
        let left = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, 1, "the parts are gone");
    }
}

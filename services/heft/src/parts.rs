//! Recordings in parts: a logger that was killed and started again begins a new file, so that what
//! is on disk already cannot be harmed. At the end of the run the parts become one recording.

use std::fs;
use std::path::{Path, PathBuf};

use messages::channels::{CHANNELS, Channel, Visitor};
use messages::{Envelope, Message, Receiver};
use recording::{Reader, Writer};

use crate::failure::Failure;

/// Name of part `index` of a recording.
fn part(recording: &Path, index: u32) -> PathBuf {
    recording.with_extension(format!("part{index}.mcap"))
}

/// Puts aside what the logger had written before its `restarts`-th restart.
pub fn put_aside(recording: &Path, restarts: u32) -> Result<(), Failure> {
    if restarts == 0 || !recording.exists() {
        return Ok(());
    }
    let aside = part(recording, restarts);
    fs::rename(recording, &aside).map_err(|e| Failure::file("put aside", &aside, &e))
}

/// Joins the parts of a recording, oldest first, and removes them; does nothing where there are
/// none. Parts that cannot be read stay as they are.
pub fn join(recording: &Path, restarts: u32) -> Result<(), Failure> {
    let parts: Vec<PathBuf> = (1..=restarts)
        .map(|i| part(recording, i))
        .filter(|p| p.exists())
        .collect();
    if parts.is_empty() {
        return Ok(());
    }
    let mut entries = Vec::new();
    let mut metadata = None;
    for file in parts.iter().map(PathBuf::as_path).chain([recording]) {
        if !file.exists() {
            continue;
        }
        let reader = Reader::open(file)?;
        metadata.get_or_insert_with(|| reader.metadata().clone());
        for &channel in CHANNELS {
            let messages = envelopes(&reader, channel)?;
            entries.extend(messages.into_iter().map(|message| Entry {
                published_ns: published_ns(&message),
                channel,
                message,
            }));
        }
    }
    let Some(metadata) = metadata else {
        return Ok(());
    };
    entries.sort_by_key(|entry| entry.published_ns);
    let joined = recording.with_extension("joined.mcap");
    let mut writer = Writer::create(&joined, &metadata)?;
    for entry in &entries {
        entry.message.open(WriteTo(&mut writer, entry.channel))?;
    }
    writer.finish()?;
    fs::rename(&joined, recording).map_err(|e| Failure::file("write", recording, &e))?;
    for file in parts {
        fs::remove_file(&file).map_err(|e| Failure::file("remove", &file, &e))?;
    }
    Ok(())
}

struct Entry {
    published_ns: u64,
    channel: &'static Channel,
    message: Envelope,
}

/// When the last stage that a message passed published it [ns].
fn published_ns(message: &Envelope) -> u64 {
    let hops = message.hops();
    let last = hops.sensor_ns.max(hops.filter_ns).max(hops.estimate_ns);
    last.max(message.stamp().measured_ns)
}

/// The messages of a channel, whatever their type.
pub fn envelopes(reader: &Reader, channel: &Channel) -> Result<Vec<Envelope>, recording::Error> {
    struct Read<'a>(&'a Reader, &'a str);

    impl Visitor for Read<'_> {
        type Output = Result<Vec<Envelope>, recording::Error>;

        fn visit<M: Message>(self) -> Self::Output {
            let messages: Vec<M> = self.0.messages(self.1)?;
            Ok(messages.iter().map(Message::envelope).collect())
        }
    }

    channel.payload.visit(Read(reader, channel.name))
}

struct WriteTo<'a>(&'a mut Writer, &'static Channel);

impl Receiver for WriteTo<'_> {
    type Output = Result<(), recording::Error>;

    fn receive<M: Message>(self, message: &M) -> Self::Output {
        self.0.write(self.1, message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::ExcavatorSensors;
    use messages::channels::EXCAVATOR_SENSORS;
    use recording::Metadata;

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

    #[test]
    fn parts_become_one_recording_in_order() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("run.mcap");
        write(&file, 0..10);
        put_aside(&file, 1).unwrap();
        write(&file, 12..20);
        put_aside(&file, 2).unwrap();
        write(&file, 25..30);
        join(&file, 2).unwrap();
        let messages: Vec<ExcavatorSensors> = Reader::open(&file)
            .unwrap()
            .messages("excavator/sensors")
            .unwrap();
        let numbers: Vec<u64> = messages.iter().map(|m| m.stamp.sequence).collect();
        let expected: Vec<u64> = (0..10).chain(12..20).chain(25..30).collect();
        assert_eq!(numbers, expected);
        assert_eq!(
            fs::read_dir(folder.path()).unwrap().count(),
            1,
            "the parts are gone"
        );
    }
}

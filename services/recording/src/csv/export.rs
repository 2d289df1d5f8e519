use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use messages::channels;
use messages::{Value, Words, words};

use super::estimate::put_number;
use crate::output::{Output, first_line};
use crate::presence::Recorded;
use crate::{Error, Reader, RecordedField};

/// Writes each channel of a recording to a CSV file of its own in a folder, which is created if
/// needed: `excavator/sensors` becomes `excavator_sensors.csv`. Columns are the recorded fields, with codes
/// by their names, followed by a column of 0 and 1 for each flag. A number that was not
/// measured, or is not estimated, is an empty cell.
///
/// # Errors
/// The recording is damaged, or the folder cannot be written.
pub fn export(reader: &Reader, folder: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
    let folder = folder.as_ref();
    std::fs::create_dir_all(folder).map_err(|e| Error::system("create the folder", folder, &e))?;
    let channels = reader.channels().into_iter();
    channels
        .map(|channel| one(reader, channel, folder))
        .collect()
}

/// Recognizes an exported channel, of any version, by the first bytes of a file.
pub fn is_export(head: &[u8]) -> bool {
    head.starts_with(b"machine,epoch,sequence,")
}

fn one(reader: &Reader, channel: &str, folder: &Path) -> Result<PathBuf, Error> {
    let path = folder.join(format!("{}.csv", channel.replace('/', "_")));
    let inputs: Vec<&Path> = reader.files().collect();
    let fields = reader.fields(channel);
    let meaning = Meaning::of(channel, &fields);
    let names = fields.iter().map(|f| f.name.as_str());
    let flags = meaning.flags.iter().map(|(name, _)| name.as_ref());
    let header = names.chain(flags).collect::<Vec<_>>().join(",");
    let is_ours = |head: &[u8]| is_export(head) || first_line(head).unwrap_or_default() == header;
    let mut out = Output::create("write the channel", &path, &inputs, is_ours)?;
    out.put(header.as_bytes())?;
    out.put(b"\n")?;
    let numbers = Recorded::of(channel, &fields);
    let mut row = String::new();
    let mut outcome = Ok(());
    reader.for_each_value(channel, |_, values| {
        row.clear();
        let lacks = numbers.lacks(values);
        for (i, value) in values.iter().enumerate() {
            row.push_str(if i == 0 { "" } else { "," });
            match (meaning.codes[i], value) {
                (Some(words), Value::U32(code)) => row.push_str(words.name(*code)),
                _ if lacks(i) => {}
                _ => put(&mut row, *value),
            }
        }
        let flags = meaning.at.map_or(0, |at| values[at].as_f64() as u32);
        for (_, bit) in &meaning.flags {
            row.push_str(if flags & bit == 0 { ",0" } else { ",1" });
        }
        row.push('\n');
        if outcome.is_ok() {
            outcome = out.put(row.as_bytes());
        }
    })?;
    outcome?;
    out.finish()?;
    Ok(path)
}

/// Meaning of the codes and bits of a channel; empty for an unknown channel.
struct Meaning {
    /// For each field the names of its codes.
    codes: Vec<Option<&'static Words>>,
    /// Position of the field of flags.
    at: Option<usize>,
    /// Name and bit of each flag.
    flags: Vec<(Cow<'static, str>, u32)>,
}

impl Meaning {
    fn of(channel: &str, fields: &[RecordedField]) -> Self {
        let known = channels::find(channel).map(|c| c.payload.shape());
        let codes = |f: &RecordedField| {
            let words = known.and_then(|shape| shape.words_of(&f.name));
            words.filter(|w| matches!(w, Words::Codes(_)))
        };
        let at = fields.iter().position(|f| f.name == "flags");
        let flags = known.filter(|_| at.is_some()).into_iter();
        let flags = flags.flat_map(words::flags);
        Self {
            codes: fields.iter().map(codes).collect(),
            at,
            flags: flags.map(|(name, entry)| (name, entry.number)).collect(),
        }
    }
}

fn put(row: &mut String, value: Value) {
    let _ = match value {
        Value::F64(x) => {
            put_number(row, x);
            Ok(())
        }
        Value::U32(n) => write!(row, "{n}"),
        Value::U64(n) => write!(row, "{n}"),
    };
}

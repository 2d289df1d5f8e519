//! MCAP files of other programs (ROS 2, Foxglove, own loggers): numbers by topic and field, by a map.

pub(crate) mod codec;
pub(crate) mod list;
pub(crate) mod node;
mod proto;
mod ros;

use std::collections::BTreeMap;
use std::path::Path;

use self::codec::Codec;
use self::node::{Step, path};
use crate::Error;
use crate::copy::{UNREADABLE, for_each_message};
use crate::map::{Entry, Map, Origin, TopicName, TopicTime, Topics, hint};
use crate::mapped::{MappedRows, Source};
use crate::reader::{Lacks, Part, Reader};
use crate::sampling::Series;
use crate::signal::{self, Row, Sensors};

/// The rows of a foreign file.
pub(crate) struct TopicRows<S: Sensors> {
    rows: MappedRows<S>,
    /// Values that were read, latest first: time since the first [ns], series, value.
    waiting: Vec<(i64, usize, f64)>,
    /// Time of the first value [ns].
    start: i64,
    has_ended: bool,
    /// Parts of the file that could not be read.
    pub lacks: Lacks,
}

/// A number of the map in the messages of a topic.
struct Wanted<'a> {
    entry: &'a Entry,
    name: &'a TopicName,
    path: Vec<Step>,
    found: bool,
}

impl<S: Sensors> TopicRows<S> {
    /// Reads the values that the map names.
    pub(crate) fn open(file: &Path, map: &Map) -> Result<Self, Error> {
        let Some(topics) = &map.topics else {
            return Err(Error::new(
                "the signal map has no [topics] table",
                map.file(),
                "name topic and field of each signal under [topics.signals]; heft map lists them",
            ));
        };
        let signals = signal::signals::<S>();
        map.check(&topics.signals, &signals)?;
        map.require::<S>(&topics.signals, "[topics.signals]")?;
        let mut wanted = Vec::new();
        let rows = (&topics.rows, "a topic");
        let rows = MappedRows::new(map, &topics.signals, rows, |entry, term, target| {
            Ok(match &term.origin {
                Origin::Constant(value) => Source::Constant(term.conversion.apply(*value)),
                Origin::Topic(name) => {
                    wanted.push(wanted_of(map, entry, name)?);
                    let turn = entry.turn(&term.conversion, target);
                    Source::Series(
                        Series::new(&term.timing, topics.hold, turn),
                        term.conversion,
                    )
                }
                Origin::Column(_) | Origin::Can(_) | Origin::Nowhere => Source::Constant(f64::NAN),
            })
        })?;
        let (mut waiting, lacks) = values(file, map, topics, &mut wanted)?;
        waiting.sort_by_key(|(time, ..)| *time); // stable
        check_times(&waiting, file, topics)?;
        let start = waiting.first().map_or(0, |(time, ..)| *time);
        for (time, ..) in &mut waiting {
            *time -= start;
        }
        waiting.reverse();
        Ok(Self {
            rows,
            waiting,
            start,
            has_ended: false,
            lacks,
        })
    }

    /// The next row; none at the end.
    pub(crate) fn row(&mut self) -> Option<Row<S>> {
        loop {
            if let Some(row) = self.rows.row() {
                return Some(row);
            }
            if self.has_ended {
                return None;
            }
            match self.waiting.last().map(|next| next.0) {
                Some(time) => self.take(time),
                None => {
                    self.has_ended = true;
                    self.rows.finish(absolute(self.start));
                }
            }
        }
    }

    /// Takes all values of one time: they belong to the same row.
    fn take(&mut self, time: i64) {
        // Rows that were complete before do not include these values.
        self.rows.pass(time, absolute(self.start));
        while let Some((_, series, value)) = self.waiting.pop_if(|next| next.0 == time) {
            self.rows.push(series, time, value);
        }
        self.rows.hear(time, absolute(self.start));
    }
}

/// Converts times since the first value to the clock of the file [ns].
fn absolute(start: i64) -> impl Fn(i64) -> u64 {
    move |ns| u64::try_from(start.saturating_add(ns)).unwrap_or(0)
}

fn wanted_of<'a>(map: &Map, entry: &'a Entry, name: &'a TopicName) -> Result<Wanted<'a>, Error> {
    let path = path(&name.field).ok_or_else(|| {
        Error::new(
            format!("{} is no path of fields", name.field),
            map.place(entry),
            "write field = \"twist.angular.z\", or field = \"axes[2]\"",
        )
    })?;
    Ok(Wanted {
        entry,
        name,
        path,
        found: false,
    })
}

/// Time [ns], index of the number, value.
type Values = Vec<(i64, usize, f64)>;

/// All values of the map's numbers, and the parts of the file that could not be read.
fn values(
    file: &Path,
    map: &Map,
    topics: &Topics,
    wanted: &mut [Wanted<'_>],
) -> Result<(Values, Lacks), Error> {
    let reader = list::open(file)?;
    check_topics(&reader, map, wanted)?;
    let mut values = Vec::new();
    for (i, part) in reader.parts.iter().enumerate() {
        let codecs = codecs(part, map, wanted)?;
        for_each_message(&reader, i, |head, data| {
            let Some(codec) = codecs.get(&head.channel) else {
                return Ok(None);
            };
            let topic = &part.scan.channels[&head.channel].topic;
            let Some(node) = codec.decode(data) else {
                return Ok(Some(UNREADABLE));
            };
            let time = match topics.time {
                TopicTime::Log => Some(head.log_time as i64),
                TopicTime::Publish => Some(head.publish_time as i64),
                TopicTime::Header => node.stamp(),
            };
            let Some(time) = time else {
                return Ok(None);
            };
            for (i, w) in wanted.iter_mut().enumerate() {
                if w.name.topic == *topic
                    && let Some(value) = node.number(&w.path, w.name.name.as_deref())
                {
                    w.found = true;
                    values.push((time, i, value));
                }
            }
            Ok::<_, Error>(None)
        })?;
    }
    check_found(&reader, map, topics, wanted)?;
    Ok((values, reader.lacks()))
}

/// Least usual distance of two values of a sensor \[ns\].
const NEAREST: i64 = 10_000;

/// Refuses values most of which have the time of the value before, or are too near to it; `values` in order.
fn check_times(values: &Values, file: &Path, topics: &Topics) -> Result<(), Error> {
    let mut last = BTreeMap::new();
    let apart = |(time, series, _): &(i64, usize, f64)| {
        let before = last.insert(*series, *time);
        before.map_or(i64::MAX, |before| time.saturating_sub(before))
    };
    let apart: Vec<i64> = values.iter().map(apart).collect();
    let count = |limit| apart.iter().filter(|ns| **ns <= limit).count();
    let (all, repeated, near) = (values.len(), count(0), count(NEAREST));
    if 2 * near <= all {
        return Ok(());
    }
    let other = match topics.time {
        TopicTime::Header => "leave out time = \"header\", which takes the times of the arrival",
        TopicTime::Log | TopicTime::Publish => {
            "write time = \"header\" under [topics] if the messages tell their own time"
        }
    };
    let what = match 2 * repeated > all {
        true => format!("{repeated} of {all} values carry the time of the one before them"),
        false => format!(
            "{near} of {all} values come within 10 us of the one before them: their times are not in ns"
        ),
    };
    Err(Error::new(what, file.display().to_string(), other))
}

fn check_topics(reader: &Reader, map: &Map, wanted: &[Wanted<'_>]) -> Result<(), Error> {
    let names = reader.channels();
    let absent = wanted
        .iter()
        .find(|w| !names.contains(&w.name.topic.as_str()));
    absent.map_or(Ok(()), |w| {
        Err(Error::new(
            format!("the file has no topic {}", w.name.topic),
            map.place(w.entry),
            hint(&w.name.topic, names.iter().copied(), "its topics are"),
        ))
    })
}

/// Whether the rest of a path is empty or an index of a list.
fn is_place(rest: &str) -> bool {
    rest.is_empty() || rest.starts_with('[')
}

fn check_found(
    reader: &Reader,
    map: &Map,
    topics: &Topics,
    wanted: &[Wanted<'_>],
) -> Result<(), Error> {
    let absent = wanted.iter().find(|w| !w.found);
    absent.map_or(Ok(()), |w| {
        let what = match &w.name.name {
            Some(name) => format!("{} of {name} in {}", w.name.field, w.name.topic),
            None => format!("{} in {}", w.name.field, w.name.topic),
        };
        let stamp = match topics.time {
            TopicTime::Header => " with a time in its header",
            TopicTime::Log | TopicTime::Publish => "",
        };
        let (fields, names) = list::fields_of(reader, &w.name.topic);
        let field = &w.name.field;
        let is_there = |field: &String| {
            fields
                .iter()
                .any(|f| f.strip_prefix(field).is_some_and(is_place))
        };
        let absent_name = w.name.name.as_ref().filter(|name| !names.contains(name));
        let remedy = match absent_name {
            _ if fields.is_empty() => "check the topic: none of its messages could be read".into(),
            _ if !is_there(field) => {
                hint(field, fields.iter().map(String::as_str), "its numbers are")
            }
            Some(name) => hint(
                name,
                names.iter().map(String::as_str),
                "the names of its places are",
            ),
            None if topics.time == TopicTime::Header => {
                "its messages have no header.stamp: leave out time = \"header\"".into()
            }
            None => hint(field, fields.iter().map(String::as_str), "its numbers are"),
        };
        Err(Error::new(
            format!("no message has a number {what}{stamp}"),
            map.place(w.entry),
            remedy,
        ))
    })
}

/// The codecs of the required channels.
fn codecs(part: &Part, map: &Map, wanted: &[Wanted<'_>]) -> Result<BTreeMap<u16, Codec>, Error> {
    let mut codecs = BTreeMap::new();
    for channel in part.scan.channels.values() {
        if let Some(w) = wanted.iter().find(|w| w.name.topic == channel.topic) {
            let schema = part.scan.schemas.get(&channel.schema_id);
            let codec = Codec::of(channel, schema).map_err(|what| {
                Error::new(
                    what,
                    map.place(w.entry),
                    "record the topic in one of these, or convert the file",
                )
            })?;
            codecs.insert(channel.id, codec);
        }
    }
    Ok(codecs)
}

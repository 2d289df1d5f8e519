//! The topics and numbers of a foreign MCAP file, as the first lines of a map.

use std::collections::{BTreeMap, HashSet};
use std::convert::Infallible;
use std::fmt::Write;
use std::path::Path;

use super::codec::Codec;
use super::node::{Node, TURNS};
use crate::copy::for_each_message;
use crate::reader::Reader;
use crate::signal::{Sensors, signals};
use crate::steers;
use crate::suggest::names::{fitting, quoted};
use crate::suggest::ports::ports;
use crate::suggest::suggestion::Suggestion;
use crate::unit;
use crate::{Error, Quoted};

/// Largest number of listed numbers of a topic.
const MOST: usize = 60;
/// Number of messages that are read of a topic.
const LOOKED_AT: u64 = 100;

/// A topic of a file.
struct Topic {
    kind: String,
    messages: u64,
    /// Number of malformed messages among those that were read.
    broken: u64,
    /// Why its messages cannot be read, or the numbers of the first ones: a sensor may be silent in one message.
    numbers: Result<Vec<(String, f64)>, String>,
    seen: HashSet<String>,
    /// Names of the entries of its lists, from one message.
    names: Vec<String>,
}

/// The numbers of a topic by their paths, and the names of the entries of its lists.
pub(crate) fn fields_of(reader: &Reader, topic: &str) -> (Vec<String>, Vec<String>) {
    let Some(topic) = topics(reader).remove(topic) else {
        return Default::default();
    };
    let numbers = topic.numbers.unwrap_or_default().into_iter();
    (numbers.map(|(path, _)| path).collect(), topic.names)
}

/// A number for a line of a map.
struct Place {
    /// Name by which it is found: the field, or its entry's name and the content of the list.
    label: String,
    /// The same after the topic's name.
    whole: String,
    /// Unit, if known.
    unit: Option<&'static str>,
    line: String,
}

/// The lists of a `sensor_msgs/JointState`, their content and unit.
const JOINTS: [(&str, &str, &str); 3] = [
    ("position", "angle", "rad"),
    ("velocity", "velocity", "rad/s"),
    ("effort", "torque", "N m"),
];

/// Parts of a path in messages of ROS that are no measurements: its time and its uncertainty.
const BESIDE: [&str; 3] = ["header", "stamp", "variance"];

/// Whether a number is an uncertainty in a matrix.
fn is_covariance(path: &str) -> bool {
    path.split(['.', '['])
        .any(|part| part.ends_with("covariance"))
}

/// Whether a number may be a measurement, by its path. Which rotation is which angle no name tells.
fn is_measurement(path: &str) -> bool {
    let is_other = |part: &str| BESIDE.contains(&part) || TURNS.contains(&part);
    !is_covariance(path) && !path.split(['.', '[']).any(is_other)
}

/// The possible measurements of all topics, with those of joints by their names.
fn places(topics: &BTreeMap<String, Topic>) -> Vec<Place> {
    let mut all = Vec::new();
    for (name, topic) in topics {
        let place = |unit, label: String, field: &str, more: String| Place {
            unit,
            // The words of a path belong together: `angular_velocity.x` of /imu/boom is no angle of it.
            whole: format!("{name} {}", label.replace('.', " ")),
            label,
            line: format!("topic = {}, field = {}{more}", quoted(name), quoted(field)),
        };
        let numbers = topic.numbers.as_deref().unwrap_or_default();
        for (list, what, unit) in JOINTS {
            let of_joint = |joint: &String| {
                let more = format!(", name = {}", quoted(joint));
                place(Some(unit), format!("{joint} {what}"), list, more)
            };
            let is_there = numbers.iter().any(|(path, _)| path.starts_with(list));
            all.extend(topic.names.iter().filter(|_| is_there).map(of_joint));
        }
        let by_field = |(path, _): &(String, f64)| {
            // Quotes belong to the path, not to the name.
            place(None, path.replace('"', ""), path, String::new())
        };
        let measured = numbers.iter().filter(|(path, _)| is_measurement(path));
        all.extend(measured.map(by_field));
    }
    all
}

/// Opens a foreign file.
pub(crate) fn open(path: &Path) -> Result<Reader, Error> {
    let reader = Reader::open(path)?;
    if reader.channels().is_empty() {
        // What is missing explains it better.
        if let Some(lack) = reader.lacks().all().first() {
            return Err(Error::new(
                "there is no whole topic in the file",
                *lack,
                "copy or record it again",
            ));
        }
        return Err(Error::new(
            "the file has no topics",
            path.display().to_string(),
            "record again; check that the topics are published, and their names",
        ));
    }
    Ok(reader)
}

/// The beginning of a map for a foreign file: its topics and numbers as comments, and a line for each signal, filled in if the
/// name of a number fits.
pub(crate) fn map<S: Sensors>(path: &Path, reader: &Reader) -> Suggestion {
    let machine = S::MACHINE;
    let file = path.display().to_string().replace(steers, "\u{fffd}");
    let mut text = format!(
        "# Topics and numbers of {file}: fill in topic and field of each signal of the {machine}.\n\
         # Then: heft estimate {} --machine {machine} --map THIS_FILE -o out.csv\n#\n",
        Quoted(&file)
    );
    let topics = topics(reader);
    let places = places(&topics);
    for (name, topic) in &topics {
        describe(&mut text, name, topic);
    }
    let signals = signals::<S>();
    let signals = signals
        .iter()
        .filter(|s| s.name != "t" && !s.name.starts_with("true_"));
    text += "\n[topics]\nrate = 100          # rows a second, or master = \"a signal\": a row for each of its messages\n";
    text += "# time = \"header\"    # times of the messages' own headers, instead of their arrival\n\n[topics.signals]\n";
    let (mut found_all, mut taken) = (Vec::new(), Vec::new());
    for signal in signals {
        let find = |label: fn(&Place) -> &str| {
            let fits = |place: &&Place| match place.unit {
                Some(unit) => unit == signal.unit,
                None => unit::foreign(&place.label, signal.unit).is_none(),
            };
            let labels = places
                .iter()
                .map(|p| Some(p).filter(fits).map_or("", label));
            fitting(&signal.name, &labels.collect::<Vec<_>>(), &taken)
        };
        let found = find(|place| &place.label).or_else(|| find(|place| &place.whole));
        taken.extend(found);
        found_all.extend(found.map(|_| signal.name.clone()));
        let (mark, line) = match found {
            Some(at) => ("", places[at].line.as_str()),
            None => ("# ", "topic = \"/...\", field = \"...\""),
        };
        let named = found.and_then(|at| unit::of_name(&places[at].label, signal.unit));
        let named = named.filter(|unit| unit.factor != 1.0);
        let converts = named.map_or(String::new(), |unit| format!(", unit = \"{}\"", unit.name));
        let guess = found.map_or("", |_| "by its name: check it; ");
        let unit = match signal.unit {
            "" => "a number".to_owned(),
            unit => format!("[{unit}]; other units by unit = ..."),
        };
        let name = &signal.name;
        let _ = writeln!(
            text,
            "{mark}{name} = {{ {line}{converts} }}  # {guess}{unit}"
        );
    }
    let labels: Vec<&str> = places.iter().map(|place| place.whole.as_str()).collect();
    text += &ports::<S>((&labels, &taken, &found_all), |at, sign| {
        let told = unit::of_name(labels[at], "Pa");
        let unit = told.map_or(String::new(), |unit| format!(", unit = \"{}\"", unit.name));
        format!("{{ {}{unit}{sign} }}", places[at].line)
    });
    Suggestion::of::<S>(text, &found_all)
}

/// A topic and its numbers, as comments.
fn describe(text: &mut String, name: &str, topic: &Topic) {
    let name = name.replace(steers, "\u{fffd}");
    let _ = writeln!(
        text,
        "# {name}  {}  {} messages",
        topic.kind, topic.messages
    );
    match &topic.numbers {
        Err(why) => {
            let _ = writeln!(text, "#     cannot be read: {why}");
        }
        Ok(_) if topic.broken > 0 && topic.broken == topic.messages.min(LOOKED_AT) => {
            *text += "#     cannot be read: none of its messages is whole\n";
        }
        Ok(numbers) => {
            let shown: Vec<_> = numbers.iter().filter(|(p, _)| !is_covariance(p)).collect();
            for (path, value) in shown.iter().take(MOST) {
                let _ = writeln!(text, "#     {path} = {value}");
            }
            if shown.len() > MOST {
                let _ = writeln!(text, "#     and {} more", shown.len() - MOST);
            }
        }
    }
    if !topic.names.is_empty() {
        let _ = writeln!(text, "#     names of places: {}", topic.names.join(", "));
    }
}

fn topics(reader: &Reader) -> BTreeMap<String, Topic> {
    let mut topics = BTreeMap::new();
    for (i, part) in reader.parts.iter().enumerate() {
        let mut codecs = BTreeMap::new();
        for channel in part.scan.channels.values() {
            let schema = part.scan.schemas.get(&channel.schema_id);
            let codec = Codec::of(channel, schema);
            let schema = schema.filter(|s| !s.name.is_empty());
            let kind = schema.map_or(String::new(), |s| format!("{}, ", s.name));
            topics.entry(channel.topic.clone()).or_insert(Topic {
                kind: format!("{kind}{}", channel.encoding),
                messages: 0,
                broken: 0,
                seen: HashSet::new(),
                numbers: match &codec {
                    Ok(_) => Ok(Vec::new()),
                    Err(why) => Err(why.clone()),
                },
                names: Vec::new(),
            });
            codecs.insert(channel.id, codec.ok());
        }
        let Ok(()) = for_each_message(reader, i, |head, data| {
            let channel = part.scan.channels.get(&head.channel);
            let Some(topic) = channel.and_then(|c| topics.get_mut(&c.topic)) else {
                return Ok(None);
            };
            topic.messages += 1;
            if let (Ok(numbers), Some(Some(codec))) =
                (&mut topic.numbers, codecs.get(&head.channel))
                && topic.messages <= LOOKED_AT
            {
                let Some(node) = codec.decode(data) else {
                    topic.broken += 1;
                    return Ok(None);
                };
                node.numbers("", &mut |path, value| {
                    if topic.seen.insert(path.to_owned()) {
                        numbers.push((path.to_owned(), value));
                    }
                });
                if topic.names.is_empty() {
                    topic.names = names(&node);
                }
            }
            Ok::<_, Infallible>(None)
        });
    }
    topics
}

/// The entries of the lists of texts in a message.
fn names(node: &Node) -> Vec<String> {
    let Node::Record(fields) = node else {
        return Vec::new();
    };
    let lists = fields.iter().filter_map(|(_, node)| match node {
        Node::List(list) => Some(list),
        _ => None,
    });
    let texts = lists.flatten().filter_map(|node| match node {
        Node::Text(text) => Some(text.replace(steers, "\u{fffd}")),
        _ => None,
    });
    texts.take(MOST).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pressure_of_a_topic_is_no_time_stamp_and_no_variance() {
        // sensor_msgs/FluidPressure, and a covariance of sensor_msgs/Imu: the topic's name gives the quantity.
        let paths = [
            "header.stamp.sec",
            "header.stamp.nanosec",
            "variance",
            "orientation_covariance[0]",
            "fluid_pressure",
        ];
        let topic = Topic {
            kind: String::new(),
            messages: 1,
            broken: 0,
            numbers: Ok(paths.map(|path| (path.to_owned(), 1.0)).into()),
            seen: HashSet::new(),
            names: Vec::new(),
        };
        let places = places(&BTreeMap::from([("/boom/head_pressure".to_owned(), topic)]));
        let labels: Vec<_> = places.iter().map(|place| place.whole.as_str()).collect();
        assert_eq!(labels, ["/boom/head_pressure fluid_pressure"]);
        assert_eq!(fitting("boom_head_pressure", &labels, &[]), Some(0));
    }
}

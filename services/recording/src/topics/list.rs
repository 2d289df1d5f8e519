//! What a file of others holds: its topics with their numbers, as the first lines of a map.

use std::collections::{BTreeMap, HashSet};
use std::fmt::Write;
use std::path::Path;

use super::codec::Codec;
use super::for_each_message;
use super::node::Node;
use crate::reader::Reader;
use crate::signal::{Sensors, signals};
use crate::steers;
use crate::suggest::names::{fitting, quoted};
use crate::suggest::ports::ports;
use crate::suggest::suggestion::{Suggestion, links, missing};
use crate::unit;
use crate::{Error, Quoted};

/// Numbers of a topic that are listed.
const MOST: usize = 60;
/// So many messages of a topic are looked at.
const LOOKED_AT: u64 = 100;

/// A topic of a file.
struct Topic {
    kind: String,
    messages: u64,
    /// Of those that were looked at, messages that are not whole.
    broken: u64,
    /// Why its messages cannot be read, or the numbers of the first of them: a sensor may be silent in one.
    numbers: Result<Vec<(String, f64)>, String>,
    seen: HashSet<String>,
    /// Names of places in lists of one of them.
    names: Vec<String>,
}

/// The numbers of a topic, by their paths, and the names of its places.
pub(crate) fn fields_of(reader: &Reader, topic: &str) -> (Vec<String>, Vec<String>) {
    let Some(topic) = topics(reader).remove(topic) else {
        return Default::default();
    };
    let numbers = topic.numbers.unwrap_or_default().into_iter();
    (numbers.map(|(path, _)| path).collect(), topic.names)
}

/// A number that a line of a map may name.
struct Place {
    /// By which it is found: the field, or its place's name and what the list holds.
    label: String,
    /// The same behind the topic's name.
    whole: String,
    /// Unit, where it is known.
    unit: Option<&'static str>,
    line: String,
}

/// The lists of a `sensor_msgs/JointState`, what they hold, and in which unit.
const JOINTS: [(&str, &str, &str); 3] = [
    ("position", "angle", "rad"),
    ("velocity", "velocity", "rad/s"),
    ("effort", "torque", "N m"),
];

/// Parts of a path that stand beside a measurement in messages of ROS: when it was made, and how well it is known.
const BESIDE: [&str; 3] = ["header", "stamp", "variance"];

/// Whether a number may be a measurement, by its path.
fn is_measurement(path: &str) -> bool {
    let mut parts = path.split(['.', '[']);
    parts.all(|part| !BESIDE.contains(&part) && !part.ends_with("covariance"))
}

/// The numbers of all topics that may be measurements, with those of joints by their names.
fn places(topics: &BTreeMap<String, Topic>) -> Vec<Place> {
    let mut all = Vec::new();
    for (name, topic) in topics {
        let place = |unit, label: String, field: &str, more: String| Place {
            unit,
            whole: format!("{name} {label}"),
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
            // Quotes are of the path, not of the name.
            place(None, path.replace('"', ""), path, String::new())
        };
        let measured = numbers.iter().filter(|(path, _)| is_measurement(path));
        all.extend(measured.map(by_field));
    }
    all
}

/// A file of others; what it lacks is told.
pub(crate) fn open(path: &Path) -> Result<Reader, Error> {
    let reader = Reader::open(path)?;
    for lack in reader.lacks().all() {
        tracing::warn!("{lack}");
    }
    Ok(reader)
}

/// The beginning of a map for a file of others: its topics and numbers as comments, and a line for each signal, filled in where a
/// number's name fits.
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
    Suggestion {
        text,
        missing: missing::<S>(&found_all),
        unknown: Vec::new(),
        of_second: Vec::new(),
        of_others: Vec::new(),
        links: links(&found_all),
        found: taken.len(),
    }
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
            for (path, value) in numbers.iter().take(MOST) {
                let _ = writeln!(text, "#     {path} = {value}");
            }
            if numbers.len() > MOST {
                let _ = writeln!(text, "#     and {} more", numbers.len() - MOST);
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
        for_each_message(reader, i, &mut |head, data| {
            let channel = part.scan.channels.get(&head.channel);
            let Some(topic) = channel.and_then(|c| topics.get_mut(&c.topic)) else {
                return true;
            };
            topic.messages += 1;
            if let (Ok(numbers), Some(Some(codec))) =
                (&mut topic.numbers, codecs.get(&head.channel))
                && topic.messages <= LOOKED_AT
            {
                let Some(node) = codec.decode(data) else {
                    topic.broken += 1;
                    return true;
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
            true
        });
    }
    topics
}

/// The texts of the lists of texts of a message.
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
        // sensor_msgs/FluidPressure, and a covariance of sensor_msgs/Imu: the topic's name says what is measured.
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

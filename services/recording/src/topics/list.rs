//! What a file of others holds: its topics with their numbers, as the first lines of a map.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use messages::Machine;

use super::codec::Codec;
use super::for_each_message;
use super::node::Node;
use crate::Error;
use crate::reader::Reader;
use crate::signal::signals_of;

/// Numbers of a topic that are listed.
const MOST: usize = 60;

/// A topic of a file.
struct Topic {
    kind: String,
    messages: u64,
    /// Why its messages cannot be read, or the numbers of one of them.
    numbers: Result<Vec<(String, f64)>, String>,
    /// Names of places in lists of one of them.
    names: Vec<String>,
}

/// The numbers of a topic, by their paths.
pub(crate) fn fields_of(reader: &Reader, topic: &str) -> Vec<String> {
    let mut topics = topics(reader);
    match topics.remove(topic).map(|t| t.numbers) {
        Some(Ok(numbers)) => numbers.into_iter().map(|(path, _)| path).collect(),
        _ => Vec::new(),
    }
}

/// The beginning of a map for a file of others: its topics and numbers as comments, and lines to fill in.
pub(crate) fn map(path: &Path, machine: Machine) -> Result<String, Error> {
    let reader = Reader::open(path)?;
    let file = path
        .display()
        .to_string()
        .replace(char::is_control, "\u{fffd}");
    let mut text = format!(
        "# Topics and numbers of {file}: fill in topic and field of each signal of the {machine}.\n\
         # Then: heft estimate {file} --machine {machine} --map THIS_FILE -o out.csv\n#\n"
    );
    let topics = topics(&reader);
    for lack in reader.lacks().all() {
        tracing::warn!("{lack}");
    }
    for (name, topic) in topics {
        let name = name.replace(char::is_control, "\u{fffd}");
        let _ = writeln!(
            text,
            "# {name}  {}  {} messages",
            topic.kind, topic.messages
        );
        match topic.numbers {
            Err(why) => {
                let _ = writeln!(text, "#     cannot be read: {why}");
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
    let signals = signals_of(machine);
    let signals = signals
        .iter()
        .filter(|s| s.name != "t" && !s.name.starts_with("true_"));
    text += "\n[topics]\nrate = 100          # rows a second, or master = \"a signal\": a row for each of its messages\n";
    text += "# time = \"header\"    # times of the messages' own headers, instead of their arrival\n\n[topics.signals]\n";
    for signal in signals {
        let unit = if signal.unit.is_empty() {
            String::new()
        } else {
            format!("  # [{}]; other units by unit = ...", signal.unit)
        };
        let _ = writeln!(
            text,
            "# {} = {{ topic = \"/...\", field = \"...\" }}{unit}",
            signal.name
        );
    }
    Ok(text)
}

fn topics(reader: &Reader) -> BTreeMap<String, Topic> {
    let mut topics = BTreeMap::new();
    for (i, part) in reader.parts.iter().enumerate() {
        let mut codecs = BTreeMap::new();
        for channel in part.scan.channels.values() {
            let schema = part.scan.schemas.get(&channel.schema_id);
            let codec = Codec::of(channel, schema);
            let kind = schema.map_or(String::new(), |s| format!("{}, ", s.name));
            topics.entry(channel.topic.clone()).or_insert(Topic {
                kind: format!("{kind}{}", channel.encoding),
                messages: 0,
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
                && numbers.is_empty()
                && let Some(node) = codec.decode(data)
            {
                node.numbers("", &mut |path, value| {
                    numbers.push((path.to_owned(), value))
                });
                topic.names = names(&node);
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
        Node::Text(text) => Some(text.replace(char::is_control, "\u{fffd}")),
        _ => None,
    });
    texts.take(MOST).collect()
}

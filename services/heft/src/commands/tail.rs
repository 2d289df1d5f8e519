//! `heft tail`: follows a channel of a running pipeline, a line per sample.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use messages::channels::{Channel, of_machine};
use messages::words::{Said, said};
use messages::{Message, Value};
use recording::can::Outgoing;
use runtime::Sink;

use crate::attached::find;
use crate::failure::Failure;
use crate::signals::Signals;

/// Longest wait between two reads of the channel.
const NAP: Duration = Duration::from_millis(5);

/// How a sample is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// An object per line.
    Json,
    /// A header, then a row per sample.
    Csv,
    /// The frames of `heft run --output`, as candump -L writes them; the time is that of the data.
    Candump,
    /// The bytes of the structure that `heft schema --lang c` declares, one after the other.
    Binary,
    /// InfluxDB's line protocol: tags machine (its kind), unit (its number), domain and channel; times are Unix times, in ns.
    Influx,
}

/// `heft tail`
#[derive(Debug, Args)]
pub struct TailArgs {
    /// The channel, such as excavator/inertia_ukf; the pipeline's main estimate if absent
    pub channel: Option<String>,
    /// How a sample is written
    #[arg(long, value_enum, default_value = "json")]
    pub format: Format,
    /// At most this number of samples per second; all if absent
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub rate: Option<f64>,
    /// With --format candump: which estimates, in which frames (TOML)
    #[arg(long, value_name = "FILE")]
    pub output_map: Option<PathBuf>,
    /// Name of the run (`--domain` of `heft run`); the only one there is if absent
    #[arg(long)]
    pub domain: Option<String>,
}

/// A number above 0.
fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|n| n.is_finite());
    let number = number.ok_or_else(|| "this is no number".to_owned())?;
    (number > 0.0)
        .then_some(number)
        .ok_or_else(|| "it is above 0".to_owned())
}

/// Writes each sample as it comes.
struct Writer {
    format: Format,
    frames: Outgoing,
    /// First part of a line of InfluxDB, after the name of the measurement: the same in all lines.
    tags: String,
    /// Least time between two samples, and time of the last one \[s\].
    period: f64,
    last: f64,
    has_header: bool,
    text: String,
    bytes: Vec<u8>,
}

/// `heft tail`
pub fn tail(args: &TailArgs) -> Result<(), Failure> {
    let found = find(args.domain.as_deref())?;
    let machine = found.machine()?;
    let frames = Outgoing::new(machine, args.output_map.as_deref())?;
    let name = args.channel.as_deref().unwrap_or(frames.channel.name);
    let framed: Vec<&str> = frames.channels().iter().map(|c| c.name).collect();
    if args.format == Format::Candump && !framed.contains(&name) {
        return Err(Failure::input(
            format!("{name} is not sent as frames"),
            "heft tail",
            format!("{} are; an --output-map chooses", framed.join(", ")),
        ));
    }
    let Some(channel) = of_machine(machine).find(|c| c.name == name) else {
        let names: Vec<&str> = of_machine(machine).map(|c| c.name).collect();
        return Err(Failure::input(
            format!("the pipeline has no channel {name}"),
            "heft tail",
            format!("one of {}", names.join(", ")),
        ));
    };
    let tags = format!(",machine={},domain={}", machine.name(), tag(found.name()));
    let mut run = found.attach("tail", &[channel])?;
    let mut writer = Writer {
        format: args.format,
        tags,
        frames,
        period: args.rate.map_or(0.0, |r| 1.0 / r),
        last: f64::NEG_INFINITY,
        has_header: false,
        text: String::new(),
        bytes: Vec::new(),
    };
    let stop = Signals::catch()?;
    loop {
        // Messages sent before the end are still in the channel.
        let is_over = stop.came() || !run.is_alive();
        run.drain(&mut writer);
        writer
            .bytes
            .extend(std::mem::take(&mut writer.text).into_bytes());
        if !crate::out::pass(&writer.bytes) {
            return Ok(());
        }
        if is_over {
            return Ok(());
        }
        writer.bytes.clear();
        std::thread::sleep(NAP);
    }
}

impl Sink for Writer {
    fn accept<M: Message>(&mut self, channel: &'static Channel, message: &M) {
        let time = message.stamp().time;
        // A sample slightly before its due time is taken: times are sums of rounded steps.
        let is_early = time - self.last < self.period * 0.999 && time >= self.last;
        if is_early {
            return;
        }
        self.last = time;
        let out = &mut self.text;
        match self.format {
            Format::Csv => {
                if !std::mem::replace(&mut self.has_header, true) {
                    let names: Vec<_> = said(message).map(|(name, _)| name).collect();
                    let _ = writeln!(out, "{}", names.join(","));
                }
                join(out, said(message), |out, _, value| match value {
                    Said::Number(value) => put(out, value),
                    Said::Flag(set) => out.push(if set { '1' } else { '0' }),
                    Said::Word(word) => out.push_str(word),
                    Said::Missing => {}
                });
                out.push('\n');
            }
            Format::Json => {
                out.push('{');
                join(out, said(message), |out, name, value| {
                    let _ = write!(out, "\"{name}\":");
                    put_said(out, value);
                });
                out.push_str("}\n");
            }
            Format::Binary => {
                for value in (0..M::FIELDS.len()).filter_map(|i| message.get(i)) {
                    match value {
                        Value::U32(v) => self.bytes.extend(v.to_ne_bytes()),
                        Value::U64(v) => self.bytes.extend(v.to_ne_bytes()),
                        Value::F64(v) => self.bytes.extend(v.to_ne_bytes()),
                    }
                }
            }
            Format::Candump => {
                let time_ns = (message.stamp().time * 1e9) as i64;
                let envelope = message.envelope();
                for frame in self.frames.frames(&envelope, time_ns, "heft") {
                    let _ = writeln!(out, "{}", frame.line());
                }
            }
            Format::Influx => {
                let stamp = message.stamp();
                let name = channel.last_name();
                let measurement = channel.name.replace('/', "_");
                let _ = write!(out, "{measurement}{}", self.tags);
                let _ = write!(out, ",channel={name},unit={} ", stamp.machine);
                let fields = said(message)
                    .filter(|(name, said)| name != "machine" && *said != Said::Missing);
                join(out, fields, |out, name, value| {
                    let _ = write!(out, "{name}=");
                    put_said(out, value);
                    if matches!(value, Said::Number(Value::U32(_) | Value::U64(_))) {
                        out.push('u');
                    }
                });
                let _ = writeln!(out, " {}", unix_ns(stamp.measured_ns));
            }
        }
    }
}

fn join(
    out: &mut String,
    columns: impl Iterator<Item = (Cow<'static, str>, Said)>,
    mut put: impl FnMut(&mut String, &str, Said),
) {
    for (n, (name, value)) in columns.enumerate() {
        out.push_str(if n == 0 { "" } else { "," });
        put(out, &name, value);
    }
}

/// A value for JSON and the line protocol, which omits missing ones; words are names without quotes in them.
fn put_said(out: &mut String, value: Said) {
    match value {
        Said::Number(value) => put(out, value),
        Said::Flag(set) => {
            let _ = write!(out, "{set}");
        }
        Said::Word(word) => {
            let _ = write!(out, "\"{word}\"");
        }
        Said::Missing => out.push_str("null"),
    }
}

/// The Unix time \[ns\] of a time of the host's monotonic clock.
fn unix_ns(monotonic: u64) -> u64 {
    let now = u64::try_from(runtime::since_1970().as_nanos()).unwrap_or(0);
    now.saturating_sub(runtime::now_ns().saturating_sub(monotonic))
}

/// A text as the value of a tag.
fn tag(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars().filter(|c| !c.is_control()) {
        if matches!(c, ',' | '=' | ' ' | '\\') {
            out.push('\\');
        }
        out.push(c);
    }
    out
}

/// A number with all its digits.
fn put(out: &mut String, value: Value) {
    let _ = match value {
        Value::U32(v) => write!(out, "{v}"),
        Value::U64(v) => write!(out, "{v}"),
        Value::F64(v) => write!(out, "{v}"),
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_says_its_text_and_nothing_else() {
        assert_eq!(tag("a b,c=d\n"), "a\\ b\\,c\\=d");
    }

    #[test]
    fn a_monotonic_time_becomes_the_wall_clocks() {
        let now = runtime::since_1970().as_nanos() as u64;
        let before = unix_ns(runtime::now_ns().saturating_sub(1_000_000_000));
        assert!(now.abs_diff(before).abs_diff(1_000_000_000) < 100_000_000);
    }
}

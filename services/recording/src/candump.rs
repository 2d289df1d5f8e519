//! Logs of candump: frames with a time, made into rows.

use std::path::Path;

use crate::Error;
use crate::dbc::{Dbc, Message, Signal, source};
use crate::map::{Can, CanName, Entry, Map, Origin, Rows, hint};
use crate::signal::{self, Builder, Machine, Row};

/// A frame of a log.
#[derive(Debug, PartialEq)]
struct Frame<'a> {
    /// Time [s], split into whole seconds and the rest so that the start can be taken off exactly.
    time: (i64, f64),
    interface: &'a str,
    id: u32,
    extended: bool,
    data: Vec<u8>,
}

/// Reads a log as the map says.
pub(crate) fn read<M: Machine>(path: &Path, map: &Map) -> Result<Vec<Row<M>>, Error> {
    let bytes = std::fs::read(path).map_err(|e| Error::system("read the CAN log", path, &e))?;
    let text = String::from_utf8_lossy(&bytes);
    let Some(can) = &map.can else {
        return Err(Error::new(
            "the signal map has no [can] table",
            path.display().to_string(),
            "name the DBC file and the signals under [can] and [can.signals]",
        ));
    };
    let signals = signal::signals::<M>();
    map.check(&can.signals, &signals)?;
    let mut sources = sources(can, map)?;
    require::<M>(can, path)?;
    let used = can
        .signals
        .iter()
        .filter_map(|e| signals.iter().find(|s| s.name == e.signal));
    let time = signals.iter().take(1);
    let mut builder = Builder::<M>::new(time.chain(used));
    let mut rows = Resampler::new(can);
    for (number, line) in text.lines().enumerate() {
        let frame = frame(line).ok_or_else(|| {
            Error::new(
                format!("\"{}\" is no frame", line.trim()),
                format!("{}:{}", path.display(), number + 1),
                "give a log of candump -L, or of candump -ta with its times",
            )
        })?;
        if let Some(frame) = frame {
            rows.take(&frame, &mut sources, &mut builder);
        }
    }
    if let Some(silent) = sources.iter().find(|s| s.never_seen()) {
        return Err(Error::new(
            format!(
                "the log {} has no value of {}",
                path.display(),
                silent.entry.signal
            ),
            map.place(silent.entry),
            "check message, source and interface of the entry, or leave it out",
        ));
    }
    Ok(builder.finish())
}

fn require<M: Machine>(can: &Can, path: &Path) -> Result<(), Error> {
    let missing = M::REQUIRED.iter().find(|group| {
        !group
            .iter()
            .any(|name| can.signals.iter().any(|e| e.signal == *name))
    });
    missing.map_or(Ok(()), |group| {
        Err(Error::new(
            format!(
                "the map names no signal for {} ({})",
                group.join(" or "),
                M::NAME
            ),
            path.display().to_string(),
            "add it under [can.signals], or say { constant = ... }",
        ))
    })
}

/// A signal of the map with the last value that came.
struct Source<'a> {
    entry: &'a Entry,
    from: Option<(&'a CanName, Message, Signal)>,
    value: f64,
    /// Time of the value [s]; none for a constant and before the first.
    at: Option<f64>,
}

impl Source<'_> {
    fn never_seen(&self) -> bool {
        self.from.is_some() && self.at.is_none()
    }

    /// Takes the value out of a frame that carries it.
    fn take(&mut self, frame: &Frame, time: f64) -> bool {
        let Some((name, message, signal)) = &self.from else {
            return false;
        };
        let wanted = message.matches(frame.id, frame.extended)
            && name.source.is_none_or(|s| s == source(frame.id))
            && name.interface.as_ref().is_none_or(|i| i == frame.interface);
        if !wanted {
            return false;
        }
        if let Some(value) = message.value(signal, &frame.data) {
            self.value = self.entry.conversion.apply(value);
            self.at = Some(time);
        }
        true
    }

    /// The value at `time`, NaN where it is too old.
    fn held(&self, time: f64, hold: f64) -> f64 {
        match (&self.from, self.at) {
            (None, _) => self.value,
            (Some(_), Some(at)) if time - at <= hold => self.value,
            _ => f64::NAN,
        }
    }
}

fn sources<'a>(can: &'a Can, map: &Map) -> Result<Vec<Source<'a>>, Error> {
    let files: Result<Vec<Dbc>, Error> = can.dbc.iter().map(|path| Dbc::open(path)).collect();
    let files = files?;
    let resolved = can.signals.iter().map(|entry| {
        let (from, value) = match &entry.origin {
            Origin::Can(name) => (Some(resolve(name, entry, &files, map)?), f64::NAN),
            Origin::Constant(value) => (None, *value),
            Origin::Column(_) | Origin::Nowhere => (None, f64::NAN),
        };
        Ok(Source {
            entry,
            from,
            value,
            at: None,
        })
    });
    resolved.collect()
}

fn resolve<'a>(
    name: &'a CanName,
    entry: &Entry,
    files: &[Dbc],
    map: &Map,
) -> Result<(&'a CanName, Message, Signal), Error> {
    let message = files
        .iter()
        .find_map(|f| f.find(&name.message))
        .ok_or_else(|| {
            let names = files
                .iter()
                .flat_map(|f| &f.messages)
                .map(|m| m.name.as_str());
            Error::new(
                format!("the DBC has no message {}", name.message),
                map.place(entry),
                hint(&name.message, names, "its messages are"),
            )
        })?;
    let signal = message.find(&name.signal).map_err(|hint| {
        let what = format!("message {} has no signal {}", name.message, name.signal);
        Error::new(what, map.place(entry), hint)
    })?;
    Ok((name, message.clone(), signal.clone()))
}

/// Makes rows of frames: the last value of each signal is held until it is too old.
struct Resampler<'a> {
    can: &'a Can,
    start: Option<(i64, f64)>,
    next: u64,
    values: Vec<f64>,
}

impl<'a> Resampler<'a> {
    fn new(can: &'a Can) -> Self {
        Self {
            can,
            start: None,
            next: 0,
            values: Vec::new(),
        }
    }

    fn take<M: Machine>(&mut self, frame: &Frame, sources: &mut [Source], rows: &mut Builder<M>) {
        let start = *self.start.get_or_insert(frame.time);
        let time = (frame.time.0 - start.0) as f64 + (frame.time.1 - start.1);
        if let Rows::Rate(rate) = self.can.rows {
            while self.next as f64 / rate < time {
                self.row(self.next as f64 / rate, sources, rows);
                self.next += 1;
            }
        }
        let mut is_master = false;
        for source in sources.iter_mut() {
            let taken = source.take(frame, time);
            is_master |=
                taken && matches!(&self.can.rows, Rows::Master(m) if *m == source.entry.signal);
        }
        if is_master {
            self.row(time, sources, rows);
        }
    }

    fn row<M: Machine>(&mut self, time: f64, sources: &[Source], rows: &mut Builder<M>) {
        self.values.clear();
        self.values.push(time);
        self.values
            .extend(sources.iter().map(|s| s.held(time, self.can.hold)));
        rows.push(&self.values);
    }
}

/// The frame in a line of `candump -L` or `candump -t`; `Some(None)` for a line without data
/// (empty, remote or error frame), `None` for text that is no frame.
fn frame(line: &str) -> Option<Option<Frame<'_>>> {
    let line = line.trim();
    if line.is_empty() {
        return Some(None);
    }
    let (time, rest) = line.strip_prefix('(')?.split_once(')')?;
    let mut words = rest.split_whitespace();
    let interface = words.next()?;
    let mut word = words.next()?;
    if matches!(word, "RX" | "TX" | "rx" | "tx") {
        word = words.next()?;
    }
    let (id, data) = match word.split_once('#') {
        Some((id, data)) => (id, compact(data)?),
        None => (word, spaced(words)?),
    };
    let frame = data.map(|data| {
        Some(Frame {
            time: seconds(time)?,
            interface,
            id: u32::from_str_radix(id, 16).ok()?,
            extended: id.len() > 3,
            data,
        })
    });
    match frame {
        Some(frame) => Some(Some(frame?)),
        None => Some(None),
    }
}

/// `AABB..`, or `#` with a flag before it (CAN FD), or `R` (remote).
fn compact(data: &str) -> Option<Option<Vec<u8>>> {
    if data.starts_with('R') {
        return Some(None);
    }
    let digits = match data.strip_prefix('#') {
        Some(fd) => fd.get(1..)?,
        None => data,
    };
    let pairs = (0..digits.len())
        .step_by(2)
        .map(|i| hex(digits.get(i..i + 2)?));
    pairs.collect::<Option<Vec<u8>>>().map(Some)
}

/// `[8] AA BB ...`, or `[8] remote request`.
fn spaced<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<Option<Vec<u8>>> {
    let length = words.next()?.strip_prefix('[')?.strip_suffix(']')?;
    let length: usize = length.parse().ok()?;
    let words: Vec<&str> = words.take(length).collect();
    if words.first() == Some(&"remote") {
        return Some(None);
    }
    let data: Option<Vec<u8>> = words.into_iter().map(hex).collect();
    data.filter(|d| d.len() == length).map(Some)
}

fn hex(pair: &str) -> Option<u8> {
    u8::from_str_radix(pair, 16).ok()
}

fn seconds(text: &str) -> Option<(i64, f64)> {
    let (whole, rest) = text.trim().split_once('.')?;
    let rest: f64 = format!("0.{rest}").parse().ok()?;
    Some((whole.parse().ok()?, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_of_a_line_say_the_same() {
        let log = frame("(1397165409.500000) can0 18FEF100#01FF")
            .flatten()
            .expect("a frame");
        let wide = frame(" (1397165409.500000)  can0  18FEF100   [2]  01 FF").flatten();
        assert_eq!(Some(&log), wide.as_ref());
        assert_eq!(
            (log.id, log.extended, log.data),
            (0x18fe_f100, true, vec![1, 255])
        );
        assert_eq!(log.time, (1_397_165_409, 0.5));
        let standard = frame("(0.1) vcan0 123#").flatten().expect("a frame");
        assert!(!standard.extended && standard.data.is_empty());
        let fd = frame("(0.1) can0 123##1AABB").flatten().expect("a frame");
        assert_eq!(fd.data, [0xaa, 0xbb]);
    }

    #[test]
    fn what_is_no_frame_is_told_from_what_carries_no_data() {
        assert_eq!(frame(""), Some(None));
        assert_eq!(frame("(0.1) can0 123#R"), Some(None));
        for wrong in [
            "hello",
            "(0.1) can0",
            "(x) can0 123#00",
            "(0.1) can0 123#0",
            "(0.1) can0 1 [2] 00",
        ] {
            assert_eq!(frame(wrong), None, "{wrong}");
        }
    }
}

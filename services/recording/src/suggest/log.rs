//! A map for a CAN log: the signals of its DBC files that the log carries.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::io::{BufRead, BufReader, ErrorKind};
use std::path::{Path, PathBuf};

use super::names::{fitting, quoted, wanted};
use super::ports::ports;
use super::suggestion::{LINKS, Suggestion, missing};
use super::{absolute, lacking, opening, shown};
use crate::can::dbc::Dbc;
use crate::can::{self, LeftOut, Line, parse};
use crate::signal::Sensors;
use crate::{Error, packed};

/// A first map for a log.
pub(super) fn suggest<S: Sensors>(path: &Path, dbc: &[PathBuf]) -> Result<Suggestion, Error> {
    if dbc.is_empty() {
        return Err(Error::new(
            "a CAN log says nothing without the DBC file that describes it",
            path.display().to_string(),
            "give one with --dbc",
        ));
    }
    let frames = frames(path)?;
    let carried = carried(&frames, dbc)?;
    if carried.is_empty() {
        return Err(Error::new(
            "the log has no message of the DBC file",
            path.display().to_string(),
            format!(
                "give the DBC of this bus (standard and extended identifiers are different ones); the log has {}",
                identifiers(&frames)
            ),
        ));
    }
    let names: Vec<String> = carried.iter().map(Carried::name).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut out = opening::<S>(path) + &keys(dbc);
    let (mut found, mut taken) = (Vec::new(), Vec::new());
    let mut links = [const { None }; LINKS.len()];
    for signal in wanted::<S>().into_iter().filter(|signal| signal != "t") {
        let Some(at) = fitting(&signal, &names, &taken) else {
            continue;
        };
        taken.push(at);
        let link = LINKS.iter().position(|link| *link == signal);
        let before = link.and_then(|at| links[at.checked_sub(1)?]);
        let before = before.filter(|_| absolute::by_name(names[at]));
        out += &carried[at].line(&signal, before);
        if let Some(link) = link {
            links[link] = Some(&carried[at]);
        }
        found.push(signal);
    }
    out += &ports::<S>((&names, &taken, &found), |at, sign| {
        format!("{{ {}{sign} }}", carried[at].place())
    });
    let blank = |_: &str| "{ message = \"...\", signal = \"...\" }".to_owned();
    out += &lacking::<S>(&found, &missing::<S>(&found), blank);
    let all = shown(&names.join(", "));
    let _ = writeln!(out, "\n# Sensors of the DBC that the log carries: {all}");
    Ok(Suggestion::of::<S>(out, &found))
}

/// The keys of the bus above its signals.
fn keys(dbc: &[PathBuf]) -> String {
    let files = dbc.iter().map(|f| quoted(&f.display().to_string()));
    let files: Vec<String> = files.collect();
    format!(
        "\n[can]\ndbc = [{}]  # paths beside this map\n\
         rate = 100  # rows a second\nhold = 0.5  # older values are missing [s]\n\n[can.signals]\n",
        files.join(", ")
    )
}

/// A signal of a DBC that a log carries.
struct Carried {
    message: String,
    signal: String,
    unit: String,
    /// Number of frames.
    count: u32,
}

impl Carried {
    fn name(&self) -> String {
        format!("{}.{}", self.message, self.signal)
    }

    /// Its place, as a map writes it.
    fn place(&self) -> String {
        let (message, signal) = (quoted(&self.message), quoted(&self.signal));
        format!("message = {message}, signal = {signal}")
    }

    /// The line of a map that reads `wanted` from it; less the angle of the link `before`, if it is absolute.
    fn line(&self, wanted: &str, before: Option<&Self>) -> String {
        let (place, count) = (self.place(), self.count);
        let unit = if self.unit.is_empty() {
            "no unit: taken as SI".into()
        } else {
            format!("unit {} by the DBC", shown(&self.unit))
        };
        match before.map(Self::place) {
            Some(before) => format!(
                "{wanted} = {{ terms = [{{ {place} }}, {{ {before}, sign = -1 }}] }}  # {}: less the link before; {count} frames; {unit}\n",
                absolute::BY_NAME
            ),
            None => format!("{wanted} = {{ {place} }}  # by its name; {count} frames; {unit}\n"),
        }
    }
}

/// Number of frames in a log by identifier and whether it is extended.
type Frames = BTreeMap<(u32, bool), u32>;

/// The first identifiers, as candump prints them: three digits, or eight of an extended one.
fn identifiers(frames: &Frames) -> String {
    let first = frames.keys().take(5);
    let first =
        first.map(|(id, extended)| format!("{id:0width$X}", width = if *extended { 8 } else { 3 }));
    first.collect::<Vec<_>>().join(", ")
}

fn frames(path: &Path) -> Result<Frames, Error> {
    let failed = |e| Error::system("read the CAN log", path, &e);
    let log = BufReader::new(packed::open(path).map_err(failed)?);
    let (mut counts, mut left_out) = (BTreeMap::new(), LeftOut::default());
    for (number, line) in (1..).zip(log.split(b'\n')) {
        let line = match line {
            Err(e) if !counts.is_empty() && e.kind() == ErrorKind::UnexpectedEof => break,
            line => line.map_err(failed)?,
        };
        let text = can::text(&line);
        let mut said = parse(&text);
        if let Some(Line::Frame { frame, timed }) = &mut said {
            // A map needs no times.
            *timed = true;
            *counts.entry((frame.id, frame.extended)).or_insert(0_u32) += 1;
        }
        left_out.count(said.as_ref(), number, &text);
    }
    if !counts.is_empty() {
        left_out.judge(&path.display().to_string())?;
    }
    if counts.is_empty() {
        return Err(Error::new(
            "there is no frame in the file",
            path.display().to_string(),
            "give a log of candump -L, or of candump -ta with its times",
        ));
    }
    Ok(counts)
}

/// The signals of the DBC files that a log carries.
fn carried(counts: &Frames, dbc: &[PathBuf]) -> Result<Vec<Carried>, Error> {
    let mut carried = Vec::new();
    for file in dbc {
        for message in Dbc::open(file)?.messages {
            let matching = counts
                .iter()
                .filter(|((id, x), _)| message.matches(*id, *x));
            let count: u32 = matching.map(|(_, n)| n).sum();
            let signals = message.signals.iter().filter(|_| count > 0);
            carried.extend(signals.map(|signal| Carried {
                message: message.name.clone(),
                signal: signal.name.clone(),
                unit: signal.unit.clone(),
                count,
            }));
        }
    }
    Ok(carried)
}

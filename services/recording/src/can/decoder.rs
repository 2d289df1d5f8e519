//! Decodes CAN frames into rows of samples, by a signal map.

use super::dbc::{Dbc, Message, Place, Reading, source};
use super::frame::Frame;
use crate::Error;
use crate::map::{CanName, Entry, Map, Origin, hint};
use crate::mapped::{MappedRows, Source};
use crate::sampling::{SECOND, Series};
use crate::signal::{self, Row, Sensors};

/// Largest lateness of a frame that is merely out of order [ns].
const DISORDER: i64 = SECOND;
/// Largest step forward in time without confirmation [ns], and largest difference of a second frame that confirms a larger step.
const JUMP: i64 = 10 * SECOND;
/// Number of consecutive implausible times of which the last is accepted.
const MOST_STRANGE: u32 = 3;
/// Largest time since the first frame [ns], 73 years: the sum of a few times cannot overflow.
const LONGEST: i64 = i64::MAX / 4;
/// Largest plausible step between two values of a signal [ns]: no sensor is slower, so longer steps indicate times in milliseconds.
/// Steps of 1 s are useless, but their times are in seconds.
const TOO_FAR: i64 = 3 * SECOND;
/// Silence of a sender after which another one may provide the signal [ns].
const SENDER_TIMEOUT: i64 = 5 * SECOND;
/// Largest number of stored remarks.
const MOST_REMARKS: usize = 20;

/// Makes rows of frames. The rows depend only on the frames: a bus and its log give equal rows.
#[derive(Debug)]
pub struct Decoder<S: Sensors> {
    rows: MappedRows<S>,
    /// The terms that come from the bus, in the order of their series.
    terms: Vec<Bus>,
    clock: Clock,
    /// Number of values, of those with the time of the previous one, and of those more than [`TOO_FAR`] after it.
    values: u64,
    repeated: u64,
    far: u64,
    remarks: Vec<String>,
    map: Map,
}

/// A term that comes from the bus.
#[derive(Debug)]
struct Bus {
    /// Entry of its signal in the map.
    entry: Entry,
    name: CanName,
    message: Message,
    place: Place,
    /// The accepted sender.
    sender: Option<Sender>,
    has_value: bool,
    /// Time of the last value [ns].
    last: Option<i64>,
}

/// A sender on a bus.
#[derive(Debug)]
struct Sender {
    interface: String,
    /// Source address of J1939.
    address: Option<u8>,
    /// Time of its last frame [ns].
    last: i64,
}

impl<S: Sensors> Decoder<S> {
    /// A decoder for the frames that the map names. Reads its DBC files.
    ///
    /// # Errors
    /// The map has no `[can]`, lacks a signal, or names a message or signal that the DBC files do not have.
    pub fn new(map: &Map) -> Result<Self, Error> {
        let Some(can) = &map.can else {
            return Err(Error::new(
                "the signal map has no [can] table",
                map.file(),
                "name the DBC file and the signals under [can] and [can.signals]",
            ));
        };
        let signals = signal::signals::<S>();
        map.check(&can.signals, &signals)?;
        map.require::<S>(&can.signals, "[can.signals]")?;
        let mut files = Vec::new();
        for path in &can.dbc {
            files.push(Dbc::open(path)?);
        }
        let messages = files.iter_mut().flat_map(|f| &mut f.messages);
        for message in messages {
            message.j1939 = can.j1939.unwrap_or(message.j1939) && message.extended;
        }
        let resolver = Resolver { map, files: &files };
        let mut terms = Vec::new();
        let rows = (&can.rows, "the bus");
        let rows = MappedRows::new(map, &can.signals, rows, |entry, term, target| {
            let name = match &term.origin {
                Origin::Can(name) => name,
                Origin::Constant(value) => {
                    return Ok(Source::Constant(term.conversion.apply(*value)));
                }
                Origin::Column(_) | Origin::Topic(_) | Origin::Nowhere => {
                    return Ok(Source::Constant(f64::NAN));
                }
            };
            let (bus, unit) = resolver.term(entry, name)?;
            terms.push(bus);
            let conversion = map.with_dbc_unit(entry, term.conversion, &unit, target)?;
            Ok(Source::Series(
                Series::new(&term.timing, can.hold, entry.turn(&conversion, target)),
                conversion,
            ))
        })?;
        Ok(Self {
            rows,
            terms,
            clock: Clock::default(),
            values: 0,
            repeated: 0,
            far: 0,
            remarks: Vec::new(),
            map: map.clone(),
        })
    }

    /// Takes a frame.
    pub fn take(&mut self, frame: &Frame) {
        let Some(clock) = self.clock.accept(frame.time_ns, &mut self.remarks) else {
            return;
        };
        // Rows that are complete before this frame do not depend on it.
        self.rows.pass(clock, |ns| self.clock.absolute(ns));
        let mut accepted = false;
        for (series, bus) in self.terms.iter_mut().enumerate() {
            if let Some(value) = bus.read(frame, clock, &mut self.remarks) {
                accepted = true;
                self.values += 1;
                let before = bus.last.replace(clock);
                self.repeated += u64::from(before == Some(clock));
                self.far += u64::from(before.is_some_and(|before| clock - before > TOO_FAR));
                self.rows.push(series, clock, value);
            }
        }
        if accepted {
            self.rows.hear(clock, |ns| self.clock.absolute(ns));
        }
    }

    /// Completes rows up to `now_ns` on the clock of the frames, without a frame: rows continue during silence.
    pub fn pass(&mut self, now_ns: i64) {
        if let Some(clock) = self.clock.relative(now_ns) {
            self.rows.pass(clock, |ns| self.clock.absolute(ns));
        }
    }

    /// Completes the pending rows after the last frame.
    pub fn finish(&mut self) {
        self.rows.finish(|ns| self.clock.absolute(ns));
    }

    /// The next row, if one is complete. Its `measured_ns` is its time on the clock of the frames.
    pub fn row(&mut self) -> Option<Row<S>> {
        self.rows.row()
    }

    /// Sets the time of the first frame to `seconds` instead of 0.
    pub fn begin_at(&mut self, seconds: f64) {
        self.clock.shift = (seconds * 1e9) as i64;
        self.rows.begin_at(self.clock.shift);
    }

    /// Returns the remarks so far, one line each, and removes them.
    pub fn take_remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.remarks)
    }

    /// Checks whether there are frames, and whether their times are plausible and in order.
    ///
    /// # Errors
    /// There is no frame, the times are equal, too coarse or in milliseconds, or more than 40 % of the frames are out of order.
    pub fn check_times(&self, log: &str) -> Result<(), Error> {
        let Clock {
            frames,
            early,
            later,
            ..
        } = self.clock;
        if frames == 0 {
            return Err(Error::new(
                "there is no frame in the file",
                log,
                "give a log of candump -L, or of candump -ta with its times",
            ));
        }
        if frames > 1 && early == 0 && later == 0 {
            return Err(Error::new(
                format!("all {frames} frames carry one time: when they came is not known"),
                log,
                "record anew with candump -L or -ta, or have the converter write the time of each frame",
            ));
        }
        let (values, repeated) = (self.values, self.repeated);
        if early == 0 && 2 * repeated > values {
            return Err(Error::new(
                format!("{repeated} of {values} values carry the time of the one before them"),
                log,
                "record with candump -L or -ta, which tell microseconds: the times of -td are differences, and whole seconds are too coarse",
            ));
        }
        if 2 * self.far > values {
            return Err(Error::new(
                format!(
                    "{} of {values} values come more than 3 s behind the one before them: the times seem to be in milliseconds",
                    self.far
                ),
                log,
                "divide the times by 1000, or record anew with candump -L or -ta, whose times are in seconds",
            ));
        }
        // `candump -td` writes differences: at least every second one is smaller than the largest before it.
        if 5 * early > 2 * frames {
            return Err(Error::new(
                format!("{early} of {frames} frames are earlier than one before them"),
                log,
                "record with candump -L or -ta: the times of -td are differences; or sort the lines by time",
            ));
        }
        Ok(())
    }

    /// Checks whether every signal of the map has had a value.
    ///
    /// # Errors
    /// A signal has had no value.
    pub fn check_senders(&self, log: &str) -> Result<(), Error> {
        let Some(silent) = self.terms.iter().find(|bus| !bus.has_value) else {
            return Ok(());
        };
        let signal = &silent.entry.signal;
        // Many a DBC of J1939 lacks the attributes that say so.
        let is_long = |bus: &&Bus| bus.message.extended && bus.message.is_long();
        let mut own = self.terms.iter().filter(|bus| bus.entry.signal == *signal);
        let what = format!("{log} has no value of {signal}");
        let (what, remedy) = match own.find(is_long) {
            None => (
                what,
                "check message, source and interface of the entry, or leave it out",
            ),
            Some(bus) => (
                format!(
                    "{what}: {} is longer than 8 bytes, and heft does not read the transport protocol of J1939 (BAM, RTS/CTS)",
                    bus.message.name
                ),
                "map a message of 8 bytes, or have a gateway send the signal in one; on CAN FD check message, source and interface",
            ),
        };
        Err(Error::new(what, self.map.place(&silent.entry), remedy))
    }
}

impl Bus {
    /// The value in a frame: NaN if the frame marks it as missing, `None` if the frame does not contain it or is not accepted.
    fn read(&mut self, frame: &Frame, clock: i64, remarks: &mut Vec<String>) -> Option<f64> {
        let interface = self.name.interface.as_deref();
        if !self.message.matches(frame.id, frame.extended)
            || interface.is_some_and(|i| i != frame.interface)
        {
            return None;
        }
        let value = match self.place.read(frame.data()) {
            Reading::Absent => {
                if self.place.is_behind(frame.data()) {
                    let (message, signal) = (&self.name.message, &self.name.signal);
                    let text = format!(
                        "frames of {message} are too short for {signal}, which is missing there: does the DBC file fit?"
                    );
                    remark(remarks, text);
                }
                return None;
            }
            Reading::Missing => f64::NAN,
            Reading::Value(value) => value,
        };
        let is_accepted = self.is_accepted(frame, clock, remarks);
        self.has_value |= is_accepted && value.is_finite();
        is_accepted.then_some(value)
    }

    /// Whether a frame comes from the accepted sender. Two senders of one message, or two buses, measure at two places: the first one
    /// is accepted until it is silent for [`SENDER_TIMEOUT`].
    fn is_accepted(&mut self, frame: &Frame, clock: i64, remarks: &mut Vec<String>) -> bool {
        let address = self.message.j1939.then(|| source(frame.id));
        if self.name.source.is_some() && self.name.source != address {
            return false;
        }
        match &mut self.sender {
            Some(first) if first.interface == frame.interface && first.address == address => {
                first.last = clock;
                true
            }
            Some(first) if clock - first.last < SENDER_TIMEOUT => {
                let text = format!(
                    "{}.{} comes from {}",
                    self.name.message,
                    self.name.signal,
                    first.beside(frame, address)
                );
                remark(remarks, text);
                false
            }
            none_or_silent => {
                *none_or_silent = Some(Sender {
                    interface: frame.interface.to_owned(),
                    address,
                    last: clock,
                });
                true
            }
        }
    }
}

impl Sender {
    /// Remark on a second sender of the same message.
    fn beside(&self, frame: &Frame, address: Option<u8>) -> String {
        let hex = |address: Option<u8>| format!("{:#04x}", address.unwrap_or_default());
        let (first, other, key) = if self.interface == frame.interface {
            (hex(self.address), hex(address), "source")
        } else {
            let (first, other) = (&self.interface, frame.interface);
            (first.clone(), other.to_owned(), "interface")
        };
        format!("{first} and from {other}; only {first} counts: say {key} = ... in the map")
    }
}

/// Stores a new remark.
fn remark(remarks: &mut Vec<String>, text: String) {
    if remarks.len() < MOST_REMARKS && !remarks.contains(&text) {
        remarks.push(text);
    }
}

/// Finds the terms of a map in DBC files.
struct Resolver<'a> {
    map: &'a Map,
    files: &'a [Dbc],
}

impl Resolver<'_> {
    /// A term, and the unit that its file gives it.
    fn term(&self, entry: &Entry, name: &CanName) -> Result<(Bus, String), Error> {
        let all = || self.files.iter().flat_map(|f| &f.messages);
        let message = self.files.iter().find_map(|f| f.find(&name.message));
        let message = message.ok_or_else(|| {
            Error::new(
                format!("the DBC has no message {}", name.message),
                self.map.place(entry),
                hint(
                    &name.message,
                    all().map(|m| m.name.as_str()),
                    "its messages are",
                ),
            )
        })?;
        let signal = message.find(&name.signal).map_err(|hint| {
            let what = format!("message {} has no signal {}", name.message, name.signal);
            Error::new(what, self.map.place(entry), hint)
        })?;
        let place = message.place(signal).ok_or_else(|| {
            Error::new(
                format!(
                    "the multiplexor of {} is not in message {}",
                    name.signal, name.message
                ),
                self.map.place(entry),
                "correct SG_MUL_VAL_ or the multiplexor (M) of the message in the DBC file",
            )
        })?;
        if name.source.is_some() && !message.j1939 {
            return Err(Error::new(
                format!(
                    "message {} has no source address: it is not J1939's",
                    name.message
                ),
                self.map.place(entry),
                "leave out source =, or say j1939 = true under [can]",
            ));
        }
        let bus = Bus {
            entry: entry.clone(),
            name: name.clone(),
            message: message.clone(),
            place,
            sender: None,
            has_value: false,
            last: None,
        };
        Ok((bus, signal.unit.clone()))
    }
}

/// The time of frames since the first. A single wrong time is rejected, a clock that was set is accepted. Set forward, it leaves
/// a gap. Set backward, the rows continue one second after the last.
#[derive(Debug, Default)]
struct Clock {
    start: Option<i64>,
    last: i64,
    shift: i64,
    strange: Option<i64>,
    strangers: u32,
    /// Number of frames, of those earlier than a frame before them, and of those later than all before them.
    frames: u64,
    early: u64,
    later: u64,
}

impl Clock {
    /// Time of a frame since the first [ns]; `None` if it is rejected.
    fn accept(&mut self, time: i64, remarks: &mut Vec<String>) -> Option<i64> {
        let is_first = self.start.is_none();
        self.start.get_or_insert(time);
        if is_first {
            self.last = time;
        }
        let ahead = time.saturating_sub(self.last);
        self.frames += 1;
        self.early += u64::from(ahead < 0);
        self.later += u64::from(ahead > 0);
        if (-DISORDER..=JUMP).contains(&ahead) {
            if self.strangers > 0 {
                let text = "frames with a wrong time were left out";
                remark(remarks, text.into());
            }
            self.last = self.last.max(time);
        } else {
            let near = |s: i64| time.saturating_sub(s).saturating_abs() <= JUMP;
            self.strangers += 1;
            let is_confirmed = self.strange.is_some_and(near) || self.strangers >= MOST_STRANGE;
            if !is_confirmed {
                self.strange = Some(time);
                return None;
            }
            let by = ahead as f64 / 1e9;
            let since = self.relative(self.last).unwrap_or(0) as f64 / 1e9;
            if ahead < 0 {
                self.shift = self.shift.saturating_sub(ahead).saturating_add(SECOND);
                remark(
                    remarks,
                    format!(
                        "the clock went back by {:.3} s after {since:.3} s; time goes on a second later",
                        -by
                    ),
                );
            } else {
                remark(remarks, format!("a gap of {by:.3} s after {since:.3} s"));
            }
            self.last = time;
        }
        (self.strange, self.strangers) = (None, 0);
        self.relative(time)
    }

    /// A time since the first frame [ns], at most [`LONGEST`] away.
    fn relative(&self, time: i64) -> Option<i64> {
        let since = time.saturating_sub(self.start?).saturating_add(self.shift);
        Some(since.clamp(-LONGEST, LONGEST))
    }

    /// A time since the first frame on the clock of the frames [ns].
    fn absolute(&self, ns: i64) -> u64 {
        let time = ns
            .saturating_sub(self.shift)
            .saturating_add(self.start.unwrap_or(0));
        u64::try_from(time).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(all: &[f64]) -> (Vec<Option<f64>>, Vec<String>) {
        let (mut clock, mut remarks) = (Clock::default(), Vec::new());
        let ns = |s: &f64| (s * 1e9) as i64;
        let accept = |s| clock.accept(ns(s), &mut remarks).map(|t| t as f64 / 1e9);
        (all.iter().map(accept).collect(), remarks)
    }

    #[test]
    fn one_wrong_time_is_left_out_and_reported() {
        let (found, remarks) = times(&[5.0, 6.0, 1e9, 7.0, -400.0, 8.0]);
        assert_eq!(
            found,
            [Some(0.0), Some(1.0), None, Some(2.0), None, Some(3.0)]
        );
        assert_eq!(remarks.len(), 1);
    }

    #[test]
    fn a_clock_that_was_set_leaves_a_gap_or_goes_on_a_second_later() {
        let (found, remarks) = times(&[0.0, 1.0, 100.0, 101.0, 102.0]);
        assert_eq!(
            found,
            [Some(0.0), Some(1.0), None, Some(101.0), Some(102.0)]
        );
        assert!(remarks[0].starts_with("a gap of 100"), "{remarks:?}");
        let (found, remarks) = times(&[1000.0, 1001.0, 3.0, 4.0, 5.0]);
        assert_eq!(found, [Some(0.0), Some(1.0), None, Some(2.0), Some(3.0)]);
        assert!(remarks[0].starts_with("the clock went back"), "{remarks:?}");
    }

    #[test]
    fn the_largest_times_there_are_do_no_harm() {
        let max = i64::MAX as f64 / 1e9;
        let (found, _) = times(&[-max, max, -max, max, 0.0, max, max, -max, -max]);
        assert_eq!(found.len(), 9);
        let longest = LONGEST as f64 / 1e9;
        assert!(found.iter().flatten().all(|t| t.abs() <= longest));
    }
}

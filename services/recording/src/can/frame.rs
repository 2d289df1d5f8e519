//! A CAN frame, and its line in the output of `candump`.

use std::borrow::Cow;

use crate::time;

/// Longest data field of a frame (CAN FD).
pub const MAX_DATA: usize = 64;

const SECOND: i64 = 1_000_000_000;

/// A data frame with the time it was received.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    /// When it was received \[ns\], on any clock; only differences count.
    pub time_ns: i64,
    /// Name of the interface, such as `can0`.
    pub interface: &'a str,
    /// Identifier: 11 bits, or 29 if `extended`.
    pub id: u32,
    /// Whether the identifier has 29 bits.
    pub extended: bool,
    data: [u8; MAX_DATA],
    length: usize,
}

impl<'a> Frame<'a> {
    /// A frame; `None` if the data or the identifier are too long.
    pub fn new(
        time_ns: i64,
        interface: &'a str,
        id: u32,
        extended: bool,
        bytes: &[u8],
    ) -> Option<Self> {
        let mut data = [0; MAX_DATA];
        data.get_mut(..bytes.len())?.copy_from_slice(bytes);
        let largest = if extended { 0x1fff_ffff } else { 0x7ff };
        (id <= largest).then_some(Self {
            time_ns,
            interface,
            id,
            extended,
            data,
            length: bytes.len(),
        })
    }

    /// The line of `candump -L`.
    pub fn line(&self) -> String {
        let (seconds, ns) = (
            self.time_ns.div_euclid(SECOND),
            self.time_ns.rem_euclid(SECOND),
        );
        let width = if self.extended { 8 } else { 3 };
        let data: String = self.data().iter().map(|b| format!("{b:02X}")).collect();
        let (us, interface, id) = (ns / 1000, self.interface, self.id);
        format!("({seconds:010}.{us:06}) {interface} {id:0width$X}#{data}")
    }

    /// The data field.
    pub fn data(&self) -> &[u8] {
        &self.data[..self.length]
    }
}

/// Meaning of a line of candump.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Line<'a> {
    /// A frame; `timed` is false if the line has no time, and the time of the frame is then 0.
    Frame {
        /// The frame.
        frame: Frame<'a>,
        /// Whether the line has a time.
        timed: bool,
    },
    /// No data: an empty line, a remote frame, an error frame, or the details that `-e` prints below it.
    Nothing,
    /// Number of frames lost during recording (`-d`).
    Dropped(u64),
}

/// A line as a text, without the colours of `candump -c`.
pub(crate) fn text(line: &[u8]) -> Cow<'_, str> {
    const BEGIN: &str = "\x1b[";
    let text = String::from_utf8_lossy(line);
    if !text.contains(BEGIN) {
        return text;
    }
    let mut parts = text.split(BEGIN);
    let first = parts.next().unwrap_or_default().to_owned();
    let rest = parts.map(|part| {
        let is_colour = |c: char| c.is_ascii_digit() || c == ';';
        part.trim_start_matches(is_colour)
            .strip_prefix('m')
            .unwrap_or(part)
    });
    Cow::Owned(rest.fold(first, |all, part| all + part))
}

/// Reads a line of `candump`: the log form (`-L`, `-l`), or the screen form with times (`-t a`, `-t A`, `-t z`) or without.
/// The screen form may have direction (`-x`), text (`-a`), raw lengths (`-8`), bits (`-i`) or swapped bytes (`-S`).
/// `None` for text that is not a frame.
pub(crate) fn parse(line: &str) -> Option<Line<'_>> {
    // `-e` prints the details of an error frame on the line below it.
    if line.starts_with('\t') && line.split_whitespace().count() == 1 {
        return Some(Line::Nothing);
    }
    // Some editors begin a file with a byte order mark.
    let line = line.trim_start_matches('\u{feff}').trim();
    if line.is_empty() {
        return Some(Line::Nothing);
    }
    if let Some(words) = line.strip_prefix("DROPCOUNT: dropped ") {
        let count = words.split_whitespace().next()?;
        return Some(Line::Dropped(count.parse().ok()?));
    }
    let (time, rest) = match line.strip_prefix('(') {
        Some(line) => {
            let (time, rest) = line.split_once(')')?;
            (Some(time::stamp(time.trim())?), rest)
        }
        // No interface is a number with a point.
        None => match line.split_once(char::is_whitespace) {
            Some((word, rest)) if word.contains('.') && time::stamp(word).is_some() => {
                (time::stamp(word), rest)
            }
            _ => (None, line),
        },
    };
    let mut words = rest.split_whitespace();
    let interface = words.next()?;
    let mut word = words.next()?;
    // `-x`: direction, then the flags "bit rate switch" and "error state" (`-` where they are off).
    while matches!(word, "RX" | "TX" | "-" | "B" | "E") {
        word = words.next()?;
    }
    let mut bytes = Bytes::default();
    let (id, has_data) = match word.split_once('#') {
        Some((id, data)) => (id, bytes.compact(data)?),
        None => (word, bytes.spaced(words)?),
    };
    let id = id.strip_prefix("0x").unwrap_or(id);
    let extended = id.len() > 3;
    let number = hex(id.as_bytes())?;
    // Bit 29 marks an error message of the interface.
    if !has_data || (extended && number & 0x2000_0000 != 0) {
        return Some(Line::Nothing);
    }
    let frame = Frame::new(
        time.unwrap_or(0),
        interface,
        number,
        extended,
        bytes.as_slice(),
    )?;
    Some(Line::Frame {
        frame,
        timed: time.is_some(),
    })
}

/// The data bytes of a line.
struct Bytes {
    data: [u8; MAX_DATA],
    length: usize,
}

impl Default for Bytes {
    fn default() -> Self {
        Self {
            data: [0; MAX_DATA],
            length: 0,
        }
    }
}

impl Bytes {
    fn as_slice(&self) -> &[u8] {
        &self.data[..self.length]
    }

    fn push(&mut self, pair: &[u8]) -> Option<()> {
        *self.data.get_mut(self.length)? = u8::try_from(hex(pair)?).ok()?;
        self.length += 1;
        Some(())
    }

    /// Reads `AABB..`, the same after `#` and a flag (CAN FD), or `R` (remote frame: false). A raw length may follow (`_F`).
    fn compact(&mut self, data: &str) -> Option<bool> {
        if data.starts_with('R') {
            return Some(false);
        }
        let data = match data.split_once('_') {
            Some((data, raw)) if data.len() == 16 && raw.len() == 1 => {
                hex(raw.as_bytes())?;
                data
            }
            _ => data,
        };
        let digits = match data.as_bytes() {
            [b'#', flag, digits @ ..] if flag.is_ascii_hexdigit() => digits,
            digits => digits,
        };
        for pair in digits.chunks(2) {
            (pair.len() == 2).then_some(())?;
            self.push(pair)?;
        }
        Some(true)
    }

    /// Reads `[8] AA BB ...`, `{F} AA BB ...` with a raw length, or `[8] remote request` (false). A byte may be eight binary digits.
    fn spaced<'a>(&mut self, mut words: impl Iterator<Item = &'a str>) -> Option<bool> {
        let length = length(words.next()?)?;
        while self.length < length {
            let word = words.next()?;
            if self.length == 0 && word == "remote" {
                return Some(false);
            }
            // Swapped bytes form one word, the last byte first.
            for byte in word.rsplit('`') {
                self.push_word(byte)?;
            }
        }
        (self.length == length).then_some(true)
    }

    /// Reads `AA` or `10101010`.
    fn push_word(&mut self, word: &str) -> Option<()> {
        match word.as_bytes() {
            pair @ [_, _] => self.push(pair),
            bits @ [_, _, _, _, _, _, _, _] => {
                let is_bit = |b: &u8| matches!(b, b'0' | b'1');
                bits.iter().all(is_bit).then_some(())?;
                let byte = bits.iter().fold(0, |byte, bit| byte << 1 | (bit - b'0'));
                *self.data.get_mut(self.length)? = byte;
                self.length += 1;
                Some(())
            }
            _ => None,
        }
    }
}

/// Length of the data field in bytes: `[8]`, `[08]`, or `{F}`. A raw length above 8 means 8.
fn length(word: &str) -> Option<usize> {
    if let Some(raw) = word.strip_prefix('{') {
        let raw = hex(raw.strip_suffix('}')?.as_bytes())?;
        return (raw <= 15).then(|| raw.min(8) as usize);
    }
    word.strip_prefix('[')?.strip_suffix(']')?.parse().ok()
}

/// Reads one to eight hexadecimal digits, and nothing else.
fn hex(digits: &[u8]) -> Option<u32> {
    (1..=8).contains(&digits.len()).then_some(())?;
    digits.iter().try_fold(0, |number: u32, digit| {
        Some(number << 4 | char::from(*digit).to_digit(16)?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(line: &str) -> Frame<'_> {
        match parse(line) {
            Some(Line::Frame { frame, .. }) => frame,
            other => panic!("{line}: {other:?}"),
        }
    }

    #[test]
    fn every_form_of_a_line_gives_the_same_frame() {
        let log = frame("(1397165409.500000) can0 18FEF100#01FF");
        assert_eq!(
            (log.id, log.extended, log.data()),
            (0x18fe_f100, true, &[1, 255][..])
        );
        assert_eq!(log.time_ns, 1_397_165_409_500_000_000);
        for same in [
            " (1397165409.500000)  can0  18FEF100   [2]  01 FF",
            "(1397165409.500000) can0 18FEF100#01FF R",
            " (1397165409.500000)  can0  RX - -  18FEF100   [2]  01 FF   '..'",
            " (1397165409.500000)  can0  TX B E  18FEF100  [02]  01 FF",
            " (2014-04-10 21:30:09.500000)  can0  18FEF100   [2]  01 FF",
            " (1397165409.500000)  can0  18FEF100   {2}  01 FF",
            " (1397165409.500000)  can0  18FEF100   [2]  FF`01",
            " (1397165409.500000)  can0  18FEF100   [2]  00000001 11111111",
            " (1397165409.500000)  can0  18FEF100   [2]  11111111`00000001",
            "(1397165409500.000) can0 18FEF100#01FF",
            "(1397165409500) can0 18FEF100#01FF",
            "(1397165409500000) can0 18FEF100#01FF",
            "(1397165409500000000) can0 18FEF100#01FF",
            "1397165409.500000 can0 18FEF100#01FF",
            "1397165409.5 can0 0x18FEF100 [2] 01 FF",
        ] {
            assert_eq!(frame(same), log, "{same}");
        }
        let plain = parse("  can0  18FEF100   [2]  01 FF");
        assert!(
            matches!(plain, Some(Line::Frame { timed: false, frame }) if frame.data() == log.data())
        );
        let standard = frame("(0.1) vcan0 123#");
        assert!(!standard.extended && standard.data().is_empty());
        assert_eq!(frame("(0.1) can0 123##1AABB").data(), [0xaa, 0xbb]);
        let raw = frame("(0.1) can0 123#0011223344556677_E");
        assert_eq!(
            frame(" (0.1)  can0  123   {E}  00 11 22 33 44 55 66 77"),
            raw
        );
        assert_eq!(raw.data(), [0, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77]);
    }

    #[test]
    fn colours_are_no_part_of_a_frame() {
        let line = b"\x1b[34m (1700000000.000001)  can0  123   [2]  01 FF\x1b[0m\n";
        let plain = text(line);
        assert_eq!(plain, " (1700000000.000001)  can0  123   [2]  01 FF\n");
        assert!(matches!(
            parse(&plain),
            Some(Line::Frame { timed: true, .. })
        ));
    }

    #[test]
    fn what_is_no_frame_is_distinguished_from_what_carries_no_data() {
        for nothing in [
            "",
            "(0.1) can0 123#R",
            "(0.1) can0 123#R8",
            "(0.1) can0 123 [8] remote request",
            "(0.1) can0 20000080#0000000000000000",
            " (0.1)  can0  20000080   [8]  00 00 00 00 00 00 00 00   ERRORFRAME",
            "\tbus-off",
            "\tprotocol-violation{{error-on-tx}{acknowledge-slot}}",
            "(0.1) can0 123#R8_E",
        ] {
            assert_eq!(parse(nothing), Some(Line::Nothing), "{nothing}");
        }
        let dropped = "DROPCOUNT: dropped 12 CAN frames on 'can0' socket (total drops 40)";
        assert_eq!(parse(dropped), Some(Line::Dropped(12)));
        for wrong in [
            "hello",
            "DROPCOUNT: dropped",
            "(0.1) can0 123#00112233_E",
            "(0.1) can0 123 {G} 00",
            "(0.1) can0 123 [2] 00`11`22",
            "(0.1) can0 123 [1] 00000002",
            "(0.1) can0",
            "(x) can0 123#00",
            "(0.1) can0 123#0",
            "(0.1) can0 123#+1",
            "(0.1) can0 1 [2] 00",
            "(0.1) can0 1 [2] +1 00",
            "(0.1) can0 FFF#00",
            "(99999999999999999999.0) can0 123#00",
            "(0.1) can0 123 [18446744073709551615] 00",
            "t,speed",
        ] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }
}

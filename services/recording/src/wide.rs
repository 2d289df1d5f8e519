//! Text in UTF-16, as Windows programs write it, converted to UTF-8.

use std::io::{self, Read};

/// Combines two bytes to a code unit.
type Order = fn([u8; 2]) -> u16;

/// Byte order, and length of the byte order mark; none for other text.
///
/// Without a mark the zeros decide: most characters of a table or a log are ASCII.
fn order(head: &[u8]) -> Option<(Order, usize)> {
    let (little, big): (Order, Order) = (u16::from_le_bytes, u16::from_be_bytes);
    match head {
        [0xff, 0xfe, ..] => return Some((little, 2)),
        [0xfe, 0xff, ..] => return Some((big, 2)),
        _ => {}
    }
    let pairs = head.len() / 2;
    let zeros = |first: usize| head.iter().skip(first).step_by(2).filter(|b| **b == 0);
    match (zeros(0).count(), zeros(1).count()) {
        (0, after) if pairs > 3 && 2 * after > pairs => Some((little, 0)),
        (before, 0) if pairs > 3 && 2 * before > pairs => Some((big, 0)),
        _ => None,
    }
}

/// Number of bytes that decide [bytes].
const HEAD: u64 = 256;
/// Number of bytes converted at a time [bytes].
const STRETCH: u64 = 1 << 15;

/// A content in UTF-8, and whether it was converted.
pub(crate) fn utf8(mut content: Box<dyn Read>) -> (Box<dyn Read>, bool) {
    let mut head = Vec::new();
    // A read error is reported by the next read.
    let failed = content.by_ref().take(HEAD).read_to_end(&mut head).err();
    let found = order(&head);
    let rest = Resumed { failed, content };
    match found {
        None => (Box::new(io::Cursor::new(head).chain(rest)), false),
        Some((order, mark)) => {
            head.drain(..mark);
            let content = Box::new(io::Cursor::new(head).chain(rest));
            let (text, at, high) = (Vec::new(), 0, None);
            (
                Box::new(Wide {
                    content,
                    order,
                    high,
                    text,
                    at,
                }),
                true,
            )
        }
    }
}

/// The beginning of a text in UTF-8.
pub(crate) fn head(head: Vec<u8>) -> Vec<u8> {
    let mut all = Vec::new();
    let (mut content, _) = utf8(Box::new(io::Cursor::new(head)));
    let _ = content.read_to_end(&mut all); // nothing in memory can fail
    all
}

/// The rest of a content, after a read error of its head.
struct Resumed {
    failed: Option<io::Error>,
    content: Box<dyn Read>,
}

impl Read for Resumed {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match self.failed.take() {
            Some(error) => Err(error),
            None => self.content.read(out),
        }
    }
}

/// Converts while it is read.
struct Wide {
    content: Box<dyn Read>,
    order: Order,
    /// The first code unit of a surrogate pair whose second one is still to come.
    high: Option<u16>,
    text: Vec<u8>,
    at: usize,
}

impl Wide {
    fn fill(&mut self) -> io::Result<()> {
        let mut bytes = Vec::new();
        let read = (&mut self.content).take(STRETCH).read_to_end(&mut bytes);
        if bytes.is_empty() {
            read?;
        } else if let Err(error) = read {
            let content = std::mem::replace(&mut self.content, Box::new(io::empty()));
            let failed = Some(error);
            self.content = Box::new(Resumed { failed, content });
        }
        let units = bytes
            .chunks_exact(2)
            .map(|pair| (self.order)([pair[0], pair[1]]));
        let mut units: Vec<u16> = self.high.take().into_iter().chain(units).collect();
        let is_half = |unit: &u16| (0xd800..0xdc00).contains(unit);
        self.high = units.pop_if(|unit| is_half(unit) && !bytes.is_empty());
        let text = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        self.text = text.collect::<String>().into_bytes();
        self.at = 0;
        Ok(())
    }
}

impl Read for Wide {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.at == self.text.len() {
            self.fill()?;
        }
        let read = (&self.text[self.at..]).read(out)?;
        self.at += read;
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_orders_are_read_with_and_without_a_mark() {
        let text = format!("t;ü\n{}", "0;1\n\u{1f69c}".repeat(20_000));
        let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        for bytes in [
            [&[0xff, 0xfe], little.as_slice()].concat(),
            [&[0xfe, 0xff], big.as_slice()].concat(),
            little,
            big,
        ] {
            assert_eq!(head(bytes), text.as_bytes());
        }
    }

    #[test]
    fn other_text_stays_as_it_is() {
        for text in [
            &b"t,a\n0,1\n"[..],
            b"\0\0\0\0\0\0\0\0\0",
            b"t,a\n\0\0\0\0\0\0\0",
            b"",
            b"t",
        ] {
            assert_eq!(head(text.to_vec()), text);
        }
    }
}

//! The cells of the lines of a table.

use std::fmt;
use std::io::{self, BufRead, Read};

use csv_core::{ReadRecordResult, Reader, ReaderBuilder};

use super::dialect::{BLANK, Dialect};

/// The cells of a record: their text, and where each begins and ends in it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Record {
    text: Vec<u8>,
    cells: Vec<[usize; 2]>,
}

impl Record {
    /// Number of cells.
    pub(crate) fn len(&self) -> usize {
        self.cells.len()
    }

    /// A cell.
    pub(crate) fn get(&self, at: usize) -> Option<&[u8]> {
        self.cells.get(at).map(|[from, to]| &self.text[*from..*to])
    }

    /// The cells in turn.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u8]> {
        self.cells.iter().map(|[from, to]| &self.text[*from..*to])
    }

    /// Whether a cell, in quotes, holds the end of a line.
    pub(super) fn has_line_end(&self) -> bool {
        memchr::memchr(b'\n', &self.text).is_some()
    }

    fn clear(&mut self) {
        self.text.clear();
        self.cells.clear();
    }

    fn push(&mut self, cell: &[u8]) {
        let from = self.text.len();
        self.text.extend_from_slice(cell);
        self.cells.push([from, self.text.len()]);
    }

    /// The cells of a line that has no quotes.
    fn split(&mut self, line: &[u8], separator: u8) {
        self.clear();
        if line.is_empty() {
            return;
        }
        self.text.extend_from_slice(line);
        let mut from = 0;
        for at in memchr::memchr_iter(separator, line).chain([line.len()]) {
            let cell = &line[from..at];
            let blanks = cell.len() - cell.trim_ascii_start().len();
            let length = cell.trim_ascii().len();
            if is_cell(length, separator) {
                self.cells.push([from + blanks, from + blanks + length]);
            }
            from = at + 1;
        }
    }
}

/// Whether a text of this length is a cell: empty text between separating blanks is none.
fn is_cell(length: usize, separator: u8) -> bool {
    length > 0 || separator != BLANK
}

/// Splits records into cells, trimmed of blanks. Nearly every line has no quotes and is split at its
/// separators, in a tenth of the time that the library takes for the others.
#[derive(Debug)]
pub(crate) struct Cells {
    separator: u8,
    library: Reader,
    bytes: Vec<u8>,
    ends: Vec<usize>,
    record: Record,
}

impl Cells {
    pub(crate) fn new(dialect: Dialect) -> Self {
        Self {
            separator: dialect.separator,
            library: ReaderBuilder::new().delimiter(dialect.separator).build(),
            bytes: vec![0; 256],
            ends: vec![0; 32],
            record: Record::default(),
        }
    }

    /// The cells of one line. Every line gives cells: at worst its quotes are malformed, and then a cell is no number.
    pub(crate) fn split(&mut self, line: &[u8]) -> &Record {
        match plain(line) {
            Some(line) => self.record.split(line, self.separator),
            // Reading from memory cannot fail.
            None => self.read(&mut &line[..]).map_or((), drop),
        }
        &self.record
    }

    /// Reads one record of any kind; returns its number of bytes, none at the end.
    fn read(&mut self, input: &mut impl BufRead) -> io::Result<Option<usize>> {
        self.library.reset();
        self.record.clear();
        let (mut taken, mut written, mut count) = (0, 0, 0);
        loop {
            if taken > MOST {
                return Err(too_long());
            }
            let text = input.fill_buf()?;
            let (result, read, bytes, ends) =
                self.library
                    .read_record(text, &mut self.bytes[written..], &mut self.ends[count..]);
            input.consume(read);
            (taken, written, count) = (taken + read, written + bytes, count + ends);
            match result {
                // An empty input ends the last cell.
                ReadRecordResult::InputEmpty => {}
                ReadRecordResult::OutputFull => self.bytes.resize(2 * self.bytes.len(), 0),
                ReadRecordResult::OutputEndsFull => self.ends.resize(2 * self.ends.len(), 0),
                ReadRecordResult::Record => break,
                ReadRecordResult::End => return Ok(None),
            }
        }
        let mut start = 0;
        for end in &self.ends[..count] {
            let cell = unquoted(self.bytes[start..*end].trim_ascii());
            if is_cell(cell.len(), self.separator) {
                self.record.push(cell);
            }
            start = *end;
        }
        Ok(Some(taken))
    }
}

/// A cell with blanks around its quotes: `1, "2" ,3`.
fn unquoted(cell: &[u8]) -> &[u8] {
    let inner = cell.strip_prefix(b"\"").and_then(|c| c.strip_suffix(b"\""));
    inner.map_or(cell, <[u8]>::trim_ascii)
}

/// A line without its end; none if it contains quotes or other line ends.
fn plain(line: &[u8]) -> Option<&[u8]> {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    let line = line.strip_suffix(b"\r").unwrap_or(line);
    memchr::memchr3(b'"', b'\r', b'\n', line)
        .is_none()
        .then_some(line)
}

/// Longest record: a quote that is never closed would include all following lines.
const MOST: usize = 1 << 22;

fn too_long() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, TooLong)
}

/// A record is longer than [`MOST`].
#[derive(Debug)]
pub(crate) struct TooLong;

impl std::error::Error for TooLong {}

impl fmt::Display for TooLong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a row is longer than {} MB", MOST >> 20)
    }
}

/// Longest line that is read at once; a longer one is left to the library.
const LONGEST: u64 = 1 << 16;

/// The records of a table, without empty lines.
pub(crate) struct Records<R> {
    input: R,
    cells: Cells,
    /// A line, and the number of its bytes that were taken.
    line: Vec<u8>,
    at: usize,
    /// Bytes before the current record, and up to its end.
    start: u64,
    end: u64,
}

impl<R: BufRead> Records<R> {
    pub(crate) fn new(input: R, dialect: Dialect) -> Self {
        Self {
            input,
            cells: Cells::new(dialect),
            line: Vec::new(),
            at: 0,
            start: 0,
            end: 0,
        }
    }

    /// Advances to the next record; false at the end.
    pub(crate) fn advance(&mut self) -> io::Result<bool> {
        loop {
            if self.at == self.line.len() {
                self.at = 0;
                self.line.clear();
                let input = self.input.by_ref();
                input.take(LONGEST).read_until(b'\n', &mut self.line)?;
            }
            let mut text = &self.line[self.at..];
            let (length, is_cut) = (text.len(), self.line.len() as u64 == LONGEST);
            self.start = self.end;
            if length == 0 {
                return Ok(false);
            }
            // Blocks of zeros may be long, and contain no quote.
            let is_hole = is_cut && text.iter().all(|b| *b == 0);
            if let Some(line) = plain(text).filter(|_| !is_cut || is_hole) {
                self.cells.record.split(line, self.cells.separator);
                self.end += length as u64;
                self.at = self.line.len();
                if self.cells.record.len() > 0 {
                    return Ok(true);
                }
            } else {
                let input = self.input.by_ref();
                let taken = self.cells.read(&mut text.by_ref().chain(input))?;
                self.at = self.line.len() - text.len();
                self.end += taken.unwrap_or(0) as u64;
                return Ok(taken.is_some());
            }
        }
    }

    /// The cells of the current record.
    pub(crate) fn record(&self) -> &Record {
        &self.cells.record
    }

    /// Bytes before the current record.
    pub(crate) fn start(&self) -> u64 {
        self.start
    }

    /// Bytes up to its end.
    pub(crate) fn end(&self) -> u64 {
        self.end
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csv::ByteRecord;

    fn cells_of(record: &Record) -> ByteRecord {
        record.iter().collect()
    }

    fn library(text: &[u8]) -> Vec<ByteRecord> {
        let mut whole = csv::ReaderBuilder::new();
        whole.has_headers(false).flexible(true).trim(csv::Trim::All);
        let records = whole.from_reader(text).into_byte_records();
        records.map(|r| r.expect("a record")).collect()
    }

    #[test]
    fn a_line_has_the_cells_that_the_table_would_have() {
        let lines = [
            "a,b,c",
            "",
            ",",
            " 1 , 2,3 \r\n",
            "\"x, y\",2",
            "\"say \"\"so\"\"\",1\n",
            "\"open, never closed",
            "1,,",
        ];
        let mut cells = Cells::new(Dialect { separator: b',' });
        for line in lines {
            let expected = library(line.as_bytes()).pop().unwrap_or_default();
            assert_eq!(cells_of(cells.split(line.as_bytes())), expected, "{line:?}");
        }
    }

    #[test]
    fn blanks_around_quotes_belong_to_nothing() {
        let mut cells = Cells::new(Dialect { separator: b',' });
        let found = cells.split(b"\"t\" , \"speed\" ,\"slope\"\n");
        assert_eq!(cells_of(found), vec!["t", "speed", "slope"]);
    }

    #[test]
    fn several_blanks_separate_like_one() {
        let text = b"  t   \"swing speed\"  boom \n 0.00  1   -2\r\n\n   \n10.25 1 2";
        let mut records = Records::new(&text[..], Dialect { separator: BLANK });
        for expected in [
            ["t", "swing speed", "boom"],
            ["0.00", "1", "-2"],
            ["10.25", "1", "2"],
        ] {
            assert!(records.advance().expect("memory"));
            assert_eq!(cells_of(records.record()), expected.to_vec());
        }
        assert!(!records.advance().expect("memory"));
    }

    #[test]
    fn a_quote_that_is_never_closed_does_not_take_all_memory() {
        for byte in [b'2', b',', b'"'] {
            let endless = (&b"a,b\n1,\""[..]).chain(io::repeat(byte));
            let mut records =
                Records::new(io::BufReader::new(endless), Dialect { separator: b',' });
            assert!(records.advance().expect("the header"));
            let error = records.advance().expect_err("no end");
            assert!(
                error.get_ref().is_some_and(|e| e.is::<TooLong>()),
                "{error}"
            );
        }
    }

    #[test]
    fn a_table_has_the_records_that_the_library_finds() {
        let long = format!("1,{}\n", " ".repeat(2 * LONGEST as usize));
        let tables = [
            "a,b\n1,2\n3,4",
            "a,b\r\n\r\n\n1,2\r\n",
            "a,b\r1,2\r3,4\r",
            "a,b\r1,2\n\r3,4\r\n",
            "a,\"b\nc\",d\n1,\"2\r\n\",3\n4,5,6\n",
            "a,b\n1,5\" pipe\n2,\"open\n3,4\n",
            "\n\n",
            "",
            " \n,\n",
            &[&long, "2,3\n", &long, "4,\"x\"\n"].concat(),
        ];
        for table in tables {
            // Small buffers, so that every record is split somewhere.
            for room in [1, 7, 1 << 16] {
                let input = io::BufReader::with_capacity(room, table.as_bytes());
                let mut records = Records::new(input, Dialect { separator: b',' });
                let mut found = Vec::new();
                while records.advance().expect("memory") {
                    found.push(cells_of(records.record()));
                    let taken = &table.as_bytes()[records.start() as usize..records.end() as usize];
                    assert_eq!(library(taken).len(), 1, "{taken:?}");
                }
                assert_eq!(found, library(table.as_bytes()), "{table:?}");
                assert_eq!(records.end(), table.len() as u64);
            }
        }
    }
}

//! The cells of lines that come one by one.

use csv::ByteRecord;
use csv_core::{ReadRecordResult, Reader, ReaderBuilder};

use super::dialect::Dialect;

/// Splits lines of a table. Making a reader costs more than ten lines do, so one is kept.
#[derive(Debug)]
pub(crate) struct Cells {
    reader: Reader,
    bytes: Vec<u8>,
    ends: Vec<usize>,
    record: ByteRecord,
}

impl Cells {
    pub(crate) fn new(dialect: Dialect) -> Self {
        Self {
            reader: ReaderBuilder::new().delimiter(dialect.separator).build(),
            bytes: Vec::new(),
            ends: Vec::new(),
            record: ByteRecord::new(),
        }
    }

    /// The cells of one line, without the blanks around them. A line cannot be broken: at worst its quotes are, and then
    /// a cell is no number.
    pub(crate) fn split(&mut self, line: &[u8]) -> &ByteRecord {
        // Cells are not longer than the line, nor more than its bytes and one.
        self.bytes.resize(line.len() + 1, 0);
        self.ends.resize(line.len() + 2, 0);
        self.reader.reset();
        self.record.clear();
        let (mut input, mut written, mut count) = (line, 0, 0);
        loop {
            let (result, read, bytes, ends) =
                self.reader
                    .read_record(input, &mut self.bytes[written..], &mut self.ends[count..]);
            (written, count) = (written + bytes, count + ends);
            input = &input[read..];
            // An empty input is the end of the last cell.
            if !matches!(result, ReadRecordResult::InputEmpty) {
                break;
            }
        }
        let mut start = 0;
        for end in &self.ends[..count] {
            self.record.push_field(self.bytes[start..*end].trim_ascii());
            start = *end;
        }
        &self.record
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let mut whole = csv::ReaderBuilder::new();
            whole.has_headers(false).flexible(true).trim(csv::Trim::All);
            let expected = whole.from_reader(line.as_bytes()).byte_records().next();
            let expected = expected.map_or_else(ByteRecord::new, |r| r.expect("a record"));
            assert_eq!(cells.split(line.as_bytes()), &expected, "{line:?}");
        }
    }
}

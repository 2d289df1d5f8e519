//! Logs of candump.

use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::{Decoder, LeftOut, Line, parse, text};
use crate::map::Map;
use crate::packed::{self, Content};
use crate::signal::{Row, Sensors};
use crate::{Error, Lacks, MAX_LINE};

/// The rows of a log, in order.
pub(crate) struct Log<S: Sensors> {
    path: PathBuf,
    file: BufReader<Content>,
    decoder: Decoder<S>,
    line: Vec<u8>,
    number: u64,
    /// Bytes read.
    pub read: u64,
    has_ended: bool,
    left_out: LeftOut,
    /// Parts of the log that could not be read, complete at its end.
    pub lacks: Lacks,
}

impl<S: Sensors> Log<S> {
    /// Opens a log, to be read with the map.
    pub(crate) fn open(path: &Path, map: &Map) -> Result<Self, Error> {
        let failed = |e| Error::system("read the CAN log", path, &e);
        Ok(Self {
            file: BufReader::new(packed::open(path).map_err(failed)?),
            path: path.to_owned(),
            decoder: Decoder::new(map)?,
            line: Vec::new(),
            number: 0,
            read: 0,
            has_ended: false,
            left_out: LeftOut::default(),
            lacks: Lacks::default(),
        })
    }

    /// The next row; none at the end.
    pub(crate) fn row(&mut self) -> Result<Option<Row<S>>, Error> {
        loop {
            if let Some(row) = self.decoder.row() {
                return Ok(Some(row));
            }
            if self.has_ended {
                return Ok(None);
            }
            self.line.clear();
            let mut file = (&mut self.file).take(MAX_LINE as u64);
            let read = file.read_until(b'\n', &mut self.line);
            let read = match read {
                Err(e) if self.number > 0 && e.kind() == ErrorKind::UnexpectedEof => {
                    let log = self.path.display();
                    self.lacks.cut_off = Some(format!(
                        "{log}: the packed file was cut off; the frames before the cut were read"
                    ));
                    0
                }
                read => read.map_err(|e| Error::system("read the CAN log", &self.path, &e))?,
            };
            self.read += read as u64;
            if read == 0 {
                self.end()?;
            } else {
                self.number += 1;
                self.take()?;
            }
        }
    }

    fn take(&mut self) -> Result<(), Error> {
        let text = text(&self.line);
        let line = parse(&text);
        let log = self.path.display();
        if line.is_none() && !text.ends_with('\n') && self.line.len() < MAX_LINE {
            // The logger was switched off.
            let number = self.number;
            self.lacks.cut_off = Some(format!(
                "{log}:{number}: the last line was cut off; it is left out"
            ));
            return Ok(());
        }
        self.left_out.count(line.as_ref(), self.number, &text);
        match line {
            Some(Line::Frame { frame, timed: true }) => self.decoder.take(&frame),
            Some(Line::Nothing) => {}
            Some(Line::Frame { .. } | Line::Dropped(_)) | None => {
                self.left_out.judge_early(&log.to_string())?;
            }
        }
        Ok(())
    }

    fn end(&mut self) -> Result<(), Error> {
        self.has_ended = true;
        self.decoder.finish();
        let log = self.path.display();
        self.left_out.judge(&log.to_string())?;
        self.lacks.left_out = self.left_out.words(&log.to_string());
        self.decoder.check_times(&log.to_string())?;
        for remark in self.decoder.take_remarks() {
            tracing::warn!("{log}: {remark}");
        }
        self.decoder.check_senders(&format!("the log {log}"))
    }
}

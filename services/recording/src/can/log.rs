//! Logs of candump.

use std::path::Path;

use super::{Decoder, Line, parse};
use crate::Error;
use crate::map::Map;
use crate::signal::{Machine, Row};

/// Reads a log as the map says.
pub(crate) fn read<M: Machine>(path: &Path, map: &Map) -> Result<Vec<Row<M>>, Error> {
    let bytes = std::fs::read(path).map_err(|e| Error::system("read the CAN log", path, &e))?;
    let text = String::from_utf8_lossy(&bytes);
    let mut decoder = Decoder::<M>::new(map)?;
    let mut rows = Vec::new();
    let count = text.lines().count();
    for (number, line) in text.lines().enumerate() {
        match parse(line) {
            Some(Line::Frame { frame, timed: true }) => decoder.take(&frame),
            Some(Line::Frame { .. }) => {
                return Err(Error::new(
                    "the log tells no times",
                    format!("{}:{}", path.display(), number + 1),
                    "record it with candump -L, or with candump -ta",
                ));
            }
            Some(Line::Nothing) => {}
            // The last line of a log whose writer was switched off.
            None if number + 1 == count && !text.ends_with('\n') => {}
            None => {
                let shown: String = line.trim().chars().take(80).collect();
                return Err(Error::new(
                    format!("\"{shown}\" is no frame"),
                    format!("{}:{}", path.display(), number + 1),
                    "give a log of candump -L, or of candump -ta with its times",
                ));
            }
        }
        rows.extend(std::iter::from_fn(|| decoder.row()));
    }
    decoder.finish();
    rows.extend(std::iter::from_fn(|| decoder.row()));
    for remark in decoder.take_remarks() {
        tracing::warn!("{}: {remark}", path.display());
    }
    decoder.check_heard(&format!("the log {}", path.display()))?;
    Ok(rows)
}

//! Counts the lines of a log that are not frames, and stores the first of them for the message.

use super::Line;
use crate::Error;

/// Number of lines without a frame after which a log is judged before its end, and again after each multiple.
const ENOUGH: u64 = 100;
/// Largest number of characters of a line in a message.
const SHOWN: usize = 80;

/// The remedy for a line that is not a frame.
fn remedy(text: &str) -> &'static str {
    if text.starts_with("Timestamp:") {
        return "this is what python-can prints: have it write a log, by can_logger -f day.log";
    }
    "give a log of candump -L, or of candump -ta with its times; a line is (1700000000.000000) can0 18FEF100#0102030405060708, \
     its time in seconds, or in ms, µs or ns since 1970"
}

/// Counts of a log: lines, and what is not a frame.
#[derive(Debug, Default)]
pub(crate) struct LeftOut {
    /// Number of lines that are not blank.
    lines: u64,
    /// Number of those without a usable frame, and among these the number of frames without a time.
    strange: u64,
    untimed: u64,
    /// Number and text of the first line without a usable frame.
    first: Option<(u64, String)>,
    /// Number of frames lost during recording.
    dropped: u64,
}

impl LeftOut {
    /// Counts line `number`. Stores `text` for the message if it is the first line without a usable frame.
    pub(crate) fn count(&mut self, line: Option<&Line<'_>>, number: u64, text: &str) {
        self.lines += u64::from(!text.trim().is_empty());
        let is_untimed = match line {
            Some(Line::Nothing | Line::Frame { timed: true, .. }) => return,
            Some(Line::Dropped(frames)) => {
                self.dropped = self.dropped.saturating_add(*frames);
                return;
            }
            Some(Line::Frame { timed: false, .. }) => true,
            None => false,
        };
        self.strange += 1;
        self.untimed += u64::from(is_untimed);
        self.first
            .get_or_insert_with(|| (number, text.trim().chars().take(SHOWN).collect()));
    }

    /// Judges the log at every [`ENOUGH`] lines without a usable frame.
    ///
    /// # Errors
    /// As [`Self::judge`].
    pub(crate) fn judge_early(&self, log: &str) -> Result<(), Error> {
        match self.strange.is_multiple_of(ENOUGH) {
            true => self.judge(log),
            false => Ok(()),
        }
    }

    /// Checks whether at least half of the lines are frames with a time.
    ///
    /// # Errors
    /// Most lines are not frames, or have no time.
    pub(crate) fn judge(&self, log: &str) -> Result<(), Error> {
        let Some((number, text)) = self
            .first
            .as_ref()
            .filter(|_| 2 * self.strange > self.lines)
        else {
            return Ok(());
        };
        let place = format!("{log}:{number}");
        if 2 * self.untimed > self.strange {
            let remedy = "record it with candump -L, or with candump -ta";
            return Err(Error::new("the log has no times", place, remedy));
        }
        let what = match self.lines {
            1 => format!("\"{text}\" is no frame"),
            lines => format!(
                "{} of {lines} lines are no frames; the first is \"{text}\"",
                self.strange
            ),
        };
        Err(Error::new(what, place, remedy(text)))
    }

    /// Message on the lines that were left out and the frames that were lost, if there are any.
    pub(crate) fn words(&self, log: &str) -> Option<String> {
        let strange = self.first.as_ref().map(|(number, text)| {
            let lines = match self.strange {
                1 => "one line is no frame and was left out".to_owned(),
                n => format!("{n} lines are no frames and were left out"),
            };
            let first = if self.strange == 1 {
                ""
            } else {
                ", the first of them"
            };
            format!("{log}:{number}{first}: {lines}: \"{text}\"")
        });
        let dropped = (self.dropped > 0).then(|| {
            let frames = self.dropped;
            format!("{log}: {frames} frames were lost while it was recorded (DROPCOUNT of candump)")
        });
        let all: Vec<String> = strange.into_iter().chain(dropped).collect();
        (!all.is_empty()).then(|| all.join("\n"))
    }
}

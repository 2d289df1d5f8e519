//! Progress of one stream: the last sample seen, the last sent, and whether any was missed in between.

/// Most changes of a mark that are sent in one period.
pub(crate) const CHANGES: u32 = 10;

/// Up to three numbers of a sample; a change is sent at once.
pub(crate) type Mark = [u32; 3];

/// Position of a sample relative to the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Continuity {
    Next,
    Gap,
    Before,
}

/// Progress of a stream.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    /// Number of the last sample, -1 before the first.
    pub seen: i64,
    /// Number of the last message, -1 before the first.
    pub selected: i64,
    /// Whether no sample was missed since that message.
    whole: bool,
    /// Period and mark of the last sample.
    last: Option<(i64, Mark)>,
    changes: u32,
}

impl Default for Track {
    fn default() -> Self {
        Self {
            seen: -1,
            selected: -1,
            whole: true,
            last: None,
            changes: 0,
        }
    }
}

impl Track {
    /// Notes a sample; `is_first`: the process counts from 0 again.
    pub fn see(&mut self, number: u64, is_first: bool) -> Continuity {
        let number = number as i64;
        if number <= self.seen {
            return Continuity::Before;
        }
        let follows = number == self.seen + 1 || is_first;
        self.whole &= follows;
        self.seen = number;
        if follows {
            Continuity::Next
        } else {
            Continuity::Gap
        }
    }

    /// Whether the sample is the first of its period, or of a mark. In a stream that was joined midway the sample before is
    /// unknown.
    pub fn is_due(&mut self, number: u64, bucket: i64, mark: Mark) -> bool {
        match self.last.replace((bucket, mark)) {
            None => number == 0,
            Some((b, _)) if b != bucket => {
                self.changes = 0;
                true
            }
            Some((_, m)) if m != mark => {
                self.changes += 1;
                self.changes <= CHANGES
            }
            _ => false,
        }
    }

    /// Whether the mark differs from that of the sample before; at most [`CHANGES`] times a second.
    pub fn has_changed(&mut self, number: u64, second: i64, mark: Mark) -> bool {
        match self.last.replace((second, mark)) {
            None => number == 0,
            Some((before, same)) => {
                if before != second {
                    self.changes = 0;
                }
                self.changes += u32::from(same != mark);
                same != mark && self.changes <= CHANGES
            }
        }
    }

    /// Notes that a sample is sent; returns the number of the message before it, if known.
    pub fn select(&mut self, number: u64) -> Option<i64> {
        let after = self.whole.then_some(self.selected);
        (self.selected, self.whole) = (number as i64, true);
        after
    }
}

//! Where one stream is: which sample was seen last, which was sent, and whether any was missed in between.

/// Changes of verdict that are sent in one period.
pub(crate) const CHANGES: u32 = 10;

/// What a sample says that is sent at once when it changes: up to three numbers.
pub(crate) type Mark = [u32; 3];

/// How a sample follows the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Continuity {
    Next,
    Gap,
    Before,
}

/// Where a stream is.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    /// Number of the last sample, -1 before the first.
    pub seen: i64,
    /// Number of the last message, -1 before the first.
    pub selected: i64,
    /// No sample was missed since that message.
    whole: bool,
    /// Second and mark of the last sample.
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
    /// Notes a sample; `is_first`: of a process that counts from 0 again.
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

    /// Whether the sample is the first of its second, or of a mark. Of a stream that was joined on
    /// its way nothing is known of the sample before.
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

    /// Whether the mark is another than in the sample before; so many times a second at most.
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

    /// Notes that a sample is sent; returns the number of the message before it, if that is known.
    pub fn select(&mut self, number: u64) -> Option<i64> {
        let after = self.whole.then_some(self.selected);
        (self.selected, self.whole) = (number as i64, true);
        after
    }
}

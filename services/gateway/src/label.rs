//! Attachment of a message: its machine, its run, and its number in its stream.

use std::fmt;

/// The attachment of a message, as text: `MACHINE RUN NUMBER AFTER WALL_MS`, so that any language reads it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    /// The machine.
    pub machine: String,
    /// Its run: a random id. Neither the id nor the machine's clock orders runs.
    pub run: u64,
    /// Number of the sample in the message. Numbers have gaps, because a stream is a selection.
    pub number: u64,
    /// Number of the selected message before it, -1 if it is the first of the run. `None` if the sender has not seen all samples
    /// in between. A reader that lacks message `after` has a gap.
    pub after: Option<i64>,
    /// Time of measurement [ms since 1970, the machine's clock].
    pub wall_ms: u64,
}

impl Label {
    /// Reads an attachment.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        let text = std::str::from_utf8(bytes).ok().filter(|t| t.len() < 200)?;
        let mut words = text.split(' ');
        let label = Self {
            machine: words.next()?.to_owned(),
            run: words.next()?.parse().ok()?,
            number: words.next()?.parse().ok()?,
            after: match words.next()? {
                "?" => None,
                number => Some(number.parse().ok().filter(|n| *n >= -1)?),
            },
            wall_ms: words.next()?.parse().ok()?,
        };
        // The store has signed numbers.
        let fits = [label.run, label.number, label.wall_ms]
            .iter()
            .all(|n| i64::try_from(*n).is_ok());
        let follows = label.after.is_none_or(|after| after < label.number as i64);
        (words.next().is_none() && fits && follows).then_some(label)
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (machine, run, number) = (&self.machine, self.run, self.number);
        match self.after {
            Some(after) => write!(f, "{machine} {run} {number} {after} {}", self.wall_ms),
            None => write!(f, "{machine} {run} {number} ? {}", self.wall_ms),
        }
    }
}

/// Bits of a number that a process counts itself; the bits above hold the number of its restarts (health reports).
pub const LIFE: u32 = 40;

/// Restarts of the process before a number; 0 in streams that no process numbers itself.
fn life(number: i64) -> i64 {
    number >> LIFE
}

/// Least number of messages missing between a message `before` (-1: the beginning of the run) and the next one stored.
/// `per_period`: samples between two messages of the stream, 0 for one without a period. Both sides count with this function.
pub fn lost(before: i64, next: &Label, per_period: f64) -> u64 {
    if next.after.is_some_and(|after| after <= before) {
        return 0;
    }
    // A stated predecessor that is absent is one missing message.
    let least = u64::from(next.after.is_some());
    if per_period < 1.0 {
        return least;
    }
    // A restarted process counts from 0. Nothing is known of the restarts in between.
    let number = next.number as i64;
    let begun = life(number) << LIFE;
    let before = if before < begun {
        -per_period
    } else {
        (before - begun) as f64
    };
    let periods = ((number - begun) as f64 - before) / per_period;
    ((periods.round() - 1.0).max(0.0) as u64).max(least)
}

/// Number of messages missing after `before`, where message `upto` is known to have existed.
pub fn lost_behind(before: i64, upto: i64, per_period: f64) -> u64 {
    if upto <= before {
        return 0;
    }
    let last = Label {
        machine: String::new(),
        run: 0,
        number: upto.max(0) as u64,
        after: None,
        wall_ms: 0,
    };
    lost(before, &last, per_period).saturating_add(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label(number: u64, after: Option<i64>) -> Label {
        Label {
            machine: "ex-17".into(),
            run: 1_795_300_000_000,
            number,
            after,
            wall_ms: 1_795_300_000_123,
        }
    }

    #[test]
    fn a_label_reads_back_and_nonsense_does_not() {
        for after in [None, Some(-1), Some(4611)] {
            let label = label(4711, after);
            assert_eq!(Label::parse(label.to_string().as_bytes()), Some(label));
        }
        for bad in [
            "",
            "ex 1 2 3",
            "ex 1 2 3 4 5",
            "ex 1 2 2 4",
            "ex 1 2 -2 4",
            "ex -1 2 1 4",
            "ex 1 99999999999999999999 1 4",
            "ex 1 18446744073709551615 1 4",
        ] {
            assert_eq!(Label::parse(bad.as_bytes()), None, "{bad}");
        }
        assert_eq!(Label::parse(&[0xff, 0xfe]), None);
        assert_eq!(Label::parse(&[b'a'; 4000]), None);
    }

    #[test]
    fn what_is_missing_is_counted_in_messages() {
        let hz = 100.0;
        assert_eq!(lost(400, &label(500, Some(400)), hz), 0);
        assert_eq!(
            lost(400, &label(450, Some(400)), hz),
            0,
            "a change of verdict"
        );
        assert_eq!(lost(100, &label(500, Some(400)), hz), 3);
        assert_eq!(lost(100, &label(500, None), hz), 3);
        assert_eq!(lost(-1, &label(500, None), hz), 5, "0 to 400");
        assert_eq!(lost(-1, &label(0, Some(-1)), hz), 0);
        assert_eq!(lost(400, &label(460, None), hz), 0);
        assert_eq!(lost(400, &label(460, Some(430)), hz), 1);
        assert_eq!(
            lost(400, &label(9000, Some(430)), 0.0),
            1,
            "without a period"
        );
        assert_eq!(lost_behind(400, 400, hz), 0);
        assert_eq!(lost_behind(400, 700, hz), 3, "500, 600, 700");
        assert_eq!(lost_behind(400, 450, hz), 1);
        assert_eq!(lost_behind(-1, 9000, 0.0), 1);
        // After a restart: only what is missing since then.
        let (hz, again) = (1.0 / 0.3, 1_u64 << LIFE);
        assert_eq!(lost_behind(400, again as i64 | 9, hz), 4, "0, 3, 7, 9");
        assert_eq!(lost(400, &label(again | 9, None), hz), 3);
        assert_eq!(lost(again as i64 | 3, &label(again | 10, None), hz), 1);
        assert_eq!(lost(400, &label(again, Some(400)), hz), 0);
        assert_eq!(lost(-1, &label((2 * again) | 7, None), hz), 2, "0, 3");
    }
}

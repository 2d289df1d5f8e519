//! Ages of files by a clock that is set while they are written: a computer without a battery begins in 1970, and gets its time from
//! GPS or the network later.

use std::time::{Duration, SystemTime};

use rustix::time::ClockId;

/// Change of the offset between the wall clock and the time since boot that counts as a setting [ns].
const SET_NS: i64 = 500_000_000;
/// Settings that are told apart; further ones add to the latest.
const MOST: usize = 64;

/// The wall clock, and by how much it was set forward since this process looks at it.
#[derive(Debug)]
pub(crate) struct Ages {
    offset_ns: i64,
    /// Time before each setting, and its length.
    set: Vec<(SystemTime, Duration)>,
}

impl Ages {
    /// Looks at the clock for the first time.
    pub(crate) fn begin() -> Self {
        Self {
            offset_ns: offset_ns(),
            set: Vec::new(),
        }
    }

    /// Notes whether the clock was set.
    pub(crate) fn look(&mut self) {
        self.note(offset_ns(), SystemTime::now());
    }

    fn note(&mut self, offset_ns: i64, now: SystemTime) {
        let change = offset_ns.saturating_sub(self.offset_ns);
        if change.abs() < SET_NS {
            return;
        }
        self.offset_ns = offset_ns;
        // A clock that was set back makes files younger than they are: they stay longer.
        let Ok(length) = u64::try_from(change).map(Duration::from_nanos) else {
            return;
        };
        let before = now.checked_sub(length).unwrap_or(SystemTime::UNIX_EPOCH);
        let is_full = self.set.len() == MOST;
        match self.set.last_mut().filter(|_| is_full) {
            Some(last) => *last = (before, last.1.saturating_add(length)),
            None => self.set.push((before, length)),
        }
    }

    /// As if the clock had been set forward until `now`.
    #[cfg(test)]
    pub(crate) fn set_forward(&mut self, by: Duration, now: SystemTime) {
        self.note(self.offset_ns + by.as_nanos() as i64, now);
    }

    /// Age of a file that was last written at `changed`, without the lengths by which the clock was set forward since. Zero in the
    /// future.
    pub(crate) fn age(&self, changed: SystemTime, now: SystemTime) -> Duration {
        let by_clock = now.duration_since(changed).unwrap_or_default();
        let since = self.set.iter().filter(|(before, _)| changed <= *before);
        let set: Duration = since.map(|(_, length)| *length).sum();
        by_clock.saturating_sub(set)
    }
}

/// Wall time minus the time since boot, which includes a suspended computer's [ns].
fn offset_ns() -> i64 {
    nanoseconds(ClockId::Realtime) - nanoseconds(ClockId::Boottime)
}

/// A clock of the system [ns].
pub(crate) fn nanoseconds(clock: ClockId) -> i64 {
    let now = rustix::time::clock_gettime(clock);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUR: Duration = Duration::from_secs(3600);
    const YEARS: Duration = Duration::from_secs(50 * 365 * 86_400);

    #[test]
    fn a_clock_that_is_set_forward_makes_no_file_older() {
        let boot = SystemTime::UNIX_EPOCH + HOUR;
        let mut ages = Ages {
            offset_ns: 0,
            set: Vec::new(),
        };
        let (first, second) = (boot + HOUR, boot + 2 * HOUR);
        // GPS tells the time two hours after the boot; a part is written an hour later.
        let now = second + YEARS;
        ages.note(YEARS.as_nanos() as i64, now);
        assert_eq!(ages.age(first, now), HOUR);
        assert_eq!(ages.age(second, now), Duration::ZERO);
        let third = now + HOUR;
        assert_eq!(ages.age(third, third + HOUR), HOUR);
        assert_eq!(ages.age(first, third + HOUR), 3 * HOUR);
    }

    #[test]
    fn a_clock_that_is_set_back_or_slewed_changes_no_age_for_the_worse() {
        let now = SystemTime::UNIX_EPOCH + YEARS;
        let mut ages = Ages {
            offset_ns: 0,
            set: Vec::new(),
        };
        ages.note(SET_NS - 1, now);
        ages.note(-(HOUR.as_nanos() as i64), now - HOUR);
        assert!(ages.set.is_empty(), "nothing was set forward");
        assert_eq!(ages.age(now, now - HOUR), Duration::ZERO, "in the future");
        assert_eq!(ages.age(now - 3 * HOUR, now - HOUR), 2 * HOUR);
    }

    #[test]
    fn however_often_a_clock_is_set_the_list_is_bounded() {
        let mut ages = Ages {
            offset_ns: 0,
            set: Vec::new(),
        };
        let begun = SystemTime::UNIX_EPOCH;
        for hours in 1..=200_i32 {
            let offset = HOUR.as_nanos() as i64 * i64::from(hours);
            ages.note(offset, begun + HOUR * hours as u32);
        }
        assert_eq!(ages.set.len(), MOST);
        assert_eq!(ages.age(begun, begun + 200 * HOUR), Duration::ZERO);
    }
}

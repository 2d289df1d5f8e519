//! Room for honest machines where names are made up: who was heard for a moment only makes way first.

use std::time::{Duration, Instant};

/// Who was heard over less time than this is a stranger.
const MOMENT: Duration = Duration::from_secs(5);
/// Any machine that was silent for so long is forgotten where room is needed; the history keeps what it sent.
const LONG: Duration = Duration::from_secs(86_400);

/// When something was first and last heard.
#[derive(Debug, Clone, Copy)]
pub struct Contact {
    first: Instant,
    last: Instant,
}

impl Contact {
    /// Heard now, for the first time.
    pub fn now() -> Self {
        let now = Instant::now();
        Self {
            first: now,
            last: now,
        }
    }

    /// Heard again.
    pub fn again(&mut self) {
        self.last = Instant::now();
    }

    /// Heard for a moment only.
    pub fn is_stranger(&self) -> bool {
        self.last - self.first < MOMENT
    }
}

/// Who makes way: of the strangers those that were heard longest ago, and whoever was silent for long. A quarter of the
/// room at once, so that a flood of names costs a look through them now and then.
pub fn leave<'a, K: Clone + 'a>(
    all: impl Iterator<Item = (&'a K, Contact)>,
    most: usize,
) -> Vec<K> {
    let mut going: Vec<(Instant, K)> = all
        .filter(|(_, heard)| heard.is_stranger() || heard.last.elapsed() > LONG)
        .map(|(key, heard)| (heard.last, key.clone()))
        .collect();
    going.sort_unstable_by_key(|(last, _)| *last);
    going.truncate((most / 4).max(1));
    going.into_iter().map(|(_, key)| key).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strangers_make_way_the_oldest_first_and_who_stays_does_not() {
        let begin = Instant::now();
        let at = |first: u64, last: u64| Contact {
            first: begin + Duration::from_secs(first),
            last: begin + Duration::from_secs(last),
        };
        let all = [
            ("honest", at(0, 60)),
            ("b", at(3, 3)),
            ("a", at(1, 4)),
            ("c", at(9, 9)),
        ];
        let all = || all.iter().map(|(name, heard)| (name, *heard));
        assert_eq!(leave(all(), 8), ["b", "a"]);
        assert_eq!(leave(all(), 4), ["b"]);
        assert_eq!(leave(all().take(1), 4), Vec::<&str>::new());
    }
}

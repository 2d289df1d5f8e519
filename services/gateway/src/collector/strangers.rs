//! Room for honest machines in a flood of invented names: machines with contact of only a moment are removed first.

use std::time::{Duration, Instant};

/// Machines with a shorter contact than this are strangers.
const MOMENT: Duration = Duration::from_secs(5);
/// Silence after which any machine may be removed where room is needed; the history retains its messages.
const LONG: Duration = Duration::from_secs(86_400);

/// Times of first and last contact.
#[derive(Debug, Clone, Copy)]
pub struct Contact {
    first: Instant,
    last: Instant,
}

impl Contact {
    /// A first contact, now.
    pub fn now() -> Self {
        let now = Instant::now();
        Self {
            first: now,
            last: now,
        }
    }

    /// Updates the last contact to now.
    pub fn again(&mut self) {
        self.last = Instant::now();
    }

    /// Whether all contacts lie within a moment.
    pub fn is_stranger(&self) -> bool {
        self.last - self.first < MOMENT
    }
}

/// Entries to remove: strangers and machines that were silent for long, those with the oldest last contact first. At most a
/// quarter of the room at once, so that a flood of names seldom costs a search.
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

//! By how much emptied buckets differ from each other, over what their rows leave open.
//!
//! Rows leave open what the seals hold back. Most of that is the same in each dump, so emptied buckets of one machine agree better than their
//! rows claim. By how much better, they show themselves:
//! ```text
//! lambda = [PRIOR + sum (x - t)^2/S_r]/(PRIOR + n)        S_r: variance that the rows claim, x - t: beyond what was expected
//! ```
//! The share is lambda, at most 1.
//! One that is unlike the others counts as soon as another one is like them again: it was theirs, and no sensor's that changed.

/// Time between two changes of a sensor: ten hours of work, a shift [s]. One that is missed costs more than one that is looked for in vain.
pub(crate) const BETWEEN_CHANGES: f64 = 3.6e4;
/// The claim of the rows weighs as so many emptied buckets.
const PRIOR: f64 = 2.0;
/// So many buckets are remembered: machines wear, and work goes on elsewhere.
const MEMORY: f64 = 30.0;
/// One bucket says no more than this square. Rows that claim to leave nothing open would say anything.
const MOST: f64 = 1e4;

/// Memory of emptied buckets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Repeats {
    /// Sum of the squares, and how many.
    sum: f64,
    count: f64,
    /// The same of those that were unlike the others since.
    unlike: [f64; 2],
}

impl Repeats {
    /// Share of the rows' variance that is left between emptied buckets.
    pub fn share(&self) -> f64 {
        self.ratio().min(1.0)
    }

    /// The same, beyond 1 where they differ by more.
    pub fn ratio(&self) -> f64 {
        (PRIOR + self.sum) / (PRIOR + self.count)
    }

    /// An emptied bucket differs by so many deviations of its rows; it is like the others, or not.
    pub fn see(&mut self, away: f64, alike: bool) {
        let [sum, count] = &mut self.unlike;
        (*sum, *count) = (*sum + (away * away).min(MOST), *count + 1.0);
        if alike {
            let [sum, count] = core::mem::take(&mut self.unlike);
            let kept = 1.0 - (count / MEMORY).min(1.0);
            (self.sum, self.count) = (kept * self.sum + sum, kept * self.count + count);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_that_agree_are_known_better_and_one_that_does_not_counts_with_the_next() {
        let mut repeats = Repeats::default();
        assert_eq!(repeats.share(), 1.0);
        (0..10).for_each(|_| repeats.see(0.3, true));
        let agreed = repeats.share();
        assert!((0.2..0.35).contains(&agreed), "{agreed}");
        repeats.see(3.0, false);
        assert_eq!(repeats.share(), agreed);
        repeats.see(0.3, true);
        assert!(repeats.share() > 2.0 * agreed);
        (0..1000).for_each(|_| repeats.see(3.0, true));
        assert_eq!(repeats.share(), 1.0);
        // By rows that leave nothing open, and are right or not.
        for away in [f64::INFINITY, f64::NAN] {
            repeats.see(away, true);
        }
        (0..1000).for_each(|_| repeats.see(0.0, true));
        assert!(repeats.share() < 0.1, "{}", repeats.share());
    }
}

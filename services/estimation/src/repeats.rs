//! Scatter between the emptied buckets of one machine, relative to the variance that their rows claim.
//!
//! The rows' variance is mainly the friction of the seals. Most of it is the same in each dump, so emptied buckets of one machine agree
//! better than their rows claim. Their own scatter identifies by how much:
//! ```text
//! lambda = [PRIOR + sum (x - t)^2/S_r]/(PRIOR + n)        S_r: variance that the rows claim, x - t: deviation from the expected value
//! ```
//! The share is lambda, at most 1.
//! A deviating bucket counts as soon as a later one agrees again: the deviation was the bucket's, and no change of the sensor.

/// Time between two changes of a sensor [s]: ten hours of work, a shift. Missing a change costs more than looking for one in vain.
pub(crate) const BETWEEN_CHANGES: f64 = 3.6e4;
/// Weight of the rows' claim, in emptied buckets.
const PRIOR: f64 = 2.0;
/// Number of emptied buckets in the memory: machines wear, and work moves to other material.
const MEMORY: f64 = 30.0;
/// Limit of a squared deviation, in variances of the rows. Rows with next to no variance would give any value.
const MOST: f64 = 1e4;

/// Scatter of the emptied buckets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Repeats {
    /// Sum of the squared deviations, and their number.
    sum: f64,
    count: f64,
    /// Sum and number of the deviations since the last bucket that agreed.
    unlike: [f64; 2],
}

impl Repeats {
    /// Share of the rows' variance that is independent between emptied buckets, at most 1.
    pub fn share(&self) -> f64 {
        self.ratio().min(1.0)
    }

    /// The same ratio, above 1 where buckets differ by more than their rows claim.
    pub fn ratio(&self) -> f64 {
        (PRIOR + self.sum) / (PRIOR + self.count)
    }

    /// Degrees of freedom of that ratio (Student's distribution).
    pub fn degrees(&self) -> f64 {
        PRIOR + self.count
    }

    /// Takes the deviation of an emptied bucket, in standard deviations of its rows, and whether it agrees with the others.
    pub fn see(&mut self, away: f64, agrees: bool) {
        let [sum, count] = &mut self.unlike;
        (*sum, *count) = (*sum + (away * away).min(MOST), *count + 1.0);
        if agrees {
            let [sum, count] = core::mem::take(&mut self.unlike);
            let retained = 1.0 - (count / MEMORY).min(1.0);
            (self.sum, self.count) = (retained * self.sum + sum, retained * self.count + count);
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
        // Rows without variance, with and without a deviation.
        for away in [f64::INFINITY, f64::NAN] {
            repeats.see(away, true);
        }
        (0..1000).for_each(|_| repeats.see(0.0, true));
        assert!(repeats.share() < 0.1, "{}", repeats.share());
    }
}

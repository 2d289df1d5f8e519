//! Detects an emptied bucket, a known weight: what it shows beyond the usual carry-back is an error of the drawing.
//!
//! On-board weighing systems are zeroed with an empty bucket. Here each dump does it: once a load has left the bucket, its true content is
//! `left`, .015 +- .03 of the capacity. A bucket that has not turned has not been emptied, whatever the pressures show. But a fork puts its
//! load down without turning, and may be another tool than the one described. A tool that hangs free and shows less than 0 is empty: with
//! content the error of the drawing would be larger still.

use super::content::Motion;
use crate::Quantity;

/// Shares of the capacity beyond which a bucket holds a load, and below which it may be an emptied one.
const LOADED: f64 = 0.2;
const EMPTIED: f64 = 0.1;
/// Carry-back of an emptied bucket, and its standard deviation, as shares of the capacity.
const STAYS: f64 = 0.015;
const STAYS_STD: f64 = 0.03;

/// Measurement by an emptied bucket.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Tare {
    /// Payload shown beyond the usual carry-back [kg].
    pub apart: f64,
    /// Variance of that by rows and carry-back, without the drawing's [kg^2].
    pub variance: f64,
    /// The bucket has not turned since the dump: it also corrects later loads, which are weighed at this height.
    pub at_dump: bool,
}

/// State of the bucket.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Emptied {
    /// It held a load when last known, and has turned since.
    was_loaded: bool,
    turned: bool,
    /// It has been emptied since, and the ground has not filled it.
    empty: bool,
    /// It has not turned since it was emptied.
    at_dump: bool,
}

impl Emptied {
    /// Updates with the payload by the rows [kg] and the motion of arm and bucket. Returns a measurement while the bucket is empty. One that
    /// turns in the air stays empty, since only the ground fills it.
    ///
    /// A bucket that hangs free (`hangs`) and shows less than 0 is empty, however it was emptied.
    pub fn see(
        &mut self,
        shown: Quantity,
        motion: &Motion,
        hangs: bool,
        capacity: f64,
    ) -> Option<Tare> {
        self.empty &= !motion.held;
        self.turned |= motion.changing > 0.0;
        if motion.open || motion.changing > 0.0 {
            self.at_dump = false;
            return None;
        }
        if shown.value - 2.0 * shown.std > LOADED * capacity {
            (self.was_loaded, self.turned, self.empty) = (true, false, false);
        } else {
            let dumped = core::mem::take(&mut self.was_loaded) && self.turned;
            let less = hangs && !self.empty && shown.value < -shown.std;
            if dumped || less {
                (self.empty, self.at_dump) = (true, true);
            }
        }
        let left = STAYS_STD * capacity;
        let is_known = shown.std < left && shown.value.abs() < EMPTIED * capacity;
        (self.empty && is_known).then_some(Tare {
            apart: shown.value - STAYS * capacity,
            variance: shown.std * shown.std + left * left,
            at_dump: self.at_dump,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAPACITY: f64 = 5000.0;
    const STILL: Motion = Motion {
        turning: false,
        changing: 0.0,
        lifting: false,
        settling: false,
        held: false,
        open: false,
    };
    const OPEN: Motion = Motion {
        turning: true,
        changing: 1.0,
        open: true,
        ..STILL
    };
    const LOW: Motion = Motion {
        lifting: true,
        ..STILL
    };
    const IN_THE_GROUND: Motion = Motion { held: true, ..OPEN };

    /// Measurement after these payloads [kg] in these motions.
    fn shown_after(rows: &[(f64, &Motion)]) -> Option<Tare> {
        let mut bucket = Emptied::default();
        let see = |&(value, motion): &(f64, &Motion)| {
            let shown = Quantity { value, std: 40.0 };
            bucket.see(shown, motion, motion != &LOW, CAPACITY)
        };
        rows.iter().map(see).last().flatten()
    }

    /// The same of a bucket that is opened with a load and shows `after`.
    fn dumped(before: f64, after: f64) -> Option<Tare> {
        shown_after(&[(before, &STILL), (before, &OPEN), (after, &STILL)])
    }

    #[test]
    fn only_a_bucket_that_was_loaded_and_opened_is_an_empty_one() {
        let tare = dumped(3000.0, 250.0).expect("it was dumped");
        assert!((tare.apart - 175.0).abs() < 1e-9);
        assert!((tare.variance - 40.0 * 40.0 - 150.0 * 150.0).abs() < 1e-9);
        assert_eq!(
            dumped(100.0, 250.0),
            None,
            "it may never have held anything"
        );
        assert_eq!(dumped(3000.0, 2500.0), None, "a part is left");
        assert_eq!(dumped(3000.0, 800.0), None, "too much for what sticks");
        let still = shown_after(&[(3000.0, &STILL), (250.0, &STILL)]);
        assert_eq!(still, None, "it did not turn");
    }

    #[test]
    fn a_fork_that_hangs_free_and_shows_less_than_zero_is_empty_and_corrects_loads() {
        let tare = shown_after(&[(1200.0, &STILL), (-100.0, &STILL)]).expect("it was put down");
        assert!((tare.apart + 175.0).abs() < 1e-9 && tare.at_dump);
        let rows: [&[(f64, &Motion)]; 4] = [
            &[(1200.0, &STILL), (-30.0, &STILL)],
            &[(1200.0, &STILL), (-100.0, &LOW)],
            &[(1200.0, &STILL), (-600.0, &STILL)],
            &[(-100.0, &STILL), (1200.0, &STILL)],
        ];
        for rows in rows {
            assert_eq!(shown_after(rows), None, "{rows:?}");
        }
    }

    #[test]
    fn an_emptied_bucket_stays_empty_until_it_turns_in_the_ground() {
        let after = |motion, shown| {
            shown_after(&[
                (3000.0, &STILL),
                (3000.0, &OPEN),
                (20.0, &STILL),
                (20.0, motion),
                (shown, &STILL),
            ])
        };
        assert!(after(&OPEN, 60.0).is_some());
        assert_eq!(after(&IN_THE_GROUND, 60.0), None);
        assert_eq!(after(&OPEN, 600.0), None, "somebody filled it");
    }
}

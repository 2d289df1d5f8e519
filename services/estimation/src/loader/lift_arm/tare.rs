//! An emptied bucket is a weight that is known: what it shows beyond what usually stays in it is an error of the drawing.
//!
//! Every weighing system on a machine has its zero set with an empty bucket. Here the machine does it at each dump: where a load has
//! left the bucket, what is weighed then is `left`, .015 +- .03 of the capacity, give or take the rows' own noise. A bucket that did not
//! turn was not emptied, whatever the pressures show; but a fork puts its load down without, and may be another tool than the one described.
//! A tool that hangs free and shows less than nothing is empty: with content the error of the drawing would have to be larger still.

use super::content::Motion;
use crate::Quantity;

/// From this share of the capacity on a bucket holds a load, and up to this share it may be an emptied one.
const LOADED: f64 = 0.2;
const EMPTIED: f64 = 0.1;
/// What stays in an emptied bucket, and its standard deviation, as shares of the capacity.
const STAYS: f64 = 0.015;
const STAYS_STD: f64 = 0.03;

/// What an emptied bucket shows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Tare {
    /// Beyond what usually stays in it [kg].
    pub apart: f64,
    /// Variance of that without the drawing's [kg^2].
    pub variance: f64,
    /// The bucket has not turned since: it tells of later loads, which are weighed as high.
    pub at_dump: bool,
}

/// Memory of the bucket.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Emptied {
    /// It held a load when it was last seen, and has turned since.
    was_loaded: bool,
    turned: bool,
    /// It has been emptied since, and the ground has not filled it.
    empty: bool,
    /// It has not turned since it was emptied.
    at_dump: bool,
}

impl Emptied {
    /// Takes what the rows show of the payload, and what arm and bucket do; what an emptied bucket tells. One that turns in the air
    /// stays empty: only the ground fills it.
    ///
    /// One that hangs free (`hangs`) and shows less than nothing is empty, however it was emptied.
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

    /// What the bucket tells after it has shown these payloads [kg] in these motions.
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
    fn a_fork_that_hangs_free_and_shows_less_than_nothing_is_empty_and_tells_of_loads() {
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

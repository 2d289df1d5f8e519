//! An emptied bucket is a weight that is known: what it shows beyond what usually stays in it is an error of the drawing.
//!
//! Every weighing system on a machine has its zero set with an empty bucket. Here the machine does it at each dump: where a load has
//! left the bucket, what is weighed then is `left`, .01 +- .02 of the capacity, give or take the rows' own noise.

use crate::Quantity;

/// From this share of the capacity on a bucket holds a load, and up to this share it may be an emptied one.
const LOADED: f64 = 0.2;
const EMPTIED: f64 = 0.1;
/// What stays in an emptied bucket, as a share of the capacity, and its standard deviation.
const LEFT: (f64, f64) = (0.01, 0.02);

/// What an emptied bucket shows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Tare {
    /// Beyond what usually stays in it [kg].
    pub apart: f64,
    /// Variance of that without the drawing's [kg^2].
    pub variance: f64,
}

/// Memory of the bucket.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Emptied {
    /// It held a load when it opened.
    was_loaded: bool,
    /// It has been emptied since.
    empty: bool,
}

impl Emptied {
    /// Takes what the rows show of the payload, and whether the content may be changing; what an emptied bucket tells.
    pub fn see(&mut self, shown: Quantity, open: bool, capacity: f64) -> Option<Tare> {
        if open {
            self.empty = false;
            return None;
        }
        if shown.value - 2.0 * shown.std > LOADED * capacity {
            (self.was_loaded, self.empty) = (true, false);
        } else if core::mem::take(&mut self.was_loaded) {
            self.empty = true;
        }
        let left = LEFT.1 * capacity;
        let is_known = shown.std < left && shown.value.abs() < EMPTIED * capacity;
        (self.empty && is_known).then_some(Tare {
            apart: shown.value - LEFT.0 * capacity,
            variance: shown.std * shown.std + left * left,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAPACITY: f64 = 5000.0;

    /// What the bucket tells after it held `before`, and was opened or not.
    fn told(before: f64, opened: bool, after: f64) -> Option<Tare> {
        let mut bucket = Emptied::default();
        let mut see = |value: f64, open: bool| {
            let shown = Quantity { value, std: 40.0 };
            bucket.see(shown, open, CAPACITY)
        };
        assert_eq!(see(before, false), None);
        if opened {
            assert_eq!(see(before, true), None);
        }
        see(after, false)
    }

    #[test]
    fn only_a_bucket_that_was_loaded_and_opened_is_an_empty_one() {
        let tare = told(3000.0, true, 250.0).expect("it was dumped");
        assert!((tare.apart - 200.0).abs() < 1e-9);
        assert!((tare.variance - 40.0 * 40.0 - 100.0 * 100.0).abs() < 1e-9);
        assert_eq!(
            told(100.0, true, 250.0),
            None,
            "it may never have held anything"
        );
        assert_eq!(told(3000.0, true, 2500.0), None, "a part is left");
        assert_eq!(told(3000.0, true, 800.0), None, "too much for what sticks");
    }

    #[test]
    fn a_small_load_after_an_emptied_bucket_is_no_empty_one() {
        let mut bucket = Emptied::default();
        let mut see = |value: f64, open: bool| {
            let shown = Quantity { value, std: 40.0 };
            bucket.see(shown, open, CAPACITY)
        };
        see(3000.0, false);
        see(3000.0, true);
        assert!(see(20.0, false).is_some());
        see(20.0, true);
        assert_eq!(see(400.0, false), None);
    }
}

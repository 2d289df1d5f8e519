//! Detects a torque at the end of its sensor's range, where it is only a bound and no measurement.
//!
//! A noisy signal never has exactly its largest value twice in a row, but a saturated one has. A coarse or held signal repeats its values
//! everywhere, so no range is detected. Zero does not count either, since a standing machine may show it exactly.

/// Number of repeats at one end after which it is the end of the range [rows].
const ENOUGH: u32 = 5;
/// Least width of the range, in standard deviations of the noise: the signal of a standing machine shows no range.
const WIDE: f64 = 20.0;

/// Range of one signal so far.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Range {
    last: f64,
    /// Least and largest value, and how often each was repeated.
    ends: [f64; 2],
    repeats: [u32; 2],
    /// Repeats of other values.
    elsewhere: u32,
}

impl Range {
    /// The value; missing at an end of the range. `std`: noise of the sensor.
    pub(in crate::excavator) fn pass(&mut self, value: Option<f64>, std: f64) -> Option<f64> {
        let value = value?;
        let [least, largest] = self.ends;
        let is_repeated = value == self.last && value != 0.0 && largest - least > WIDE * std;
        self.last = value;
        if least < value && value < largest {
            self.elsewhere = self.elsewhere.saturating_add(u32::from(is_repeated));
            return Some(value);
        }
        let at = usize::from(value >= largest);
        let (end, repeats) = (&mut self.ends[at], &mut self.repeats[at]);
        if value != *end {
            // The former extreme was no end of the range.
            *end = value;
            self.elsewhere = self.elsewhere.saturating_add(core::mem::take(repeats));
        }
        *repeats = repeats.saturating_add(u32::from(is_repeated));
        (*repeats < ENOUGH.max(self.elsewhere)).then_some(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 3000 torques of this shape, the number that is missing and the number at the ends.
    fn missing(shape: impl Fn(f64) -> f64, ends: [f64; 2]) -> [usize; 2] {
        let mut range = Range::default();
        let (mut missing, mut at_end) = (0, 0);
        for k in 0..3000 {
            let noise = 150.0 * f64::from(k * 7919 % 13 - 6) / 6.0;
            let (sin, _) = crate::math::sin_cos(0.02 * f64::from(k));
            let value = shape(5e4 * sin + noise);
            missing += usize::from(range.pass(Some(value), 150.0).is_none());
            at_end += usize::from(ends.contains(&value));
        }
        [missing, at_end]
    }

    #[test]
    fn a_torque_that_is_cut_off_is_missing_where_it_is() {
        for ends in [[-5e5, 3e4], [-3e4, 5e5], [-3e4, 3e4]] {
            let [missing, at_end] = missing(|x| x.clamp(ends[0], ends[1]), ends);
            let accepted = usize::try_from(2 * ENOUGH + 2).expect("few");
            assert!(
                missing + accepted >= at_end && missing <= at_end && at_end > 500,
                "{ends:?}"
            );
        }
    }

    #[test]
    fn coarse_held_and_resting_ones_are_not() {
        let coarse = |x: f64| (x / 4e3).round() * 4e3;
        let zero = |x: f64| x.max(0.0);
        let resting = |_| -113.0;
        for shape in [coarse, zero, resting, |x| x] {
            assert_eq!(missing(shape, [0.0; 2])[0], 0);
        }
        let mut range = Range::default();
        let held = (0..3000).filter(|k| {
            let value = 5e4 * crate::math::sin_cos(0.02 * f64::from(k / 5 * 5)).0;
            range.pass(Some(value), 150.0).is_none()
        });
        assert_eq!(held.count(), 0);
    }
}

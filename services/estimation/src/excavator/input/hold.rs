//! Detects a signal that is updated slowly and repeated between its updates.
//!
//! A bus sends a torque 20 times a second, and the logger writes it into every row of 100 Hz. Run lengths of equal values show it:
//! no value lasts for fewer rows than an update. A quantised signal repeats values where it is slow, but not where it is fast.

/// Longest run that is counted [rows].
const LONGEST: usize = 64;
/// Least number of runs for a result.
const ENOUGH: f64 = 20.0;
/// Weight of one run in the memory of runs: 200 of them.
const MEMORY: f64 = 0.005;
/// Share of the runs that may be shorter than the hold, since stamps jitter.
const SHORTER: f64 = 0.1;

/// Statistics of run lengths of one signal.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Hold {
    last: Option<f64>,
    run: usize,
    seen: f64,
    /// Shares of the run lengths so far, up to `longest`.
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    shares: [f64; LONGEST + 1],
    longest: usize,
    rows: usize,
}

impl Default for Hold {
    fn default() -> Self {
        Self {
            last: None,
            run: 0,
            seen: 0.0,
            shares: [0.0; LONGEST + 1],
            longest: 0,
            rows: 1,
        }
    }
}

impl Hold {
    /// Takes the value of a row. Returns whether it is an update: a new value, or an equal one when the next update is due.
    pub(in crate::excavator) fn push(&mut self, value: Option<f64>) -> bool {
        self.run += 1;
        let new = value.filter(|value| self.last != Some(*value));
        let Some(value) = new else {
            return value.is_some() && self.run.is_multiple_of(self.rows);
        };
        let began = self.last.replace(value).is_some();
        let run = core::mem::replace(&mut self.run, 0);
        if began && run <= LONGEST {
            self.seen += 1.0;
            let share = MEMORY.max(1.0 / self.seen);
            let this = self.shares[run] + share * (1.0 - self.shares[run]);
            self.longest = self.longest.max(run);
            self.shares[..=self.longest]
                .iter_mut()
                .for_each(|old| *old -= share * *old);
            self.shares[run] = this;
            self.rows = self.shortest();
        }
        true
    }

    /// The last value, unless it is older than two holds.
    fn value(&self) -> Option<f64> {
        self.last.filter(|_| self.run < 2 * self.rows)
    }

    /// Length of the hold [rows]; 1 where each row has its own value.
    pub(in crate::excavator) fn rows(&self) -> usize {
        self.rows
    }

    fn shortest(&self) -> usize {
        if self.seen < ENOUGH {
            return 1;
        }
        let mut sum = 0.0;
        let found = self.shares.iter().position(|share| {
            sum += share;
            sum > SHORTER
        });
        found.unwrap_or(1).max(1)
    }
}

/// Interpolates a held signal: the mean over the rows of a hold joins the values by straight lines. Its delay is one row less than the
/// hold.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Joined {
    hold: Hold,
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    ring: [f64; LONGEST],
    count: usize,
}

impl Default for Joined {
    fn default() -> Self {
        Self {
            hold: Hold::default(),
            ring: [0.0; LONGEST],
            count: 0,
        }
    }
}

impl Joined {
    /// The interpolated value of a row; missing where the signal is missing and not held.
    pub(in crate::excavator) fn pass(&mut self, value: Option<f64>) -> Option<f64> {
        self.hold.push(value);
        let rows = self.hold.rows();
        let held = if rows > 1 {
            value.or(self.hold.value())
        } else {
            value
        };
        if let Some(value) = held {
            self.ring[self.count % LONGEST] = value;
            self.count += 1;
        }
        if rows == 1 || self.count < rows {
            return held;
        }
        let last = (1..=rows).map(|back| self.ring[(self.count - back) % LONGEST]);
        held.map(|_| last.sum::<f64>() / rows as f64)
    }

    /// Length of the hold [rows].
    pub(in crate::excavator) fn rows(&self) -> usize {
        self.hold.rows()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(value: impl Fn(u32) -> Option<f64>) -> usize {
        let mut hold = Hold::default();
        (0..1000).for_each(|k| {
            hold.push(value(k));
        });
        hold.rows()
    }

    #[test]
    fn what_is_repeated_or_left_out_is_distinguished_from_what_is_slow_or_coarse() {
        let smooth = |k: u32| crate::math::sin_cos(0.01 * f64::from(k)).0;
        assert_eq!(rows(|k| Some(smooth(k))), 1);
        assert_eq!(rows(|k| Some(smooth(k / 5 * 5))), 5);
        assert_eq!(rows(|k| (k % 5 == 0).then(|| smooth(k))), 5);
        // Quantised to a hundredth, sent twenty times a second.
        let coarse = |k: u32| (100.0 * smooth(k)).round() / 100.0;
        assert_eq!(rows(|k| Some(coarse(k / 5 * 5))), 5);
        assert_eq!(rows(|k| Some(coarse(k))), 1);
        assert_eq!(rows(|_| Some(0.0)), 1);
    }

    #[test]
    fn held_values_are_joined_by_lines_that_are_late_by_the_hold() {
        let mut joined = Joined::default();
        for k in 0..1000_u32 {
            let value = joined.pass(Some(f64::from(k / 5 * 5)));
            let expected = f64::from(k) - 4.0;
            let wrong = value.map_or(f64::INFINITY, |value| (value - expected).abs());
            assert!(k < 120 || wrong < 1e-9, "{k}: {value:?}");
        }
    }
}

//! Times of measurement from time stamps that jitter.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | t_k | `stamp` | time stamp of row k [s] |
//! | x_k | `time` | when it was measured [s] |
//! | T | `period` | period of the rows [s] |
//! | r_k | - | (t_k - t_(k-1))/T minus the nearest whole number, which is at least 1: rows may be lost |
//! | c^2 | `wavering` | E r^2/2, jitter variance of a stamp in T^2 |
//!
//! A sensor measures at a steady period; bus and logger delay the stamp of a row. An estimator that uses such stamps as times of
//! measurement finds accelerations that do not exist. Where the jitter exceeds a share of the period, the time is therefore predicted and
//! corrected by a share of the stamp's innovation. This is the steady state of a Kalman filter over time and period, known as
//! alpha-beta filter (Kalata, "The tracking index", 1984):
//! ```text
//! e = t_k - x_(k-1) - T,  x_k = x_(k-1) + T + a e,  T <- T + b e,  b = a^2/(2 - a)
//! ```
//! Rows in bursts have the largest jitter: their stamps are off by up to the whole time between two bursts. There the gain of a stamp is
//! smaller, except for the first ones, and the period is the mean difference of stamps. Twenty equally spaced rows end this mode.
//!
//! Without such jitter the stamps are the times, bit by bit: lost rows or another rate cause no jitter.

use crate::math::round;

/// Jitter (standard deviation in periods) above which stamps are filtered; a steady bus has a tenth at most.
const WAVERS: f64 = 0.15;
/// Gains a and b: share of a stamp's innovation in the time, and in the period.
const TIME: f64 = 0.1;
const PERIOD: f64 = TIME * TIME / (2.0 - TIME);
/// Jitter variance c^2 above which rows count as bursts.
const BURSTS: f64 = 0.25;
/// Gain a in bursts.
const TIME_IN_BURSTS: f64 = 0.03;
/// Largest delay of a stamp in bursts, in periods; beyond it rows are missing or their rate has changed.
const LOST_IN_BURSTS: f64 = 40.0;
/// Least distance of two rows in bursts, in periods.
const LEAST: f64 = 0.1;
/// Number of consecutive rows with equal distances, within the share [`EQUAL`], after which rows count as steady.
const STEADY: u32 = 20;
const EQUAL: f64 = 0.1;
/// Weight of one difference in the jitter variance.
const MEMORY: f64 = 0.02;
/// Largest delay of a stamp, in periods; beyond it rows are missing or their rate has changed.
const LOST: f64 = 4.0;

/// Filter of time stamps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Cadence {
    stamp: f64,
    time: f64,
    period: f64,
    wavering: f64,
    /// Number of differences in the mean period, at most 1/b.
    seen: f64,
    /// Number of rows corrected since bursts began.
    predicted: f64,
    /// Previous difference [s], number of consecutive differences equal to it, and their sum [s].
    difference: f64,
    steady: u32,
    sum: f64,
}

impl Cadence {
    /// Time of measurement of the previous row [s].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Starts or restarts at a row with this stamp [s].
    pub fn starting(stamp: f64) -> Self {
        Self {
            stamp,
            time: stamp,
            ..Self::default()
        }
    }

    /// Time of measurement of the next row [s]; its stamp must be later than the previous one.
    pub fn next(&mut self, stamp: f64) -> f64 {
        let difference = stamp - core::mem::replace(&mut self.stamp, stamp);
        self.seen = (self.seen + 1.0).min(1.0 / PERIOD);
        self.notice(difference);
        let expected = self.time + self.period;
        let late = stamp - expected;
        let bursts = self.wavering > BURSTS;
        let lost = if bursts { LOST_IN_BURSTS } else { LOST };
        if !self.wavers() || late.abs() > lost * self.period {
            // After jittering stamps the estimated time may be ahead of this one.
            let later = stamp > self.time;
            self.time = if later {
                stamp
            } else {
                self.time + TIME * self.period
            };
            self.period += (difference - self.period) / self.seen;
            self.predicted = 0.0;
        } else if bursts {
            self.predicted += 1.0;
            let share = TIME_IN_BURSTS.max(1.0 / self.predicted);
            let least = self.time + LEAST * self.period;
            self.time = (expected + share * late).max(least);
            self.period += (difference - self.period) / self.seen;
        } else {
            self.time = expected + TIME * late;
            self.period += PERIOD * late;
        }
        let rows = difference / self.period;
        let rest = rows - round(rows).max(1.0);
        self.wavering += MEMORY * (0.5 * rest * rest - self.wavering);
        self.time
    }

    /// Ends the filtering after [`STEADY`] equal differences, at any rate.
    fn notice(&mut self, difference: f64) {
        let before = core::mem::replace(&mut self.difference, difference);
        if (difference - before).abs() > EQUAL * before {
            (self.steady, self.sum) = (0, 0.0);
        }
        self.steady += 1;
        self.sum += difference;
        if self.steady >= STEADY {
            if self.wavers() {
                self.wavering = 0.0;
                self.period = self.sum / f64::from(self.steady);
                self.seen = f64::from(self.steady);
            }
            (self.steady, self.sum) = (0, 0.0);
        }
    }

    /// Estimated period of the rows [s].
    pub fn period(&self) -> f64 {
        self.period
    }

    fn wavers(&self) -> bool {
        self.wavering > WAVERS * WAVERS
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    /// Standard normal numbers (sum of twelve uniform ones).
    fn normal() -> impl FnMut() -> f64 {
        let mut state = 12345u64;
        let mut uniform = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }

    fn times(stamps: &[f64]) -> Vec<f64> {
        let mut cadence = Cadence::starting(stamps[0]);
        let later = stamps[1..].iter().map(|stamp| cadence.next(*stamp));
        std::iter::once(stamps[0]).chain(later).collect()
    }

    #[test]
    fn steady_stamps_are_the_times_whatever_rows_are_lost_and_at_any_rate() {
        let mut normal = normal();
        let mut stamps = std::vec![0.0];
        for (rows, period) in [(3000, 0.01), (1000, 0.02), (500, 0.05), (4000, 0.001)] {
            for k in 0..rows {
                let lost = if k % 17 == 0 { 2.0 } else { 1.0 };
                let last = stamps[stamps.len() - 1];
                stamps.push(last + lost * period * (1.0 + 0.03 * normal()));
            }
            assert_eq!(times(&stamps), stamps, "{period}");
            stamps.truncate(1);
        }
    }

    #[test]
    fn stamps_that_jitter_by_a_period_give_times_to_a_quarter_of_it() {
        let mut normal = normal();
        let mut stamps = std::vec![0.0];
        for k in 1..6000 {
            let last: f64 = stamps[k - 1];
            stamps.push((k as f64 * 0.01 + 0.01 * normal()).max(last + 1e-4));
        }
        let times = times(&stamps);
        assert!(times.windows(2).all(|pair| pair[1] > pair[0]));
        let error = |k: usize| times[k] - k as f64 * 0.01;
        let rows = 1000..6000;
        let mean = rows.clone().map(error).sum::<f64>() / 5000.0;
        let square = rows.map(|k| (error(k) - mean) * (error(k) - mean));
        let rms = (square.sum::<f64>() / 5000.0).sqrt();
        // Variance of the times over that of the stamps: (2 a^2 + 2 b - 3 a b)/(a (4 - b - 2 a)) = 0.076.
        assert!(rms < 0.0035 && mean.abs() < 0.004, "{rms} {mean}");
    }

    #[test]
    fn rows_that_come_in_bursts_are_spread_over_the_time_between() {
        let stamps: Vec<f64> = (0..3000)
            .map(|k| f64::from(k / 5) * 0.05 + f64::from(k % 5) * 1e-4)
            .collect();
        let times = times(&stamps);
        let periods = times.windows(2).skip(1000).map(|pair| pair[1] - pair[0]);
        let (least, most) = periods.fold((1.0, 0.0), |(l, m), p| (f64::min(l, p), f64::max(m, p)));
        assert!(least > 0.005 && most < 0.015, "{least} {most}");
    }

    #[test]
    fn bursts_of_a_tenth_of_a_second_are_spread_too_and_a_steady_rate_is_found_in_twenty_rows() {
        for rows in [3, 6, 9, 12] {
            let at =
                |k: i32| f64::from(k / rows) * 0.01 * f64::from(rows) + f64::from(k % rows) * 1e-4;
            let mut stamps: Vec<f64> = (0..4000).map(at).collect();
            let last = stamps[stamps.len() - 1];
            stamps.extend((1..200).map(|k| last + 0.1 + 0.02 * f64::from(k)));
            let times = times(&stamps);
            let periods = times[..4000]
                .windows(2)
                .skip(1000)
                .map(|pair| pair[1] - pair[0]);
            let (least, most) =
                periods.fold((1.0, 0.0), |(l, m), p| (f64::min(l, p), f64::max(m, p)));
            assert!(least > 0.005 && most < 0.015, "{rows}: {least} {most}");
            assert!(times.windows(2).all(|pair| pair[1] > pair[0]), "{rows}");
            assert_eq!(times[4030..], stamps[4030..], "{rows}");
        }
    }

    #[test]
    fn another_rate_is_followed_and_time_goes_on() {
        let mut normal = normal();
        let mut stamps = std::vec![0.0f64];
        for k in 1..4000 {
            let period = if k < 2000 { 0.01 } else { 0.02 };
            let last = stamps[k - 1];
            let clock = if k < 2000 {
                k as f64 * 0.01
            } else {
                20.0 + (k - 2000) as f64 * 0.02
            };
            stamps.push((clock + 0.4 * period * normal()).max(last + 1e-4));
        }
        let times = times(&stamps);
        assert!(times.windows(2).all(|pair| pair[1] > pair[0]));
        let away = times.iter().zip(&stamps).map(|(x, t)| (x - t).abs());
        assert!(away.fold(0.0, f64::max) < 0.081);
    }
}

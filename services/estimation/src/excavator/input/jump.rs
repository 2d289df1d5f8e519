//! Detects a joint angle that jumps further than a joint can move.
//!
//! The rate of a joint is limited. A larger step between two values that does not step back is a fault of the sensor: a slipped or
//! exchanged encoder, another zero, unit, sign or range. The true angle is then unknown. If the sensor only repeats one value, and then
//! steps back to where the joint may have moved, it was a bus that dropped out.
//!
//! A sensor whose values were late for a while steps twice, by the motion in that time, and is right afterwards. So an angle that stays
//! displaced for long may be admitted again, if another measurement can test it ([`Jump::admit`]).

use crate::excavator::joints::turned;
use crate::math::sqrt;

/// Largest rate of a joint [rad/s].
const RATE: f64 = 4.0;
/// Step of a coarse sensor [rad].
const COARSE: f64 = 0.03;
/// Largest step that counts as noise, in standard deviations of the sensor's noise.
const NOISE: f64 = 9.0;
/// Weight of one value in the mean square of the noise.
const MEMORY: f64 = 0.02;
/// While a value is repeated, the joint may move on at its last rate, for at most `HELD` [s]. Or it may set off, for at most `SET_OFF`
/// [s] with `ACCELERATION` [rad/s^2].
const HELD: f64 = 2.0;
const SET_OFF: f64 = 0.25;
const ACCELERATION: f64 = 3.0;
/// Time without a repetition longer than [`SET_OFF`] after which the sensor is known to flicker, also while its joint stands [s]. If
/// such a sensor repeats a value, it is not measured, and the joint may have moved.
const FLICKERS: f64 = 10.0;

/// Growth of the shortest repetition from one value to the next: a signal may be sent less often from now on.
const LONGER: f64 = 1.02;

/// Time without a step after which a displaced angle stays as it is [s].
const STAYS: f64 = 60.0;

/// Detector of one angle.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Jump {
    last: Option<f64>,
    /// Last change [rad], and its rate [rad/s]; no rate at first.
    step: f64,
    rate: Option<f64>,
    /// Time since the last value, and duration of its repetition until then [s].
    gap: f64,
    held: f64,
    /// Time since the last long repetition [s].
    flickers: f64,
    /// Shortest time from one value to the next of late [s]. Of a signal that is sent less often than rows are written, it is the time
    /// between two messages, in which nothing is measured.
    renews: f64,
    /// Mean square of the second differences, six times the variance of the noise [rad^2].
    rough: f64,
    /// Sum of the impossible steps [rad]; while it is not 0, values do not count.
    displaced: f64,
    jumped: bool,
    /// Last angle before the displacement [rad], time since the last impossible step [s], and whether it has had a single value since.
    before: f64,
    away: f64,
    single: bool,
}

impl Jump {
    /// The value; missing while the sensor is displaced.
    pub(in crate::excavator) fn pass(&mut self, value: Option<f64>, period: f64) -> Option<f64> {
        self.gap += period;
        self.flickers += period;
        let value = value?;
        let step = turned(value - self.last.replace(value).unwrap_or(value));
        if step == 0.0 {
            self.held += self.gap;
        } else {
            self.change(value, step);
            self.held = 0.0;
        }
        let gap = core::mem::take(&mut self.gap);
        if self.has_jumped() {
            self.away += gap;
            return None;
        }
        (self.before, self.away, self.single) = (value, 0.0, true);
        Some(value)
    }

    fn change(&mut self, value: f64, step: f64) {
        let held = self.held;
        let (unmeasured, moves_on, off) = if held > SET_OFF {
            (self.unmeasured(), held.min(HELD), SET_OFF)
        } else {
            (0.0, held, held)
        };
        let noise = COARSE + NOISE * sqrt(self.rough / 6.0);
        let unmeasured = if self.rate.is_none() {
            // The first value may have come before the first row.
            self.renews = HELD;
            unmeasured
        } else if held == 0.0 {
            self.renews = self.gap;
            0.0
        } else {
            self.renews = (held + self.gap).min(LONGER * self.renews);
            unmeasured.max(held.min(self.renews - self.gap))
        };
        let possible = RATE * (self.gap + unmeasured)
            + noise
            + 2.0 * self.rate.unwrap_or(RATE).min(RATE) * moves_on
            + 0.5 * ACCELERATION * off * off;
        // No motion leads away from a value that leapt here and was not measured, however long it lasted.
        let leaps_back = unmeasured > 0.0 || step.abs() > RATE * self.gap + noise;
        if self.has_jumped() && self.single && leaps_back {
            let within = RATE * (self.away + self.gap) + COARSE;
            if turned(value - self.before).abs() <= within {
                (self.displaced, self.jumped) = (0.0, false);
                return;
            }
        }
        if step.abs() <= possible {
            let bend = step - self.step;
            self.rough += MEMORY * (bend * bend - self.rough);
            self.step = step;
            self.rate = Some(step.abs() / (self.held + self.gap));
            self.single = false;
            return;
        }
        self.single = !self.has_jumped();
        self.away = 0.0;
        self.displaced = turned(self.displaced + step);
        if self.displaced.abs() <= possible {
            self.displaced = 0.0;
        }
        self.jumped = self.displaced != 0.0;
    }

    /// Duration of a long repetition in which a flickering sensor was not measured [s]; 0 for another sensor.
    fn unmeasured(&mut self) -> f64 {
        let before = core::mem::take(&mut self.flickers) - self.held;
        if before > FLICKERS { self.held } else { 0.0 }
    }

    /// Whether the sensor is displaced and its values do not count.
    pub(in crate::excavator) fn has_jumped(&self) -> bool {
        self.jumped
    }

    /// Whether it is, and has measured for long without a step. A single value that is repeated is no measurement.
    pub(in crate::excavator) fn stays(&self) -> bool {
        self.has_jumped() && !self.single && self.away > STAYS
    }

    /// Displacement \[rad\].
    pub(in crate::excavator) fn by(&self) -> f64 {
        self.displaced
    }

    /// Lets the displaced angle count, until the next impossible step.
    pub(in crate::excavator) fn admit(&mut self) {
        self.jumped = false;
    }

    /// Revokes [`Self::admit`].
    pub(in crate::excavator) fn refuse(&mut self) {
        self.jumped = self.displaced != 0.0;
    }

    /// Confirms an admitted angle: the displacement returns to 0.
    pub(in crate::excavator) fn believe(&mut self) {
        if !self.jumped {
            self.displaced = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{PI, TAU};

    use super::*;
    use crate::math::sin_cos;

    /// Number of valid values, and whether the angle has jumped: a joint at 100 Hz that moves by `rate`, its values changed by `wrong`.
    fn passed(rate: f64, wrong: impl Fn(u32, f64) -> Option<f64>) -> (usize, bool) {
        let mut jump = Jump::default();
        let values = (0..400).map(|k| wrong(k, rate * 0.01 * f64::from(k)));
        let passed = values.filter_map(|v| jump.pass(v, 0.01)).count();
        (passed, jump.has_jumped())
    }

    #[test]
    fn a_step_that_stays_is_a_fault_and_one_that_comes_back_is_not() {
        for rate in [-1.0, 0.0, 0.3, 2.0] {
            let sound = passed(rate, |_, angle| Some(angle));
            assert_eq!(sound, (400, false), "{rate}");
            let held = passed(rate, |k, angle| {
                Some(if (100..150).contains(&k) { rate } else { angle })
            });
            assert_eq!(held, (400, false), "{rate}: held and free again");
        }
        for rate in [-1.0, 0.3, 2.0] {
            let stays = passed(rate, |k, angle| {
                Some(angle + if k < 200 { 0.0 } else { 0.15 })
            });
            assert_eq!(stays, (200, true), "{rate}");
            let back = passed(rate, |k, angle| {
                Some(angle + if (200..230).contains(&k) { 0.15 } else { 0.0 })
            });
            assert_eq!(back, (370, false), "{rate}");
            let word = passed(rate, |k, angle| {
                Some(if (200..230).contains(&k) { -2.7 } else { angle })
            });
            assert_eq!(word, (370, false), "{rate}: a bus that drops out");
            let spikes = passed(rate, |k, angle| {
                Some(angle + if k % 20 == 19 { 0.5 } else { 0.0 })
            });
            assert_eq!(spikes, (380, true), "{rate}: the last one is a spike");
        }
    }

    #[test]
    fn one_that_came_late_for_a_while_may_be_admitted_once_it_stays() {
        let mut jump = Jump::default();
        // Delayed by .2 s from 20 to 40 s.
        for k in 0..9_000_u32 {
            let late = if (2_000..4_000).contains(&k) { 20 } else { 0 };
            let value = sin_cos(0.01 * f64::from(k - k.min(late))).0;
            let passes = jump.pass(Some(value), 0.01).is_some();
            assert_eq!(passes, k < 2_000, "{k}");
            assert!(!jump.stays(), "{k}");
        }
        for k in 9_000..10_100_u32 {
            jump.pass(Some(sin_cos(0.01 * f64::from(k)).0), 0.01);
        }
        assert!(jump.stays());
        jump.admit();
        jump.refuse();
        assert!(jump.pass(Some(sin_cos(101.0).0), 0.01).is_none());
        jump.admit();
        assert!(jump.pass(Some(sin_cos(101.0).0), 0.01).is_some());
        jump.believe();
        jump.refuse();
        assert!(jump.pass(Some(sin_cos(101.0).0), 0.01).is_some());
        assert!(jump.pass(Some(1.3), 0.01).is_none(), "a step");
    }

    #[test]
    fn a_sensor_that_flickers_was_not_measured_while_it_repeats_a_value() {
        // A joint that stands for 15 s, and moves by .4 rad within half a second in which the bus repeats its last value.
        let jumped = |noise: f64| {
            let mut jump = Jump::default();
            for k in 0..2000_i32 {
                let moves = 0.0005 * f64::from(k.min(300));
                let flicker = noise * f64::from(k.min(1800) * 7919 % 13 % 3);
                let away = if k > 1850 { 0.4 } else { 0.0 };
                jump.pass(Some(moves + flicker + away), 0.01);
            }
            jump.has_jumped()
        };
        assert!(!jumped(0.001));
        // A sensor without noise was measured: it slipped.
        assert!(jumped(0.0));
    }

    #[test]
    fn of_a_signal_that_is_sent_less_often_than_rows_nothing_is_measured_between_two_messages() {
        // A bucket that sets off to 2 rad/s within .1 s each two seconds, with or without noise, each of its values in some rows; while
        // it moves at 30.3 s it comes to be `away` beside it.
        let jumped = |rows: u32, noise: f64, away: f64| {
            let mut jump = Jump::default();
            let mut angle = 0.0;
            for k in 0..4000_u32 {
                let phase = k % 200;
                let direction = if k % 400 < 200 { 1.0 } else { -1.0 };
                let rate = if phase < 60 {
                    0.2 * f64::from(phase.min(10))
                } else {
                    0.0
                };
                angle += 0.01 * direction * rate;
                if k % rows == 0 {
                    let noise = noise * f64::from(k * 7919 % 13);
                    jump.pass(
                        Some(angle + noise + if k < 3030 { 0.0 } else { away }),
                        0.01,
                    );
                } else if let Some(last) = jump.last {
                    jump.pass(Some(last), 0.01);
                }
            }
            jump.has_jumped()
        };
        for rows in [5, 8, 10, 14] {
            for noise in [0.0, 1e-4] {
                assert!(!jumped(rows, noise, 0.0), "{rows} {noise}");
                assert!(jumped(rows, noise, 2.0), "{rows} {noise}");
            }
        }
    }

    #[test]
    fn a_word_that_a_leap_leads_to_and_a_leap_leaves_is_no_measurement_however_long() {
        // A joint with noise that leaps to `word` at 20 s, for `rows`; it ends at `end`, and then continues `displaced`.
        let seen = |word: f64, rows: u32, end: f64, displaced: f64| {
            let mut jump = Jump::default();
            let from = 2000;
            let mut stayed = false;
            let missing = (0..from + rows + 7000).filter(|&k| {
                let noise = 0.001 * f64::from(k * 7919 % 13) / 6.0;
                let moved = f64::from(k.saturating_sub(from).min(rows)) / f64::from(rows);
                let angle = 0.6 + (end - 0.6) * moved + noise;
                let value = match k {
                    _ if k < from => angle,
                    _ if k < from + rows => word,
                    _ => angle + displaced,
                };
                let missing = jump.pass(Some(value), 0.01).is_none();
                stayed |= jump.stays();
                missing
            });
            let missing = missing.count();
            (missing, jump.has_jumped(), stayed)
        };
        for word in [0.0, 1.3, -2.7] {
            for rows in [5_u32, 30, 100, 7500] {
                for end in [0.6, 0.5] {
                    let found = seen(word, rows, end, 0.0);
                    let expected = (rows as usize, false, false);
                    assert_eq!(found, expected, "{word} for {rows} rows, to {end}");
                }
            }
            // The joint comes to the word, while the sensor is off.
            let (missing, jumped, _) = seen(word, 100, word + 0.02, 0.0);
            assert!((100..103).contains(&missing) && !jumped, "{word} {missing}");
            // Back within .05 s, but .4 rad away: it slipped.
            assert_eq!(seen(word, 5, 0.6, 0.4), (7005, true, true), "{word}");
        }
    }

    #[test]
    fn noise_a_coarse_sensor_a_turn_and_a_gap_are_no_jumps() {
        let noise = |k: u32| 0.01 * f64::from(k * 7919 % 13) / 6.0 - 0.01;
        for (what, (count, jumped)) in [
            ("noise", passed(1.0, |k, a| Some(a + noise(k)))),
            (
                "coarse",
                passed(1.0, |_, a| Some((a / 0.02).round() * 0.02)),
            ),
            (
                "turn",
                passed(1.0, |_, a| Some((a + 2.0 + PI).rem_euclid(TAU) - PI)),
            ),
            ("rare", passed(1.0, |k, _| Some(f64::from(k / 10) * 0.1))),
        ] {
            assert!(count == 400 && !jumped, "{what}");
        }
        let gap = passed(1.0, |k, a| (!(150..300).contains(&k)).then_some(a));
        assert_eq!(gap, (250, false));
    }
}

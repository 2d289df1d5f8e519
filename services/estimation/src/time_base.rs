//! Accepts or refuses rows by their time, and detects wrong clocks.
//!
//! Rows must increase in time. Two faults would cost all rows that follow, and are detected:
//! - one stamp far ahead: when the next row continues where the rows before it ended, only that stamp was wrong;
//! - a clock that was set back: when refused rows have increased among themselves for a while, their time is accepted. After a small
//!   step back, as of a clock that follows another, the rows continue. After a larger one they may be of another day, and the estimator
//!   restarts.
//!
//! Stamps that jitter about a steady period are filtered ([`crate::cadence`]).

use crate::cadence::Cadence;

/// Duration for which refused rows must increase among themselves before their time is accepted [s].
const CONVINCING: f64 = 1.0;
/// Largest step back after which rows continue [s], and the duration above for it [s].
const LITTLE: f64 = 10.0;
const CONVINCING_A_LITTLE: f64 = 0.2;

/// Longest reported gap [s], 30 years: every estimate is forgotten by then, and no power of it overflows.
pub(crate) const LONGEST: f64 = 1e9;

/// Meaning of a row's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Tick {
    /// The first row with a time.
    First,
    /// Time since the previous row was measured [s], at most [`LONGEST`].
    Later(f64),
    /// Not later than the previous row, or not finite.
    Refused,
    /// Not later than the previous row, because the clock was set back.
    SetBack,
}

/// Time of the last accepted row, and the state of the fault detection.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct TimeBase {
    last: Option<f64>,
    cadence: Cadence,
    /// The time before the last row, if that row jumped.
    before_jump: Option<f64>,
    /// Time of the last refused row, and the duration for which refused rows have increased among themselves [s].
    refused: Option<(f64, f64)>,
    /// Total by which the clock has been set back while the rows continued [s].
    back: f64,
}

impl TimeBase {
    /// Time stamp of the last accepted row [s].
    pub fn last(&self) -> Option<f64> {
        self.last
    }

    /// Time of measurement of the last accepted row [s].
    pub fn time(&self) -> f64 {
        self.cadence.time() + self.back
    }

    /// Whether [`Self::tick`] would refuse this time.
    pub fn refuses(&self, time: f64, gap: f64) -> bool {
        let is_later = |last: f64| time > last && (time - last).is_finite();
        if time.is_finite() && self.last.is_none_or(is_later) {
            return false;
        }
        // Rare, so a copy is stepped.
        let mut clock = *self;
        clock.tick(time, gap) == Tick::Refused
    }

    /// Takes the time of a row; a step longer than `gap` is a jump.
    pub fn tick(&mut self, time: f64, gap: f64) -> Tick {
        if !time.is_finite() {
            return Tick::Refused;
        }
        let Some(last) = self.last else {
            *self = Self::beginning(time);
            return Tick::First;
        };
        // The difference of two finite times may be infinite.
        let continues = |from: f64| time > from && time - from <= gap;
        if time > last && (time - last).is_finite() {
            if time - last > gap {
                *self = Self {
                    before_jump: Some(last),
                    back: self.back,
                    ..Self::beginning(time)
                };
                return Tick::Later((time - last).min(LONGEST));
            }
            let before = self.cadence.time();
            self.last = Some(time);
            (self.before_jump, self.refused) = (None, None);
            return Tick::Later(self.cadence.next(time) - before);
        }
        if let Some(before) = self.before_jump.filter(|t| time < last && continues(*t)) {
            let back = self.back;
            *self = Self::beginning(time);
            self.back = back;
            return Tick::Later(time - before);
        }
        let agreed = match self.refused {
            Some((from, agreed)) if continues(from) => agreed + (time - from),
            _ => 0.0,
        };
        let little = last - time < LITTLE;
        let enough = if little {
            CONVINCING_A_LITTLE
        } else {
            CONVINCING
        };
        if agreed < enough {
            self.refused = Some((time, agreed));
            return Tick::Refused;
        }
        if little {
            return self.go_on(time, agreed);
        }
        *self = Self::beginning(time);
        Tick::SetBack
    }

    /// Continues after the clock was set back; rows have been refused for `refused` since then [s].
    fn go_on(&mut self, time: f64, refused: f64) -> Tick {
        let period = refused + self.cadence.period();
        let measured = self.time() + period;
        *self = Self {
            back: measured - time,
            ..Self::beginning(time)
        };
        Tick::Later(period)
    }

    fn beginning(time: f64) -> Self {
        Self {
            last: Some(time),
            cadence: Cadence::starting(time),
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAP: f64 = 0.25;

    fn ticking(until: u32) -> TimeBase {
        let mut base = TimeBase::default();
        for k in 0..until {
            assert_ne!(base.tick(f64::from(k) * 0.01, GAP), Tick::Refused);
        }
        base
    }

    #[test]
    fn what_would_be_refused_is_known_beforehand() {
        let mut base = TimeBase::default();
        let wrong = [f64::NAN, f64::INFINITY, -1e308, 0.0, 5.0, 1e6];
        for k in 0..400_u32 {
            let time = match k % 7 {
                3 => wrong[(k / 7 % 6) as usize],
                // A clock that is set back permanently.
                _ if k > 200 => f64::from(k) * 0.01 - 50.0,
                _ => f64::from(k) * 0.01,
            };
            let asked = base.refuses(time, GAP);
            assert_eq!(asked, base.tick(time, GAP) == Tick::Refused, "{k}: {time}");
        }
    }

    #[test]
    fn one_stamp_far_ahead_costs_no_row_after_it() {
        for ahead in [10.0, 1e9, f64::MAX] {
            let mut base = ticking(100);
            assert!(matches!(base.tick(ahead, GAP), Tick::Later(dt) if dt <= LONGEST));
            assert!(matches!(base.tick(1.0, GAP), Tick::Later(dt) if (dt - 0.01).abs() < 1e-9));
            assert!(matches!(base.tick(1.01, GAP), Tick::Later(dt) if (dt - 0.01).abs() < 1e-9));
        }
    }

    #[test]
    fn a_gap_is_accepted_once_a_row_confirms_it() {
        let mut base = ticking(100);
        assert!(matches!(base.tick(3.0, GAP), Tick::Later(_)));
        assert_eq!(base.tick(3.0, GAP), Tick::Refused);
        assert!(matches!(base.tick(3.01, GAP), Tick::Later(_)));
        assert_eq!(base.tick(1.0, GAP), Tick::Refused);
    }

    #[test]
    fn rows_go_on_when_the_clock_is_set_back_by_a_little() {
        for back in [0.3, 1.0, 3.0, 9.0] {
            let mut base = ticking(1000);
            let mut before = base.time();
            let mut refused = 0;
            for k in 0..200 {
                let tick = base.tick(10.0 - back + f64::from(k) * 0.01, GAP);
                if tick == Tick::Refused {
                    refused += 1;
                    continue;
                }
                let Tick::Later(period) = tick else {
                    panic!("{tick:?}")
                };
                assert!((base.time() - before - period).abs() < 1e-9);
                before = base.time();
                assert!(
                    (before - 9.99 - 0.01 * f64::from(k + 1)).abs() < 1e-6,
                    "{back} {k} {before}"
                );
            }
            assert!((20..=22).contains(&refused), "{refused}");
        }
    }

    #[test]
    fn a_clock_set_back_is_accepted_after_a_second() {
        let mut base = ticking(2000);
        let ticks: [Tick; 150] = core::array::from_fn(|k| base.tick(2.0 + k as f64 * 0.01, GAP));
        let at = ticks.iter().position(|t| *t == Tick::SetBack);
        // 100 steps of 0.01 s, one more where they round down.
        assert!(matches!(at, Some(100 | 101)), "{at:?}");
        assert!(ticks[..100].iter().all(|t| *t == Tick::Refused));
        assert!(ticks[102..].iter().all(|t| matches!(t, Tick::Later(_))));
    }

    #[test]
    fn late_rows_between_good_ones_never_set_the_clock_back() {
        let mut base = ticking(1000);
        for k in 0..500 {
            let now = 10.0 + f64::from(k) * 0.01;
            assert!(matches!(base.tick(now, GAP), Tick::Later(_)));
            assert_eq!(base.tick(now - 5.0, GAP), Tick::Refused);
        }
    }
}

//! Payload from a measured machine mass: its difference to the empty machine.
//!
//! The empty mass is the least mass that has held constant. It counts where it is near the described one or a load has left the machine
//! with it; an offset of the scale then cancels. A mass that does not hold is a bucket that fills or empties, and no load.

use estimation::math::norm;
use estimation::{CommonError, Quantity};

/// Assumed standard deviation of such a scale: half a percent of the machine, two percent of the load.
const SCALE_STD: [f64; 2] = [0.005, 0.02];
/// Time constant of the smoothing of the mass [s].
const SMOOTH: f64 = 0.2;
/// Share of the mass within which it counts as constant.
const SAME: f64 = 0.01;
/// Duration of a constant mass after which it weighs a load, and an empty machine [s].
const HOLDS: f64 = 0.3;
const EMPTY_HOLDS: f64 = 1.0;
/// Duration for which a mass counts where rows come more often than masses: a display renews each second [s].
const RENEWS: f64 = 2.0;
/// Share of the described mass by which a plausible mass may be below it.
const BELOW: f64 = 0.2;
/// Share of the described mass by which the empty machine may be above it; a load is more.
const EMPTY: f64 = 0.05;

/// State of a scale under the machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    /// Described mass of the empty machine [kg].
    described: f64,
    /// Least mass that has held [kg].
    least: Option<f64>,
    /// Whether a load was on it; whether that has left.
    was_loaded: bool,
    was_emptied: bool,
    /// Smoothed mass [kg], and its time [s].
    smooth: Option<(f64, f64)>,
    /// Constant mass [kg], and since when [s].
    anchor: (f64, f64),
    /// Its last result.
    shown: Option<Shown>,
}

/// Result of the scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shown {
    pub payload: Quantity,
    /// Errors that are common to all loads.
    pub common: CommonError,
    /// Whether the mass does not hold: the bucket fills or empties.
    pub changing: bool,
}

impl Scale {
    pub(super) fn new(described: f64) -> Self {
        Self {
            described,
            least: None,
            was_loaded: false,
            was_emptied: false,
            smooth: None,
            anchor: (0.0, 0.0),
            shown: None,
        }
    }

    /// Result at this time, where a mass comes with the row or came shortly before.
    pub(super) fn step(&mut self, mass: Option<f64>, time: f64) -> Option<Shown> {
        if let Some(mass) = mass {
            self.shown = self.weigh(mass, time);
        }
        let (_, last) = self.smooth?;
        self.shown
            .filter(|_| (0.0..RENEWS).contains(&(time - last)))
    }

    /// Result of this mass.
    fn weigh(&mut self, mass: f64, time: f64) -> Option<Shown> {
        if !(mass.is_finite() && mass > (1.0 - BELOW) * self.described) {
            return None;
        }
        // Restart after a clock that was set back.
        let before = self.smooth.filter(|(_, last)| *last <= time);
        if before.is_none() {
            self.anchor = (mass, time);
        }
        let (smooth, last) = before.unwrap_or((mass, time));
        let smooth = smooth + ((time - last) / SMOOTH).clamp(0.0, 1.0) * (mass - smooth);
        self.smooth = Some((smooth, time));
        if (smooth - self.anchor.0).abs() > SAME * smooth {
            self.anchor = (smooth, time);
        }
        let (held, since) = self.anchor;
        if time - since >= EMPTY_HOLDS {
            self.see_held(held);
        }
        // Until then the machine may have started loaded.
        let is_known = |least: &f64| self.was_emptied || *least < (1.0 + EMPTY) * self.described;
        let learnt = self.least.filter(is_known);
        let empty = learnt.unwrap_or(self.described);
        let zero = if learnt.is_some() {
            0.0
        } else {
            EMPTY * self.described
        };
        // From the constant mass, so that all of its rows have equal variances.
        let common = CommonError {
            scale_std: SCALE_STD[1],
            zero_std: zero,
        };
        Some(Shown {
            payload: Quantity {
                value: mass - empty,
                std: norm(&[SCALE_STD[0] * held, common.std(held - empty)]),
            },
            common,
            changing: time - since < HOLDS,
        })
    }

    /// Takes a mass that has held.
    fn see_held(&mut self, mass: f64) {
        let least = self.least.map_or(mass, |least| least.min(mass));
        self.least = Some(least);
        self.was_loaded |= mass > (1.0 + EMPTY) * least;
        self.was_emptied |= self.was_loaded && mass < (1.0 + SAME) * least;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Passes masses at 100 Hz through a scale; the last result of each row, [from, to) in seconds.
    fn shown(described: f64, parts: &[(f64, f64)]) -> Vec<Shown> {
        let mut scale = Scale::new(described);
        let (mut time, mut mass) = (0.0, parts[0].1);
        let mut results = Vec::new();
        for (seconds, to) in parts {
            let rows = (100.0 * seconds) as u32;
            let by = (to - mass) / f64::from(rows.max(1));
            for _ in 0..rows {
                mass += by;
                time += 0.01;
                results.push(
                    scale
                        .step(Some(mass), time)
                        .expect("a mass of this machine"),
                );
            }
        }
        results
    }

    #[test]
    fn a_bucket_that_fills_is_changing_and_a_full_one_is_not() {
        let results = shown(
            12_000.0,
            &[(5.0, 12_100.0), (2.5, 15_700.0), (3.0, 15_700.0)],
        );
        assert!(results[550..740].iter().all(|s| s.changing));
        let full = results.last().expect("rows");
        assert!(!full.changing && full.payload.holds(3600.0));
        assert!((full.payload.value - 3600.0).abs() < 1e-6, "{full:?}");
    }

    #[test]
    fn a_mass_that_comes_once_a_second_counts_in_between_and_not_for_ever() {
        let mut scale = Scale::new(12_000.0);
        let at = |t: u32| f64::from(t) * 0.01;
        for t in 0..500 {
            let mass = (t % 100 == 0).then_some(15_000.0);
            let shown = scale.step(mass, at(t)).expect("a mass");
            assert_eq!(shown.changing, t < 100, "{t}");
        }
        assert!(scale.step(None, at(610)).is_none());
        // The clock was set back by a second.
        assert!(scale.step(None, at(300)).is_none());
        let first = scale.step(Some(15_000.0), at(300)).expect("a mass");
        let then = scale.step(Some(15_000.0), at(340)).expect("a mass");
        assert!(first.changing && !then.changing);
    }

    #[test]
    fn a_scale_that_is_off_shows_it_empty_once_a_load_has_left() {
        // 7 % more than the true mass.
        let off = |kg: f64| 1.07 * kg;
        let parts = [
            (5.0, off(12_000.0)),
            (1.0, off(15_500.0)),
            (5.0, off(15_500.0)),
            (1.0, off(12_000.0)),
            (5.0, off(12_000.0)),
            (1.0, off(15_500.0)),
            (5.0, off(15_500.0)),
        ];
        let results = shown(12_000.0, &parts);
        let (first, second) = (results[1090].payload, results.last().expect("rows").payload);
        assert!(first.std > 600.0 && first.holds(3500.0), "{first:?}");
        assert!(
            (second.value - off(3500.0)).abs() < 1.0 && second.std < 150.0,
            "{second:?}"
        );
    }
}

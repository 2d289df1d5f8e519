//! Do stretches of a swing agree within what they claim?
//!
//! A filter whose model holds moves its estimate, over any stretch, by as much as the stretch takes from its
//! variance: `E (x_end - x_start)^2 = P_start - P_end`. Where stretches move it further than that, they
//! contradict each other, whatever the cause; the interval then widens by the root of the mean ratio (Birge
//! 1932). This also catches what no state of the model names.

use super::super::geometry::Inertia;
use super::filter::Filter;

/// Length of a stretch [s].
const STRETCH: f64 = 0.4;
/// A stretch that takes less than this share of the variance says nothing.
const INFORMATIVE: f64 = 0.05;
/// Share of one stretch in the mean ratio; largest ratio of one.
const MEMORY: f64 = 0.12;
const LARGEST: f64 = 36.0;
/// Ratio that an outright contradiction counts as.
const OUTRIGHT: f64 = 18.0;

/// Where a stretch began: how the inertia depends on the states, its value and its variance.
type Start = ([(usize, f64); 5], f64, f64);

/// Mean ratio of what stretches moved to what they may move.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Agreement {
    /// The posture stays that in which the stretch began.
    start: Option<Start>,
    elapsed: f64,
    ratio: f64,
}

impl Agreement {
    pub(super) fn new() -> Self {
        Self {
            start: None,
            elapsed: 0.0,
            ratio: 1.0,
        }
    }

    /// The filter after a tick of motion in which only the motion informed.
    pub(super) fn push(&mut self, filter: &Filter, now: &Inertia, period: f64) {
        let Some((row, before, variance_before)) = self.start else {
            self.begin(filter, now);
            return;
        };
        self.elapsed += period;
        if self.elapsed < STRETCH {
            return;
        }
        let (value, variance) = filter.combination(&row);
        let taken = variance_before - variance;
        if taken > INFORMATIVE * variance_before {
            let moved = value - before;
            self.ratio += MEMORY * ((moved * moved / taken).min(LARGEST) - self.ratio);
        }
        self.begin(filter, now);
    }

    fn begin(&mut self, filter: &Filter, now: &Inertia) {
        let row = filter.inertia_row(now);
        let (value, variance) = filter.combination(&row);
        self.start = Some((row, value, variance));
        self.elapsed = 0.0;
    }

    /// The motion contradicts the value outright.
    pub(super) fn contradict(&mut self) {
        self.ratio += MEMORY * (OUTRIGHT - self.ratio).max(0.0);
        self.start = None;
    }

    /// The value has changed for another reason: the next stretch begins anew.
    pub(super) fn interrupt(&mut self) {
        self.start = None;
    }

    /// Factor of the variance, at least 1.
    pub(super) fn factor(&self) -> f64 {
        self.ratio.max(1.0)
    }
}

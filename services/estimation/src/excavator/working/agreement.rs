//! Agreement of the stretches of a swing within their predicted variance.
//!
//! Where the model holds, a stretch moves the estimate by as much as it lowers the variance: `E (x_end - x_start)^2 = P_start - P_end`.
//! Where stretches move it further, they contradict each other, whatever the cause. The interval then widens by the root of the mean
//! ratio (Birge 1932). This also detects effects that are no state of the model.

use super::super::geometry::Inertia;
use super::filter::Filter;

/// Duration of a stretch [s].
const STRETCH: f64 = 0.4;
/// Share of the variance that a stretch must remove to carry information.
const INFORMATIVE: f64 = 0.05;
/// Weight of one stretch in the mean ratio.
const MEMORY: f64 = 0.12;
/// Upper limit of the ratio of one stretch.
const LARGEST: f64 = 36.0;
/// Ratio of an outright contradiction.
const OUTRIGHT: f64 = 18.0;

/// Start of a stretch: row of the inertia, its value and its variance.
type Start = ([(usize, f64); 5], f64, f64);

/// Mean ratio of the squared change over a stretch to the variance lost.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Agreement {
    /// The stretch keeps the posture in which it began.
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

    /// Adds the filter after a tick in which only motion has informed it.
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

    /// Counts an outright contradiction by the motion.
    pub(super) fn contradict(&mut self) {
        self.ratio += MEMORY * (OUTRIGHT - self.ratio).max(0.0);
        self.start = None;
    }

    /// Restarts the stretch, since the value has changed for another reason.
    pub(super) fn interrupt(&mut self) {
        self.start = None;
    }

    /// Factor of the variance, at least 1.
    pub(super) fn factor(&self) -> f64 {
        self.ratio.max(1.0)
    }
}

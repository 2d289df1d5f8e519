//! Hypothesis that the torque gain is off by more than its Gaussian prior allows, where pressures weigh beside it.
//!
//! A Gaussian prior excludes an error of four standard deviations, but one machine in eight has such an error. Torque and pressures then contradict
//! each other, and the filter takes the mean of both. The hypothesis differs from the filter by one prior only, so it needs no second
//! filter. With the prior N(0, a²), the posterior N(m, v) of the filter, and the other prior N(0, b²),
//!
//! ```text
//! 1/v' = 1/v - 1/a² + 1/b²        m' = v' m/v        E = (a/b) sqrt(v'/v) exp((m/v)² (v' - v)/2)
//! ```
//! E is the ratio of the evidences (Dickey 1971). A quantity that has the covariance c with the gain moves by c (m' - m)/v, and its
//! variance grows by (c/v)² (v' - v). The interval is that of the mixture ([`crate::mixture`]).

use super::filter::{BUCKET, Filter, GAIN, LINKS, UPPER};
use super::parallel::is_calibrated;
use crate::excavator::doubts::Doubts;
use crate::excavator::geometry::Inertia;
use crate::excavator::size::Sticking;
use crate::math::{exp, ln, sqrt};
use crate::mixture::spread;

/// Standard deviation of a gain that is off. Larger errors are left to the parallel filter.
const OFF: f64 = 0.1;
/// Prior log odds of such a gain: one machine in eight.
const LOG_ODDS: f64 = -1.9;
/// Upper limit of the log odds.
const MOST: f64 = 20.0;
/// Time between two updates \[s\].
const PERIOD: f64 = 0.2;

/// Hypothesis that the gain is off.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Tail {
    /// The torque has not been compared with a reference.
    is_open: bool,
    since: f64,
    /// Variances that the mixture adds to inertia and payload, over the squares of their covariances with the gain.
    per_square: [f64; 2],
}

impl Tail {
    pub(super) fn new(doubts: &Doubts) -> Self {
        Self {
            is_open: !is_calibrated(doubts),
            since: 0.0,
            per_square: [0.0; 2],
        }
    }

    /// Advances by a tick of this length; returns whether an update is due.
    pub(super) fn is_due(&mut self, period: f64) -> bool {
        self.since += period;
        let due = self.since >= PERIOD;
        if due {
            self.since = 0.0;
        }
        due
    }

    /// Withdraws the hypothesis.
    pub(super) fn forget(&mut self) {
        self.per_square = [0.0; 2];
    }

    /// Updates the hypothesis with a filter; `stated`: standard deviation of its gain; `disagreement`: ratio of observed to predicted
    /// variance of its innovations.
    pub(super) fn ask(
        &mut self,
        filter: &Filter,
        (stated, disagreement): (f64, f64),
        now: &Inertia,
        sticks: &Sticking,
    ) {
        self.forget();
        let (m, v) = (filter.x[GAIN], filter.p[GAIN][GAIN]);
        if !(self.is_open && v > 0.0 && stated > 0.0 && stated < OFF) {
            return;
        }
        // A gain that wanders may be known less closely than stated.
        let information = (1.0 / v - 1.0 / (stated * stated)).max(0.0);
        let other = 1.0 / (information + 1.0 / (OFF * OFF));
        let (moves, more) = (m / v, (other - v).max(0.0));
        let evidence = 0.5 * moves * moves * more / disagreement;
        let volumes = ln(stated / OFF) + 0.5 * ln(other / v);
        let odds = exp((LOG_ODDS + evidence + volumes.min(0.0)).min(MOST));
        let probability = odds / (1.0 + odds);
        let [payload, inertia] = filter.variances(now, sticks);
        let own = [inertia, payload];
        // A quantity that hardly depends on the gain now may do so before the next update.
        let reach = 2.0 * (moves.abs() * more + sqrt(more)) / v;
        let both = covariances(filter, now, sticks);
        for ((per, c), own) in self.per_square.iter_mut().zip(both).zip(own) {
            let per_gain = c / v;
            let std = sqrt(own + per_gain * per_gain * more);
            let apart = spread(probability, per_gain * moves * more, std);
            let added = (apart * apart - own).max(0.0);
            *per = (added / (c * c).max(f64::MIN_POSITIVE)).min(reach * reach);
        }
    }

    /// Variances that the mixture adds to those of the filter: of payload [kg^2] and inertia [(kg m^2)^2].
    pub(super) fn variances(&self, filter: &Filter, now: &Inertia, sticks: &Sticking) -> [f64; 2] {
        if self.per_square == [0.0; 2] {
            return [0.0; 2];
        }
        let [inertia, payload] = covariances(filter, now, sticks);
        let [per_inertia, per_payload] = self.per_square;
        [
            payload * payload * per_payload,
            inertia * inertia * per_inertia,
        ]
    }

    /// The variance that it adds to that of the gain.
    pub(super) fn gain_variance(&self, filter: &Filter) -> f64 {
        let [one, other] = self.per_square;
        let own = filter.p[GAIN][GAIN];
        own * own * one.max(other)
    }
}

/// Covariances of inertia and payload with the gain.
fn covariances(filter: &Filter, now: &Inertia, sticks: &Sticking) -> [f64; 2] {
    let p = &filter.p[GAIN];
    let load: f64 = filter.load_row().iter().map(|(i, a)| a * p[*i]).sum();
    let beside = p[UPPER] + now.per_bucket * p[BUCKET] + now.links * p[LINKS];
    [
        now.per_payload * load + beside,
        load + sticks.share * p[BUCKET],
    ]
}

#[cfg(test)]
mod tests {
    use super::super::filter::{M, N};
    use super::*;

    const STATED: f64 = 0.03;

    /// Filter that has measured an inertia of 5e4 kg m^2 over the gain, and the inertia by another witness; both differ by the share
    /// `apart`.
    fn filter(apart: f64, stated: f64) -> Filter {
        let mut std = [0.0; N];
        (std[GAIN], std[UPPER]) = (stated, 5000.0);
        let mut filter = Filter::new([0.0; N], &std);
        let torque = [(UPPER, 1.0), (GAIN, -5e4)];
        filter.measure(torque, -5e4 * apart, 500.0 * 500.0, 1e9, &mut None);
        let value = -filter.x[UPPER];
        filter.measure([(UPPER, 1.0)], value, 1000.0 * 1000.0, 1e9, &mut None);
        filter
    }

    fn asked(filter: &Filter) -> (f64, f64) {
        let (now, sticks) = (Inertia::default(), Sticking::default());
        let doubts = Doubts::default();
        let mut tail = Tail::new(&doubts);
        tail.ask(filter, (STATED, 1.0), &now, &sticks);
        let [_, added] = tail.variances(filter, &now, &sticks);
        (filter.x[UPPER], sqrt(filter.p[UPPER][UPPER] + added))
    }

    #[test]
    fn witnesses_that_agree_add_next_to_nothing_and_those_that_do_not_reach_the_other_prior() {
        let (_, agreed) = asked(&filter(0.0, STATED));
        let alone = sqrt(filter(0.0, STATED).p[UPPER][UPPER]);
        assert!(agreed < 1.15 * alone, "{agreed} {alone}");
        let (value, std) = asked(&filter(0.15, STATED));
        let truth = filter(0.15, OFF).x[UPPER];
        assert!(value.abs() > 2.0 * alone, "{value} {alone}");
        assert!((value - truth).abs() < 1.96 * std, "{value} {std} {truth}");
    }

    #[test]
    fn the_other_prior_gives_the_result_of_a_filter_that_begins_with_it() {
        let (a, b) = (filter(0.1, STATED), filter(0.1, OFF));
        let (m, v) = (a.x[GAIN], a.p[GAIN][GAIN]);
        let other = 1.0 / (1.0 / v - 1.0 / (STATED * STATED) + 1.0 / (OFF * OFF));
        assert!((other / b.p[GAIN][GAIN] - 1.0).abs() < 1e-9);
        assert!((other * m / v - b.x[GAIN]).abs() < 1e-9);
        let moved = a.x[UPPER] + a.p[GAIN][UPPER] / v * (b.x[GAIN] - m);
        assert!((moved - b.x[UPPER]).abs() < 1e-6, "{moved}");
    }

    #[test]
    fn what_did_not_depend_on_the_gain_when_asked_does_not_explode_when_it_does() {
        let (now, sticks) = (Inertia::default(), Sticking::default());
        let mut filter = filter(0.4, STATED);
        let mut tail = Tail::new(&Doubts::default());
        filter.p[M][M] = 400.0 * 400.0;
        tail.ask(&filter, (STATED, 1.0), &now, &sticks);
        let v = filter.p[GAIN][GAIN];
        filter.p[GAIN][M] = 0.9 * 400.0 * sqrt(v);
        let [payload, _] = tail.variances(&filter, &now, &sticks);
        let truth = OFF / STATED * 400.0;
        assert!(
            payload.is_finite() && sqrt(payload) < 20.0 * truth,
            "{payload}"
        );
    }

    #[test]
    fn a_gain_that_is_stated_as_anything_or_was_compared_has_no_tail() {
        let (now, sticks) = (Inertia::default(), Sticking::default());
        let asked = |gain_std: f64, stated: f64| {
            let mut tail = Tail::new(&Doubts {
                gain_std,
                ..Doubts::default()
            });
            tail.ask(&filter(0.1, STATED), (stated, 1.0), &now, &sticks);
            tail.per_square[0] > 0.0
        };
        assert!(asked(0.05, STATED));
        assert!(!asked(0.05, 0.2));
        assert!(!asked(0.01, STATED));
    }
}

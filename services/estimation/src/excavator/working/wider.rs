//! Is a sensor wrong by far more than it is stated to be?
//!
//! A gaussian prior says that ten standard deviations never happen. Sensors have a fault now and then. A hypothesis differs from what the
//! filter assumes by the prior of one constant only, so no second filter is needed. With the prior N(0, a²), the posterior N(m, v) that the
//! filter has, and another prior N(0, b²):
//!
//! ```text
//! 1/v' = 1/v - 1/a² + 1/b²        m' = v' m/v        E = a/b sqrt(v'/v) exp((m'²/v' - m²/v)/2)
//! ```
//! E is the ratio of the evidences (Savage, Dickey); everything else follows the constant by its covariance with it.

use super::filter::{BUCKET, Filter, GAIN, M, SPAN, Vector, ZERO, inertia_row};
use crate::excavator::geometry::Inertia;
use crate::excavator::size::Sticking;
use crate::math::{exp, sqrt};
use crate::mixture::spread;

#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Wider {
    per: [[f64; 2]; 3],
    since: f64,
}

impl Wider {
    pub(super) fn new() -> Self {
        Self { per: [[0.0; 2]; 3], since: 0.0 }
    }

    pub(super) fn is_due(&mut self, period: f64) -> bool {
        self.since += period;
        let due = self.since >= 0.2;
        if due { self.since = 0.0; }
        due
    }

    pub(super) fn weigh(&mut self, filter: &Filter, stated: &Vector, usual: f64, now: &Inertia, sticks: &Sticking) {
        use crate::tune::get;
        let h = [
            (GAIN, get(0, 0.1), if stated[SPAN] > 0.0 { get(1, -1.6) } else { get(6, -2.3) }),
            (SPAN, get(2, 0.1), get(3, -1.6)),
            (ZERO, get(4, 5.0) * stated[ZERO], get(5, -1.6)),
        ];
        let mut found = [(0.0, 0.0, 0.0, 0.0); 3];
        let mut sum = 1.0;
        for ((i, b, odds), found) in h.into_iter().zip(&mut found) {
            let (m, v, a) = (filter.x[i], filter.p[i][i], stated[i]);
            if !(v > 0.0 && a > 0.0 && b > a) {
                continue;
            }
            let told = (1.0 / v - 1.0 / (a * a)).max(0.0);
            let other = 1.0 / (told + 1.0 / (b * b));
            let per = m / v;
            let evidence = 0.5 * per * per * (other - v);
            let odds = exp((odds + evidence / usual).min(10.0)) * (a / b * sqrt(other / v)).min(1.0);
            sum += odds;
            *found = (odds, per * (other - v) / v, (other - v) / (v * v), v);
        }
        for (k, (i, ..)) in h.into_iter().enumerate() {
            let (odds, away, more, v) = found[k];
            self.per[k] = [0.0; 2];
            if odds <= 0.0 { continue; }
            let both = covariances(filter, i, now, sticks);
            let own = [filter.combination(&inertia_row(now)).1, filter.payload(sticks).1];
            for q in 0..2 {
                let c = both[q];
                let std = sqrt((own[q] + c * c * more).max(0.0));
                let _ = v;
                let s = spread(odds / sum, c * away, std);
                let extra = (s * s - own[q]).max(0.0);
                self.per[k][q] = extra / (c * c).max(1e-9);
            }
        }
    }

    pub(super) fn variances(&self, filter: &Filter, now: &Inertia, sticks: &Sticking) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for (k, i) in [GAIN, SPAN, ZERO].into_iter().enumerate() {
            let both = covariances(filter, i, now, sticks);
            for q in 0..2 {
                sums[q] += both[q] * both[q] * self.per[k][q];
            }
        }
        sums
    }
}

fn covariances(filter: &Filter, i: usize, now: &Inertia, sticks: &Sticking) -> [f64; 2] {
    let p = &filter.p[i];
    [
        inertia_row(now).iter().map(|(j, a)| a * p[*j]).sum(),
        p[M] + sticks.share * p[BUCKET],
    ]
}

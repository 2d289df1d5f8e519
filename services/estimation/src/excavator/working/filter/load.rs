//! The load: its content held and released, its payload and inertia with their variances and rows.

use super::super::states::*;
use super::super::trail::Trail;
use super::Filter;
use crate::excavator::geometry::Inertia;
use crate::excavator::size::Sticking;

/// Share of the prior variance above which a content counts as not informed.
const INFORMED: f64 = 0.5;

impl Filter {
    /// Sets another content of the bucket: value and variance, as a true mass, or in units of the measured torque.
    pub(in crate::excavator) fn hold(
        &mut self,
        (value, variance): (f64, f64),
        true_mass: bool,
        trail: &mut Option<Trail>,
    ) {
        if !true_mass {
            self.set(M, value, variance, trail);
            return;
        }
        let share = 1.0 / (1.0 + self.x[GAIN]);
        self.x[M] = value * share;
        let per_gain = -self.x[M] * share;
        if let Some(trail) = trail {
            let mut row = [0.0; N];
            row[GAIN] = per_gain;
            trail.row(M, &row);
        }
        let of_gain = self.with(GAIN);
        for (j, covariance) in of_gain.iter().enumerate() {
            self.p[M][j] = per_gain * covariance;
            self.p[j][M] = self.p[M][j];
        }
        self.p[M][M] = share * share * variance + per_gain * per_gain * of_gain[GAIN];
    }

    /// Removes the prior of the load (value, variance), so that it no longer informs other states. A load that has hardly been informed
    /// since is left unchanged.
    #[inline]
    pub(in crate::excavator) fn take_back(
        &mut self,
        (value, variance): (f64, f64),
        true_mass: bool,
        trail: &mut Option<Trail>,
    ) {
        let row = self.content_row(true_mass);
        let (load, own) = self.combination(&row);
        if own <= INFORMED * variance {
            let load = if true_mass { self.load() } else { load };
            self.without(row, (value - load, variance), trail);
        }
    }

    /// Relinearises the content after a measurement of its true mass; `before`: the content prior to that measurement. A gain error leaves
    /// a true mass unchanged. The covariance of content and gain must therefore correspond to the present content.
    pub(in crate::excavator) fn weighs_true_mass(
        &mut self,
        before: f64,
        trail: &mut Option<Trail>,
    ) {
        let per_gain = (before - self.x[M]) / (1.0 + self.x[GAIN]);
        if let Some(trail) = trail {
            let mut row = [0.0; N];
            (row[M], row[GAIN]) = (1.0, per_gain);
            trail.row(M, &row);
        }
        let of_gain = self.with(GAIN);
        let own = self.p[M][M] + per_gain * (2.0 * of_gain[M] + per_gain * of_gain[GAIN]);
        for (j, covariance) in of_gain.iter().enumerate() {
            self.p[j][M] += per_gain * covariance;
            self.p[M][j] = self.p[j][M];
        }
        self.p[M][M] = own;
    }

    /// Row of the content: as a true mass, or in units of the measured torque.
    fn content_row(&self, true_mass: bool) -> [(usize, f64); 2] {
        if true_mass {
            self.load_row()
        } else {
            [(M, 1.0), (GAIN, 0.0)]
        }
    }

    /// Content of the bucket beyond what sticks in it, as a true mass [kg].
    pub(in crate::excavator) fn load(&self) -> f64 {
        (1.0 + self.x[GAIN]) * self.x[M]
    }

    /// Payload with what sticks in the bucket [kg].
    pub(in crate::excavator) fn payload(&self, sticks: &Sticking) -> f64 {
        self.load() + sticks.of(self.x[BUCKET])
    }

    /// Row of the load.
    pub(in crate::excavator) fn load_row(&self) -> [(usize, f64); 2] {
        [(M, 1.0 + self.x[GAIN]), (GAIN, self.x[M])]
    }

    /// Row of the payload.
    pub(in crate::excavator) fn payload_row(&self, sticks: &Sticking) -> [(usize, f64); 3] {
        let [load, gain] = self.load_row();
        [load, gain, (BUCKET, sticks.share)]
    }

    /// Estimated inertia at a posture, with this payload [kg m^2].
    pub(in crate::excavator) fn inertia(&self, now: &Inertia, payload: f64) -> f64 {
        let x = &self.x;
        let beside = x[UPPER] + x[BUCKET] * now.per_bucket + x[LINKS] * now.links;
        now.with_payload(payload) + beside
    }

    /// Row of the inertia at a posture.
    #[inline]
    pub(in crate::excavator) fn inertia_row(&self, now: &Inertia) -> [(usize, f64); 5] {
        let per_payload = now.per_payload;
        let [load, gain] = self.load_row().map(|(i, entry)| (i, entry * per_payload));
        [
            load,
            gain,
            (UPPER, 1.0),
            (BUCKET, now.per_bucket),
            (LINKS, now.links),
        ]
    }

    /// Variances of the payload [kg^2] and of the inertia at a posture [(kg m^2)^2].
    pub(in crate::excavator) fn variances(&self, now: &Inertia, sticks: &Sticking) -> [f64; 2] {
        let (p, share) = (&self.p, sticks.share);
        let (per_load, per_bucket, links) = (now.per_payload, now.per_bucket, now.links);
        let [(_, of_load), (_, of_gain)] = self.load_row();
        let with_load = |i: usize| of_load * p[M][i] + of_gain * p[GAIN][i];
        let of_bucket = with_load(BUCKET);
        let load = of_load * with_load(M) + of_gain * with_load(GAIN);
        let beside = with_load(UPPER) + per_bucket * of_bucket + links * with_load(LINKS);
        let upper =
            p[UPPER][UPPER] + 2.0 * (per_bucket * p[UPPER][BUCKET] + links * p[UPPER][LINKS]);
        let bucket = per_bucket * (per_bucket * p[BUCKET][BUCKET] + 2.0 * links * p[BUCKET][LINKS]);
        let payload = load + share * (2.0 * of_bucket + share * p[BUCKET][BUCKET]);
        let inertia = per_load * (per_load * load + 2.0 * beside)
            + (upper + bucket + links * links * p[LINKS][LINKS]);
        [payload.max(0.0), inertia.max(0.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn removing_a_prior_restores_the_other_states() {
        let (prior, known) = ((200.0, 160.0 * 160.0), 30.0 * 30.0);
        let measured = |prior: (f64, f64)| {
            let mut filter = Filter::new([0.0; N], &[0.0; N]);
            filter.set(M, prior.0, prior.1, &mut None);
            filter.set(BUCKET, 0.0, known, &mut None);
            let row = [(M, 1.0), (BUCKET, 1.0)];
            filter.measure(row, -prior.0, 100.0, 1e9, &mut None);
            filter
        };
        let mut filter = measured(prior);
        assert!(filter.x[BUCKET] < -5.0, "{}", filter.x[BUCKET]);
        filter.take_back(prior, false, &mut None);
        assert!(filter.x[BUCKET].abs() < 1e-9, "{}", filter.x[BUCKET]);
        assert!((filter.p[BUCKET][BUCKET] / known - 1.0).abs() < 1e-9);
        // A flat prior gives the same content.
        let flat = measured((prior.0, 1e12));
        assert!((filter.x[M] - flat.x[M]).abs() < 1e-4, "{}", filter.x[M]);
        assert!((filter.p[M][M] / flat.p[M][M] - 1.0).abs() < 1e-4);
    }

    #[test]
    fn variances_are_those_of_the_rows() {
        let std: Vector = core::array::from_fn(|i| 1.0 + 0.1 * i as f64);
        let mut filter = Filter::new(std, &std);
        let all: [(usize, f64); N] = core::array::from_fn(|i| (i, 1.0 - 0.1 * i as f64));
        filter.measure(all, 1.0, 2.0, 1e9, &mut None);
        let now = Inertia {
            per_payload: 3.0,
            per_bucket: 2.0,
            links: 0.7,
            ..Inertia::default()
        };
        let sticks = Sticking {
            share: 0.3,
            ..Sticking::default()
        };
        let [payload, inertia] = filter.variances(&now, &sticks);
        let (_, by_row) = filter.combination(&filter.payload_row(&sticks));
        assert!((payload / by_row - 1.0).abs() < 1e-12);
        let (_, by_row) = filter.combination(&filter.inertia_row(&now));
        assert!((inertia / by_row - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_content_held_as_a_true_mass_does_not_inform_the_gain() {
        let mut std = [0.0; N];
        std[GAIN] = 0.05;
        let mut x = [0.0; N];
        x[GAIN] = 0.1;
        let mut filter = Filter::new(x, &std);
        let prior = (200.0, 160.0 * 160.0);
        filter.hold(prior, true, &mut None);
        assert!((filter.load() - 200.0).abs() < 1e-9);
        let row = filter.load_row();
        assert!((filter.combination(&row).1 / prior.1 - 1.0).abs() < 1e-9);
        // A scale shows 600 kg; then the prior is removed.
        let before = filter.x[M];
        filter.measure(row, 400.0, 100.0, 1e9, &mut None);
        filter.weighs_true_mass(before, &mut None);
        filter.take_back(prior, true, &mut None);
        assert!((filter.x[GAIN] - 0.1).abs() < 1e-9 && (filter.load() - 600.0).abs() < 2.0);
        assert!((filter.p[GAIN][GAIN] - 0.0025).abs() < 1e-12);
    }
}

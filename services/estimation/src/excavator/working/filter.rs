//! Extended Kalman filter of the swing. Its states include every constant in which a described machine may differ.
//!
//! ```text
//! J w' = (1 + k) [T - l |T| th - T_f th + d - b w] - Jd w + g0 M (p cos psi - q sin psi)
//! J = J_e(q) + dJ_u + dm_b g_b(q) + e J_l(q) + (1 + k) m g(q),  th = tanh(w / width),  M = S + sum m_i r_i + (1 + k) m r_p + ...
//! measured velocity: y(t) = w(t - tau) = w - tau w'
//! ```
//!
//! | symbol | index | meaning | unit |
//! |---|---|---|---|
//! | w | [`W`] | swing velocity | rad/s |
//! | m | [`M`] | payload beyond what sticks in the bucket, over 1 + k | kg |
//! | d | [`OFFSET`] | offset of the measured torque | N m |
//! | b | [`DAMPING`] | viscous damping | N m s/rad |
//! | k | [`GAIN`] | true torque over the measured one, minus 1 | - |
//! | l | [`LOSS`] | share of the torque lost while driving, gained while braking | - |
//! | T_f | [`FRICTION`] | Coulomb friction | N m |
//! | p, q | [`SLOPE`], [`SLOPE`] + 1 | slope of the ground, sin(beta) times sine and cosine of its direction | - |
//! | S | [`MOMENT`] | first moment of the upper body | kg m |
//! | tau | [`DELAY`] | delay of the velocity behind the torque | s |
//! | dJ_u | [`UPPER`] | inertia of the upper body beyond the described one | kg m^2 |
//! | dm_b | [`BUCKET`] | mass of the bucket, with what sticks in it, beyond the described one | kg |
//! | e | [`LINKS`] | masses of boom and arm over the described ones, minus 1 | - |
//! | s, z, f, h | [`SPAN`], [`ZERO`], [`REST`], [`HELD`] | of the boom's moment: [`super::super::measurements::boom_moment`] | -, N, N, N |
//!
//! No motion identifies the common scale of torque and masses. Payload, friction, damping and offset are therefore over 1 + k: in units
//! of the measured torque. The unobservable direction of the states then does not depend on their values, so that linearisation adds no
//! information along it. In coordinates where that direction turns, it does (Huang, Mourikis, Roumeliotis 2010).
//!
//! All states but w and m are constants of the machine and its place. Only row W of the transition differs from the identity, in the
//! states before [`ACTING`]. A step therefore costs two passes over the covariance. It is stored by columns: the sums along its rows run
//! side by side, each in a fixed order. Covariances of the states from [`SEEN`] on with those before are stored in the columns of the
//! former only.

use super::super::geometry::Inertia;
pub(super) use super::states::*;
use super::trail::Trail;
use crate::excavator::measurements::boom_moment::GRAVITY;
use crate::excavator::size::Sticking;
use crate::kalman::Innovation;
use crate::math::{exp, tanh};
use crate::mixture::mix;

/// Share of the prior variance above which a content counts as not informed.
const INFORMED: f64 = 0.5;

/// Inputs of one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Input {
    /// Length of the step [s].
    pub(super) period: f64,
    /// Measured torque, mean over the step [N m].
    pub(super) torque: f64,
    /// Inertia: mean over the step, and rate.
    pub(super) inertia: Inertia,
    pub(super) rate: Inertia,
    /// Inertia at the end of the step, for the first moments.
    pub(super) now: Inertia,
    /// Sine and cosine of the swing angle.
    pub(super) turn: (f64, f64),
    /// Variance of the torque beyond the model [(N m)^2].
    pub(super) torque_variance: f64,
    /// Share of the payload that leaves during the step.
    pub(super) leaving: f64,
    /// Process noise of the payload over the step [kg^2].
    pub(super) payload_variance: f64,
}

/// Predicted measurement: its row, its covariances with the states, and its variance without measurement noise.
pub(super) struct Measured<const K: usize> {
    row: [(usize, f64); K],
    column: Vector,
    pub(super) variance: f64,
}

impl<const K: usize> Measured<K> {
    fn whole(&self) -> Vector {
        let mut whole = [0.0; N];
        for (i, entry) in self.row {
            whole[i] = entry;
        }
        whole
    }
}

/// State and covariance.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Filter {
    pub(super) x: Vector,
    /// Covariance by columns, symmetric to rounding. `p[i][j]` with i < [`SEEN`] <= j is not stored.
    pub(super) p: [Vector; N],
    /// Acceleration over the last step [rad/s^2].
    pub(super) acceleration: f64,
}

impl Filter {
    /// Starts with independent states.
    pub(super) fn new(x: Vector, std: &Vector) -> Self {
        let mut p = [[0.0; N]; N];
        for (i, std) in std.iter().enumerate() {
            p[i][i] = std * std;
        }
        Self {
            x,
            p,
            acceleration: 0.0,
        }
    }

    /// Predicts over one step. `width`: velocity over which friction changes its sign [rad/s]; `least`: lower limit of the inertia
    /// [kg m^2].
    pub(super) fn predict(
        &mut self,
        input: &Input,
        width: f64,
        least: f64,
        trail: &mut Option<Trail>,
    ) {
        let (x, dt) = (&mut self.x, input.period);
        let (w, gain) = (x[W], 1.0 + x[GAIN]);
        let m = gain * x[M];
        let parts = |of: &Inertia| {
            of.with_payload(m) + x[UPPER] + x[BUCKET] * of.per_bucket + x[LINKS] * of.links
        };
        let inertia = parts(&input.inertia).max(least);
        let rate = parts(&input.rate) - x[UPPER];
        let direction = tanh(w / width);
        let size = input.torque.abs();
        let (sin, cos) = input.turn;
        let lean = GRAVITY * (x[SLOPE] * cos - x[SLOPE + 1] * sin);
        let now = &input.now;
        let moment = x[MOMENT]
            + now.moment
            + m * now.radius
            + x[BUCKET] * now.bucket_radius
            + x[LINKS] * now.links_moment;
        let dissipated = x[FRICTION] + x[LOSS] * size;
        let driving = input.torque + x[OFFSET] - dissipated * direction - x[DAMPING] * w;
        let f = (gain * driving + lean * moment - rate * w) / inertia;
        let steep = dissipated.max(0.0) * (1.0 - direction * direction) / width;

        let step = dt / inertia;
        // The process noise acts like the measured torque.
        let of_torque = step * gain;
        let mut row = [0.0; ACTING];
        row[W] = exp(-step * (gain * (x[DAMPING] + steep) + rate));
        let heavier = |radius, rate, inertia| step * (lean * radius - rate * w - f * inertia);
        let (of, rates) = (&input.inertia, &input.rate);
        let per_load = heavier(now.radius, rates.per_payload, of.per_payload);
        row[M] = gain * per_load;
        row[BUCKET] = heavier(now.bucket_radius, rates.per_bucket, of.per_bucket);
        row[LINKS] = heavier(now.links_moment, rates.links, of.links);
        row[UPPER] = -step * f;
        row[OFFSET] = of_torque;
        row[DAMPING] = -of_torque * w;
        row[GAIN] = step * driving + x[M] * per_load;
        row[LOSS] = -of_torque * size * direction;
        row[FRICTION] = -of_torque * direction;
        row[SLOPE] = step * GRAVITY * moment * cos;
        row[SLOPE + 1] = -step * GRAVITY * moment * sin;
        row[MOMENT] = step * lean;
        x[W] += dt * f;
        self.acceleration = f;
        if let Some(trail) = trail {
            let mut whole = [0.0; N];
            whole[..ACTING].copy_from_slice(&row);
            trail.row(W, &whole);
        }

        let column = self.along_motion(&row);
        let own: f64 = row.iter().zip(&column).map(|(entry, c)| entry * c).sum();
        let variance = own + input.torque_variance * of_torque * of_torque;
        for (i, &covariance) in column.iter().enumerate() {
            self.p[W][i] = covariance;
            self.p[i][W] = covariance;
        }
        self.p[W][W] = variance;
        self.leave(input, trail);
    }

    /// Removes the share of the payload that leaves, and adds the process noise of the payload.
    pub(super) fn leave(&mut self, input: &Input, trail: &mut Option<Trail>) {
        if input.leaving > 0.0 {
            let remaining = 1.0 - input.leaving;
            if let Some(trail) = trail {
                let mut row = [0.0; N];
                row[M] = remaining;
                trail.row(M, &row);
            }
            self.x[M] *= remaining;
            for i in 0..N {
                self.p[M][i] *= remaining;
                self.p[i][M] *= remaining;
            }
        }
        self.p[M][M] += input.payload_variance;
    }

    /// Adds the delay times this acceleration to the velocity: it was measured during that acceleration, and lags.
    pub(super) fn lag(&mut self, acceleration: f64, trail: &mut Option<Trail>) {
        let of_delay = self.with(DELAY);
        let (x, p) = (&mut self.x, &mut self.p);
        if let Some(trail) = trail {
            let mut row = [0.0; N];
            (row[W], row[DELAY]) = (1.0, acceleration);
            trail.row(W, &row);
        }
        x[W] += x[DELAY] * acceleration;
        let variance = p[W][W];
        for (i, covariance) in of_delay.iter().enumerate() {
            p[W][i] = acceleration * covariance;
            p[i][W] = p[W][i];
        }
        p[W][W] = variance + acceleration * acceleration * of_delay[DELAY];
    }

    /// Updates with a velocity of this variance. Innovations beyond `gate` standard deviations are weakened. Returns the innovation
    /// before the gate.
    pub(super) fn correct(
        &mut self,
        velocity: f64,
        variance: f64,
        gate: f64,
        trail: &mut Option<Trail>,
    ) -> Innovation {
        let row = [(W, 1.0), (DELAY, -self.acceleration)];
        let value = velocity - self.x[W] + self.x[DELAY] * self.acceleration;
        self.measure(row, value, variance, gate, trail)
    }

    /// Updates with a scalar measurement of the sparse `row x`; `value`: measured minus predicted.
    pub(super) fn measure<const K: usize>(
        &mut self,
        row: [(usize, f64); K],
        value: f64,
        variance: f64,
        gate: f64,
        trail: &mut Option<Trail>,
    ) -> Innovation {
        let measured = self.measured(row);
        let innovation = Innovation {
            value,
            variance: measured.variance + variance,
        };
        self.absorb(&measured, innovation, gate, trail);
        innovation
    }

    /// Predicts a measurement of `row x`.
    #[inline(always)]
    pub(super) fn measured<const K: usize>(&self, row: [(usize, f64); K]) -> Measured<K> {
        let column = self.along(row.into_iter());
        Measured {
            row,
            variance: row
                .iter()
                .fold(0.0, |sum, (i, entry)| sum + column[*i] * entry),
            column,
        }
    }

    /// Updates with a predicted measurement and its innovation.
    #[inline(always)]
    pub(super) fn absorb<const K: usize>(
        &mut self,
        measured: &Measured<K>,
        innovation: Innovation,
        gate: f64,
        trail: &mut Option<Trail>,
    ) {
        let Innovation { value, variance } = innovation;
        let gated = variance.max(value * value / (gate * gate));
        let share = 1.0 / gated;
        let gain = measured.column.map(|c| c * share);
        if let Some(trail) = trail {
            trail.measured(&measured.whole(), &gain, value, gated);
        }
        self.take(&gain, value, &measured.column);
    }

    /// Removes the prior of the load (value, variance), so that it no longer informs other states. A load that has hardly been informed
    /// since is left unchanged.
    #[inline]
    pub(super) fn take_back(
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

    /// Row of the content: as a true mass, or in units of the measured torque.
    fn content_row(&self, true_mass: bool) -> [(usize, f64); 2] {
        if true_mass {
            self.load_row()
        } else {
            [(M, 1.0), (GAIN, 0.0)]
        }
    }

    /// Inverse of a measurement that differed by `value` from its prediction: an update with a negative variance.
    #[inline(never)]
    pub(super) fn without<const K: usize>(
        &mut self,
        row: [(usize, f64); K],
        (value, variance): (f64, f64),
        trail: &mut Option<Trail>,
    ) {
        let measured = self.measured(row);
        let left = measured.variance - variance;
        let gain = measured.column.map(|c| c / left);
        if let Some(trail) = trail {
            trail.measured(&measured.whole(), &gain, value, left);
        }
        self.take(&gain, value, &measured.column);
    }

    /// Sets another content of the bucket: value and variance, as a true mass, or in units of the measured torque.
    pub(super) fn hold(
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

    /// Relinearises the content after a measurement of its true mass; `before`: the content prior to that measurement. A gain error leaves
    /// a true mass unchanged. The covariance of content and gain must therefore correspond to the present content.
    pub(super) fn weighs_true_mass(&mut self, before: f64, trail: &mut Option<Trail>) {
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

    /// Updates states and covariance by a gain, an innovation, and the covariances with the measurement.
    #[inline(always)]
    fn take(&mut self, gain: &Vector, value: f64, column: &Vector) {
        for (x, g) in self.x.iter_mut().zip(gain) {
            *x += g * value;
        }
        let weighs = self.weighs();
        let (seen, others) = self.p.split_at_mut(SEEN);
        for (p, c) in seen.iter_mut().zip(column) {
            for (p, g) in p[..SEEN].iter_mut().zip(gain) {
                *p -= g * c;
            }
        }
        if weighs {
            for (p, c) in others.iter_mut().zip(&column[SEEN..]) {
                for (p, g) in p.iter_mut().zip(gain) {
                    *p -= g * c;
                }
            }
        }
    }

    /// Covariances of all states with a linear combination of some.
    #[inline(always)]
    pub(super) fn along(&self, entries: impl Iterator<Item = (usize, f64)>) -> Vector {
        let mut sums = [0.0; N];
        for (j, entry) in entries {
            let covariances = self.with(j);
            for (sum, covariance) in sums.iter_mut().zip(covariances) {
                *sum += covariance * entry;
            }
        }
        sums
    }

    /// The same for a combination of the states before [`ACTING`].
    #[inline(always)]
    fn along_motion(&self, row: &[f64; ACTING]) -> Vector {
        let mut sums = [0.0; N];
        for (entry, column) in row.iter().zip(&self.p) {
            for (sum, covariance) in sums[..SEEN].iter_mut().zip(column) {
                *sum += covariance * entry;
            }
        }
        if self.weighs() {
            for (sum, column) in sums[SEEN..].iter_mut().zip(&self.p[SEEN..]) {
                *sum = dot_pairs(row, &column[..ACTING]);
            }
        }
        sums
    }

    /// Whether the states from [`SEEN`] on are uncertain: they are where pressures weigh. Without a variance they have no covariances.
    #[inline(always)]
    fn weighs(&self) -> bool {
        (SEEN..N).any(|i| self.p[i][i] != 0.0)
    }

    /// Estimated inertia at a posture, with this payload [kg m^2].
    pub(super) fn inertia(&self, now: &Inertia, payload: f64) -> f64 {
        let x = &self.x;
        let beside = x[UPPER] + x[BUCKET] * now.per_bucket + x[LINKS] * now.links;
        now.with_payload(payload) + beside
    }

    /// Value and variance of a linear combination of few states.
    #[inline(always)]
    pub(super) fn combination<const K: usize>(&self, row: &[(usize, f64); K]) -> (f64, f64) {
        let (mut value, mut variance) = (0.0, 0.0);
        for (k, &(i, a)) in row.iter().enumerate() {
            value += a * self.x[i];
            let of = |j: usize| self.p[i.max(j)][i.min(j)];
            let beside: f64 = row[k + 1..].iter().map(|&(j, b)| b * of(j)).sum();
            variance += a * (a * self.p[i][i] + 2.0 * beside);
        }
        (value, variance.max(0.0))
    }

    /// Content of the bucket beyond what sticks in it, as a true mass [kg].
    pub(super) fn load(&self) -> f64 {
        (1.0 + self.x[GAIN]) * self.x[M]
    }

    /// Payload with what sticks in the bucket [kg].
    pub(super) fn payload(&self, sticks: &Sticking) -> f64 {
        self.load() + sticks.of(self.x[BUCKET])
    }

    /// Variances of the payload [kg^2] and of the inertia at a posture [(kg m^2)^2].
    pub(super) fn variances(&self, now: &Inertia, sticks: &Sticking) -> [f64; 2] {
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

    /// Row of the payload.
    pub(super) fn payload_row(&self, sticks: &Sticking) -> [(usize, f64); 3] {
        let [load, gain] = self.load_row();
        [load, gain, (BUCKET, sticks.share)]
    }

    /// Row of the load.
    pub(super) fn load_row(&self) -> [(usize, f64); 2] {
        [(M, 1.0 + self.x[GAIN]), (GAIN, self.x[M])]
    }

    /// Row of the inertia at a posture.
    #[inline]
    pub(super) fn inertia_row(&self, now: &Inertia) -> [(usize, f64); 5] {
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

    /// Covariances of all states with state `i`.
    #[inline(always)]
    fn with(&self, i: usize) -> Vector {
        let mut covariances = self.p[i];
        if i < SEEN {
            for (covariance, column) in covariances[SEEN..].iter_mut().zip(&self.p[SEEN..]) {
                *covariance = column[i];
            }
        }
        covariances
    }

    /// Sets state `i` to a value with a variance, independent of all other states.
    pub(super) fn set(&mut self, i: usize, value: f64, variance: f64, trail: &mut Option<Trail>) {
        if let Some(trail) = trail {
            trail.set(i);
        }
        self.x[i] = value;
        for j in 0..N {
            self.p[i][j] = 0.0;
            self.p[j][i] = 0.0;
        }
        self.p[i][i] = variance;
    }

    /// Returns mean and covariance of the mixture with another filter of this probability.
    pub(super) fn mixed(mut self, other: &Self, probability: f64) -> Self {
        mix(&mut self.x, &mut self.p, (&other.x, &other.p), probability);
        self
    }

    /// Returns whether all states and variances are finite.
    pub(super) fn is_finite(&self) -> bool {
        // A covariance that is not finite reaches the states with the next motion; one of the pressures with their next moment.
        let variances: f64 = (0..N).map(|i| self.p[i][i]).sum();
        (self.sum() + variances).is_finite()
    }

    /// Returns whether the same holds, and no variance is negative.
    pub(super) fn is_sound(&self) -> bool {
        let (mut variances, mut least) = (0.0, 0.0);
        for i in 0..N {
            let variance = self.p[i][i];
            variances += variance;
            // One instruction; NaN shows in the sum.
            least = if least < variance { least } else { variance };
        }
        least == 0.0 && (self.sum() + variances).is_finite()
    }

    /// Sum of all states, two at a time.
    fn sum(&self) -> f64 {
        let pairs = self.x.as_chunks::<2>();
        let add = |[a, b]: [f64; 2], pair: &[f64; 2]| [a + pair[0], b + pair[1]];
        let [a, b] = pairs.0.iter().fold([0.0; 2], add);
        a + b + pairs.1.iter().sum::<f64>()
    }
}

/// Sum of products, two at a time.
fn dot_pairs(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.as_chunks::<2>(), b.as_chunks::<2>());
    let mut sums = [0.0; 2];
    for (a, b) in a.0.iter().zip(b.0) {
        sums[0] += a[0] * b[0];
        sums[1] += a[1] * b[1];
    }
    let rest: f64 = a.1.iter().zip(b.1).map(|(a, b)| a * b).sum();
    sums[0] + sums[1] + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step in which a torque drives the swing.
    fn swing() -> Input {
        Input {
            period: 0.01,
            torque: 2000.0,
            inertia: Inertia {
                empty: 6000.0,
                per_payload: 9.0,
                ..Inertia::default()
            },
            ..Input::default()
        }
    }

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
    fn a_torque_in_another_unit_is_another_gain_and_nothing_else() {
        let velocity = |torque: f64| {
            let input = Input {
                torque: 2000.0 * torque,
                torque_variance: 9e4 * torque * torque,
                ..swing()
            };
            let mut x = [0.0; N];
            x[GAIN] = 1.0 / torque - 1.0;
            let mut filter = Filter::new(x, &[0.0; N]);
            (0..100).for_each(|_| filter.predict(&input, 0.01, 1000.0, &mut None));
            (filter.x[W], filter.p[W][W])
        };
        let (value, variance) = velocity(1.0);
        let (other, its_variance) = velocity(1.25);
        assert!((other / value - 1.0).abs() < 1e-12, "{other} {value}");
        assert!(
            (its_variance / variance - 1.0).abs() < 1e-12,
            "{its_variance} {variance}"
        );
    }

    #[test]
    fn a_common_factor_of_masses_and_torque_leaves_the_motion_unchanged_at_any_load_and_loss() {
        let input = Input {
            rate: Inertia {
                per_payload: 2.0,
                ..Inertia::default()
            },
            ..swing()
        };
        let moved = |scale: f64| {
            let mut x = [0.0; N];
            (x[W], x[M], x[OFFSET], x[DAMPING]) = (0.3, 250.0, 40.0, 900.0);
            (x[LOSS], x[FRICTION]) = (0.05, 300.0);
            (x[GAIN], x[UPPER]) = (scale - 1.0, (scale - 1.0) * 6000.0);
            let mut filter = Filter::new(x, &[0.0; N]);
            (0..50).for_each(|_| filter.predict(&input, 0.01, 1000.0, &mut None));
            filter.x[W]
        };
        assert!((moved(1.2) / moved(1.0) - 1.0).abs() < 1e-12);
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

    #[test]
    fn covariances_that_are_not_stored_are_not_read() {
        let all: [(usize, f64); N] = core::array::from_fn(|i| (i, 1.0 - 0.1 * i as f64));
        let done = |not_kept: f64| {
            let mut filter = Filter::new([0.5; N], &[1.0; N]);
            for column in &mut filter.p[..SEEN] {
                column[SEEN..].fill(not_kept);
            }
            let other = Filter::new([0.4; N], &[0.9; N]);
            let input = Input {
                leaving: 0.1,
                ..swing()
            };
            filter.measure(all, 1.0, 2.0, 1e9, &mut None);
            filter.predict(&input, 0.01, 1000.0, &mut None);
            filter.correct(0.4, 0.1, 4.0, &mut None);
            filter.lag(0.1, &mut None);
            filter.weighs_true_mass(0.3, &mut None);
            filter.hold((1.0, 9.0), true, &mut None);
            filter.measure([(M, 1.0), (ZERO, 1.0)], 0.1, 1.0, 1e9, &mut None);
            filter.take_back((1.0, 9.0), true, &mut None);
            filter.fade(&other, 0.9, &[GAIN, ZERO]);
            filter.set(REST, 0.0, 1.0, &mut None);
            filter = filter.mixed(&other, 0.3);
            let along = filter.along(all.into_iter());
            let (value, variance) = filter.combination(&all);
            let own: f64 = all.iter().map(|(i, entry)| entry * along[*i]).sum();
            assert!((variance / own - 1.0).abs() < 1e-12);
            (filter.x, along, value)
        };
        assert_eq!(done(0.0), done(f64::NAN));
    }

    #[test]
    fn a_covariance_that_is_no_number_anywhere_shows_with_the_next_motion_and_moment_or_is_gone() {
        let input = swing();
        let moved = |i: usize, j: usize, covariance: f64| {
            let mut filter = Filter::new([1.0; N], &[1.0; N]);
            filter.p[i][j] = covariance;
            filter.predict(&input, 0.01, 1000.0, &mut None);
            filter.correct(1.0, 1.0, 1e3, &mut None);
            let pressures = [SPAN, ZERO, REST, HELD].map(|i| (i, 1.0));
            filter.measure(pressures, 0.0, 1.0, 1e3, &mut None);
            filter
        };
        for i in 0..N {
            let mut filter = Filter::new([1.0; N], &[1.0; N]);
            filter.p[i][i] = -1e-9;
            assert!(!filter.is_sound(), "a negative variance at {i}");
            for j in (0..N).filter(|j| *j != i && (i >= SEEN || *j < SEEN)) {
                assert!(moved(i, j, 0.1).is_sound());
                for none in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    let filter = moved(i, j, none);
                    let gone = filter.p.iter().flatten().all(|p| p.is_finite());
                    assert!(gone || !filter.is_sound(), "{none} at {i}, {j}");
                }
            }
        }
    }
}

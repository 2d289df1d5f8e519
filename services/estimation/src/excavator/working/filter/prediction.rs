//! Prediction of the swing over one step, and what else moves the states without a measurement.

use super::super::states::*;
use super::super::trail::Trail;
use super::Filter;
use crate::excavator::geometry::Inertia;
use crate::excavator::measurements::boom_moment::GRAVITY;
use crate::math::{exp, tanh};

/// Inputs of one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::excavator) struct Input {
    /// Length of the step [s].
    pub(in crate::excavator) period: f64,
    /// Measured torque, mean over the step [N m].
    pub(in crate::excavator) torque: f64,
    /// Inertia: mean over the step, and rate.
    pub(in crate::excavator) inertia: Inertia,
    pub(in crate::excavator) rate: Inertia,
    /// Inertia at the end of the step, for the first moments.
    pub(in crate::excavator) now: Inertia,
    /// Sine and cosine of the swing angle.
    pub(in crate::excavator) turn: (f64, f64),
    /// Variance of the torque beyond the model [(N m)^2].
    pub(in crate::excavator) torque_variance: f64,
    /// Share of the payload that leaves during the step.
    pub(in crate::excavator) leaving: f64,
    /// Process noise of the payload over the step [kg^2].
    pub(in crate::excavator) payload_variance: f64,
}

impl Filter {
    /// Predicts over one step. `width`: velocity over which friction changes its sign [rad/s]; `least`: lower limit of the inertia
    /// [kg m^2].
    pub(in crate::excavator) fn predict(
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
    pub(in crate::excavator) fn leave(&mut self, input: &Input, trail: &mut Option<Trail>) {
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
    pub(in crate::excavator) fn lag(&mut self, acceleration: f64, trail: &mut Option<Trail>) {
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
pub(super) mod tests {
    use super::*;

    /// A step in which a torque drives the swing.
    pub(in crate::excavator) fn swing() -> Input {
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
}

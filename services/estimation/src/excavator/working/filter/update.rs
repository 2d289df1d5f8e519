//! Updates with scalar measurements, and their inverse.

use super::super::states::*;
use super::super::trail::Trail;
use super::Filter;
use crate::kalman::Innovation;

/// Predicted measurement: its row, its covariances with the states, and its variance without measurement noise.
pub(in crate::excavator) struct Measured<const K: usize> {
    row: [(usize, f64); K],
    column: Vector,
    pub(in crate::excavator) variance: f64,
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

impl Filter {
    /// Updates with a velocity of this variance. Innovations beyond `gate` standard deviations are weakened. Returns the innovation
    /// before the gate.
    pub(in crate::excavator) fn correct(
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
    pub(in crate::excavator) fn measure<const K: usize>(
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
    pub(in crate::excavator) fn measured<const K: usize>(
        &self,
        row: [(usize, f64); K],
    ) -> Measured<K> {
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
    pub(in crate::excavator) fn absorb<const K: usize>(
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

    /// Inverse of a measurement that differed by `value` from its prediction: an update with a negative variance.
    #[inline(never)]
    pub(in crate::excavator) fn without<const K: usize>(
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
}

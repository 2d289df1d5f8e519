//! Kalman update by one scalar linear measurement of a few states: y = h'x + e.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | x, P | `state`, `covariance` | states and their covariance, symmetric |
//! | h | `by` | regressor of the measurement |
//! | y - h'x | `innovation` | measured minus expected |
//! | P h, h'P h + R | `cross`, `variance` | covariance with the states; variance of the innovation, that of e included |

/// Scalar measurement, not yet applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement<const N: usize> {
    pub innovation: f64,
    pub variance: f64,
    cross: [f64; N],
}

impl<const N: usize> Measurement<N> {
    /// Measurement with this innovation; `noise` is the variance of e.
    pub fn of(covariance: &[[f64; N]; N], by: &[f64; N], innovation: f64, noise: f64) -> Self {
        let cross = covariance.each_ref().map(|row| dot(row, by));
        Self {
            innovation,
            variance: dot(&cross, by) + noise,
            cross,
        }
    }

    /// Updates state and covariance.
    pub fn take(&self, state: &mut [f64; N], covariance: &mut [[f64; N]; N]) {
        for (i, row) in covariance.iter_mut().enumerate() {
            let gain = self.cross[i] / self.variance;
            state[i] += gain * self.innovation;
            for (p, cross) in row.iter_mut().zip(&self.cross) {
                *p -= gain * cross;
            }
        }
    }
}

/// Covariance of independent states with these standard deviations.
pub const fn diagonal<const N: usize>(stds: [f64; N]) -> [[f64; N]; N] {
    let mut covariance = [[0.0; N]; N];
    let mut i = 0;
    while i < N {
        covariance[i][i] = stds[i] * stds[i];
        i += 1;
    }
    covariance
}

/// h'x.
pub fn dot<const N: usize>(x: &[f64; N], by: &[f64; N]) -> f64 {
    x.iter().zip(by).map(|(x, h)| x * h).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_measurements_of_two_states_are_the_least_squares() {
        let (mut state, mut covariance) = ([1.0, -2.0], [[1e8, 0.0], [0.0, 1e8]]);
        for (by, value) in [([1.0, 1.0], 3.0), ([1.0, -1.0], 1.0)] {
            let innovation = value - dot(&state, &by);
            let measured = Measurement::of(&covariance, &by, innovation, 1.0);
            measured.take(&mut state, &mut covariance);
        }
        assert!((state[0] - 2.0).abs() < 1e-6 && (state[1] - 1.0).abs() < 1e-6);
        // Half of the variance of a measurement each, and independent.
        assert!((covariance[0][0] - 0.5).abs() < 1e-6 && (covariance[1][1] - 0.5).abs() < 1e-6);
        assert!(covariance[0][1].abs() < 1e-6 && covariance[1][0].abs() < 1e-6);
    }
}

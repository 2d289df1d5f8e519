//! Standard deviation of the ratio from unreported curves: differences of the slips that persist and have no torque as a cause.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | y | `innovation` | innovation of the difference of the axles' slips | 1 |
//! | R, P | `noise`, `predicted` | variance of its row, and of its prediction | 1 |
//! | s | `lasting` | mean of y over T = 0.3 s | 1 |
//! | G | `by_share` | derivative of y by the ratio | 1 |
//! | c | - | difference of the slips that lasts for a curve | 1 |
//!
//! The axles of an articulated machine run on different circles: their slips differ by about gamma^2 as long as the curve lasts.
//! White noise and the uncertainty of the prediction give E s^2 = P + R dt/(2 T). The excess, averaged over [`MEMORY`], is c^2.
//!
//! The filter treats the rows of a curve as independent errors, but they share one error. With curves of duration [`LASTS`], the
//! error of the ratio is c sqrt(LASTS/MEMORY) over the rms of G. Other persistent causes count as well, such as soft ground under
//! one axle or a tyre that loses pressure.

use crate::math::sqrt;

/// Averaging time that separates persistent from white errors [s].
const TIME: f64 = 0.3;
/// Averaging time of c^2 and G^2 [s].
const MEMORY: f64 = 20.0;
/// Duration of a curve of a loader at work [s].
const LASTS: f64 = 3.0;

/// Running means of the persistent difference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Curves {
    lasting: f64,
    /// Exponential means of c^2 and G^2.
    square: f64,
    by_share: f64,
}

/// Difference of the axles' slips in one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    pub innovation: f64,
    pub predicted: f64,
    pub noise: f64,
    pub by_share: f64,
}

impl Curves {
    /// Updates the means with a row in which both wheels count, `dt` after the last. A result that is not finite resets them.
    pub fn see(&mut self, row: &Difference, dt: f64) {
        let weight = (dt / TIME).min(1.0);
        self.lasting += weight * (row.innovation - self.lasting);
        let chance = row.predicted + row.noise * 0.5 * weight;
        let (away, memory) = (self.lasting * self.lasting - chance, (dt / MEMORY).min(1.0));
        let next = Self {
            square: self.square + memory * (away - self.square),
            by_share: self.by_share + memory * (row.by_share * row.by_share - self.by_share),
            ..*self
        };
        *self = if next.square.is_finite() && next.by_share.is_finite() && next.lasting.is_finite()
        {
            next
        } else {
            Self::default()
        };
    }

    /// Standard deviation of the ratio from curves; 0 before the first row.
    pub fn ratio_std(&self) -> f64 {
        if self.by_share > 0.0 {
            sqrt(self.square.max(0.0) / self.by_share * (LASTS / MEMORY))
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Standard deviation after a minute of noise of 1e-3, with curves of this slip for 3 s of each 9 s.
    fn after(curve: f64) -> f64 {
        let mut curves = Curves::default();
        let mut seed = 1_u32;
        for k in 0..6000_u32 {
            let noise: f64 = (0..12)
                .map(|_| {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    f64::from(seed) / f64::from(u32::MAX) - 0.5
                })
                .sum();
            let turns = if k % 900 < 300 { curve } else { 0.0 };
            let row = Difference {
                innovation: 1e-3 * noise + turns,
                predicted: 1e-9,
                noise: 1e-6,
                by_share: 0.02,
            };
            curves.see(&row, 0.01);
        }
        curves.ratio_std()
    }

    #[test]
    fn curves_widen_the_ratio_and_a_straight_machine_hardly() {
        assert!(after(0.0) < 0.003, "{}", after(0.0));
        assert!(after(0.004) > 0.03, "{}", after(0.004));
    }

    #[test]
    fn a_row_that_is_not_finite_resets_the_means() {
        let mut curves = Curves::default();
        let row = Difference {
            innovation: f64::INFINITY,
            predicted: 0.0,
            noise: 0.0,
            by_share: 0.02,
        };
        curves.see(&row, 0.01);
        assert_eq!(curves, Curves::default());
        assert_eq!(curves.ratio_std(), 0.0);
    }
}

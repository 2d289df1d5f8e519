//! Fluctuation of the wheel slips, identified from the innovations of the wheel speeds.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | w | `by_slip` | part of the wheel speed by the slip of the torque [rad/s] |
//! | V | `variance` | variance of the innovation without fluctuation: sensor, radius, relaxation, prediction |
//! | c^2 | `square` | variance of the slip, as a share of its square |
//! | nu | `innovation` | innovation of the wheel speed [rad/s] |
//!
//! On a rough road axle loads, and with them the slips, fluctuate far more than on asphalt. E nu^2 = V + c^2 w^2, so c^2 is the
//! weighted mean of (nu^2 - V)/w^2 over the last rows. Its lower bound is the stated c_b^2, which counts like a second of rows. The
//! weights, w^4/(V + c_b^2 w^2)^2, are those of least squares for c = c_b.
//!
//! Waves of a few hertz last for many rows, which then share one error: the excess of c^2 over c_b^2 counts as often
//! (`wheel_noise`, `TOGETHER`). Under loads that fluctuate by c the mean slip is larger by c^2, E 1/(1 + e) = 1 + c^2 + .., on an
//! unknown axle. The interval of what the slips determine includes this. Before the first rows the road is unknown, so a rough one
//! counts like some of them (`ROUGH_ROWS`).

/// Averaging time [s].
const MEMORY: f64 = 20.0;
/// Weight of the stated c_b^2, in rows whose only noise is fluctuation.
const PRIOR_ROWS: f64 = 100.0;
/// Initial c, that of a rough road, and its weight in rows: the road is unknown at the start.
const ROUGH: f64 = 0.12;
const ROUGH_ROWS: f64 = 16.0;
/// Standard deviations to which an innovation is limited: an outlier is no road.
const MOST: f64 = 5.0;

/// Weighted mean of c^2.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SlipFluctuation {
    /// Weighted sum of c^2, and sum of the weights, both times c_b^4.
    sums: [f64; 2],
}

impl Default for SlipFluctuation {
    fn default() -> Self {
        Self {
            sums: [ROUGH_ROWS * ROUGH * ROUGH, ROUGH_ROWS],
        }
    }
}

/// Values w and V of one wheel in a row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Wavering {
    pub by_slip: f64,
    pub variance: f64,
}

impl SlipFluctuation {
    /// Returns c^2, at least `usual` (c_b^2).
    pub fn square(&self, usual: f64) -> f64 {
        let [sum, weight] = self.sums;
        ((sum + PRIOR_ROWS * usual) / (weight + PRIOR_ROWS)).max(usual)
    }

    /// Updates with a row's innovation of a wheel [rad/s]; `usual` is c_b.
    pub fn see(&mut self, innovation: f64, row: &Wavering, usual: f64) {
        let slip = row.by_slip * row.by_slip;
        let usually = row.variance + usual * usual * slip;
        let most = MOST * MOST * (row.variance + self.square(usual * usual) * slip);
        let expected = usual * usual * slip / usually;
        let weight = expected * expected;
        let excess = (innovation * innovation).min(most) - row.variance;
        if weight > 0.0 {
            self.sums[0] += weight * excess / slip;
            self.sums[1] += weight;
        }
    }

    /// Fades the sums over `dt` [s].
    pub fn forget(&mut self, dt: f64) {
        let remaining = 1.0 - (dt / MEMORY).min(1.0);
        self.sums = self.sums.map(|sum| remaining * sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// c after a minute of rows whose innovations alternate between plus and minus their standard deviation.
    fn found(share: f64, slip: f64) -> f64 {
        let mut fluctuation = SlipFluctuation::default();
        let row = Wavering {
            by_slip: slip,
            variance: 4e-6,
        };
        for k in 0..6000 {
            let size = (row.variance + (share * slip).powi(2)).sqrt();
            let innovation = if k % 2 == 0 { size } else { -size };
            fluctuation.forget(0.01);
            fluctuation.see(innovation, &row, 0.05);
        }
        fluctuation.square(0.05 * 0.05).sqrt()
    }

    #[test]
    fn at_the_start_a_rough_road_is_possible_and_an_even_one_is_soon_known() {
        let usual = 0.05 * 0.05;
        let mut fluctuation = SlipFluctuation::default();
        let start = fluctuation.square(usual).sqrt();
        assert!((0.06..0.08).contains(&start), "{start}");
        let row = Wavering {
            by_slip: 0.1,
            variance: 4e-6,
        };
        // Four seconds of slips that fluctuate as usual.
        for k in 0..400 {
            let size = (row.variance + usual * 0.01).sqrt();
            fluctuation.see(if k % 2 == 0 { size } else { -size }, &row, 0.05);
        }
        let then = fluctuation.square(usual).sqrt();
        assert!((0.05..0.057).contains(&then), "{then}");
    }

    #[test]
    fn fluctuating_slips_are_found_and_the_stated_fluctuation_is_the_lower_bound() {
        // 740 of 840 rows are the new ones.
        assert!((found(0.3, 0.05) / 0.3 - 1.0).abs() < 0.1);
        assert!((found(0.02, 0.05) - 0.05).abs() < 1e-12);
        // Rows without slips carry no information. After three times the memory, less than one of the initial sixteen rows is left.
        let left = found(0.3, 0.0);
        assert!((0.05..0.0512).contains(&left), "{left}");
    }
}

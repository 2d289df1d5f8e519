//! How much the slips of the wheels waver, found in the innovations of their speeds.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | w | `by_slip` | wheel speed that the slip of the torque makes up [rad/s] |
//! | V | `variance` | variance of the innovation without wavering: sensor, radius, relaxation, prediction |
//! | c^2 | `square` | variance of the slip, as a share of its square |
//! | nu | `innovation` | innovation of the wheel speed [rad/s] |
//!
//! On a rough road axle loads, and with them the slips, waver by far more than on asphalt. E nu^2 = V + c^2 w^2, so c^2 is the
//! weighted mean of (nu^2 - V)/w^2 over the last rows, never below what the settings say, which count as much as a second of
//! rows. The weights, w^4/(V + c_b^2 w^2)^2, are those of least squares where c is what the settings say.
//!
//! Waves of a few hertz last many rows, which then tell the same: what c^2 has more than usual counts as often
//! (`wheel_noise`, `TOGETHER`). Under loads that waver by c the mean slip is larger by c^2, E 1/(1 + e) = 1 + c^2 + .., and nobody
//! says on which axle: the interval of what the slips tell carries it. Before the first rows nobody knows the road, so a rough
//! one counts as some of them (`ROUGH_ROWS`).

/// How far back rows count [s].
const MEMORY: f64 = 20.0;
/// The settings' share counts as so many rows that only waver.
const PRIOR_ROWS: f64 = 100.0;
/// At the start nobody knows the road: c of a rough one counts as so many rows.
const ROUGH: f64 = 0.12;
const ROUGH_ROWS: f64 = 16.0;
/// An innovation of more standard deviations than this counts as this many: an outlier is no road.
const MOST: f64 = 5.0;

/// The wavering of the slips.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SlipFluctuation {
    /// Weighted sum of c^2, and sum of the weights, in c_b^4.
    sums: [f64; 2],
}

impl Default for SlipFluctuation {
    fn default() -> Self {
        Self {
            sums: [ROUGH_ROWS * ROUGH * ROUGH, ROUGH_ROWS],
        }
    }
}

/// What a row says of one wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Wavering {
    pub by_slip: f64,
    pub variance: f64,
}

impl SlipFluctuation {
    /// c^2, at least `usual` (c_b^2).
    pub fn square(&self, usual: f64) -> f64 {
        let [sum, weight] = self.sums;
        ((sum + PRIOR_ROWS * usual) / (weight + PRIOR_ROWS)).max(usual)
    }

    /// Takes a row's innovation of a wheel [rad/s].
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

    /// Forgets over `dt` [s].
    pub fn forget(&mut self, dt: f64) {
        let kept = 1.0 - (dt / MEMORY).min(1.0);
        self.sums = self.sums.map(|sum| kept * sum);
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
        // Four seconds of slips that waver as usual.
        for k in 0..400 {
            let size = (row.variance + usual * 0.01).sqrt();
            fluctuation.see(if k % 2 == 0 { size } else { -size }, &row, 0.05);
        }
        let then = fluctuation.square(usual).sqrt();
        assert!((0.05..0.057).contains(&then), "{then}");
    }

    #[test]
    fn slips_that_waver_are_found_and_no_less_than_usual_is_believed() {
        // 740 of 840 rows are the new ones.
        assert!((found(0.3, 0.05) / 0.3 - 1.0).abs() < 0.1);
        assert!((found(0.02, 0.05) - 0.05).abs() < 1e-12);
        // Rows without slips tell nothing: what is left is a row of the start's twenty, after three times the memory.
        let left = found(0.3, 0.0);
        assert!((0.05..0.0512).contains(&left), "{left}");
    }
}

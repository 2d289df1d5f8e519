//! What the slips of each axle tell of the ratio, to first order.
//!
//! An axle that pulls with F slips by s = F/(K N), so its slips tell K N. The ratio lam comes from both axles, whatever K is, or
//! from one axle and what is known of K. With a_f = ln(K lam), a_r = ln(K (1 - lam)), each told with a relative error e,
//! ```text
//! information on (ln K, lam) = [1/e_K^2, 0; 0, 1/sigma_0^2] + j_f j_f'/e_f^2 + j_r j_r'/e_r^2,
//! j_f = [1, 1/lam],  j_r = [1, -1/(1 - lam)],  e_i^2 = sigma_s^2 T/int s_i^2 dt
//! ```
//! The filter also uses terms of second order in the force: load that moves to the other axle, tyres that saturate. Pitching and another
//! tyre law blur them, and where one axle alone pulls they are all that tells K from lam. So they never make the ratio surer than this.

use crate::Quantity;
use crate::math::sqrt;

/// Slip that no force explains, and for how long it stays alike [s]: an axle that slips by .01 for 10 s tells its K N to 1 %. With .0012
/// four of eight sound machines lose .07 to .18 of their trust, with this none.
const UNEXPLAINED_SLIP: f64 = 0.0005;
const ALIKE: f64 = 0.3;
/// Slower than this wheels say nothing [m/s].
const SLOWEST: f64 = 0.5;

/// How much each axle has slipped by its pull: integrals of the squared slips [s], front and rear.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Axles {
    slipped: [f64; 2],
}

impl Axles {
    /// Takes `dt` at a speed [m/s] in which pulls make the axles slip so.
    pub fn see(&mut self, slips: [f64; 2], speed: f64, dt: f64) {
        if speed.abs() > SLOWEST {
            for (slipped, slip) in self.slipped.iter_mut().zip(slips) {
                let tells = slip * slip * dt;
                if tells.is_finite() {
                    *slipped += tells;
                }
            }
        }
    }

    /// Standard deviation of the ratio, with a relative deviation `stiffness_std` of K beforehand; `ratio`: now, and its
    /// deviation beforehand.
    pub fn ratio_std(&self, ratio: Quantity, stiffness_std: f64) -> f64 {
        let told = self
            .slipped
            .map(|slipped| slipped / (UNEXPLAINED_SLIP * UNEXPLAINED_SLIP * ALIKE));
        let by_ratio = [1.0 / ratio.value, -1.0 / (1.0 - ratio.value)];
        let mut of_stiffness = 1.0 / (stiffness_std * stiffness_std);
        let mut of_ratio = 1.0 / (ratio.std * ratio.std);
        let mut shared = 0.0;
        for (told, by_ratio) in told.into_iter().zip(by_ratio) {
            of_stiffness += told;
            of_ratio += told * by_ratio * by_ratio;
            shared += told * by_ratio;
        }
        1.0 / sqrt(of_ratio - shared * shared / of_stiffness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEFORE: Quantity = Quantity {
        value: 0.48,
        std: 0.1,
    };

    fn driven(slips: [f64; 2], time: u32) -> f64 {
        let mut axles = Axles::default();
        (0..100 * time).for_each(|_| axles.see(slips, -2.0, 0.01));
        axles.ratio_std(BEFORE, 0.13)
    }

    #[test]
    fn both_axles_tell_the_ratio_and_one_alone_as_well_as_the_stiffness_is_known() {
        assert!((driven([0.0; 2], 10) - 0.1).abs() < 1e-12);
        assert!(driven([0.01; 2], 60) < 0.01);
        let one = driven([0.0, 0.02], 600);
        let known = 0.13 * (1.0 - BEFORE.value);
        let both = 1.0 / (1.0 / (known * known) + 100.0).sqrt();
        assert!((one / both - 1.0).abs() < 0.01, "{one} {both}");
    }

    #[test]
    fn a_standing_machine_and_no_number_tell_nothing() {
        let mut axles = Axles::default();
        axles.see([0.01; 2], 0.1, 1.0);
        axles.see([f64::NAN, f64::INFINITY], 2.0, 1.0);
        assert_eq!(axles, Axles::default());
    }
}

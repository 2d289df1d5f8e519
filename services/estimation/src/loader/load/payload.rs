//! Centre of gravity with a reported payload of known mass and place (feed-forward).
//!
//! ```text
//! M = m_e + m_p,  a = m_e/M
//! h = a h_0 + (m_p/M) h_p,   lam = a lam_0 + (m_p/M)(l + x_p)/l
//! ```
//! m_e, h_0 and lam_0 are those of the empty machine, l is the wheelbase. With a reported payload the states h and lam are h_0 and lam_0,
//! so taking up a load does not move them.

use crate::loader::layout::Each;
use crate::loader::physics::cg_model::Loading;
use crate::math::sqrt;

/// A known payload with its standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Payload {
    /// Mass m_p \[kg\].
    pub mass: f64,
    /// Its standard deviation \[kg\].
    pub mass_std: f64,
    /// Height h_p of its centre above ground \[m\].
    pub height: f64,
    /// Its standard deviation \[m\].
    pub height_std: f64,
    /// Distance x_p of its centre ahead of the front axle \[m\].
    pub overhang: f64,
    /// Its standard deviation \[m\].
    pub overhang_std: f64,
}

impl Payload {
    /// A payload with the usual errors: mass 5 %, height 0.10 m, overhang 0.05 m.
    pub fn new(mass: f64, height: f64, overhang: f64) -> Self {
        Self {
            mass,
            mass_std: 0.05 * mass.abs(),
            height,
            height_std: 0.10,
            overhang,
            overhang_std: 0.05,
        }
    }

    pub(in crate::loader) fn is_valid(&self) -> bool {
        let fields = [
            self.mass,
            self.mass_std,
            self.height,
            self.height_std,
            self.overhang,
            self.overhang_std,
        ];
        fields.iter().all(|x| x.is_finite()) && self.mass >= 0.0
    }

    /// Effect on the centre of gravity of an empty machine.
    pub(in crate::loader) fn loading(&self, empty_mass: f64, wheelbase: f64) -> Loading {
        let total = empty_mass + self.mass;
        let part = self.mass / total;
        Loading {
            share: empty_mass / total,
            height: part * self.height,
            ratio: part * (wheelbase + self.overhang) / wheelbase,
        }
    }

    /// Standard deviations of the loaded centre of gravity, from those of the empty machine and of the payload.
    pub(in crate::loader) fn loaded_std(
        &self,
        empty_mass: f64,
        wheelbase: f64,
        centre: Each<f64>,
        std: Each<f64>,
    ) -> Each<f64> {
        let total = empty_mass + self.mass;
        let (share, part) = (empty_mass / total, self.mass / total);
        let arm = (wheelbase + self.overhang) / wheelbase;
        let norm = |a: f64, b: f64, c: f64| sqrt(a * a + b * b + c * c);
        let mass_std = self.mass_std / total;
        Each {
            ratio: norm(
                share * std.ratio,
                part * self.overhang_std / wheelbase,
                (arm - centre.ratio) * mass_std,
            ),
            height: norm(
                share * std.height,
                part * self.height_std,
                (self.height - centre.height) * mass_std,
            ),
        }
    }
}

//! A load that nobody tells: how probable it is that the bucket holds another than the one under which the ratio was learnt.
//!
//! A loader fills and empties its bucket slowly, and force over acceleration tells of it only when it drives again:
//! ```text
//! slow:     q+ = q + (1 - q) dt/T
//! driving:  q/(1 - q) *= exp[(r^2 - (r - d u)^2)/(2 R)],   r = a - kappa u + c sgn(v)
//! ```
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | q | `probability` | the load is another one | 1 |
//! | T | `BETWEEN` | slow time between two changes | s |
//! | kappa, c | - | as they were known before (`inertia`) | 1, m/s^2 |
//! | d | - | by how much another load would move kappa | 1 |
//! | u, a | - | force over the stated mass, acceleration | m/s^2 |

use super::inertia::{NOISE, Push, TOGETHER};
use crate::math::exp;

/// Slower than this a bucket is filled or emptied: penetration and dumping of a V cycle [m/s].
const SLOW: f64 = 1.5;
/// Slow time between two changes: a V cycle of 40 s has two, and is slow for half of it [s].
const BETWEEN: f64 = 10.0;
/// Share of the loaded machine that a usual load is: rated payload over operating mass with it.
pub(super) const USUAL_LOAD: f64 = 0.22;
/// From this share of it on the machine counts as loaded.
const HALF: f64 = 0.5;
/// A probability below this is none, and none is nearer to 1: no row is as certain as its noise says.
const LEAST: f64 = 1e-3;

/// Memory of what a bucket may hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct UnreportedLoad {
    probability: f64,
    /// kappa and c before the machine slowed down.
    before: Option<[f64; 2]>,
}

impl UnreportedLoad {
    /// Takes a row; `known` are kappa and c after it, `counts` where the torques alone move the machine.
    pub fn see(&mut self, row: &Push, known: [f64; 2], counts: bool, dt: f64) {
        if row.speed.abs() < SLOW {
            self.before.get_or_insert(known);
            self.probability += (1.0 - self.probability) * (dt / BETWEEN).min(1.0);
            return;
        }
        let Some([gain, rolling]) = self.before else {
            return;
        };
        if !counts {
            return;
        }
        let resists = rolling.copysign(row.speed);
        let residual = row.acceleration - gain * row.pull + resists;
        let loaded = gain < 1.0 - HALF * USUAL_LOAD;
        let other = residual - if loaded { USUAL_LOAD } else { -USUAL_LOAD } * row.pull;
        let noise = NOISE * NOISE * (TOGETHER / dt).max(1.0);
        let likelier = (residual * residual - other * other) / (2.0 * noise);
        let kept = (1.0 - self.probability).max(LEAST) * exp(-likelier);
        self.probability = (self.probability / (self.probability + kept)).min(1.0 - LEAST);
        // Neither a certain row nor a bad one leaves anything to learn.
        if self.probability.is_nan() || self.probability < LEAST {
            self.settle();
        }
    }

    /// What was learnt is of the load that is carried now.
    pub fn settle(&mut self) {
        *self = Self::default();
    }

    /// Probability of another load.
    pub fn probability(&self) -> f64 {
        self.probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stands for `slow` seconds, then drives with this kappa; the probability before and after.
    fn drive(slow: u32, kappa: f64) -> [f64; 2] {
        let mut unreported_load = UnreportedLoad::default();
        let row = |acceleration: f64, pull: f64, speed: f64| Push {
            acceleration,
            pull,
            speed,
        };
        (0..100 * slow)
            .for_each(|_| unreported_load.see(&row(0.0, 0.0, 0.2), [1.0, 0.2], true, 0.01));
        let before = unreported_load.probability();
        (0..300).for_each(|_| {
            unreported_load.see(&row(kappa * 0.8 - 0.2, 0.8, 2.0), [1.0, 0.2], true, 0.01);
        });
        [before, unreported_load.probability()]
    }

    #[test]
    fn a_slow_machine_may_hold_another_load_and_a_driven_one_shows_it() {
        assert_eq!(drive(0, 1.0), [0.0; 2]);
        let [slow, same] = drive(10, 1.0);
        assert!((0.6..0.7).contains(&slow) && same < 0.05, "{slow} {same}");
        let [_, loaded] = drive(10, 1.0 - USUAL_LOAD);
        assert!(loaded > 0.95, "{loaded}");
    }
}

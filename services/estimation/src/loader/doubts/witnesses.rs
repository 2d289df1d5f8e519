//! Comparison of two estimates (*witnesses*) of one centre of gravity: by the slips of the wheels, and by the weight that the lift
//! arm carries.
//!
//! They share only the empty machine and the payload. The one with the smaller deviation is reported. The other checks it, where
//! the slips are trusted by themselves:
//! ```text
//! z^2 = (lam_s - lam_w)^2/(sigma_s^2 + sigma_w^2),   averaged over some seconds
//! ```
//! Where they differ by more than both claim, or the content of the bucket would be negative, an assumption of one of them is
//! wrong. The data do not show which: the interval spans both, and neither is trusted.

use crate::Quantity;
use crate::loader::estimate::{Estimate, Status};
use crate::loader::lift_arm::Weighed;
use crate::loader::reason::Reason;
use crate::loader::settings::Settings;
use crate::math::sqrt;

/// Averaging time of the disagreement [s].
const MEMORY: f64 = 5.0;
/// Mean z^2 beyond which the witnesses disagree: 1 in 100 by chance.
const DIFFER: f64 = 6.6;
/// Largest standard deviation of a trusted payload, as a share of the machine's mass.
const KNOWN_PAYLOAD: f64 = 0.03;
/// Largest part of that deviation from the unknown place of the tilt cylinder, a twentieth of the rated payload. Of two places one
/// is true, and the mean of both is certainly off by its distance from either.
const UNDECIDED: f64 = 0.5;

/// State of the comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Witnesses {
    /// Mean z^2.
    apart: f64,
}

impl Witnesses {
    /// Merges `weighed` into `answer`, which is that of the slips, `dt` after the one before.
    pub fn judge(
        &mut self,
        settings: &Settings,
        answer: &mut Estimate,
        weighed: &Weighed,
        dt: f64,
    ) {
        let slips = [answer.cg_ratio, answer.cg_height];
        if answer.trusted_ratio && !weighed.carried.open {
            self.compare(slips[0], weighed.ratio, dt);
        }
        let differ = self.apart > DIFFER || weighed.wrong;
        let (ratio, by_weight) = sharper(slips[0], weighed.ratio, answer.trusted_ratio);
        let (height, height_by_weight) = sharper(slips[1], weighed.height, answer.trusted_height);
        let spanned = |one: Quantity, other: Quantity| Quantity {
            std: sqrt(one.std * one.std + (one.value - other.value) * (one.value - other.value)),
            ..one
        };
        (answer.cg_ratio, answer.cg_height) = if differ {
            (
                spanned(weighed.ratio, slips[0]),
                spanned(weighed.height, slips[1]),
            )
        } else {
            (ratio, height)
        };
        answer.cg_distance = (1.0 - answer.cg_ratio.value) * settings.machine.wheelbase;
        answer.payload = Some(weighed.payload);
        // Pressures show a load change directly, wheels only indirectly. From a bucket on the ground, nothing leaves that was carried.
        answer.changing = weighed.carried.open && !weighed.carried.rests;
        let limits = &settings.estimator;
        let (ratio, height) = (answer.cg_ratio, answer.cg_height);
        answer.converged_ratio = ratio.std <= limits.converged_ratio * ratio.value.abs();
        answer.converged_height = height.std <= limits.converged_height;
        let trusted = !weighed.carried.open && !differ && answer.status != Status::Diverged;
        if by_weight || differ {
            (answer.excited_ratio, answer.identifiable_ratio) = (true, true);
            answer.trusted_ratio = trusted && answer.converged_ratio;
        }
        if height_by_weight || differ {
            (answer.excited_height, answer.identifiable_height) = (true, true);
            answer.trusted_height = trusted && answer.converged_height;
        }
        if by_weight && height_by_weight {
            // The weight does not depend on what the slips lack.
            (answer.fresh, answer.consistent, answer.reason) = (true, true, Reason::None);
        }
        let known = KNOWN_PAYLOAD * weighed.carried.mass;
        // The interval includes the error of the gain at a load. Work does not identify it, so the limit of trust leaves it out.
        let (std, gain) = (weighed.payload.std, weighed.gain_left);
        let is_precise = std * std - gain * gain <= known * known;
        answer.trusted_payload = trusted && is_precise && weighed.undecided <= UNDECIDED * known;
        if differ {
            let reason = if weighed.wrong {
                Reason::LiftCylinder
            } else {
                Reason::Disagreement
            };
            (answer.consistent, answer.reason) = (false, reason);
        } else if weighed.carried.open {
            answer.reason = Reason::Load;
        }
        if weighed.silent {
            (answer.fresh, answer.reason) = (false, Reason::Missing);
            (answer.trusted_ratio, answer.trusted_height) = (false, false);
        }
    }

    fn compare(&mut self, slips: Quantity, weight: Quantity, dt: f64) {
        let away = slips.value - weight.value;
        let square = away * away / (slips.std * slips.std + weight.std * weight.std);
        if square.is_finite() {
            self.apart += (dt / MEMORY).clamp(0.0, 1.0) * (square - self.apart);
        }
    }
}

/// Returns the estimate with the smaller deviation, and whether it is that of the weight. Slips count only where they are trusted.
fn sharper(slips: Quantity, weight: Quantity, trusted: bool) -> (Quantity, bool) {
    if trusted && slips.std < weight.std {
        (slips, false)
    } else {
        (weight, true)
    }
}

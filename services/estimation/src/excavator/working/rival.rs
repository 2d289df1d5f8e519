//! Are torque and velocity still measured as they were before the machine stood?
//!
//! A torque that is wrong by a factor, and a velocity that is by its inverse, look like another inertia, and what the bucket
//! holds is not known. But damping and friction are known from before, and do not change. So a second filter goes along
//! from each standstill on, with the gain of the torque reopened, and the likelihoods of the innovations tell the two
//! apart (a generalised likelihood ratio; Willsky and Jones 1976).

use super::filter::{Filter, GAIN, Input, M};
use crate::kalman::Innovation;
use crate::math::{exp, ln};

/// Standard deviation of the factor by which a sensor may be wrong.
const FACTOR: f64 = 0.3;
/// Probability that one has broken since the last swing.
const BEFOREHAND: f64 = 0.001;
/// Logarithm of the likelihood ratio that says it has: odds of 160 to 1.
const EVIDENCE: f64 = 12.0;

/// The second filter.
// One of them is made per machine, in place: there is no allocator to box it with.
#[expect(clippy::large_enum_variant)]
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum Rival {
    /// The machine stands: what was known of the sensors may have changed.
    #[default]
    Resting,
    /// It goes along; the logarithm of its likelihood over the filter's.
    Going(Filter, f64),
    /// It has won in this swing.
    Won,
}

impl Rival {
    /// Goes along from here on, if the machine stood.
    pub(super) fn set_off(&mut self, filter: &Filter) {
        if let Self::Resting = self {
            let mut rival = filter.clone();
            rival.p[GAIN][GAIN] += FACTOR * FACTOR;
            *self = Self::Going(rival, 0.0);
        }
    }

    /// The machine stands; whether it did not before.
    pub(super) fn is_over(&mut self) -> bool {
        !matches!(core::mem::take(self), Self::Resting)
    }

    /// One tick: what drives both, the velocity with its variance, and the innovation of the filter. The rival itself where
    /// it has won.
    pub(super) fn step(
        &mut self,
        input: &Input,
        (width, least): (f64, f64),
        measured: Option<(f64, f64)>,
        gate: f64,
        innovation: Innovation,
        disagreement: f64,
    ) -> Option<Filter> {
        let Self::Going(rival, evidence) = self else {
            return None;
        };
        rival.predict(input, width, least, &mut None);
        let (velocity, variance) = measured?;
        let other = rival.correct(velocity, variance, gate, &mut None);
        let squares = [innovation, other].map(|i| i.nis().min(gate * gate));
        let volumes = ln(innovation.variance / other.variance);
        *evidence += 0.5 * (squares[0] - squares[1] + volumes) / disagreement;
        if *evidence < EVIDENCE {
            return None;
        }
        match core::mem::replace(self, Self::Won) {
            Self::Going(rival, _) => Some(rival),
            _ => None,
        }
    }

    /// Mean square by which a payload is off that the filter gives, as far as the rival may be right [kg^2].
    pub(super) fn variance(&self, payload: f64) -> f64 {
        let Self::Going(rival, evidence) = self else {
            return 0.0;
        };
        let odds = BEFOREHAND * exp(evidence.min(EVIDENCE));
        let difference = rival.x[M] - payload;
        odds / (1.0 + odds) * (rival.p[M][M].max(0.0) + difference * difference)
    }

    /// Whether its numbers are sound.
    pub(super) fn is_sound(&self) -> bool {
        match self {
            Self::Going(rival, evidence) => rival.is_sound() && evidence.is_finite(),
            _ => true,
        }
    }
}

//! Mode D: torque and posture. One filter, two filters side by side on a calibrated machine,
//! or the default for an uncalibrated one ([`Working`]).

use crate::excavator::changing_payload::ChangingPayload;
use crate::excavator::drive::Drive;
use crate::excavator::payload::{Change, Model, Outcome, PayloadFilter, reading};
use crate::excavator::settings::{Settings, Variant};
use crate::excavator::standstill::Phase;
use crate::excavator::state::State;
use crate::excavator::working::{Trail, Working};

/// Mode D in any variant.
// There is one per machine, in place, and no allocator to box it.
#[expect(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) enum PostureTorque {
    /// One filter.
    Plain(Model, PayloadFilter),
    /// Two filters side by side, on a calibrated machine.
    Auto(ChangingPayload),
    /// The default, on an uncalibrated machine.
    Working(Working),
}

impl PostureTorque {
    pub(in crate::excavator) fn new(settings: &Settings) -> Self {
        match (settings.estimator.variant, &settings.doubts) {
            (Variant::Auto, Some(doubts)) => Self::Working(Working::new(settings, doubts)),
            (Variant::Auto, None) => Self::Auto(ChangingPayload::new(settings)),
            (variant, _) => {
                let model = Model::new(settings, variant == Variant::Known);
                Self::Plain(model, PayloadFilter::new(&model))
            }
        }
    }

    /// Takes one tick; `reopen` after a long stand. The default estimator writes its step into `trail`.
    pub(in crate::excavator) fn step(
        &mut self,
        settings: &Settings,
        drive: &Drive,
        (phase, reopen): (Phase, bool),
        trail: &mut Option<Trail>,
    ) -> State {
        match self {
            Self::Plain(model, filter) => {
                if reopen {
                    filter.reopen(model);
                }
                let outcome = if phase == Phase::Moving {
                    filter.step(model, drive, Change::default())
                } else {
                    filter.rest(model, drive, phase);
                    Outcome::default()
                };
                reading(model, filter, drive, &outcome, filter.payload().1, false)
            }
            Self::Auto(auto) => auto.step(drive, phase, reopen),
            Self::Working(working) => working.step(settings, drive, phase, trail),
        }
    }

    /// The default estimator, which can record a trail.
    pub(in crate::excavator) fn working(&mut self) -> Option<&mut Working> {
        match self {
            Self::Working(working) => Some(working),
            _ => None,
        }
    }

    /// Whether the numbers of the filters are finite, without negative variances.
    pub(in crate::excavator) fn is_sound(&self) -> bool {
        match self {
            Self::Plain(_, filter) => filter.is_sound(),
            Self::Auto(auto) => auto.is_sound(),
            Self::Working(working) => working.is_sound(),
        }
    }
}

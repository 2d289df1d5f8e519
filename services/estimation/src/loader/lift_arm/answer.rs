//! Answer of a row: payload, mass and centre of gravity with all deviations.

use core::ops::Deref;

use super::LiftWitness;
use super::changed::DOUBTED;
use super::geometry::Empty;
use super::numbers::{EMPTY_MASS, TURN};
use super::steps::AngleSteps;
use crate::Quantity;
use crate::loader::layout::Each;
use crate::loader::physics::cg_model::Loading;
use crate::math::{norm, sqrt};

/// What the machine carries in a row: input to the slip-based filter, whose states are those of the empty machine.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::loader) struct Carried {
    /// Mass of the machine with its load [kg].
    pub mass: f64,
    /// Effect of load and arm on the empty machine's centre of gravity.
    pub loading: Loading,
    /// Standard deviations of ratio and height given the empty machine [-, m].
    pub loading_std: [f64; 2],
    /// The content may be changing, or the ground may carry a part of it.
    pub open: bool,
    /// The ground may carry a part of it.
    pub rests: bool,
}

/// Estimate of a row from the pressures.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::loader) struct Weighed {
    /// Payload, not limited to positive values: an empty bucket may show less than 0 [kg].
    pub payload: Quantity,
    /// Front-axle load fraction.
    pub ratio: Quantity,
    /// Height of the centre of gravity [m].
    pub height: Quantity,
    /// Input to the slip-based filter.
    pub carried: Carried,
    /// Standard deviation of the payload by an unknown place of the tilt cylinder; 0 where the bucket turn is stated [kg].
    pub undecided: f64,
    /// Standard deviation by the pressure's gain at a load, included in that of the payload [kg]. Only a weighed load identifies it.
    pub gain_left: f64,
    /// The stated deviations do not explain the pressures (`below`), or a sensor has probably changed (beyond `DOUBTED`).
    pub wrong: bool,
    /// Signals of the arm are missing or too old: this is a prediction since the last weight (`silence`).
    pub silent: bool,
}

/// Estimate of a row, or a prediction where signals are missing.
pub(in crate::loader) enum Said<'a> {
    Weighed(&'a Weighed),
    Silent(Weighed),
}

impl Deref for Said<'_> {
    type Target = Weighed;

    fn deref(&self) -> &Weighed {
        match self {
            Self::Weighed(weighed) => weighed,
            Self::Silent(weighed) => weighed,
        }
    }
}

impl LiftWitness {
    /// Centre of gravity with this payload, with all deviations. `moved`: the machine with its arm one deviation away, where the angles
    /// are not measured. `open`: the content is not known.
    pub(super) fn answer(
        &self,
        machine: &Empty,
        moved: &Empty,
        payload: Quantity,
        open: bool,
    ) -> Weighed {
        let drawing = &self.drawing;
        let centre = machine.with(payload.value);
        // An emptied bucket does not identify the gain at the pressure of a load.
        let gain_left = drawing.gain_left_std * payload.value.max(0.0);
        // With a changed sensor the content may be anything up to the capacity.
        let changed = self.changed();
        let anything = sqrt(changed) * drawing.capacity;
        let std = norm(&[payload.std, gain_left, anything]);
        let more = moved.with(payload.value + std);
        let rows = [std, more.ratio - centre.ratio, more.height - centre.height];
        let shown = self
            .doubts
            .doubted(payload.value, centre, rows, self.below.factor());
        // While the content may be changing, the deviation is mostly that of the content itself: the bound at 0 is not applied.
        let widened = if open {
            shown
        } else {
            shown.not_less_than_nothing()
        };
        let mass = drawing.values[EMPTY_MASS] + widened.payload.value;
        let share = drawing.values[EMPTY_MASS] / mass;
        let (empty, Each { ratio, height }) = (self.empty(), widened.centre);
        Weighed {
            payload: shown.payload,
            ratio,
            height,
            carried: Carried {
                mass,
                loading: Loading {
                    share,
                    height: height.value - share * empty.height.0,
                    ratio: ratio.value - share * empty.ratio.0,
                },
                loading_std: [widened.moved.ratio, widened.moved.height],
                open,
                rests: false,
            },
            undecided: self.linkage.map_or(0.0, |_| self.doubts.of_payload(TURN)),
            gain_left,
            wrong: !self.below.explains(shown.payload) || changed > DOUBTED,
            silent: false,
        }
    }

    /// Probability that a sensor of the arm has changed.
    fn changed(&self) -> f64 {
        if self.angle_steps.iter().any(AngleSteps::has_stepped) {
            1.0
        } else {
            let (emptied, moved) = (self.changed.probability(), self.inertial.probability());
            if emptied > moved { emptied } else { moved }
        }
    }
}

//! A load that is known beside the slips: reported, or weighed by the lift pressure. With it the states h, lam are those of the
//! empty machine.

use super::mass_step::Centre;
use super::payload::Payload;
use crate::loader::keys::{Machine, Prior};
use crate::loader::layout::Each;
use crate::loader::lift_arm::Weighed;
use crate::loader::physics::cg_model::Loading;
use crate::math::norm;

/// What is known of the load.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct KnownLoad {
    reported: Option<Payload>,
    /// What the lift pressure says of this row.
    weighed: Option<Weighed>,
    /// What the error of a weighed load has left in the ratio of the empty machine, as a standard deviation: what the slips showed of
    /// that one they showed under a load. Errors of many loads may have one cause, such as a lever, so none average out.
    left: f64,
}

impl KnownLoad {
    /// The states are those of the empty machine.
    pub fn is_some(&self) -> bool {
        self.reported.is_some() || self.weighed.is_some()
    }

    /// The content of the bucket is being weighed, and may be changing.
    pub fn is_open(&self) -> bool {
        self.weighed.as_ref().is_some_and(|weighed| weighed.open)
    }

    /// Takes a payload for the rows to come; one that is not finite is ignored.
    pub fn report(&mut self, payload: Option<Payload>) {
        if payload.is_none_or(|p| p.is_valid()) {
            self.reported = payload;
        }
    }

    /// Takes what the lift pressure says of the next row. Where it begins to, or ceases, height and ratio mean another machine, with
    /// its load or without: the centre of gravity that is known of that one.
    pub fn weigh(
        &mut self,
        weighed: Option<Weighed>,
        prior: &Prior,
        empty: Each<(f64, f64)>,
    ) -> Option<Centre> {
        let is_same = weighed.is_some() == self.weighed.is_some();
        self.weighed = weighed;
        if is_same {
            return None;
        }
        self.left = 0.0;
        if weighed.is_none() {
            return Some(prior.centre());
        }
        let Each { height, ratio } = empty;
        let usual = prior.cg_height_std / prior.cg_height * height.0;
        Some([
            (height.0, height.1.max(usual)),
            (ratio.0, ratio.1.max(prior.cg_ratio_std)),
        ])
    }

    /// A row has informed the ratio under a load, with this gain of its error.
    pub fn learn(&mut self, gain: impl FnOnce() -> f64) {
        if let Some(weighed) = &self.weighed {
            let doubt = weighed.loading_std[0] / weighed.loading.share;
            self.left += gain() * (doubt - self.left);
        }
    }

    /// What it adds to the empty machine.
    pub fn loading(&self, machine: &Machine) -> Loading {
        let reported = self
            .reported
            .map(|p| p.loading(machine.mass, machine.wheelbase));
        let weighed = self.weighed.map(|w| w.loading);
        reported.or(weighed).unwrap_or(Loading::NONE)
    }

    /// Mass of the machine with it [kg].
    pub fn mass(&self, machine: &Machine) -> Option<f64> {
        let reported = self.reported.map(|p| machine.mass + p.mass);
        reported.or(self.weighed.map(|w| w.mass))
    }

    /// Centre of gravity with it and standard deviations, from those of the states.
    pub fn loaded(
        &self,
        machine: &Machine,
        own: Each<f64>,
        std: Each<f64>,
    ) -> (Each<f64>, Each<f64>) {
        let with = |loading: Loading| Each {
            ratio: loading.share * own.ratio + loading.ratio,
            height: loading.share * own.height + loading.height,
        };
        if let Some(weighed) = &self.weighed {
            let share = weighed.loading.share;
            let [of_ratio, of_height] = weighed.loading_std;
            let std = Each {
                ratio: norm(&[share * std.ratio, share * self.left, of_ratio]),
                height: norm(&[share * std.height, of_height]),
            };
            return (with(weighed.loading), std);
        }
        let Some(payload) = &self.reported else {
            return (own, std);
        };
        let (mass, wheelbase) = (machine.mass, machine.wheelbase);
        let centre = with(payload.loading(mass, wheelbase));
        (centre, payload.loaded_std(mass, wheelbase, centre, std))
    }
}

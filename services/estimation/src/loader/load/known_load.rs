//! A load known independently of the slips: weighed by the lift pressure, or reported. With it the states h and lam are those of the empty
//! machine.
//!
//! Where both are known, the weighed load counts in the mass, in the model and in the answer. It is of this row and posture, while a
//! report holds until the next one, and it detects an unreported dump. The states restart with the weighing, as those of the empty machine
//! with its arm at the reference. While the arm's signals are missing, the report counts again.

use super::mass_step::Centre;
use super::payload::Payload;
use crate::loader::keys::{Machine, Prior};
use crate::loader::layout::Each;
use crate::loader::lift_arm::Carried;
use crate::loader::physics::cg_model::Loading;
use crate::math::norm;

/// A load by its source.
enum Load<'a> {
    Weighed(&'a Carried),
    Reported(&'a Payload),
}

/// The known loads.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct KnownLoad {
    /// Last reported load.
    reported: Option<Payload>,
    /// Load of this row by the lift pressure.
    weighed: Option<Carried>,
    /// Standard deviation of the empty machine's ratio by errors of weighed loads: the slips measure the loaded machine. Errors of many
    /// loads may have one cause, such as a lever, so they do not average out.
    left: f64,
}

impl KnownLoad {
    /// The states are those of the empty machine.
    pub fn is_some(&self) -> bool {
        self.reported.is_some() || self.weighed.is_some()
    }

    /// A load is reported.
    pub fn is_reported(&self) -> bool {
        self.reported.is_some()
    }

    /// The content is weighed, and may be changing.
    pub fn is_open(&self) -> bool {
        self.weighed.as_ref().is_some_and(|weighed| weighed.open)
    }

    /// Sets the reported payload of the following rows; one that is not finite, or negative, is ignored.
    pub fn report(&mut self, payload: Option<Payload>) {
        if payload.is_none_or(|p| p.is_valid()) {
            self.reported = payload;
        }
    }

    /// Sets the weighed load of the next row. Where weighing begins or ends, the states change their meaning (machine without or with its
    /// load): returns the prior of the new one.
    pub fn weigh(
        &mut self,
        weighed: Option<Carried>,
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

    /// Updates `left` with a row that has updated the ratio under a load; `gain`: share of the load's error in the ratio.
    pub fn learn(&mut self, gain: impl FnOnce() -> f64) {
        if let Some(weighed) = &self.weighed {
            let doubt = weighed.loading_std[0] / weighed.loading.share;
            self.left += gain() * (doubt - self.left);
        }
    }

    /// The load that counts.
    fn load(&self) -> Option<Load<'_>> {
        let reported = self.reported.as_ref().map(Load::Reported);
        self.weighed.as_ref().map(Load::Weighed).or(reported)
    }

    /// Effect of the load on the empty machine.
    pub fn loading(&self, machine: &Machine) -> Loading {
        match self.load() {
            Some(Load::Weighed(weighed)) => weighed.loading,
            Some(Load::Reported(payload)) => payload.loading(machine.mass, machine.wheelbase),
            None => Loading::NONE,
        }
    }

    /// Mass of the machine with its load [kg].
    pub fn mass(&self, machine: &Machine) -> Option<f64> {
        self.load().map(|load| match load {
            Load::Weighed(weighed) => weighed.mass,
            Load::Reported(payload) => machine.mass + payload.mass,
        })
    }

    /// Centre of gravity with the load, and standard deviations, from those of the states.
    pub fn loaded(
        &self,
        machine: &Machine,
        own: Each<f64>,
        std: Each<f64>,
    ) -> (Each<f64>, Each<f64>) {
        let Some(load) = self.load() else {
            return (own, std);
        };
        let loading = self.loading(machine);
        let share = loading.share;
        let centre = Each {
            ratio: share * own.ratio + loading.ratio,
            height: share * own.height + loading.height,
        };
        let std = match load {
            Load::Weighed(weighed) => {
                let [of_ratio, of_height] = weighed.loading_std;
                Each {
                    ratio: norm(&[share * std.ratio, share * self.left, of_ratio]),
                    height: norm(&[share * std.height, of_height]),
                }
            }
            Load::Reported(payload) => {
                payload.loaded_std(machine.mass, machine.wheelbase, centre, std)
            }
        };
        (centre, std)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loader::Settings;

    const EMPTY: Each<f64> = Each {
        ratio: 0.4,
        height: 1.0,
    };
    const STD: Each<f64> = Each {
        ratio: 0.01,
        height: 0.1,
    };

    /// A load of half the machine's mass, so that no report is near it.
    fn weighed(machine: &Machine) -> Carried {
        Carried {
            mass: 1.5 * machine.mass,
            loading: Loading {
                share: 1.0 / 1.5,
                height: 0.5,
                ratio: 0.4,
            },
            loading_std: [0.02, 0.03],
            open: false,
            rests: false,
        }
    }

    #[test]
    fn a_weighed_load_counts_before_a_reported_one_in_mass_model_and_answer() {
        let Settings { machine, prior, .. } = Settings::default();
        let empty = Each {
            ratio: (0.4, 0.01),
            height: (1.0, 0.1),
        };
        let by_weight = Some(weighed(&machine));
        let [mut both, mut alone] = [KnownLoad::default(); 2];
        both.report(Some(Payload::new(1000.0, 1.5, 1.35)));
        let reported = both.mass(&machine);
        for load in [&mut both, &mut alone] {
            load.weigh(by_weight, &prior, empty);
        }
        assert_eq!(both.mass(&machine), alone.mass(&machine));
        assert_eq!(both.loading(&machine), alone.loading(&machine));
        let answers = [both, alone].map(|load| load.loaded(&machine, EMPTY, STD));
        assert_eq!(answers[0], answers[1]);
        // The arm's signals are missing: the report still holds.
        both.weigh(None, &prior, empty);
        assert_eq!(both.mass(&machine), reported);
        assert_eq!(reported, Some(machine.mass + 1000.0));
    }
}

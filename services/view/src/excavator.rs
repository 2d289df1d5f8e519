//! Presentation of the excavator: its parameters, and its own words and panels.

pub mod figures;
mod panels;
mod words;

#[cfg(test)]
pub(crate) use words::REMEDIES;
pub(crate) use words::load_advice;

use messages::{ExcavatorEstimate, ExcavatorTruth, Machine, excavator_bits as bits};

use sheet::count_shown;
use sheet::excavator::QUANTITIES;

use crate::estimate::{Estimate, InnovationRule, Parameter, parameters};
use crate::judgement::Judgement;
use crate::panels::Panel;

impl Estimate for ExcavatorEstimate {
    type Truth = ExcavatorTruth;
    const MACHINE: Machine = Machine::Excavator;
    const INNOVATION: InnovationRule = InnovationRule {
        window: 50,
        measurements: 1.0,
        limit: 1.8,
    };
    const PARAMETERS: &'static [Parameter<Self, ExcavatorTruth>] =
        &parameters::<_, _, { count_shown(QUANTITIES) }>(QUANTITIES);
    const CONDITIONS: &'static [(&'static str, u32)] = &[
        ("excited", bits::EXCITED),
        ("consistent", bits::CONSISTENT),
        ("fresh", bits::FRESH),
        ("converged", bits::CONVERGED),
        ("identifiable", bits::IDENTIFIABLE),
        ("trusted", bits::TRUSTED),
    ];
    const MOTION_NAME: (&'static str, f64) = ("swing", 0.05);
    const STRETCH: &'static [&'static str] = &["inertia", "payload"];
    const LOAD_EACH: bool = true;

    fn motion(&self) -> f64 {
        self.velocity.abs()
    }

    fn nis(&self) -> f64 {
        self.nis
    }

    fn judgements(&self) -> Vec<Judgement> {
        vec![words::inertia(self)]
    }

    fn forgetting(&self) -> Vec<f64> {
        [
            self.forgetting_inertia,
            self.forgetting_damping,
            self.forgetting_torque,
        ]
        .to_vec()
    }

    fn own_panels(estimates: &[Self]) -> Vec<Panel> {
        panels::forgetting(estimates)
            .into_iter()
            .chain(panels::activity(estimates))
            .collect()
    }
}

//! Presentation of the wheel loader: its parameters and its own words.

pub mod figures;
mod words;

#[cfg(test)]
pub(crate) use words::REMEDIES;
pub(crate) use words::load_advice;

use messages::{LoaderEstimate, LoaderTruth, Machine, loader_bits as bits};

use sheet::count_shown;
use sheet::loader::QUANTITIES;

use crate::estimate::{Estimate, InnovationRule, Parameter, parameters};
use crate::judgement::Judgement;

impl Estimate for LoaderEstimate {
    type Truth = LoaderTruth;
    const MACHINE: Machine = Machine::Loader;
    const INNOVATION: InnovationRule = InnovationRule {
        window: 400,
        measurements: 3.0,
        limit: 2.0,
    };
    const PARAMETERS: &'static [Parameter<Self, LoaderTruth>] =
        &parameters::<_, _, { count_shown(QUANTITIES) }>(QUANTITIES);
    const CONDITIONS: &'static [(&'static str, u32)] = &[
        ("consistent", bits::CONSISTENT),
        ("fresh", bits::FRESH),
        ("load fraction excited", bits::EXCITED_RATIO),
        ("load fraction converged", bits::CONVERGED_RATIO),
        ("load fraction trusted", bits::TRUSTED_RATIO),
        ("height excited", bits::EXCITED_HEIGHT),
        ("height converged", bits::CONVERGED_HEIGHT),
        ("height trusted", bits::TRUSTED_HEIGHT),
        ("payload trusted", bits::TRUSTED_PAYLOAD),
    ];
    const MOTION_NAME: (&'static str, f64) = ("drive", 0.3);
    const STRETCH: &'static [&'static str] = &["cg_ratio", "cg_height", "payload"];
    const LOAD_EACH: bool = false;

    fn motion(&self) -> f64 {
        self.speed.abs()
    }

    fn nis(&self) -> f64 {
        self.nis
    }

    fn judgements(&self) -> Vec<Judgement> {
        vec![words::position(self), words::height(self)]
    }
}

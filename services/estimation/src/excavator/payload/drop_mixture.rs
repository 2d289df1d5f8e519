//! Mode D with the older drop model, for comparison: a mixture of two copies of the filter. In the second one the
//! payload may drop.

use crate::excavator::consider::Consider;
use crate::excavator::drive::Drive;
use crate::excavator::payload::{Change, Model, Outcome, PayloadFilter, reading};
use crate::excavator::settings::Settings;
use crate::excavator::standstill::Phase;
use crate::excavator::state::State;
use crate::math::{exp, sqrt};

/// Mixture of two copies of the filter, with a constant and with a dropping payload.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct DropMixture {
    models: [Model; 2],
    pub(in crate::excavator) filters: [PayloadFilter; 2],
    probability: [f64; 2],
    started: bool,
}

/// Transition probabilities from model i to model j, per tick.
const TRANSITION: [[f64; 2]; 2] = [[0.998, 0.002], [0.03, 0.97]];

impl DropMixture {
    pub(in crate::excavator) fn new(settings: &Settings) -> Self {
        let model = Model::new(settings, false);
        let filter = PayloadFilter::new(&model);
        let kilogram = settings.geometry.payload_scale();
        let drop = settings.estimator.drop_q_m * kilogram * kilogram;
        let drop = model.with_payload_variance_rate(drop);
        Self {
            models: [model, drop],
            filters: [filter.clone(), filter],
            probability: [0.5; 2],
            started: false,
        }
    }

    /// Takes one tick; `reopen` after a long stand.
    pub(in crate::excavator) fn step(
        &mut self,
        drive: &Drive,
        phase: Phase,
        reopen: bool,
    ) -> State {
        if reopen {
            for (filter, model) in self.filters.iter_mut().zip(&self.models) {
                filter.reopen(model);
            }
        }
        let mut outcome = Outcome::default();
        if phase == Phase::Moving {
            if self.started {
                self.mix();
            }
            outcome = self.advance(drive);
        } else {
            for filter in &mut self.filters {
                filter.rest(&self.models[0], drive, phase);
            }
        }
        self.started = true;
        let mut mean = merge(&self.filters, self.probability);
        mean.limit(&self.models[0]);
        let mut state = reading(
            &self.models[0],
            &mean,
            drive,
            &outcome,
            mean.payload().1,
            false,
        );
        state.drop_probability = self.probability[1];
        state
    }

    fn mix(&mut self) {
        let mu = self.probability;
        let c: [f64; 2] =
            core::array::from_fn(|j| TRANSITION[0][j] * mu[0] + TRANSITION[1][j] * mu[1]);
        self.filters = core::array::from_fn(|j| {
            merge(
                &self.filters,
                core::array::from_fn(|i| TRANSITION[i][j] * mu[i] / c[j]),
            )
        });
        self.probability = c;
    }

    fn advance(&mut self, drive: &Drive) -> Outcome {
        let mut outcomes = [Outcome::default(); 2];
        for (j, slot) in outcomes.iter_mut().enumerate() {
            let outcome = self.filters[j].step(&self.models[j], drive, Change::default());
            let likelihood = if drive.velocity.is_some() {
                let nis = outcome.innovation.value * outcome.innovation.value / outcome.gated;
                exp(-0.5 * nis.min(100.0)) / sqrt(outcome.gated)
            } else {
                1.0
            };
            self.probability[j] = self.probability[j] * likelihood + 1e-12;
            *slot = outcome;
        }
        let sum = self.probability[0] + self.probability[1];
        self.probability = self.probability.map(|mu| mu / sum);
        outcomes[usize::from(self.probability[1] > 0.5)]
    }
}

/// Mean and covariance of a mixture, including the spread of the means.
fn merge(filters: &[PayloadFilter; 2], weights: [f64; 2]) -> PayloadFilter {
    let x = filters[0].x * weights[0] + filters[1].x * weights[1];
    let spread = |i: usize| {
        let d = filters[i].x - x;
        (filters[i].p + d * d.transpose()) * weights[i]
    };
    PayloadFilter {
        x,
        p: spread(0) + spread(1),
        doubt: Consider::mix(&filters[0].doubt, &filters[1].doubt, weights),
    }
}

//! The step as the paper prints it; beyond the paper, inputs are held and measurements may be missing.

use super::report::RowReport;
use super::update::measurements;
use super::{Belief, CgFilter};
use crate::loader::estimate::Status;
use crate::loader::measurements::conditions::Conditions;
use crate::loader::physics::cg_model::CgModel;
use crate::loader::sample::Sample;
use crate::loader::settings::Settings;

/// Standard deviation of a measurement that stands for "not measured".
const NOT_MEASURED_STD: f64 = 1e6;

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    pub(super) fn step_printed(
        &mut self,
        settings: &Settings,
        sample: &Sample,
        model: &CgModel,
    ) -> RowReport<M> {
        let process_std = self.process_std(settings, &Conditions::default(), false, model.dt);
        let measured = measurements::<M>(sample, None);
        let accepted = measured.map(f64::is_finite);
        let mut std = self.sensor_std(settings);
        for (std, accepted) in std.iter_mut().zip(accepted) {
            if !accepted {
                *std = NOT_MEASURED_STD;
            }
        }
        let Some(filter) = self.belief.sigma_points() else {
            return RowReport::without_update(Status::Diverged, false);
        };
        let printed = filter.step_printed(model, &process_std, &std, |predicted| {
            core::array::from_fn(|j| {
                if accepted[j] {
                    measured[j] - predicted[j]
                } else {
                    0.0
                }
            })
        });
        self.clamp(settings);
        RowReport {
            nis: printed.nis,
            accepted,
            ..RowReport::without_update(Status::Updated, false)
        }
    }
}

//! Which measurements are used, and with what weight.

use super::report::RowReport;
use super::{Belief, CgFilter};
use crate::loader::estimate::Status;
use crate::loader::layout::{FRONT_WHEEL, REAR_WHEEL};
use crate::loader::sample::Sample;
use crate::loader::settings::Settings;
use crate::math::sqrt;

/// Whether a measurement is used, and whether it is de-weighted; `std` grows in that case.
fn gate(
    settings: &Settings,
    innovation: f64,
    std: &mut f64,
    predicted_std: impl Fn() -> f64,
) -> (bool, bool) {
    if !innovation.is_finite() {
        return (false, false);
    }
    if !settings.protected() {
        return (true, false);
    }
    let keys = &settings.estimator;
    let predicted = predicted_std();
    let normalised = innovation.abs() / sqrt(*std * *std + predicted * predicted);
    if normalised >= keys.reject || normalised.is_nan() {
        return (false, false);
    }
    let soft = normalised > keys.gate;
    if soft {
        *std += innovation.abs() / keys.gate;
    }
    (true, soft)
}

impl<const N: usize, const M: usize, B: Belief<N, M>> CgFilter<N, M, B> {
    /// Gates every measurement of a row, and sets wheels aside while brakes act.
    pub(super) fn gates(
        &self,
        settings: &Settings,
        sample: &Sample,
        innovation: &[f64; M],
        std: &mut [f64; M],
        expected: &B::Expected,
    ) -> RowReport<M> {
        let mut report = RowReport::without_update(Status::Updated, false);
        for j in 0..M {
            (report.accepted[j], report.deweighted[j]) =
                gate(settings, innovation[j], &mut std[j], || {
                    B::measurement_std(expected, j)
                });
        }
        if settings.at_work() {
            // A held torque belongs to another time, and a wheel without its torque carries no information.
            let driven = sample.front_torque.is_some() && sample.rear_torque.is_some();
            let (braking, accepted) = (self.effect.braking, &mut report.accepted);
            report.set_aside = driven && braking && accepted[FRONT_WHEEL] && accepted[REAR_WHEEL];
            accepted[FRONT_WHEEL] &= driven && !braking;
            accepted[REAR_WHEEL] &= driven && !braking;
        }
        report
    }
}

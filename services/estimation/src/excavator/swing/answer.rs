//! Estimate of a row: the reading of the last tick, extrapolated to the row's time and posture.

use super::super::estimate::{Estimate, Flags, Sample};
use super::super::mode::Reading;
use super::super::reason::Reason;
use super::super::state::State;
use super::SwingEstimator;
use crate::Quantity;
use crate::math::sqrt;

/// Factor of the standard deviation with unknown torque and a velocity differenced from an angle, since changes of
/// torque are then detected late.
const ENCODER_WITHOUT_TORQUE: f64 = 3.0;
/// Growth of the relative standard deviation while the posture is stale [1/s].
const STALE_POSTURE: f64 = 0.3;

impl SwingEstimator {
    /// The estimate of a row; repeats the last one until there is a tick.
    pub(super) fn estimate(&self, sample: &Sample, reset: bool) -> Estimate {
        let Some(reading) = &self.reading else {
            let mut again = self.last;
            again.refused = self.screen.refused();
            again.method = self.method;
            again.flags = Flags {
                reset,
                held: true,
                ..Flags::default()
            };
            return again;
        };
        let state = self.at_row(reading, sample);
        let r = reading.reasons;
        let ahead = sample.time - reading.tick.time;
        let (needs_torque, _) = self.needs();
        Estimate {
            inertia: state.inertia,
            inertia_std: state.inertia_std,
            damping: state.damping.filter(|d| d.1 > 0.0).map(quantity),
            torque: if needs_torque {
                self.measured_torque(reading)
            } else {
                state.total_torque.map(quantity)
            },
            payload: state.payload.map(quantity),
            offset: state
                .offset
                .filter(|_| needs_torque)
                .map(|(d, std)| quantity((-d, std))),
            velocity: state.velocity + state.acceleration * ahead,
            acceleration: state.acceleration,
            nis: state.nis,
            flags: Flags {
                excited: r.excited,
                consistent: r.consistent,
                fresh: r.fresh,
                converged: r.converged,
                identifiable: r.identifiable && self.lateness() < 1.5,
                held: reading.held,
                changing: state.changing,
                reset,
                ..Flags::default()
            },
            method: self.method,
            refused: self.screen.refused(),
            reason: if self.screen.is_frozen() {
                Reason::Frozen
            } else if self.screen.has_jumped() {
                Reason::Jump
            } else if !r.fresh && state.reason.is_constant() {
                Reason::None
            } else {
                state.reason
            },
            ..Estimate::default()
        }
    }

    /// Measured torque, corrected by its offset and gain. It is late by its delay, and differs by what it changes in that time.
    fn measured_torque(&self, reading: &Reading) -> Option<Quantity> {
        let torque = self.grid.torque()?;
        let (offset, offset_std) = reading.state.offset.unwrap_or((0.0, 0.0));
        let (gain, gain_std) = reading
            .state
            .gain
            .unwrap_or((0.0, self.settings.sensors.swing_torque_gain_std));
        let noise = self.settings.sensors.swing_torque_std;
        let (measured, scale) = (torque + offset, 1.0 + gain);
        let variance = noise * noise * reading.tick.share + offset_std * offset_std;
        let by_gain = measured * gain_std;
        let (late, late_std) = (
            self.delays[1],
            self.settings.doubts.map_or(0.0, |d| d.delay_std),
        );
        let rate = self.grid.torque_rate();
        let by_delay = rate * rate * (late * late + late_std * late_std);
        let std = sqrt(scale * scale * variance + by_gain * by_gain + by_delay);
        Some(quantity((scale * measured, std)))
    }

    /// Factor of the standard deviation without torque. Those modes must detect changes of torque within 0.15 s. Rows slower
    /// than the grid and differenced angles delay that; the interval then widens, and the estimate is not trusted.
    fn lateness(&self) -> f64 {
        if self.needs().0 {
            return 1.0;
        }
        let encoder = if self.columns.velocity {
            1.0
        } else {
            ENCODER_WITHOUT_TORQUE
        };
        encoder * self.slowness
    }

    /// The reading at the posture of this row, which may be newer than that of the tick.
    fn at_row(&self, reading: &Reading, sample: &Sample) -> State {
        let mut state = reading.state;
        let posture = sample.posture;
        if let ((_, true), Some((mass, _)), [Some(boom), Some(arm), Some(bucket)]) =
            (self.needs(), state.payload, posture)
        {
            let (now, before) = ([boom, arm, bucket], reading.tick.posture);
            if now != before {
                let [now, before] = [now, before].map(|q| self.settings.geometry.inertia(q));
                state.inertia += now.with_payload(mass) - before.with_payload(mass);
                state.inertia_std *= now.per_payload / before.per_payload;
            }
        }
        let lateness = self.lateness();
        state.inertia_std *= lateness;
        state.payload = state.payload.map(|(mass, std)| (mass, std * lateness));
        let age = reading.tick.posture_age;
        if self.needs().1 && age.is_finite() && age > self.settings.estimator.fresh_others {
            let stale = (age - self.settings.estimator.fresh_others).min(3.0);
            let unknown = STALE_POSTURE * stale * state.inertia;
            state.inertia_std = sqrt(state.inertia_std * state.inertia_std + unknown * unknown);
        }
        state
    }
}

fn quantity((value, std): (f64, f64)) -> Quantity {
    Quantity { value, std }
}

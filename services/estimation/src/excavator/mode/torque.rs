//! Mode BM: torque without posture, in momentum form.
//!
//! ```text
//! p = J w,   l = ln J:   p' = T + d - T_f tanh(w/0.008) - b w,   l a random walk,   y = p exp(-l)
//! ```
//!
//! The unknown rate of the posture does not appear in p, which makes the mode possible: with the states w and J
//! the error is tens of percent while the arm moves. The mode needs a standstill in the record, where p is known
//! to be 0; after a start in mid-swing p is unknown.
//!
//! Damping and offset are held at their nominal values (`Auto`, `Known`) or estimated. Where they are held, their
//! uncertainty widens the interval (see [`crate::excavator::consider`]), unless the variant states that they are
//! known.
//!
//! The random walk of l is deliberately fast, so that l can follow the posture. Its variance then overstates the
//! error, and the reported standard deviation is c_I = 0.6 of it where the damping is held.

use crate::consistency::gated_variance;
use crate::excavator::consider::{Consider, Doubt};
use crate::excavator::drive::Drive;
use crate::excavator::settings::{Settings, Variant};
use crate::excavator::standstill::{Phase, released_variance};
use crate::excavator::state::State;
use crate::kalman::Innovation;
use crate::math::{exp, ln, sqrt, tanh};
use nalgebra::{Matrix4, Vector4};

/// Filter of momentum, ln J, torque offset and damping.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct TorqueMode {
    x: Vector4<f64>,
    p: Matrix4<f64>,
    /// Damping and offset are held fixed.
    fixed: bool,
    /// Errors due to damping, offset and torque gain.
    doubts: [Consider<4>; 3],
    gain_std: f64,
    prior_variance: f64,
}

impl TorqueMode {
    pub(in crate::excavator) fn new(settings: &Settings) -> Self {
        let (e, prior) = (&settings.estimator, &settings.prior);
        let fixed = matches!(e.variant, Variant::Auto | Variant::Known);
        let doubt = Doubt::new(settings);
        let (offset_std, damping_std) = if fixed {
            (prior.known_torque_offset_std, 0.0)
        } else {
            (prior.torque_offset_std, prior.damping_std)
        };
        let relative = prior.inertia_std / prior.inertia;
        let stds = Vector4::new(1.0, relative, offset_std, damping_std);
        Self {
            x: Vector4::new(0.0, ln(prior.inertia), 0.0, settings.nominal_damping),
            p: Matrix4::from_diagonal(&stds.component_mul(&stds)),
            fixed,
            doubts: [
                Consider::state(3, if fixed { doubt.damping } else { 0.0 }),
                Consider::state(2, if fixed { doubt.offset } else { 0.0 }),
                Consider::input(doubt.gain),
            ],
            gain_std: doubt.gain,
            prior_variance: relative * relative,
        }
    }

    pub(in crate::excavator) fn step(
        &mut self,
        settings: &Settings,
        drive: &Drive,
        phase: Phase,
        reopen: bool,
    ) -> State {
        if reopen && self.p[(1, 1)] < self.prior_variance {
            self.clear(1);
            self.p[(1, 1)] = self.prior_variance;
            self.doubts.iter_mut().for_each(|doubt| doubt.set(1, 0.0));
        }
        let (innovation, acceleration) = match phase {
            Phase::Moving => {
                let acceleration = self.predict(settings, drive);
                (self.correct(settings, drive), acceleration)
            }
            _ => {
                self.rest(settings, drive, phase);
                (Innovation::default(), 0.0)
            }
        };
        self.state(settings, innovation, acceleration)
    }

    #[expect(non_snake_case, reason = "the symbols of the model")]
    fn predict(&mut self, s: &Settings, drive: &Drive) -> f64 {
        let e = &s.estimator;
        let dt = drive.period;
        let inertia = exp(self.x[1]);
        let w = self.x[0] / inertia;
        let b = self.x[3];
        let th = tanh(w / e.friction_width);
        let slope = s.coulomb_friction * (1.0 - th * th) / e.friction_width;
        let f = drive.torque + self.x[2] - s.coulomb_friction * th - b * w;
        let mut F = Matrix4::identity();
        F[(0, 0)] = exp(-dt * (b + slope) / inertia);
        F[(0, 1)] = dt * (b + slope) * w;
        F[(0, 2)] = dt;
        F[(0, 3)] = -dt * w;
        self.x[0] += dt * f;
        self.p = F * self.p * F.transpose();
        let [damping, offset, gain] = &mut self.doubts;
        damping.predict(&F, 0.0);
        offset.predict(&F, 0.0);
        gain.predict(&F, self.gain_std * drive.torque * dt);
        let torque_std = s.sensors.swing_torque_std / e.torque_noise_divisor;
        let torque_variance = torque_std * torque_std * drive.share + drive.stale_torque;
        self.p[(0, 0)] += torque_variance * dt * dt;
        self.p[(1, 1)] += e.q_l * dt;
        f / inertia
    }

    #[expect(non_snake_case, reason = "the symbols of the model")]
    fn correct(&mut self, s: &Settings, drive: &Drive) -> Innovation {
        let Some(y) = drive.velocity else {
            return Innovation::default();
        };
        let reciprocal = exp(-self.x[1]);
        let h = self.x[0] * reciprocal;
        let H = Vector4::new(reciprocal, -h, 0.0, 0.0);
        let PH = self.p * H;
        let variance = H.dot(&PH) + drive.variance;
        let value = y - h;
        let gain = PH / gated_variance(value, variance, s.estimator.gate);
        self.x += gain * value;
        self.p -= gain * PH.transpose();
        for doubt in &mut self.doubts {
            doubt.correct(&gain, &H);
        }
        self.p = (self.p + self.p.transpose()) * 0.5;
        self.x[1] = self.x[1].clamp(ln(s.inertia_min), ln(s.inertia_max));
        Innovation { value, variance }
    }

    fn rest(&mut self, settings: &Settings, drive: &Drive, phase: Phase) {
        self.clear(0);
        if let Phase::Released(w) = phase {
            let inertia = exp(self.x[1]);
            let p = w * inertia;
            let relative = self.p[(1, 1)];
            self.x[0] = p;
            self.p[(0, 0)] =
                inertia * inertia * released_variance(drive.variance) + p * p * relative;
            self.p[(0, 1)] = p * relative;
            self.p[(1, 0)] = p * relative;
            self.doubts
                .iter_mut()
                .for_each(|doubt| doubt.set(0, p * doubt.of(1)));
        } else {
            self.x[0] = 0.0;
            self.doubts.iter_mut().for_each(|doubt| doubt.set(0, 0.0));
            self.p[(0, 0)] = 100.0;
            self.p[(1, 1)] += 0.1 * settings.estimator.q_l * drive.period;
        }
    }

    fn clear(&mut self, i: usize) {
        self.p.row_mut(i).fill(0.0);
        self.p.column_mut(i).fill(0.0);
    }

    pub(in crate::excavator) fn is_sound(&self) -> bool {
        self.x.iter().chain(self.p.iter()).all(|v| v.is_finite())
            && self.p.diagonal().iter().all(|&v| v >= 0.0)
    }

    fn state(&self, s: &Settings, innovation: Innovation, acceleration: f64) -> State {
        let inertia = exp(self.x[1]).clamp(s.inertia_min, s.inertia_max);
        let factor = if self.fixed {
            s.estimator.interval_factor
        } else {
            1.0
        };
        let std = |i: usize| sqrt(self.p[(i, i)].max(0.0));
        let own = factor * std(1);
        let doubted: f64 = self
            .doubts
            .iter()
            .map(|doubt| doubt.of(1) * doubt.of(1))
            .sum();
        State {
            inertia,
            inertia_std: inertia * sqrt(own * own + doubted),
            damping: Some((self.x[3], std(3))),
            offset: Some((self.x[2], std(2))),
            velocity: self.x[0] / inertia,
            acceleration,
            nis: innovation.nis(),
            unsettled: inertia <= s.inertia_min || inertia >= s.inertia_max,
            ..State::default()
        }
    }
}

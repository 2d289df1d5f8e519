//! A tick of motion: torque and velocity inform the filters, or the velocity alone where nothing else is known.

use super::filter::{DAMPING, FRICTION, GAIN, Input, M, W};
use super::trail::Trail;
use super::weigh::Weigh;
use super::{CREPT, Working};
use crate::excavator::drive::Drive;
use crate::excavator::settings::Settings;
use crate::kalman::Innovation;
use crate::math::sin_cos;

/// Random walk of the torque gain [1/sqrt(s)]: emptied buckets, as weights of zero, share one error, which must not average out.
const GAIN_DRIFT: f64 = 0.001;
/// Least standard deviation of the torque gain beside weighed loads. It is that of their own inertia: span and drawing 1 % each, the
/// load's centre 1.3 %, lengths 1 %. These errors are common to all loads and must not average out.
const WEIGHED_GAIN: f64 = 0.022;
/// Standard deviation of the gain's random walk in 100 s of motion. Such a drift is no fault, however closely the gain was calibrated.
pub(super) const GAIN_WALK: f64 = 10.0 * GAIN_DRIFT;
/// Time of motion in which friction and damping wander by their stated standard deviations [s]: oil warms up, a brake drags.
pub(super) const WARMING: f64 = 60.0;
/// Velocity below which a holding brake, a brake that opens late, or trapped oil may carry any part of the torque [rad/s].
const BRAKED: f64 = 0.04;
/// Time for which that part is constant [s].
const BRAKE_LASTS: f64 = 0.1;
/// Rate of an opening in which as much leaves as may slide out of an emptied bucket [rad/s]: a mass m changes by m in 1.7 s, one
/// standard deviation.
const SLIDES: f64 = 0.7;
/// Least velocity at which a gain error is distinguishable from a dragging brake [rad/s].
const FREE: f64 = 0.1;

impl Working {
    /// Processes a tick of motion; `share`: weight of a new torque in the smoothed one.
    pub(super) fn moving(
        &mut self,
        s: &Settings,
        drive: &Drive,
        share: f64,
        trail: &mut Option<Trail>,
    ) -> Innovation {
        self.torque += share * (drive.torque - self.torque);
        self.largest = self.largest.max(self.torque.abs());
        let input = self.input(s, drive);
        let there = self.weigh.as_ref().is_some_and(Weigh::is_there);
        let weighed = self.weighs();
        for filter in [&mut self.filter, &mut self.parallel.filter] {
            filter.p[GAIN][GAIN] += GAIN_DRIFT * GAIN_DRIFT * drive.period;
            if weighed {
                let floor = WEIGHED_GAIN.min(self.stated[GAIN]);
                filter.p[GAIN][GAIN] = filter.p[GAIN][GAIN].max(floor * floor);
            }
            for i in [FRICTION, DAMPING] {
                filter.p[i][i] += self.stated[i] * self.stated[i] * drive.period / WARMING;
            }
        }
        self.fade(s, drive.period, trail);
        self.recall.ages(drive.period);
        let (width, gate) = (s.estimator.friction_width, s.estimator.gate);
        self.parallel.set_off(&self.filter);
        if there {
            self.scale.leave(&input);
        }
        self.filter.predict(&input, width, s.inertia_min, trail);
        self.swing(drive.period);
        let mut innovation = Innovation::default();
        let variance = drive.variance + self.noise.vibration();
        if let Some(velocity) = drive.velocity {
            innovation = self.filter.correct(velocity, variance, gate, trail);
        }
        let measured = drive.velocity.map(|velocity| (velocity, variance));
        let shape = (width, s.inertia_min);
        let usual = self.contradiction.usual();
        let free = self.filter.x[W].abs() > FREE && !self.pushed;
        let other = free.then_some((innovation, usual));
        self.parallel.step(&input, shape, measured, gate, other);
        if self.parallel.overtakes(&mut self.filter) {
            self.anew = true;
            self.contradiction.outright();
        }
        if measured.is_none() {
            return innovation;
        }
        let z = innovation.normalised();
        self.noise.push(z);
        let no_payload = self.watch_payload(s, z);
        if self.bucket.is_open() {
            self.agreement.interrupt();
            self.sway.forget();
        } else {
            self.agreement.push(&self.filter, &drive.now, drive.period);
            let velocity = self.filter.x[W];
            self.sway
                .push(drive.torque, velocity, &drive.now, drive.period);
        }
        self.tare(s, drive, trail);
        if !self.pushed {
            self.watch_pushes(s, no_payload, trail);
        }
        innovation
    }

    /// Processes a tick in which the torque, the inertia or the drive of the swing is unknown. The velocity gives the swing angle, and no
    /// information about the load.
    pub(super) fn drifting(
        &mut self,
        s: &Settings,
        drive: &Drive,
        trail: &mut Option<Trail>,
    ) -> Innovation {
        if let Some(velocity) = drive.velocity {
            self.filter.set(W, velocity, drive.variance, trail);
            self.parallel
                .filter
                .set(W, velocity, drive.variance, &mut None);
        }
        self.filter.acceleration = 0.0;
        self.swing(drive.period);
        // A bucket that opens loses its load in any case.
        let input = self.input(s, drive);
        self.filter.leave(&input, trail);
        self.parallel.filter.leave(&input, &mut None);
        self.scale.leave(&input);
        self.tare(s, drive, trail);
        Innovation::default()
    }

    /// Advances the swing angle.
    fn swing(&mut self, period: f64) {
        self.angle += self.filter.x[W] * period;
        self.turn = sin_cos(self.angle);
    }

    /// Returns the inputs of a step, with the variance of what is not measured.
    fn input(&self, s: &Settings, drive: &Drive) -> Input {
        let sensor = s.sensors.swing_torque_std;
        let model = self.torque_share * self.largest;
        let nearly = 1.0 - self.filter.x[W].abs() / BRAKED;
        let braked = nearly.max(0.0) * (drive.torque.abs() + s.coulomb_friction);
        // The ground's force on a digging bucket is correlated in time, unlike noise.
        let pushed = if self.pushed || self.slow_for > CREPT {
            self.largest
        } else {
            0.0
        };
        let opening = self.bucket.opening_rate() * drive.period;
        let slides = if self.is_losing() {
            SLIDES * drive.period
        } else {
            0.0
        };
        let m = self.filter.x[M].max(0.0);
        Input {
            period: drive.period,
            torque: drive.torque,
            inertia: drive.mean,
            rate: drive.rate,
            now: drive.now,
            turn: self.turn,
            torque_variance: model * model * self.noise.scale() * 0.01 / drive.period
                + sensor * sensor * drive.share
                + braked * braked * BRAKE_LASTS / drive.period
                + pushed * pushed * CREPT / drive.period
                + drive.changing_torque
                + drive.stale_torque,
            leaving: (s.estimator.opening_decay * opening).min(0.5),
            payload_variance: 0.5 * m * m * (opening + slides)
                + s.estimator.q_m * self.rated * self.rated * 1e-5 * drive.period,
        }
    }
}

//! Estimate of the default estimator with its interval, and the reason why it may not be trusted.

use super::Working;
use super::filter::{
    BUCKET, DAMPING, DELAY, FRICTION, GAIN, LINKS, LOSS, OFFSET, SLOPE, SPAN, UPPER, W, ZERO,
};
use super::motion::GAIN_WALK;
use super::pushes::SUSPICIOUS;
use super::scale::anything;
use super::weigh::Weigh;
use crate::excavator::drive::Drive;
use crate::excavator::geometry::Inertia;
use crate::excavator::reason::Reason;
use crate::excavator::settings::Settings;
use crate::excavator::state::State;
use crate::kalman::Innovation;
use crate::math::sqrt;

/// Deviation from the description at which a constant is named [standard deviations].
const NAMED_DEVIATION: f64 = 3.0;
/// The same of gain and bucket, which only swings of different loads distinguish. They stay so uncertain that fewer must do: sound
/// machines show at most 1.2 and 2.1.
const NAMED_GAIN: f64 = 1.65;
const NAMED_BUCKET: f64 = 2.3;
/// Weight of the description, as the number of constants seen to agree with it, beside those of [`MACHINE`].
const BELIEF: f64 = 1.0;
/// Change of friction and damping with the oil's temperature, as a share.
const OIL_TEMPERATURE_SHARE: f64 = 0.1;
/// Relative standard deviation of the damping by losses of another form than T_f sign w + b w, such as Stribeck friction and churning:
/// b is 0 to 23 % too large on machines of independent simulators.
const OTHER_LOSSES: f64 = 0.1;
/// Least standard deviation of the described loss of the drive.
const LEAST_LOSS: f64 = 0.01;
/// Constants of the description that motion identifies.
const MACHINE: [usize; 8] = [FRICTION, DAMPING, LOSS, OFFSET, GAIN, UPPER, BUCKET, LINKS];
/// Upper limit of the square of one constant.
const SURPRISE: f64 = 16.0;
/// Share of the variance removed by motion at which a constant has half the weight of a known one.
const HARDLY_LEARNT: f64 = 0.05;
/// Lowest boom angle of a machine that swings [rad]: below it, the angle has the other sign.
const LOWEST_BOOM_ANGLE: f64 = -0.25;
/// Least deviation of a named constant, as a share of the stated standard deviation.
const MIN_SHARE: f64 = 0.33;
/// Deviations from which gain and offset are faults [stated standard deviations]. Half of a wrong gain appears as inertia.
const FAULT_DEVIATIONS: [(usize, f64); 2] = [(GAIN, 2.0), (OFFSET, 3.5)];
/// Least friction and damping of a machine, as a share of the described ones.
const MIN_FRICTION_SHARE: f64 = 0.25;
/// Mean ratio above which the stretches of the swings disagree.
const DISAGREEMENT: f64 = 3.0;

impl Working {
    /// Returns the estimate after a tick, with its interval and reason.
    pub(super) fn state(
        &self,
        settings: &Settings,
        drive: &Drive,
        innovation: Innovation,
        standing: bool,
    ) -> State {
        let (x, p) = (&self.filter.x, &self.filter.p);
        let [least, most] = settings.payload_range();
        let weight = self.filter.payload(&self.sticks);
        let [variance, inertia_variance] = self.filter.variances(&drive.now, &self.sticks);
        let payload = weight.clamp(least, most);
        let at_limit = payload != weight;
        let down = !standing && drive.posture[0] < LOWEST_BOOM_ANGLE;
        let factor = self.disagreement() * self.doubt();
        let contradicted = self.is_contradicted();
        let frozen = self.weigh.as_ref().is_some_and(Weigh::is_frozen);
        let misfits = self.weigh.as_ref().is_some_and(Weigh::misfits);
        let fills = !standing && self.ground.is_pulled();
        let may_hold_anything = contradicted || frozen || misfits || fills;
        let anything = if may_hold_anything {
            anything([least, most], payload)
        } else {
            0.0
        };
        let inertia = self
            .filter
            .inertia(&drive.now, self.filter.load() + payload - weight);
        let parallel =
            self.parallel
                .variances(&self.sticks, [payload, inertia, x[GAIN]], &drive.now);
        let tail = self.tail.variances(&self.filter, &drive.now, &self.sticks);
        let other = self.attachment.variances();
        let form = self.drawn_wrong(settings, drive, payload, down);
        let g = drive.now.per_payload;
        let weighs = self.weigh.as_ref().is_some_and(Weigh::is_there);
        let [payload, inertia] = if contradicted && weighs {
            self.scale.answer(&self.sticks, &drive.now, [least, most])
        } else {
            let variance = variance * factor + self.loads.variance(payload);
            [
                (
                    payload,
                    variance + parallel[0] + tail[0] + other[0] + anything,
                ),
                (
                    inertia,
                    inertia_variance * factor + parallel[1] + tail[1] + other[1] + anything * g * g,
                ),
            ]
        };
        // The damping is over 1 + k in the filter.
        let (b, scale) = (x[DAMPING], 1.0 + x[GAIN]);
        let hypotheses = self.tail.gain_variance(&self.filter) + parallel[2];
        let gain_variance = factor * p[GAIN][GAIN] + hypotheses;
        let together = scale * p[DAMPING][DAMPING] + 2.0 * b * p[DAMPING][GAIN];
        let variance =
            factor * scale * together + b * b * (gain_variance + OTHER_LOSSES * OTHER_LOSSES);
        let damping = (scale * b, sqrt(variance.max(0.0)));
        State {
            inertia: inertia.0,
            inertia_std: sqrt(inertia.1 + form * form),
            payload: Some((payload.0, sqrt(payload.1))),
            damping: Some(damping),
            gain: Some((x[GAIN], sqrt(gain_variance))),
            offset: Some((x[OFFSET], sqrt(p[OFFSET][OFFSET].max(0.0)))),
            velocity: x[W],
            acceleration: self.filter.acceleration,
            nis: innovation.nis(),
            changing: self.bucket.is_open() || self.changed,
            weighed: self.weigh.as_ref().is_some_and(Weigh::is_fresh),
            unsettled: at_limit
                || down
                || self.bucket.is_settling()
                || may_hold_anything
                || self.weigh.as_ref().is_some_and(Weigh::swings)
                || self.change.level() > SUSPICIOUS
                || self.noise.is_unexplained(),
            opening: self.bucket.is_open(),
            reason: if down {
                Reason::Sign
            } else if frozen {
                Reason::Frozen
            } else {
                self.reason(standing, (at_limit, contradicted))
            },
            ..State::default()
        }
    }

    /// Standard deviation of the inertia by errors of the drawing [kg m^2]. A boom that points `down` may have an angle of the other
    /// sign.
    fn drawn_wrong(&self, settings: &Settings, drive: &Drive, payload: f64, down: bool) -> f64 {
        let form = self.form(&drive.now);
        if !down {
            return form;
        }
        let [boom, arm, bucket] = drive.posture;
        let other = settings.geometry.inertia([-boom, arm, bucket]);
        let apart = other.with_payload(payload) - drive.now.with_payload(payload);
        sqrt(form * form + apart * apart)
    }

    /// Factor of the variances by which stretches of this swing disagree, or usually do.
    pub(super) fn disagreement(&self) -> f64 {
        self.agreement.factor().max(self.contradiction.usual())
    }

    /// Factor of the variances that the description states, at least 1. Constants that motion identifies may lie further from their
    /// description than it allows for. Then those that motion does not identify probably do too (inverse-gamma prior of the common
    /// scale). Where the description holds, the squared change of a constant equals on average the variance that motion removed, large or
    /// small. The factor is the mean of their ratios. The delay is the bus's, and carries no information about the description.
    pub(super) fn doubt(&self) -> f64 {
        let (x, p) = (&self.filter.x, &self.filter.p);
        let (mut sum, mut count) = (BELIEF, BELIEF);
        let mut ask = |i: usize| {
            let per_stated = self.per_stated[i];
            if per_stated <= 0.0 {
                return;
            }
            let learnt = (1.0 - p[i][i] * per_stated).max(0.0);
            let away = x[i] - self.described[i];
            let square = away * away * per_stated;
            // Part of the deviation of friction and damping is due to the oil.
            let counted = if i == FRICTION || i == DAMPING {
                learnt * square
            } else {
                square
            };
            let share = 1.0 / (learnt + HARDLY_LEARNT);
            sum += counted.min(SURPRISE * learnt) * share;
            count += learnt * share;
        };
        MACHINE.into_iter().for_each(&mut ask);
        // Without a torque, span and zero do not count: they absorb the friction of the seals.
        if self.parallel.is_driven() {
            [SPAN, ZERO].into_iter().for_each(&mut ask);
        }
        (sum / count).max(1.0)
    }

    /// Inverse of the variance that the description allows for constant `i`; 0 where it allows for none.
    pub(super) fn per_stated(i: usize, described: f64, stated: f64) -> f64 {
        let least = match i {
            FRICTION | DAMPING => OIL_TEMPERATURE_SHARE * described,
            LOSS => LEAST_LOSS,
            _ => 0.0,
        };
        let variance = (stated * stated).max(least * least);
        if variance > 0.0 { 1.0 / variance } else { 0.0 }
    }

    /// Standard deviation of the inertia by errors of the drawing, at this posture [kg m^2].
    pub(super) fn form(&self, now: &Inertia) -> f64 {
        self.form_share * (now.links + self.described_bucket * now.per_bucket)
    }

    /// Returns the reason: a condition of the estimate, or the constant that deviates most from its description in its own standard
    /// deviations.
    pub(super) fn reason(&self, standing: bool, (at_limit, contradicted): (bool, bool)) -> Reason {
        if standing && self.bucket.is_unlocked() {
            return Reason::Content;
        }
        if at_limit {
            return Reason::Limit;
        }
        if self.weigh.as_ref().is_some_and(Weigh::swings) {
            return Reason::Hanging;
        }
        let doubt = if contradicted {
            Reason::Contradiction
        } else if self.noise.is_unexplained() {
            Reason::Unexplained
        } else if self.agreement.factor() > DISAGREEMENT {
            Reason::Disagreement
        } else {
            Reason::None
        };
        if doubt != Reason::None {
            return if self.sway.hangs() {
                Reason::Hanging
            } else {
                doubt
            };
        }
        let mut most = (1.0, Reason::None);
        for (i, limit, reason) in [
            (SLOPE, NAMED_DEVIATION, Reason::Slope),
            (SLOPE + 1, NAMED_DEVIATION, Reason::Slope),
            (LOSS, NAMED_DEVIATION, Reason::Loss),
            (FRICTION, NAMED_DEVIATION, Reason::Friction),
            (GAIN, NAMED_GAIN, Reason::Gain),
            (DELAY, NAMED_DEVIATION, Reason::Delay),
            (OFFSET, NAMED_DEVIATION, Reason::Offset),
            (DAMPING, NAMED_DEVIATION, Reason::Damping),
            (BUCKET, NAMED_BUCKET, Reason::Attachment),
        ] {
            let difference = (self.filter.x[i] - self.described[i]).abs();
            if difference > MIN_SHARE * self.stated[i] {
                let sizes = difference / sqrt(self.filter.p[i][i].max(1e-300)) / limit;
                if sizes > most.0 {
                    most = (sizes, reason);
                }
            }
        }
        most.1
    }

    /// Returns whether something is contradicted: by motion or load, by the pressures, or by a constant.
    pub(super) fn is_contradicted(&self) -> bool {
        self.contradiction.is_open() || self.is_undecided() || self.is_beyond()
    }

    /// Returns whether it is unknown which of torque and pressures errs, or the pressures may have changed.
    fn is_undecided(&self) -> bool {
        self.scale.is_undecided() && !self.weigh.as_ref().is_some_and(Weigh::is_gone)
    }

    /// Returns whether a constant lies beyond what the description allows for, or beyond any machine: next to no friction.
    pub(super) fn is_beyond(&self) -> bool {
        let (x, p) = (&self.filter.x, &self.filter.p);
        let apart = |(i, most): (usize, f64)| {
            let walked = if i == GAIN { GAIN_WALK } else { 0.0 };
            let allowed = self.stated[i] * self.stated[i] + walked * walked;
            let away = x[i] - self.described[i];
            away * away > most * most * allowed
        };
        let absent = |i: usize| {
            let lack = MIN_FRICTION_SHARE * self.described[i] - x[i];
            lack > 0.0 && lack * lack > 9.0 * p[i][i]
        };
        FAULT_DEVIATIONS.into_iter().any(apart) || [FRICTION, DAMPING].into_iter().any(absent)
    }
}

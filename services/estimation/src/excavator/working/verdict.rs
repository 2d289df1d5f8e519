//! What the default estimator says of its state: the estimate with its interval, and why it may not be believed.

use super::filter::{
    BUCKET, DAMPING, DELAY, FRICTION, GAIN, LINKS, LOSS, OFFSET, SLOPE, SPAN, UPPER, W, ZERO,
};
use super::scale::anything;
use super::weigh::Weigh;
use super::{GAIN_WALK, SUSPICIOUS, Working};
use crate::excavator::drive::Drive;
use crate::excavator::geometry::Inertia;
use crate::excavator::reason::Reason;
use crate::excavator::settings::Settings;
use crate::excavator::state::State;
use crate::kalman::Innovation;
use crate::math::sqrt;

/// A constant this many standard deviations from its description is named. Of what only swings of different loads tell apart (the
/// torque's gain, the bucket) the swings leave so much open that fewer must do: sound machines show at most 1.2 and 2.1.
const NAMED_DEVIATION: f64 = 3.0;
const NAMED_GAIN: f64 = 1.65;
const NAMED_BUCKET: f64 = 2.3;
/// The description is believed as if so many constants had been seen to be as it says, beside those of [`MACHINE`].
const BELIEF: f64 = 1.0;
/// Friction and damping change by this share with the oil's temperature.
const OIL_TEMPERATURE_SHARE: f64 = 0.1;
/// The share that a drive loses is described no better than to this.
const LEAST_LOSS: f64 = 0.01;
/// What the motion tells of the machine's description.
const MACHINE: [usize; 8] = [FRICTION, DAMPING, LOSS, OFFSET, GAIN, UPPER, BUCKET, LINKS];
/// One constant says no more than this square.
const SURPRISE: f64 = 16.0;
/// One of which the motion has taken this share of the variance says half of what a known one does.
const HARDLY_LEARNT: f64 = 0.05;
/// No machine swings with its boom further down than this: the angle has the other sign [rad].
const LOWEST_BOOM_ANGLE: f64 = -0.25;
/// Less than this share of what the description allows for is not worth a word.
const MIN_SHARE: f64 = 0.33;
/// Gain and offset so many stated standard deviations from the described ones are faults; half of a wrong gain passes for inertia.
const FAULT_DEVIATIONS: [(usize, f64); 2] = [(GAIN, 2.0), (OFFSET, 3.5)];
/// No machine has less than this share of the described friction and damping.
const MIN_FRICTION_SHARE: f64 = 0.25;
/// Mean ratio at which stretches of the swings disagree.
const DISAGREEMENT: f64 = 3.0;

impl Working {
    pub(super) fn state(
        &self,
        settings: &Settings,
        drive: &Drive,
        innovation: Innovation,
        standing: bool,
    ) -> State {
        let (x, p) = (&self.filter.x, &self.filter.p);
        let std = |i: usize| sqrt(p[i][i].max(0.0));
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
        let may_hold_anything = contradicted || frozen || misfits && self.slow_for > 0.0;
        let anything = if may_hold_anything {
            anything([least, most], payload)
        } else {
            0.0
        };
        let inertia = self
            .filter
            .inertia(&drive.now, self.filter.load() + payload - weight);
        let parallel = self
            .parallel
            .variances(&self.sticks, payload, inertia, &drive.now);
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
        State {
            inertia: inertia.0,
            inertia_std: sqrt(inertia.1 + form * form),
            payload: Some((payload.0, sqrt(payload.1))),
            damping: Some((x[DAMPING], std(DAMPING))),
            offset: Some((x[OFFSET], std(OFFSET))),
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

    /// Standard deviation of what the drawing misses of the inertia [kg m^2]: a boom that points `down` may be one with the other sign.
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

    /// Factor of the variances by which stretches of this swing disagree, or those of earlier ones did.
    pub(super) fn disagreement(&self) -> f64 {
        self.agreement.factor().max(self.contradiction.usual())
    }

    /// Factor of the variances that the description states, at least 1: where constants that the motion tells lie further from
    /// their description than it allows for, what the motion does not tell will too (inverse-gamma prior of the common scale). Where
    /// the description holds, the square of what was learnt of a constant is the variance that the motion took away, be it much or
    /// little of it; the scale is the mean of their ratios. A delay is the bus's, and says nothing of the drawing.
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
            // What wanders with the oil is not only the description's.
            let told = if i == FRICTION || i == DAMPING {
                learnt * square
            } else {
                square
            };
            let share = 1.0 / (learnt + HARDLY_LEARNT);
            sum += told.min(SURPRISE * learnt) * share;
            count += learnt * share;
        };
        MACHINE.into_iter().for_each(&mut ask);
        // The pressures' are not asked without a torque beside them: they take up what the seals do.
        if self.parallel.is_driven() {
            [SPAN, ZERO].into_iter().for_each(&mut ask);
        }
        (sum / count).max(1.0)
    }

    /// One over the variance that the description allows constant `i`; 0 where it allows none.
    pub(super) fn per_stated(i: usize, described: f64, stated: f64) -> f64 {
        let least = match i {
            FRICTION | DAMPING => OIL_TEMPERATURE_SHARE * described,
            LOSS => LEAST_LOSS,
            _ => 0.0,
        };
        let variance = (stated * stated).max(least * least);
        if variance > 0.0 { 1.0 / variance } else { 0.0 }
    }

    /// Standard deviation of what the drawing misses of the inertia at this posture [kg m^2].
    pub(super) fn form(&self, now: &Inertia) -> f64 {
        self.form_share * (now.links + self.described_bucket * now.per_bucket)
    }

    /// What differs most from its description, in its own standard deviations.
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

    /// Whether swings or constants contradict the description.
    pub(super) fn is_contradicted(&self) -> bool {
        self.contradiction.is_open() || self.is_undecided() || self.is_beyond()
    }

    /// Whether nobody knows if torque or pressures err.
    fn is_undecided(&self) -> bool {
        self.scale.is_undecided() && !self.weigh.as_ref().is_some_and(Weigh::is_gone)
    }

    /// Whether a constant is not what the description allows for, or none that a machine has: next to no friction.
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

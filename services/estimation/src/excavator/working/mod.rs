//! Torque and posture on a machine that nobody has calibrated: the default of mode D.
//!
//! One filter carries everything that the machine may differ by ([`filter`]); what no state explains raises
//! the noise of the torque until the innovations are white again ([`noise`]); what the bucket holds is
//! unknown as soon as it could have changed ([`bucket`]). Sensors that go wrong are contradicted ([`contradiction`], [`rival`]).

mod agreement;
mod bucket;
mod contradiction;
mod filter;
mod noise;
mod rival;
mod smoother;
mod weigh;

use self::agreement::Agreement;
use self::bucket::{Bucket, Content};
use self::contradiction::Contradiction;
use self::filter::{
    BUCKET, DAMPING, DELAY, FRICTION, Filter, GAIN, Input, LINKS, LOSS, M, MOMENT, N, OFFSET,
    SLOPE, UPPER, Vector, W, inertia_row,
};
use self::noise::Noise;
use self::rival::Rival;
pub use self::smoother::{Smoothed, Smoother, Trail};
use self::weigh::Weigh;
use super::doubts::Doubts;
use super::drive::Drive;
use super::geometry::Inertia;
use super::reason::Reason;
use super::settings::Settings;
use super::standstill::Phase;
use super::state::State;
use crate::consistency::Cusum;
use crate::kalman::Innovation;
use crate::math::{exp, ln, sin_cos, sqrt};
use core::f64::consts::TAU;

/// An emptied bucket still holds this share of the rated payload, with this standard deviation: soil sticks, from nothing to 15 %, and
/// mostly little of it (an exponential distribution has both alike).
const STICKING: [f64; 2] = [0.035, 0.04];
/// So many times what sticks is taken for the same as before; beyond, what is left of the error is small beside the bucket's.
const ALIKE: f64 = 3.0;
/// Standard deviation of the payload, as a share of the rated one, below which the motion has said enough to
/// tell an empty bucket from a loaded one.
const TOLD: f64 = 0.15;
/// What stays in an emptied bucket weighs the same in two swings, with this standard deviation as a share of the rated payload.
const KEPT: f64 = 0.05;
/// A load that stays (a hook, a clamp, clay) is so many times as frequent as a sensor that breaks.
const STAYS: f64 = 100.0;

/// Random walk of the torque's gain: weights of zero all err alike, and must not add up [1/sqrt(s)].
const GAIN_DRIFT: f64 = 0.001;
/// So far may it have walked in 100 s of motion, however closely it was calibrated: that is no fault.
const GAIN_WALK: f64 = 10.0 * GAIN_DRIFT;
/// Noise of a sample of the inclinometer, and its mounting error [rad].
const INCLINOMETER: f64 = 0.03;
const MOUNTING: f64 = 0.004;
/// A constant this many standard deviations from its description is named.
const NAMED: f64 = 3.0;
/// Sum of normalised innovations at which the payload has changed without a word, and from which on it may have.
const CHANGE: f64 = 10.0;
const SUSPICIOUS: f64 = 4.0;
/// Time constant of the smoothed torque and angles [s].
const SMOOTHING: f64 = 0.05;
/// An upper body slower than this for so long may be digging [rad/s, s].
const CREEPING: f64 = 0.05;
const CREPT: f64 = 0.3;
/// Below this velocity a holding brake or stiction may take any part of the torque [rad/s].
const BRAKED: f64 = 0.04;
/// The description is believed as if so many constants had been as it says.
const BELIEF: f64 = 4.0;
/// Friction and damping change by this share with the oil's temperature.
const WARMTH: f64 = 0.1;
/// One constant says no more than this square.
const SURPRISE: f64 = 16.0;
/// No machine swings with its boom further down than this: the angle has the other sign [rad].
const DOWN: f64 = -0.25;
/// Less than this share of what the description allows for is not worth a word.
const MATERIAL: f64 = 0.33;
/// Factor of the torque's noise variance above which the motion does not follow the model.
const UNEXPLAINED: f64 = 30.0;
/// A weight is told closely within this share of the empty machine's inertia.
const CLOSE: f64 = 0.03;
/// Gain and offset so many stated standard deviations from the described ones are faults; half of a wrong gain passes for inertia.
const BEYOND: [(usize, f64); 2] = [(GAIN, 2.0), (OFFSET, 3.5)];
/// No machine has less than this share of the described friction and damping.
const LEAST: f64 = 0.25;
/// Mean ratio at which stretches of the swings disagree.
const DISAGREEMENT: f64 = 3.0;

/// The default estimator with torque and posture.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Working {
    filter: Filter,
    /// Of the doubts: what the model leaves out of the torque and of the inertia, as shares.
    torque_share: f64,
    form_share: f64,
    /// Mass of the bucket, as described [kg].
    described_bucket: f64,
    /// The states as described, and their standard deviations.
    described: Vector,
    stated: Vector,
    noise: Noise,
    agreement: Agreement,
    bucket: Bucket,
    /// Rated payload [kg].
    rated: f64,
    /// Swing angle since the start [rad].
    turn: f64,
    /// Largest torque seen, smoothed [N m].
    torque: f64,
    largest: f64,
    /// Sums of the innovations: a payload that changes and that no joint announces.
    change: Cusum,
    /// They have reached their limit in this swing: its value is not believed any more.
    changed: bool,
    /// An emptied bucket has weighed nothing in this swing.
    weighed_nothing: bool,
    /// The emptied bucket has been used as a weight of nearly nothing.
    tared: bool,
    /// How often it has been: what sticks is the same in all of them, so that they are worth little more than one.
    tares: f64,
    /// What the bucket weighed before it was emptied [kg].
    carried: Option<f64>,
    /// Sensors that are wrong by a factor since the machine stood, weighed against those that are not.
    rival: Rival,
    contradiction: Contradiction,
    /// The boom's cylinders, where they are described.
    weigh: Option<Weigh>,
    /// The upper body hardly moves for this time [s].
    slow_for: f64,
    /// What each tick does is kept; the next one is the first.
    trailing: bool,
    anew: bool,
}

impl Working {
    pub(super) fn new(settings: &Settings, doubts: &Doubts) -> Self {
        let (p, s) = (&settings.prior, settings);
        let (moment, moment_std) = doubts.upper_moment(&settings.geometry);
        let mut x = [0.0; N];
        let mut std = [0.0; N];
        for (i, value, deviation) in [
            (W, 0.0, 1e-3),
            (M, p.payload, p.payload_std),
            (OFFSET, 0.0, p.torque_offset_std),
            (DAMPING, s.nominal_damping, p.damping_std),
            (GAIN, 0.0, doubts.gain_std),
            (LOSS, 1.0 - doubts.efficiency, doubts.efficiency_std),
            (FRICTION, s.coulomb_friction, doubts.friction_std),
            (SLOPE, 0.0, doubts.slope_std),
            (SLOPE + 1, 0.0, doubts.slope_std),
            (MOMENT, moment, moment_std),
            (DELAY, doubts.delay, doubts.delay_std),
            (
                UPPER,
                0.0,
                doubts.upper_share * settings.geometry.upper_inertia,
            ),
            (
                BUCKET,
                0.0,
                doubts.bucket_share * settings.geometry.masses[2],
            ),
            (LINKS, 0.0, doubts.links_share),
        ] {
            x[i] = value;
            std[i] = deviation;
        }
        let filter = Filter::new(x, &std);
        Self {
            rival: Rival::new(&filter),
            filter,
            torque_share: doubts.torque_share,
            form_share: doubts.form_share,
            described_bucket: settings.geometry.masses[2],
            described: x,
            stated: std,
            noise: Noise::new(),
            agreement: Agreement::new(),
            bucket: Bucket::new(settings.estimator.opening_rate),
            rated: settings.rated_payload(),
            turn: 0.0,
            torque: 0.0,
            largest: 0.0,
            change: Cusum::new(0.5, CHANGE),
            changed: false,
            weighed_nothing: false,
            tared: false,
            tares: 0.0,
            carried: None,
            contradiction: Contradiction::new(),
            weigh: settings.boom.map(Weigh::new),
            slow_for: 0.0,
            trailing: false,
            anew: true,
        }
    }

    /// One tick; what it does goes into the trail, where that is kept.
    pub(super) fn step(
        &mut self,
        settings: &Settings,
        drive: &Drive,
        phase: Phase,
        trail: &mut Option<Trail>,
    ) -> State {
        let standing = phase == Phase::Held;
        if self.trailing {
            *trail = Some(Trail::NOTHING);
        }
        let share = 1.0 - exp(-drive.period / SMOOTHING);
        let reached = self.filter.x[W].abs() + CREPT * self.filter.acceleration.abs();
        self.slow_for = if standing || reached < CREEPING {
            self.slow_for + drive.period
        } else {
            0.0
        };
        // Who digs is pushed by the ground, and creeps.
        let stands = standing || self.slow_for > CREPT;
        let content = self.bucket.step(drive, share, stands, self.weigh.as_ref());
        self.hold(settings, content, trail);
        if let Some(weigh) = &mut self.weigh {
            let motion = (self.turn, self.filter.x[W]);
            let opens = self.bucket.is_open() || self.bucket.is_settling();
            let doing = (content, opens);
            let moment = weigh.step(settings, drive, motion, doing);
            let rival = &mut self.rival.filter;
            weigh.begin(drive, [&mut self.filter, rival], trail);
            if let Some(moment) = moment {
                let said = weigh.measure(settings, &moment, &mut self.filter, trail);
                let other = weigh.measure(settings, &moment, rival, &mut None);
                let gate = settings.estimator.gate;
                self.rival
                    .weigh([said, other], gate, self.contradiction.usual());
                weigh.watch(&moment, said);
                if weigh.renews(said) {
                    self.hold(settings, Content::Unknown, trail);
                    self.agreement.interrupt();
                }
            }
        }
        if let (true, Some(inclination)) = (standing, drive.inclination) {
            self.incline(inclination, trail);
        }
        let innovation = match phase {
            Phase::Moving => self.moving(settings, drive, share, trail),
            Phase::Held => self.rest(0.0, 1e-6, trail),
            Phase::Released(w) => self.set_off(w, drive, trail),
        };
        let anew = core::mem::take(&mut self.anew);
        if let Some(trail) = trail {
            trail.finish(&self.filter, &drive.now, drive.posture);
            trail.anew = anew;
            trail.range = settings.payload_range();
            trail.form = self.form(&drive.now);
            trail.disagreement = self.agreement.factor() * self.doubt();
        }
        self.state(settings, drive, innovation, standing)
    }

    /// What the bucket holds from now on.
    fn hold(&mut self, settings: &Settings, content: Content, trail: &mut Option<Trail>) {
        let p = &settings.prior;
        let (value, std) = match content {
            Content::Unchanged => return,
            Content::Emptied => self.sticking(),
            Content::Unknown => (p.payload, p.payload_std),
        };
        self.filter.set(M, value, std * std, trail);
        self.rival.filter.set(M, value, std * std, &mut None);
        self.tared = content == Content::Emptied;
        self.tares += f64::from(u8::from(self.tared));
    }

    /// Variance of a payload of which nothing is known [kg^2].
    fn anything(&self) -> f64 {
        0.25 * self.rated * self.rated
    }

    /// What an emptied bucket still holds, and its standard deviation [kg].
    fn sticking(&self) -> (f64, f64) {
        let [share, sticking] = STICKING.map(|share| share * self.rated);
        (share, sticking * sqrt(1.0 + self.tares.min(ALIKE)))
    }

    /// Keeps from now on what each tick does.
    pub(super) fn keep_trail(&mut self) {
        self.trailing = true;
    }

    fn rest(&mut self, velocity: f64, variance: f64, trail: &mut Option<Trail>) -> Innovation {
        self.filter.set(W, velocity, variance, trail);
        self.rival.filter.set(W, velocity, variance, &mut None);
        self.filter.acceleration = 0.0;
        self.noise.rest();
        self.change.clear();
        self.changed = false;
        if self.rival.is_over() {
            self.contradiction.swung(self.agreement.factor());
        }
        self.agreement.interrupt();
        self.weighed_nothing = false;
        Innovation::default()
    }

    /// Sets off with a measured velocity, which is late by what the delay makes of the acceleration.
    fn set_off(&mut self, velocity: f64, drive: &Drive, trail: &mut Option<Trail>) -> Innovation {
        let innovation = self.rest(velocity, drive.variance / 4.0 + 0.02 * 0.02, trail);
        let acceleration = drive.torque / drive.now.with_payload(self.filter.x[M]);
        self.filter.lag(acceleration, trail);
        self.rival.filter.lag(acceleration, &mut None);
        innovation
    }

    /// `share` of a new torque in the smoothed one.
    fn moving(
        &mut self,
        s: &Settings,
        drive: &Drive,
        share: f64,
        trail: &mut Option<Trail>,
    ) -> Innovation {
        if !drive.driven {
            return self.drifting(s, drive, trail);
        }
        self.torque += share * (drive.torque - self.torque);
        self.largest = self.largest.max(self.torque.abs());
        let sensor = s.sensors.swing_torque_std;
        let model = self.torque_share * self.largest;
        let nearly = 1.0 - self.filter.x[W].abs() / BRAKED;
        let braked = nearly.max(0.0) * (drive.torque.abs() + s.coulomb_friction);
        // What the ground does to a bucket that digs lasts, unlike noise.
        let pushed = if self.slow_for > CREPT {
            self.largest
        } else {
            0.0
        };
        let opening = self.bucket.opening_rate() * drive.period;
        let m = self.filter.x[M].max(0.0);
        let input = Input {
            period: drive.period,
            torque: drive.torque,
            inertia: drive.mean,
            rate: drive.rate,
            now: drive.now,
            turn: sin_cos(self.turn),
            torque_variance: model * model * self.noise.scale() * 0.01 / drive.period
                + sensor * sensor * drive.share
                + braked * braked
                + pushed * pushed * CREPT / drive.period
                + drive.stale_torque,
            leaving: (s.estimator.opening_decay * opening).min(0.5),
            payload_variance: 0.5 * m * m * opening
                + s.estimator.q_m * self.rated * self.rated * 1e-5 * drive.period,
        };
        for filter in [&mut self.filter, &mut self.rival.filter] {
            filter.p[GAIN][GAIN] += GAIN_DRIFT * GAIN_DRIFT * drive.period;
        }
        let (width, gate) = (s.estimator.friction_width, s.estimator.gate);
        self.rival.set_off(&self.filter);
        self.filter.predict(&input, width, s.inertia_min, trail);
        self.turn += self.filter.x[W] * drive.period;
        let mut innovation = Innovation::default();
        if let Some(velocity) = drive.velocity {
            innovation = self.filter.correct(velocity, drive.variance, gate, trail);
        }
        let measured = drive.velocity.map(|velocity| (velocity, drive.variance));
        let shape = (width, s.inertia_min);
        let usual = self.contradiction.usual();
        self.rival
            .step(&input, shape, measured, gate, innovation, usual);
        if self.rival.overtakes(&mut self.filter) {
            self.anew = true;
            self.contradiction.outright();
        }
        if measured.is_none() {
            return innovation;
        }
        let z = innovation.normalised();
        self.noise.push(z);
        if self.change.push(z.clamp(-3.0, 3.0)) {
            if !self.changed {
                let before = (self.filter.x[M], self.filter.p[M][M]);
                self.contradiction.changed(before);
            }
            let anything = self.anything();
            for filter in [&mut self.filter, &mut self.rival.filter] {
                filter.p[M][M] += anything;
            }
            self.agreement.contradict();
            self.changed = true;
        } else if self.changed {
            let weight = (self.filter.x[M], self.filter.p[M][M]);
            self.changed = !self.contradiction.withdraws(weight, self.anything());
        }
        if self.bucket.is_open() {
            self.agreement.interrupt();
        } else {
            self.agreement.push(&self.filter, &drive.now, drive.period);
        }
        self.tare(gate, &drive.now, trail);
        innovation
    }

    /// Nobody knows what drives the swing: its velocity says where the machine is, and nothing of the load.
    fn drifting(&mut self, s: &Settings, drive: &Drive, trail: &mut Option<Trail>) -> Innovation {
        if let Some(velocity) = drive.velocity {
            self.filter.set(W, velocity, drive.variance, trail);
            self.rival
                .filter
                .set(W, velocity, drive.variance, &mut None);
        }
        self.turn += self.filter.x[W] * drive.period;
        self.tare(s.estimator.gate, &drive.now, trail);
        Innovation::default()
    }

    /// The slope along the axes of the start, from pitch and roll of the standing upper body: accelerations of
    /// the swing would pass for inclinations.
    fn incline(&mut self, [pitch, roll]: [f64; 2], trail: &mut Option<Trail>) {
        let (sin, cos) = sin_cos(self.turn);
        let slopes = [roll * cos - pitch * sin, -roll * sin - pitch * cos];
        for (i, slope) in (SLOPE..).zip(slopes) {
            if self.filter.p[i][i] > MOUNTING * MOUNTING {
                let value = slope - self.filter.x[i];
                let variance = INCLINOMETER * INCLINOMETER;
                self.filter.measure([(i, 1.0)], value, variance, 1e3, trail);
                let rival = &mut self.rival.filter;
                let value = slope - rival.x[i];
                rival.measure([(i, 1.0)], value, variance, 1e3, &mut None);
            }
        }
    }

    /// An emptied bucket weighs next to nothing: that fixes the gain of the torque.
    fn tare(&mut self, gate: f64, now: &Inertia, trail: &mut Option<Trail>) {
        let told = TOLD * self.rated;
        let variance = self.filter.p[M][M];
        let claimed = variance * self.contradiction.usual();
        if variance > told * told {
            return;
        }
        if !self.bucket.is_emptied() {
            if !self.bucket.is_open() && !self.bucket.is_settling() {
                self.carried = Some(self.filter.x[M]);
            }
            return;
        }
        let (empty, std) = self.sticking();
        let rival = &self.rival.filter;
        let [value, other] = [empty - self.filter.x[M], empty - rival.x[M]];
        let apart = value * value > 9.0 * (claimed + std * std);
        let explained = other * other < 4.0 * (rival.p[M][M] + std * std);
        if apart && self.is_kept(variance) {
            return;
        }
        if apart && !explained {
            self.contradiction.outright();
            return;
        }
        let close = value * value < 4.0 * (variance + std * std);
        if !apart && !close {
            return;
        }
        if !apart && !core::mem::replace(&mut self.weighed_nothing, true) && !self.changed {
            let (_, before) = self.filter.combination(&inertia_row(now));
            self.contradiction.agreed(sqrt(before) < CLOSE * now.empty);
        }
        if !core::mem::replace(&mut self.tared, true) {
            let row = [(M, 1.0)];
            let said = self.filter.measure(row, value, std * std, gate, trail);
            let rival = &mut self.rival.filter;
            let other = rival.measure(row, other, std * std, gate, &mut None);
            self.rival
                .weigh([said, other], gate, self.contradiction.usual());
            self.tares += 1.0;
            self.agreement.interrupt();
        }
    }

    /// Whether an emptied bucket has rather kept what it carried, as a hook or a clamp does: then it weighs as before. With a sensor that
    /// broke it weighs less by what left it, which may be any share of the rated payload: the likelihoods, and how frequent either is, decide.
    fn is_kept(&self, variance: f64) -> bool {
        let stays = KEPT * self.rated;
        let spread = variance + stays * stays;
        let odds = STAYS * STAYS * self.rated * self.rated / (TAU * spread);
        self.carried.is_some_and(|before| {
            let left = before - self.filter.x[M];
            left * left < spread * ln(odds.max(1.0))
        })
    }

    fn state(
        &self,
        settings: &Settings,
        drive: &Drive,
        innovation: Innovation,
        standing: bool,
    ) -> State {
        let (x, p) = (&self.filter.x, &self.filter.p);
        let std = |i: usize| sqrt(p[i][i].max(0.0));
        let [least, most] = settings.payload_range();
        let payload = x[M].clamp(least, most);
        let at_limit = payload != x[M];
        let down = !standing && drive.posture[0] < DOWN;
        let factor = self.agreement.factor() * self.doubt();
        let (_, inertia_variance) = self.filter.combination(&inertia_row(&drive.now));
        let contradicted = self.contradiction.is_open() || self.is_beyond();
        let anything = if contradicted {
            // Uniform in its range, about the estimate.
            let (width, middle) = (most - least, 0.5 * (most + least));
            width * width / 12.0 + (payload - middle) * (payload - middle)
        } else {
            0.0
        };
        let inertia = self.filter.inertia(&drive.now, payload);
        let rival = self.rival.variances(payload, inertia, &drive.now);
        let payload_std = sqrt(p[M][M].max(0.0) * factor + rival[0] + anything);
        let form = self.form(&drive.now);
        let g = drive.now.per_payload;
        State {
            inertia,
            inertia_std: sqrt(
                inertia_variance * factor + rival[1] + anything * g * g + form * form,
            ),
            payload: Some((payload, payload_std)),
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
                || contradicted
                || self.weigh.as_ref().is_some_and(Weigh::swings)
                || self.change.level() > SUSPICIOUS,
            opening: self.bucket.is_open(),
            reason: if down {
                Reason::Sign
            } else {
                self.reason(at_limit, standing)
            },
            ..State::default()
        }
    }

    /// Factor of the variances that the description states, at least 1: where constants that the motion tells lie further from
    /// their description than it allows for, what the motion does not tell will too (inverse-gamma prior of the common scale).
    fn doubt(&self) -> f64 {
        let (x, p) = (&self.filter.x, &self.filter.p);
        let (mut sum, mut count) = (BELIEF, BELIEF);
        for (i, least) in [
            (FRICTION, WARMTH * self.described[FRICTION]),
            (DAMPING, WARMTH * self.described[DAMPING]),
            (LOSS, 0.01),
            (DELAY, 0.005),
        ] {
            let stated = (self.stated[i] * self.stated[i]).max(least * least);
            let told = (1.0 - p[i][i] / stated).max(0.0);
            let away = x[i] - self.described[i];
            sum += told * (away * away / stated).min(SURPRISE);
            count += told;
        }
        (sum / count).max(1.0)
    }

    /// Standard deviation of what the drawing misses of the inertia at this posture [kg m^2].
    fn form(&self, now: &Inertia) -> f64 {
        self.form_share * (now.links + self.described_bucket * now.per_bucket)
    }

    /// What differs most from its description, in its own standard deviations.
    fn reason(&self, at_limit: bool, standing: bool) -> Reason {
        if standing && self.bucket.is_unlocked() {
            return Reason::Content;
        }
        if at_limit {
            return Reason::Limit;
        }
        if self.weigh.as_ref().is_some_and(Weigh::swings) {
            return Reason::Hanging;
        }
        if self.contradiction.is_open() || self.is_beyond() {
            return Reason::Contradiction;
        }
        if self.noise.scale() > UNEXPLAINED {
            return Reason::Unexplained;
        }
        if self.agreement.factor() > DISAGREEMENT {
            return Reason::Disagreement;
        }
        let mut most = (NAMED, Reason::None);
        for (i, reason) in [
            (SLOPE, Reason::Slope),
            (SLOPE + 1, Reason::Slope),
            (LOSS, Reason::Loss),
            (FRICTION, Reason::Friction),
            (GAIN, Reason::Gain),
            (DELAY, Reason::Delay),
            (OFFSET, Reason::Offset),
            (DAMPING, Reason::Damping),
            (BUCKET, Reason::Attachment),
        ] {
            let difference = (self.filter.x[i] - self.described[i]).abs();
            if difference > MATERIAL * self.stated[i] {
                let sizes = difference / sqrt(self.filter.p[i][i].max(1e-300));
                if sizes > most.0 {
                    most = (sizes, reason);
                }
            }
        }
        most.1
    }

    /// Whether a constant is not what the description allows for, or none that a machine has: next to no friction.
    fn is_beyond(&self) -> bool {
        let (x, p) = (&self.filter.x, &self.filter.p);
        let apart = |(i, most): (usize, f64)| {
            let walked = if i == GAIN { GAIN_WALK } else { 0.0 };
            let allowed = self.stated[i] * self.stated[i] + walked * walked;
            let away = x[i] - self.described[i];
            away * away > most * most * allowed
        };
        let absent = |i: usize| {
            let lack = LEAST * self.described[i] - x[i];
            lack > 0.0 && lack * lack > 9.0 * p[i][i]
        };
        BEYOND.into_iter().any(apart) || [FRICTION, DAMPING].into_iter().any(absent)
    }

    pub(super) fn is_sound(&self) -> bool {
        self.filter.is_sound() && self.rival.is_sound()
    }
}

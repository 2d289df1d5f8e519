//! Default estimator of mode D: swing torque and joint angles, on a machine that is not calibrated.
//!
//! An extended Kalman filter estimates velocity, payload and every constant in which the machine may differ from its description
//! ([`filter`]). The variances of torque and velocity adapt until the innovations are white ([`noise`]). The payload returns to its prior
//! as soon as the bucket's content may have changed ([`bucket`], [`tare`]). Faulty sensors are detected as contradictions
//! ([`contradiction`], [`parallel`]). Then the pressures alone determine the load, where there are any ([`scale`]). Interval and reasons:
//! [`verdict`].

mod agreement;
mod attachment;
mod bucket;
mod changed;
mod contradiction;
mod correlations;
mod fading;
mod filter;
mod moved;
mod noise;
mod parallel;
mod recall;
mod scale;
mod smoother;
mod states;
mod sway;
mod tail;
mod tare;
mod trail;
mod trial;
mod verdict;
mod weigh;

use self::agreement::Agreement;
use self::attachment::Attachment;
use self::bucket::{Bucket, Content};
use self::contradiction::Contradiction;
use self::filter::{
    BUCKET, DAMPING, DELAY, FRICTION, Filter, GAIN, Input, LINKS, LOSS, M, MOMENT, N, OFFSET,
    SLOPE, SPAN, UPPER, Vector, W, ZERO,
};
use self::noise::Noise;
use self::parallel::ParallelFilter;
use self::recall::Recall;
use self::scale::Scale;
pub use self::smoother::{Smoothed, Smoother};
use self::sway::Sway;
use self::tail::Tail;
pub use self::trail::Trail;
use self::weigh::Weigh;
use super::doubts::Doubts;
use super::drive::Drive;
use super::grid::alike;
use super::measurements::boom_moment::FADING;
use super::measurements::ground::{Ground, SWEEPING};
use super::settings::Settings;
use super::size::Sticking;
use super::standstill::{Phase, released_variance};
use super::state::State;
use crate::CommonError;
use crate::consistency::Cusum;
use crate::kalman::Innovation;
use crate::math::{exp, norm, sin_cos};

/// Random walk of the torque gain [1/sqrt(s)]: emptied buckets, as weights of zero, share one error, which must not average out.
const GAIN_DRIFT: f64 = 0.001;
/// Least standard deviation of the torque gain beside weighed loads. It is that of their own inertia: span and drawing 1 % each, the
/// load's centre 1.3 %, lengths 1 %. These errors are common to all loads and must not average out.
const WEIGHED_GAIN: f64 = 0.022;
/// Standard deviation of the gain's random walk in 100 s of motion. Such a drift is no fault, however closely the gain was calibrated.
const GAIN_WALK: f64 = 10.0 * GAIN_DRIFT;
/// Time of motion in which friction and damping wander by their stated standard deviations [s]: oil warms up, a brake drags.
const WARMING: f64 = 60.0;
/// Standard deviation of an inclinometer sample [rad].
const INCLINOMETER: f64 = 0.03;
/// Mounting error of the inclinometer [rad].
const MOUNTING: f64 = 0.004;
/// Time of standing after which the machine may have travelled to other ground on its tracks [s].
const TRAVEL: f64 = 2.0;
/// Probability of such travel per further second [1/s].
const TRAVELS: f64 = 0.02;
/// Torque beyond friction that may still be none [standard deviations of its noise].
const NONE: f64 = 3.0;
/// Time within which the slope's variance returns to the stated one, while tracks turn the upper body [s]: the machine is travelling.
const UNDER_WAY: f64 = 2.0;
/// Threshold of the CUSUM of normalised innovations: the payload has changed without a joint motion.
const CHANGE: f64 = 10.0;
/// Level of the same sum above which the payload may have changed.
const SUSPICIOUS: f64 = 4.0;
/// Time constant of the smoothed torque and angles [s].
const SMOOTHING: f64 = 0.05;
/// Velocity below which an upper body creeps, and may be digging [rad/s].
const CREEPING: f64 = 0.05;
/// Time of creeping after which the bucket counts as digging, and for which the ground's force is constant [s].
const CREPT: f64 = 0.3;
/// Time within which an upper body that goes on accelerating reaches the velocity of a swing [s]: it sets off, and sweeps nothing.
const SETS_OFF: f64 = 1.0;
/// Time constant of the smoothed acceleration [s], twice that of the torque. The acceleration is that of the estimated velocity, since a
/// torque on a held upper body accelerates nothing.
const GAINS: f64 = 2.0 * SMOOTHING;
/// Velocity below which a holding brake, a brake that opens late, or trapped oil may carry any part of the torque [rad/s].
const BRAKED: f64 = 0.04;
/// Time for which that part is constant [s].
const BRAKE_LASTS: f64 = 0.1;
/// Rate of an opening in which as much leaves as may slide out of an emptied bucket [rad/s]: a mass m changes by m in 1.7 s, one
/// standard deviation.
const SLIDES: f64 = 0.7;
/// Least velocity at which a gain error is distinguishable from a dragging brake [rad/s].
const FREE: f64 = 0.1;

/// The default estimator with torque and posture.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Working {
    filter: Filter,
    /// Stated doubts (uncertainties that the model includes): unmodelled torque and inertia as shares, and the errors common to all
    /// loads.
    torque_share: f64,
    form_share: f64,
    loads: CommonError,
    /// Described mass of the bucket [kg].
    described_bucket: f64,
    /// Described states (slopes: as an inclinometer shows them), and their stated standard deviations.
    described: Vector,
    stated: Vector,
    /// Inverse of the stated variances, see [`Self::per_stated`].
    per_stated: Vector,
    /// Standard deviation of the torque gain where pressures weigh too.
    weighed_gain: f64,
    noise: Noise,
    sway: Sway,
    agreement: Agreement,
    bucket: Bucket,
    ground: Ground,
    /// Rated payload [kg].
    rated: f64,
    /// Swing angle since the start [rad]; its sine and cosine.
    angle: f64,
    turn: (f64, f64),
    /// Smoothed torque, and its largest magnitude so far [N m].
    torque: f64,
    largest: f64,
    /// CUSUM of the innovations: detects a payload that changes without a joint motion.
    change: Cusum,
    /// That sum has reached its threshold in this swing: the payload is not trusted.
    changed: bool,
    /// The change is no payload: something pushes the upper body until it stands.
    pushed: bool,
    /// Tracks turn the machine while no swing torque acts: this motion carries no information about the inertia.
    rides: bool,
    /// Log likelihood ratio of another gain, from an emptied bucket that seems to weigh something.
    weighed_something: f64,
    /// The content still includes the prior of an unknown content, which must be removed when the content is over.
    expected: bool,
    /// The content was set as a true mass, since pressures weigh it; else in units of the measured torque.
    true_mass: bool,
    /// The emptied bucket has been used as a weight of nearly nothing.
    tared: bool,
    /// Soil that sticks in the bucket, common to all contents.
    sticks: Sticking,
    /// Content before the bucket was emptied [kg].
    carried: Option<f64>,
    /// Hypothesis that a sensor is wrong by a factor since the machine stood.
    parallel: ParallelFilter,
    contradiction: Contradiction,
    recall: Recall,
    /// Hypothesis that the gain is off, beside pressures.
    tail: Tail,
    /// Hypothesis that another bucket is attached.
    attachment: Attachment,
    /// Measurement by the boom cylinders, where they are described.
    weigh: Option<Weigh>,
    /// Load by the pressures alone.
    scale: Scale,
    /// Time in motion since the constants last faded \[s\].
    unfaded: f64,
    /// Time for which the upper body has hardly moved [s]; its velocity a tick ago [rad/s]; its smoothed acceleration [rad/s^2].
    slow_for: f64,
    before: f64,
    gaining: f64,
    /// Last sampling period [s], and the decay factor of the smoothed acceleration over it.
    smoothing: (f64, f64),
    /// Number of ticks, for checks that do not run in each of them.
    ticks: u32,
    /// The operations of each tick are recorded in a trail. The next tick is the first one of a restarted filter.
    trailing: bool,
    anew: bool,
}

impl Working {
    pub(super) fn new(settings: &Settings, doubts: &Doubts) -> Self {
        let (p, s) = (&settings.prior, settings);
        let (moment, moment_std) = doubts.upper_moment(&settings.geometry);
        let bucket = doubts.bucket_share * settings.geometry.masses[2];
        let upper = doubts.upper_share * settings.geometry.upper_inertia;
        let sticking = p.sticking();
        let sticks = sticking.among(bucket);
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
            (UPPER, 0.0, upper),
            (BUCKET, sticking.expected, bucket),
            (LINKS, 0.0, doubts.links_share),
        ] {
            x[i] = value;
            std[i] = deviation;
        }
        let mut filter = Filter::new(x, &std);
        if let Some(found) = doubts.found {
            correlations::correlate(&mut filter, doubts, found);
        }
        filter.p[BUCKET][BUCKET] += sticking.std * sticking.std;
        std[BUCKET] = norm(&[bucket, sticking.std]);
        Self {
            parallel: ParallelFilter::new(&filter, doubts),
            scale: Scale::new(&filter),
            filter,
            torque_share: doubts.torque_share,
            form_share: doubts.form_share,
            loads: doubts.loads,
            described_bucket: settings.geometry.masses[2],
            described: x,
            stated: std,
            per_stated: core::array::from_fn(|i| Self::per_stated(i, x[i], std[i])),
            weighed_gain: doubts.weighed_gain_std,
            noise: Noise::new(),
            sway: Sway::default(),
            agreement: Agreement::new(),
            bucket: Bucket::new(settings.estimator.opening_rate),
            ground: Ground::new(),
            rated: settings.prior.full_load(),
            angle: 0.0,
            turn: (0.0, 1.0),
            torque: 0.0,
            largest: 0.0,
            change: Cusum::new(0.5, CHANGE),
            changed: false,
            pushed: false,
            rides: false,
            weighed_something: 0.0,
            expected: true,
            true_mass: false,
            tared: false,
            sticks,
            carried: None,
            contradiction: Contradiction::new(),
            recall: Recall::default(),
            tail: Tail::new(doubts),
            attachment: Attachment::new(settings.geometry.masses[2], bucket, sticking),
            weigh: settings.boom.map(Weigh::new),
            unfaded: 0.0,
            slow_for: 0.0,
            before: 0.0,
            gaining: 0.0,
            smoothing: (0.0, 1.0),
            ticks: 0,
            trailing: false,
            anew: true,
        }
    }

    /// Processes one tick, and records its operations in the trail where one is requested.
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
        self.ticks = self.ticks.wrapping_add(1);
        let decay = self.decay(drive.period);
        let share = 1.0 - decay * decay;
        let gained = (self.filter.x[W] - self.before) / drive.period;
        self.before = self.filter.x[W];
        self.gaining += (1.0 - decay) * (gained - self.gaining);
        let reached = self.filter.x[W].abs() + CREPT * self.gaining.abs();
        self.slow_for = if standing || reached < CREEPING {
            self.slow_for + drive.period
        } else {
            0.0
        };
        // The ground pushes a digging bucket, and the upper body creeps. A machine on turning tracks stands on them.
        // Both count as standing for the content.
        let stands = standing || self.slow_for > CREPT || self.rides;
        let content = self.content(settings, drive, share, stands);
        self.hold(settings, content, trail);
        if self.weigh(settings, drive, (content, stands), trail) {
            self.hold(settings, Content::Unknown, trail);
            self.agreement.interrupt();
        }
        if let (true, Some(inclination)) = (standing, drive.inclination) {
            self.incline(inclination, trail);
        }
        let innovation = match phase {
            Phase::Moving if !drive.driven || self.is_riding(settings, drive, share) => {
                self.drifting(settings, drive, trail)
            }
            Phase::Moving => self.moving(settings, drive, share, trail),
            Phase::Held => {
                self.rides = false;
                if self.slow_for > TRAVEL {
                    self.attachment.stands(self.slow_for);
                    self.travel(TRAVELS * drive.period);
                }
                self.rest(0.0, 1e-6, trail)
            }
            Phase::Released(w) => {
                self.rides = is_quiet(settings, drive.torque);
                if self.rides {
                    self.torque = drive.torque;
                }
                self.set_off(w, drive, settings.inertia_min, trail)
            }
        };
        self.attachment.wait(drive.period);
        self.doubt_gain(drive);
        let restarted = core::mem::take(&mut self.anew);
        let state = self.state(settings, drive, innovation, standing);
        if let Some(trail) = trail {
            trail.finish(&self.filter, &self.sticks, &drive.now);
            trail.anew = restarted;
            trail.contradicted = self.is_contradicted();
            trail.range = settings.payload_range();
            trail.form = self.form(&drive.now);
            trail.loads = self.loads;
            trail.disagreement = self.disagreement() * self.doubt();
            trail.doubts(&state);
        }
        state
    }

    /// Returns the decay factor of the smoothed acceleration. Periods are mostly equal, so the last one is cached.
    fn decay(&mut self, period: f64) -> f64 {
        let (known, decay) = self.smoothing;
        if alike(known, period) {
            return decay;
        }
        let decay = exp(-period / GAINS);
        self.smoothing = (period, decay);
        decay
    }

    /// Follows the joints; returns how they may have changed the content. `share`: weight of new angles in the smoothed ones.
    fn content(&mut self, settings: &Settings, drive: &Drive, share: f64, stands: bool) -> Content {
        let weighs = self.weigh.as_ref().is_some_and(Weigh::is_there);
        let digs = weighs.then(|| self.ground.digs());
        let content = self.bucket.step(drive, share, stands, digs);
        let (lengths, velocity) = (settings.geometry.lengths, self.filter.x[W]);
        if weighs || !stands && velocity.abs() < SWEEPING {
            self.ground
                .step(drive.posture, lengths, (velocity, stands), drive.period);
        } else {
            self.ground.ends_sweep();
        }
        if self.bucket.is_settling() {
            self.ground.opens();
        }
        let sets_off = velocity.abs() + SETS_OFF * self.gaining.abs() > SWEEPING;
        if self.ground.is_pulled() && !sets_off {
            // The bucket fills while the upper body sweeps.
            return Content::Unknown;
        }
        content
    }

    /// Takes in the moment of the boom cylinders, where one is complete. Returns whether the load must be another one.
    fn weigh(
        &mut self,
        settings: &Settings,
        drive: &Drive,
        (content, stands): (Content, bool),
        trail: &mut Option<Trail>,
    ) -> bool {
        let Some(weigh) = &mut self.weigh else {
            return false;
        };
        let motion = (self.turn, self.filter.x[W]);
        let opens = self.bucket.is_settling();
        let moment = weigh.step(
            settings,
            drive,
            motion,
            (content, opens, self.ground.may_touch()),
        );
        self.begin_weighing(drive, trail);
        let Some(moment) = moment else {
            return false;
        };
        if moment.stood < FADING && !self.parallel.is_driven() {
            self.fade_alone(settings, moment.period, trail);
        }
        let anything = self.anything();
        if let Some(weigh) = &self.weigh {
            let known = !self.attachment.may_be_another();
            self.scale
                .weigh(weigh, settings, &moment, (self.rated, known));
        }
        if self.parallel.is_driven() {
            self.doubt_pressures();
        } else if self.scale.is_misled() {
            self.contradiction.outright();
        }
        let Some(weigh) = &mut self.weigh else {
            return false;
        };
        let parallel = &mut self.parallel.filter;
        let believes = !self.scale.is_doubted();
        let innovation = weigh.measure(settings, &moment, (&mut self.filter, believes), trail);
        let other = weigh.measure(settings, &moment, (parallel, believes), &mut None);
        if !believes {
            if self.carries() {
                let load = (self.filter.load(), self.filter.p[M][M]);
                self.scale.sees(load, anything);
            }
            return false;
        }
        let load = (self.filter.load(), self.rated);
        if moment.touches {
            return weigh.sets_down(innovation, load);
        }
        let (gate, usual) = (settings.estimator.gate, self.contradiction.usual());
        self.parallel.weigh([innovation, other], gate, usual);
        weigh.watch(&moment, innovation, load, stands);
        let renews = weigh.renews(innovation, drive.posture[2]);
        if renews && innovation.value < 0.0 {
            // The ground may carry what is missing.
            self.ground.rests();
        }
        let same = self.parallel.is_driven() || !self.attachment.may_be_another();
        if renews && self.bucket.is_emptied() && same {
            // Nothing has been filled into an emptied bucket.
            self.contradiction.outright();
        }
        renews
    }

    /// Compares torque and pressures. Where they begin to contradict each other, the torque goes on alone.
    fn doubt_pressures(&mut self) {
        if self.is_beyond() {
            self.contradiction.outright();
        }
        if self.scale.doubts(self.contradiction.is_open()) {
            self.tail.forget();
            // The torque weighs again what both have weighed.
            let anything = self.anything();
            for filter in [&mut self.filter, &mut self.parallel.filter] {
                filter.p[M][M] += anything;
            }
        }
    }

    /// Starts the measurement by pressures: from now on they weigh beside the torque.
    fn begin_weighing(&mut self, drive: &Drive, trail: &mut Option<Trail>) {
        let filters = [
            &mut self.filter,
            &mut self.parallel.filter,
            &mut self.scale.filter,
        ];
        let weigh = self.weigh.as_mut();
        let Some(stated) = weigh.and_then(|weigh| weigh.begin(drive, filters, trail)) else {
            return;
        };
        for (i, std) in [SPAN, ZERO].into_iter().zip(stated) {
            self.restate(i, std);
        }
        self.recall.forget();
        self.parallel.is_joined_by_pressures();
        let std = self.weighed_gain;
        if std < self.stated[GAIN] && !self.parallel.is_driven() {
            self.restate(GAIN, std);
            self.filter.set(GAIN, 0.0, std * std, trail);
            self.parallel.knows_gain(std);
        }
    }

    /// Returns whether the bucket may still hold what was filled into it.
    fn carries(&self) -> bool {
        !(self.bucket.is_settling() || self.bucket.is_emptied())
    }

    /// Returns whether pressures weigh and are trusted.
    fn weighs(&self) -> bool {
        self.weigh.as_ref().is_some_and(Weigh::is_there) && !self.scale.is_doubted()
    }

    /// Updates the hypothesis of a gain that is off, where pressures weigh beside a torque that has informed the filter.
    fn doubt_gain(&mut self, drive: &Drive) {
        if self.weighs() && self.tail.is_due(drive.period) && self.parallel.is_driven() {
            let known = (self.stated[GAIN], self.disagreement());
            self.tail.ask(&self.filter, known, &drive.now, &self.sticks);
        }
    }

    /// Replaces the stated standard deviation of state `i`.
    fn restate(&mut self, i: usize, std: f64) {
        self.stated[i] = std;
        self.per_stated[i] = Self::per_stated(i, self.described[i], std);
    }

    /// Starts to record the operations of each tick.
    pub(super) fn keep_trail(&mut self) {
        self.trailing = true;
    }

    /// Holds the velocity at standstill, or restarts it, and ends the swing.
    fn rest(&mut self, velocity: f64, variance: f64, trail: &mut Option<Trail>) -> Innovation {
        self.filter.set(W, velocity, variance, trail);
        self.parallel.filter.set(W, velocity, variance, &mut None);
        self.filter.acceleration = 0.0;
        self.noise.rest();
        self.sway.rest();
        self.change.clear();
        self.changed = false;
        let pushed = core::mem::take(&mut self.pushed);
        if self.parallel.is_over() {
            self.contradiction.swung(self.agreement.factor());
            if !pushed && self.noise.is_unexplained() {
                self.contradiction.is_left_unexplained();
            }
        }
        self.agreement.interrupt();
        self.weighed_something = 0.0;
        Innovation::default()
    }

    /// Starts a motion with a measured velocity, which lags by the delay times the acceleration.
    fn set_off(
        &mut self,
        velocity: f64,
        drive: &Drive,
        inertia_min: f64,
        trail: &mut Option<Trail>,
    ) -> Innovation {
        let innovation = self.rest(velocity, released_variance(drive.variance), trail);
        let inertia = drive.now.with_payload(self.filter.load()).max(inertia_min);
        let acceleration = drive.torque / inertia;
        self.filter.lag(acceleration, trail);
        self.parallel.filter.lag(acceleration, &mut None);
        innovation
    }

    /// Advances the swing angle.
    fn swing(&mut self, period: f64) {
        self.angle += self.filter.x[W] * period;
        self.turn = sin_cos(self.angle);
    }

    /// Processes a tick of motion; `share`: weight of a new torque in the smoothed one.
    fn moving(
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

    /// Tests whether the payload changes without a joint motion; `z`: normalised innovation. Returns true where it changes again although
    /// its variance was raised: then the cause is no payload.
    fn watch_payload(&mut self, s: &Settings, z: f64) -> bool {
        let weight = (self.filter.x[M], self.filter.p[M][M]);
        let anything = self.anything();
        if self.change.push(z.clamp(-3.0, 3.0)) {
            // Without a torque, the motion carries no information about the payload.
            self.rides = is_quiet(s, self.torque);
            if self.rides {
                self.agreement.interrupt();
                return false;
            }
            for filter in [&mut self.filter, &mut self.parallel.filter] {
                filter.p[M][M] += anything;
            }
            self.agreement.contradict();
            let again = core::mem::replace(&mut self.changed, true);
            if !again {
                self.contradiction.changed(weight);
            }
            return again;
        }
        if self.changed && !self.pushed {
            self.changed = !self.contradiction.withdraws(weight, anything);
        }
        false
    }

    /// Tests whether something pushes the upper body: the change is no payload, or one that no bucket can hold.
    fn watch_pushes(&mut self, s: &Settings, no_payload: bool, trail: &mut Option<Trail>) {
        let (weight, range) = (self.filter.payload(&self.sticks), s.payload_range());
        let beyond = weight != weight.clamp(range[0], range[1]) && !self.attachment.is_possible();
        let pushes = beyond && {
            let row = self.filter.payload_row(&self.sticks);
            let payload = (weight, self.filter.combination(&row).1);
            self.contradiction.weighs(payload, range, self.changed)
        };
        if pushes || no_payload {
            self.contradiction.pushes();
            self.pushed = true;
            self.hold(s, Content::Unknown, trail);
        }
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

    /// Processes a tick in which the torque, the inertia or the drive of the swing is unknown. The velocity gives the swing angle, and no
    /// information about the load.
    fn drifting(&mut self, s: &Settings, drive: &Drive, trail: &mut Option<Trail>) -> Innovation {
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

    /// Returns whether tracks still turn the upper body: as long as no torque acts.
    fn is_riding(&mut self, s: &Settings, drive: &Drive, share: f64) -> bool {
        if self.rides {
            self.torque += share * (drive.torque - self.torque);
            self.rides = is_quiet(s, self.torque);
            self.travel(drive.period / UNDER_WAY);
        }
        self.rides
    }

    /// Adds the variance of another slope, as the machine may have travelled with this probability.
    fn travel(&mut self, probability: f64) {
        for i in [SLOPE, SLOPE + 1] {
            let anywhere = self.stated[i] * self.stated[i];
            let more = probability * anywhere;
            let parallel = &mut self.parallel.filter;
            for filter in [&mut self.filter, parallel, &mut self.scale.filter] {
                if filter.p[i][i] < anywhere {
                    filter.p[i][i] += more;
                }
            }
        }
    }

    /// Measures the slope along the axes of the start, from pitch and roll of the standing upper body. During a swing, accelerations
    /// would appear as inclination.
    fn incline(&mut self, [pitch, roll]: [f64; 2], trail: &mut Option<Trail>) {
        let (sin, cos) = self.turn;
        let slopes = [roll * cos - pitch * sin, -roll * sin - pitch * cos];
        self.scale
            .incline(slopes, MOUNTING * MOUNTING, INCLINOMETER * INCLINOMETER);
        for (i, slope) in (SLOPE..).zip(slopes) {
            self.described[i] = slope;
            if self.filter.p[i][i] > MOUNTING * MOUNTING {
                let value = slope - self.filter.x[i];
                let variance = INCLINOMETER * INCLINOMETER;
                self.filter.measure([(i, 1.0)], value, variance, 1e3, trail);
                let parallel = &mut self.parallel.filter;
                let value = slope - parallel.x[i];
                parallel.measure([(i, 1.0)], value, variance, 1e3, &mut None);
            }
        }
    }

    /// Returns whether all numbers are sound. The two other filters are checked for negative variances alternately, each every 16 ticks.
    pub(super) fn is_sound(&self) -> bool {
        let beside = [&self.parallel.filter, &self.scale.filter];
        let in_turn = match self.ticks % 16 {
            0 => beside[0].is_sound(),
            8 => beside[1].is_sound(),
            _ => true,
        };
        let weighs = self.weigh.is_none() || self.scale.filter.is_finite();
        self.filter.is_sound() && self.parallel.is_finite() && weighs && in_turn
    }
}

/// Returns whether a torque counts as none: within friction and the noise of its sensor.
fn is_quiet(s: &Settings, torque: f64) -> bool {
    torque.abs() < s.coulomb_friction + NONE * s.sensors.swing_torque_std
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excavator::Reason;
    use crate::excavator::keys::Description;

    #[test]
    fn a_gain_is_known_better_where_pressures_weigh_beside_the_torque() {
        let mut d = Description::default();
        let c = &mut d.boom_cylinder;
        (c.count, c.head_area, c.rod_area) = (1.0, 0.01, 0.007);
        (c.base_distance, c.rod_distance) = (0.6, 1.3);
        let settings = Settings::of(&d);
        let doubts = settings.doubts.expect("doubts");
        let mut working = Working::new(&settings, &doubts);
        let variances = |working: &Working| {
            [&working.filter, &working.parallel.filter].map(|filter| filter.p[GAIN][GAIN])
        };
        let before = variances(&working);
        assert!((before[0] - doubts.gain_std * doubts.gain_std).abs() < 1e-12);
        let drive = Drive {
            boom_pressure: Some([12e6, 1e6]),
            ..Drive::default()
        };
        working.begin_weighing(&drive, &mut None);
        let after = variances(&working);
        assert!((after[0] - doubts.weighed_gain_std * doubts.weighed_gain_std).abs() < 1e-12);
        // The parallel filter's gain stays open.
        assert!(after[1] < before[1] && after[1] > 50.0 * after[0]);
        // What motion has identified since is not reset.
        working.filter.p[GAIN][GAIN] = 1e-4;
        working.begin_weighing(&drive, &mut None);
        assert!((working.filter.p[GAIN][GAIN] - 1e-4).abs() < 1e-12);
    }

    #[test]
    fn a_filter_beside_the_first_that_is_no_number_shows_at_once_and_a_negative_variance_within_16_ticks()
     {
        let settings = Settings::of(&Description::default());
        let sound = Working::new(&settings, &settings.doubts.expect("doubts"));
        let shows = |working: &Working| {
            let at = |ticks| Working {
                ticks,
                ..working.clone()
            };
            (0..16).filter(|&ticks| !at(ticks).is_sound()).count()
        };
        assert_eq!(shows(&sound), 0);
        let mut broken = sound.clone();
        broken.parallel.filter.x[M] = f64::NAN;
        assert_eq!(shows(&broken), 16);
        let mut broken = sound.clone();
        broken.parallel.filter.p[M][M] = -1.0;
        assert_eq!(shows(&broken), 1);
        let mut broken = sound;
        broken.scale.filter.p[M][M] = -1.0;
        assert_eq!(shows(&broken), 1);
    }

    #[test]
    fn a_slope_that_the_inclinometer_shows_is_no_reason() {
        let settings = Settings::of(&Description::default());
        let doubts = settings.doubts.expect("doubts");
        let mut working = Working::new(&settings, &doubts);
        for _ in 0..200 {
            working.incline([0.06, 0.0], &mut None);
        }
        assert!((working.filter.x[SLOPE + 1] + 0.06).abs() < 0.01);
        assert_eq!(working.reason(false, (false, false)), Reason::None);
        // The motion contradicts the inclinometer.
        working.filter.x[SLOPE + 1] = 0.06;
        assert_eq!(working.reason(false, (false, false)), Reason::Slope);
    }

    #[test]
    fn a_content_is_unknown_where_the_arm_pulls_the_bucket_in_during_a_slow_sweep() {
        let settings = Settings::of(&Description::default());
        let known = 30.0 * 30.0;
        // Variance of a content that was known before the arm moved by this angle [rad] in a second, at these swing velocities [rad/s].
        let after = |arm: f64, velocity: fn(f64) -> f64| {
            let mut working = Working::new(&settings, &settings.doubts.expect("doubts"));
            let at = |share: f64, velocity: f64, working: &mut Working| {
                let posture = [0.6, -1.8 + share * arm, -1.5];
                let now = settings.geometry.inertia(posture);
                let drive = Drive {
                    period: 0.01,
                    velocity: Some(velocity),
                    variance: 2.5e-5,
                    torque: 4000.0,
                    now,
                    mean: now,
                    posture,
                    driven: true,
                    seen: true,
                    ..Drive::default()
                };
                working.filter.set(W, velocity, 1e-4, &mut None);
                working.step(&settings, &drive, Phase::Moving, &mut None);
            };
            (0..50).for_each(|_| at(0.0, 0.5, &mut working));
            working.rest(0.0, 1e-6, &mut None);
            (working.before, working.gaining) = (0.0, 0.0);
            working.filter.set(M, 0.0, known, &mut None);
            for k in 0..100 {
                let time = f64::from(k) / 100.0;
                at(time, velocity(time), &mut working);
            }
            working.filter.p[M][M]
        };
        let prior = settings.prior.payload_std * settings.prior.payload_std;
        let swept = after(-0.3, |time| if time < 0.2 { 0.06 } else { 0.15 });
        assert!(swept > 0.5 * prior, "{swept} {prior}");
        let stretched = after(0.3, |time| if time < 0.2 { 0.06 } else { 0.15 });
        assert!(stretched < 2.0 * known, "the arm stretches");
        assert!(after(-0.3, |_| 0.5) < 2.0 * known, "the machine swings");
        let sets_off = after(-0.3, |time| 0.02 + 0.4 * time);
        assert!(sets_off < 2.0 * known, "the machine sets off");
    }

    #[test]
    fn tracks_that_turn_the_machine_while_no_torque_acts_inform_no_state() {
        let settings = Settings::of(&Description::default());
        let mut working = Working::new(&settings, &settings.doubts.expect("doubts"));
        let now = settings.geometry.inertia([0.6, -1.8, -1.5]);
        let mut turn = |velocity: f64, torque: f64, phase: Phase| {
            let drive = Drive {
                period: 0.01,
                velocity: Some(velocity),
                variance: 2.5e-5,
                torque,
                now,
                mean: now,
                posture: [0.6, -1.8, -1.5],
                driven: true,
                seen: true,
                ..Drive::default()
            };
            working.step(&settings, &drive, phase, &mut None);
            let change = working.described[FRICTION] - working.filter.x[FRICTION];
            (
                change == 0.0,
                working.contradiction.is_open(),
                working.rides,
            )
        };
        turn(0.0, 0.0, Phase::Held);
        turn(0.02, 0.0, Phase::Released(0.02));
        for k in 0..400 {
            let velocity = 0.3 * sin_cos(0.015 * f64::from(k)).0;
            assert_eq!(turn(velocity, 0.0, Phase::Moving), (true, false, true));
        }
        // A torque drives the swing again.
        (0..30).for_each(|_| {
            turn(0.2, 4000.0, Phase::Moving);
        });
        assert!(!turn(0.2, 4000.0, Phase::Moving).2);
    }
}

//! Default estimator of mode D: swing torque and joint angles, on a machine that is not calibrated.
//!
//! An extended Kalman filter estimates velocity, payload and every constant in which the machine may differ from its description
//! ([`filter`]). The variances of torque and velocity adapt until the innovations are white ([`noise`]). The payload returns to its prior
//! as soon as the bucket's content may have changed ([`bucket`], [`tare`]). Faulty sensors are detected as contradictions
//! ([`contradiction`], [`parallel`]). Then the pressures alone determine the load, where there are any ([`scale`]). Interval and reasons:
//! [`verdict`].
//!
//! This file holds the state and the order of a tick. [`motion`] and [`standing`] are its two cases, [`pressures`] the second witness,
//! [`pushes`] what changes during a swing without a joint motion.

mod agreement;
mod attachment;
mod bucket;
mod changed;
mod contradiction;
mod correlations;
mod fading;
mod filter;
mod gap;
mod motion;
mod moved;
mod noise;
mod parallel;
mod pressures;
mod pushes;
mod recall;
mod scale;
mod smoother;
mod standing;
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
    BUCKET, DAMPING, DELAY, FRICTION, Filter, GAIN, LINKS, LOSS, M, MOMENT, N, OFFSET, SLOPE,
    UPPER, Vector, W,
};
use self::noise::Noise;
use self::parallel::ParallelFilter;
use self::pushes::CHANGE;
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
use super::measurements::ground::Ground;
use super::settings::Settings;
use super::size::Sticking;
use super::standstill::Phase;
use super::state::State;
use crate::CommonError;
use crate::consistency::Cusum;
use crate::math::{exp, norm};

/// Time constant of the smoothed torque and angles [s].
const SMOOTHING: f64 = 0.05;
/// Velocity below which an upper body creeps, and may be digging [rad/s].
const CREEPING: f64 = 0.05;
/// Time of creeping after which the bucket counts as digging, and for which the ground's force is constant [s].
const CREPT: f64 = 0.3;
/// Time constant of the smoothed acceleration [s], twice that of the torque. The acceleration is that of the estimated velocity, since a
/// torque on a held upper body accelerates nothing.
const GAINS: f64 = 2.0 * SMOOTHING;

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
    /// The start of this motion was not seen: booms and oil may swing already, and the motion carries no information about the inertia.
    joined: bool,
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
            joined: false,
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
            Phase::Held => self.stand(drive.period, trail),
            Phase::Released(w) => self.set_off(w, drive, settings, trail),
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

    /// Replaces the stated standard deviation of state `i`.
    fn restate(&mut self, i: usize, std: f64) {
        self.stated[i] = std;
        self.per_stated[i] = Self::per_stated(i, self.described[i], std);
    }

    /// Starts to record the operations of each tick.
    pub(super) fn keep_trail(&mut self) {
        self.trailing = true;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excavator::keys::Description;

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
}

//! Changes of the bucket's content in the filters. The content is unknown as soon as it may have changed. An emptied bucket weighs next
//! to nothing, which determines the torque gain.

use core::f64::consts::TAU;

use super::Working;
use super::attachment::Emptied;
use super::bucket::Content;
use super::filter::{BUCKET, Filter, M, W};
use super::trail::Trail;
use super::weigh::Weigh;
use crate::excavator::drive::Drive;
use crate::excavator::measurements::ground::SWEEPING;
use crate::excavator::settings::Settings;
use crate::kalman::Innovation;
use crate::math::ln;

/// Standard deviation of sticking soil from load to load, as a share of that between machines.
const LOAD_TO_LOAD: f64 = 8.0 / 7.0;
/// Standard deviation of its lasting change after each load, as a share of that from load to load.
const LASTING: f64 = 0.125;
/// Standard deviation of the payload below which motion distinguishes an empty bucket from a loaded one, as a share of the rated payload.
const KNOWN_STD_SHARE: f64 = 0.15;
/// Standard deviation between two swings of the weight of a load that stays in an emptied bucket, as a share of the rated payload.
const RESIDUE_STD_SHARE: f64 = 0.05;
/// Frequency of a load that stays (a hook, a clamp, clay) over that of a broken sensor.
const STUCK_LOAD_ODDS: f64 = 100.0;
/// Time within which an upper body that goes on accelerating reaches the velocity of a swing [s]: it sets off, and sweeps nothing.
const SETS_OFF: f64 = 1.0;

impl Working {
    /// Follows the joints; returns how they may have changed the content. `share`: weight of new angles in the smoothed ones.
    pub(super) fn content(
        &mut self,
        settings: &Settings,
        drive: &Drive,
        share: f64,
        stands: bool,
    ) -> Content {
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

    /// Returns whether the bucket may still hold what was filled into it.
    pub(super) fn carries(&self) -> bool {
        !(self.bucket.is_settling() || self.bucket.is_emptied())
    }

    /// Updates the filters for a change of the bucket's content.
    pub(super) fn hold(
        &mut self,
        settings: &Settings,
        content: Content,
        trail: &mut Option<Trail>,
    ) {
        let p = &settings.prior;
        if self.expected && (content != Content::Unchanged || self.bucket.is_open()) {
            self.content_is_over((p.payload, p.payload_std), trail);
        }
        let (value, std) = match content {
            Content::Unchanged => return,
            Content::Emptied => (0.0, self.sticking()),
            Content::Unknown => (p.payload, p.payload_std),
        };
        if self.scale.is_doubted() {
            self.scale.compare(self.anything());
        }
        self.recall(settings);
        self.contradiction.content_changes();
        self.sway.forget();
        if self.attachment.pending {
            self.settle_attachment(settings.estimator.gate, trail);
        }
        let goes_on_alone = self.scale.is_doubted() && !self.is_contradicted();
        if let Some(weigh) = &mut self.weigh {
            weigh.holds_another();
            if goes_on_alone {
                self.scale.knows(&self.filter);
            }
            self.scale.hold((value, std), content == Content::Emptied);
        }
        self.true_mass = self.weighs();
        let holds = (value, std * std);
        self.filter.hold(holds, self.true_mass, trail);
        let parallel = &mut self.parallel.filter;
        parallel.hold(holds, self.true_mass, &mut None);
        self.tared = false;
        self.expected = content == Content::Unknown;
        if content == Content::Emptied {
            self.is_emptied();
        }
    }

    /// Ends a content: removes its prior, value and standard deviation, from the filters. Contents are similar (a machine that grades
    /// carries none for an hour). A hundred equal priors would therefore seem to inform the other masses.
    fn content_is_over(&mut self, (value, std): (f64, f64), trail: &mut Option<Trail>) {
        self.expected = false;
        let prior = (value, std * std);
        self.filter.take_back(prior, self.true_mass, trail);
        let parallel = &mut self.parallel.filter;
        parallel.take_back(prior, self.true_mass, &mut None);
        self.scale.filter.take_back(prior, true, &mut None);
    }

    /// Widens the bucket's mass: other soil may stick from now on.
    pub(super) fn is_emptied(&mut self) {
        self.tared = true;
        let changes = LASTING * self.sticking();
        for filter in [
            &mut self.filter,
            &mut self.parallel.filter,
            &mut self.scale.filter,
        ] {
            filter.p[BUCKET][BUCKET] += changes * changes;
        }
    }

    /// Variance of an unknown payload [kg^2].
    pub(super) fn anything(&self) -> f64 {
        0.25 * self.rated * self.rated
    }

    /// Variance of a payload below which an empty bucket is distinguishable from a loaded one [kg^2].
    fn known_variance(&self) -> f64 {
        let limit = KNOWN_STD_SHARE * self.rated;
        limit * limit
    }

    /// Standard deviation of what sticks, from load to load \[kg\].
    pub(super) fn sticking(&self) -> f64 {
        LOAD_TO_LOAD * self.attachment.sticking.std
    }

    /// Returns whether an emptied bucket weighs something that may still be sliding out.
    pub(super) fn is_losing(&self) -> bool {
        let (m, std) = (self.filter.x[M], self.sticking());
        self.bucket.may_slide()
            && self.content_variance() <= self.known_variance()
            && m > 0.0
            && m * m > self.filter.p[M][M] + std * std
    }

    /// Tests an emptied bucket, and uses it as a weight of next to nothing, which determines the torque gain.
    pub(super) fn tare(&mut self, settings: &Settings, drive: &Drive, trail: &mut Option<Trail>) {
        let (gate, now) = (settings.estimator.gate, &drive.now);
        if self.filter.x[M] < 0.0 && !self.bucket.is_emptied() {
            self.weighs_less_than_nothing(gate, now, trail);
        }
        if self.content_variance() > self.known_variance() {
            return;
        }
        if !self.changed {
            self.contradiction.is_weighed();
        }
        if !self.bucket.is_emptied() {
            if !self.bucket.is_settling() {
                self.carried = Some(self.filter.x[M]);
            }
            return;
        }
        let std = self.sticking();
        let variance = self.filter.p[M][M];
        let claimed = variance * self.contradiction.usual();
        let parallel = &self.parallel.filter;
        let [value, other] = [-self.filter.x[M], -parallel.x[M]];
        if self.is_losing() {
            return;
        }
        let apart = value * value > 9.0 * (claimed + std * std);
        let parallel_variance = parallel.p[M][M];
        let explained = other * other < 4.0 * (parallel_variance + std * std);
        if apart && self.is_kept(variance) {
            return;
        }
        let emptied = Emptied {
            variance: std * std,
            tared: self.tared,
            seen: true,
        };
        if self.attachment.is_asked(&self.filter, &emptied) {
            if self.doubts_attachment(emptied, gate, now, trail) && (apart || !self.tared) {
                return;
            }
        } else {
            self.attachment.forget();
        }
        if apart && !explained {
            self.contradiction.outright();
            return;
        }
        let doubtful = value * value > 4.0 * (claimed + std * std);
        if doubtful && self.tared {
            // Another gain may explain it. Its evidence is updated with each row, as the weight is known better.
            let both = [(value, variance), (other, parallel_variance)];
            let both = both.map(|(value, variance)| Innovation {
                value,
                variance: variance + std * std,
            });
            let (usual, before) = (self.contradiction.usual(), self.weighed_something);
            self.weighed_something = self.parallel.weigh_again(both, gate, usual, before);
        }
        let close = value * value < 4.0 * (variance + std * std);
        if !apart && !close {
            return;
        }
        if !apart && !self.changed && !self.contradiction.has_agreed() {
            let explained = !self.noise.is_unexplained();
            // Without such knowledge it agrees where it is weighed well enough.
            let weighed = (1.0 / variance - 1.0 / (std * std)) * self.known_variance() > 1.0;
            if explained
                && self
                    .agrees_with_before(std * std, settings, drive)
                    .unwrap_or(weighed)
            {
                self.contradiction.agrees();
            }
        }
        if !self.tared {
            self.is_emptied();
            self.attachment.is_known();
            self.holds_nothing(std * std, gate, trail);
        }
    }

    /// Measures the content as nothing, with this variance [kg^2].
    pub(super) fn holds_nothing(&mut self, variance: f64, gate: f64, trail: &mut Option<Trail>) {
        self.scale.tare(variance, gate);
        let tare = |filter: &mut Filter, trail: &mut Option<Trail>| {
            let value = -filter.x[M];
            filter.measure([(M, 1.0)], value, variance, gate, trail)
        };
        let innovations = [
            tare(&mut self.filter, trail),
            tare(&mut self.parallel.filter, &mut None),
        ];
        self.parallel
            .weigh(innovations, gate, self.contradiction.usual());
        self.agreement.interrupt();
    }

    /// Returns whether an emptied bucket has rather retained its load, as a hook or a clamp does: then it weighs as before. With a broken
    /// sensor it weighs less by what left it, which may be any share of the rated payload. The likelihoods, and the frequencies of both,
    /// decide.
    pub(super) fn is_kept(&self, variance: f64) -> bool {
        let stays = RESIDUE_STD_SHARE * self.rated;
        let spread = variance + stays * stays;
        let odds = STUCK_LOAD_ODDS * STUCK_LOAD_ODDS * self.rated * self.rated / (TAU * spread);
        self.carried.is_some_and(|before| {
            let left = before - self.filter.x[M];
            left * left < spread * ln(odds.max(1.0))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excavator::keys::Description;
    use crate::excavator::standstill::Phase;

    #[test]
    fn similar_contents_do_not_inform_the_bucket() {
        let settings = Settings::of(&Description::default());
        let mut working = Working::new(&settings, &settings.doubts.expect("doubts"));
        let before = working.filter.p[BUCKET][BUCKET];
        // A machine that grades carries nothing, each time that something may have been filled in.
        for _ in 0..100 {
            let weight = [(M, 1.0), (BUCKET, 1.0)];
            let value = -working.filter.combination(&weight).0;
            let filter = &mut working.filter;
            filter.measure(weight, value, 100.0, 1e9, &mut None);
            working.hold(&settings, Content::Unknown, &mut None);
        }
        let (x, p) = (working.filter.x[BUCKET], working.filter.p[BUCKET][BUCKET]);
        assert!(x * x < p, "{x} {p}");
        assert!(p > 0.99 * before, "{p} {before}");
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
}

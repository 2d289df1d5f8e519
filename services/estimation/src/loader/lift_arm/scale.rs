//! The payload from row to row: a Kalman filter of payload m_p and rest of friction e.
//!
//! ```text
//! tau_row = empty + m_p k + r F (s f + e) + noise         k: moment of a kilogram; F: full force; f, s: friction and its direction
//! ```
//! While the bucket turns, m_p walks by as much as the bucket holds, by the angle where it turns slowly; else it stays. e fades to what
//! the seals leave unknown. An e that no seals have is content that comes or goes: a jump, however slow.
//! The noise is that of the pressures and of the load that heaves while the machine drives: found in the innovations, as a
//! share of the moment. Heaving goes on for some tenths of a second, in which rows tell the same.
//! Doubts of the drawing are no noise: they are added to the answer (`doubt`).

use super::content::Motion;
use super::drawing::Drawing;
use super::geometry::Shown;
use super::numbers::FRICTION;
use super::seals::Seals;
use crate::Quantity;
use crate::linear::Measurement;
use crate::math::sqrt;

/// How long heaving, lifting and settling contents do the same to the moment, and rows tell the same [s].
const TOGETHER: f64 = 0.3;
/// Smoothing of the innovation that shows a jump [s].
const FAST: f64 = 0.3;
/// Averaging time of the heaving [s].
const MEMORY: f64 = 3.0;
/// Heaving at the start, and at least, as shares of the moment.
const FIRST_HEAVING: f64 = 0.02;
const LEAST_HEAVING: f64 = 0.004;
/// Moments of an arm that carries nothing heave too: what counts as carried at least, as a share of the full force.
const ARM_ALONE: f64 = 0.03;
/// A load swings for some periods of half a second after the machine or the arm has stopped: what heaves now, over as long as rows tell
/// the same [s].
const ROCKING: f64 = 0.2;
/// Square of an innovation beyond which it is no heaving: a fifth of the moment.
const MOST_HEAVING: f64 = 0.04;
/// What an accelerated arm adds, and what a moving content does, as shares of the moment.
const LIFTING: f64 = 0.08;
const SETTLING: f64 = 0.15;
/// What a missing accelerometer adds, as a share of the moment.
const ACCELERATED: f64 = 0.05;
/// Share of the capacity by which the content walks in a second, turning and carried.
const TURNING_WALK: f64 = 0.8;
const CARRIED_WALK: f64 = 3e-4;
/// What the ground may have put into the bucket meanwhile, as a share of the capacity: per root second and at most.
const DUG_WALK: f64 = 0.7;
const DUG: f64 = 0.45;
/// A jump of the moment opens the content by this share of the capacity.
const JUMP: f64 = 0.25;
/// Standard deviations of the smoothed innovation that are a jump.
const JUMPS: f64 = 3.5;
/// Shares of the variances of heaving and of noise that the smoothing over `FAST` leaves.
const HEAVING_LEFT: f64 = 0.6;
const NOISE_LEFT: f64 = 0.04;
/// What drawing and friction leave unexplained in a smoothed innovation, as a share of the moment.
const UNEXPLAINED: f64 = 0.015;
/// Rest of friction before the first row: standard deviation, as a share of the friction.
const UNKNOWN_REST: f64 = 1.5;
/// The rest of friction is another one after so long while the rod moves, and while it stands [s].
const REST_MOVING: f64 = 0.3;
const REST_STILL: f64 = 3.0;

/// Memory of the scale.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Scale {
    /// Payload [kg], and rest of friction as a share of the full force.
    state: [f64; 2],
    covariance: [[f64; 2]; 2],
    /// Smoothed innovation, and variance of what heaves, as shares of the moment.
    fast: f64,
    heaving: f64,
    /// The same of the last moments, whatever its size.
    rocking: f64,
    /// The moment is another one, of a rocking machine or of another content.
    swings: bool,
    jumped: bool,
    /// What was lifted: known, and the ground has not had it since.
    lifted: Option<Lifted>,
}

/// A payload that was known in the air, where nothing comes into a bucket.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Lifted {
    /// [kg], [kg^2]
    payload: f64,
    variance: f64,
    /// Variance of what may have left since [kg^2].
    left: f64,
    /// Smoothed moment beyond it, as a share of the moment.
    above: f64,
}

impl Scale {
    /// A bucket that holds anything.
    pub fn new(drawing: &Drawing) -> Self {
        let capacity = drawing.capacity;
        let friction = UNKNOWN_REST * drawing.values[FRICTION];
        Self {
            state: [JUMP * capacity, 0.0],
            covariance: [[capacity * capacity, 0.0], [0.0, friction * friction]],
            fast: 0.0,
            heaving: FIRST_HEAVING * FIRST_HEAVING,
            rocking: 0.0,
            swings: false,
            jumped: false,
            lifted: None,
        }
    }

    /// The bucket may hold anything; the noise stays.
    pub fn forget(&mut self, drawing: &Drawing) {
        let heaving = self.heaving;
        *self = Self {
            heaving,
            ..Self::new(drawing)
        };
    }

    /// Takes a row.
    pub fn step(
        &mut self,
        drawing: &Drawing,
        shown: &Shown,
        seals: &Seals,
        motion: &Motion,
        accelerated: bool,
        dt: f64,
    ) {
        let Shown {
            lever,
            empty,
            per_load,
            lifting,
        } = *shown;
        let full = lever.abs() * drawing.full_force(&drawing.values);
        // The friction that is expected is in the moment already, its rest is a state.
        let by = [per_load, full];
        let innovation = lifting - empty - per_load * self.state[0] - full * self.state[1];
        let carried = lifting.abs() + ARM_ALONE * full;
        let predicted = self.variance(by);
        let noise = lever.abs() * drawing.force_std();
        let expected = predicted / (carried * carried);
        self.listen(innovation / carried, expected, motion, dt);
        let still = !motion.settling && !motion.lifting && !motion.held;
        self.swings = still && self.is_jump([carried, predicted, noise], self.heaving);
        let jumped = still
            && (self.swings && self.is_jump([carried, predicted, noise], self.heaves())
                || self.is_no_friction(drawing, seals.unknown()));
        self.jumped = jumped;
        self.lift(innovation, [per_load, carried], motion, dt);
        if jumped || motion.held {
            return;
        }
        let mut share = self.heaves().max(LEAST_HEAVING * LEAST_HEAVING);
        for (acts, std) in [
            (motion.lifting, LIFTING),
            (motion.settling, SETTLING),
            (!accelerated, ACCELERATED),
        ] {
            if acts {
                share += std * std;
            }
        }
        let together = (TOGETHER / dt).max(1.0);
        let variance = noise * noise + together * share * carried * carried;
        self.correct(by, innovation, variance);
    }

    /// Follows what was lifted, and how far the moment is beyond it.
    fn lift(&mut self, innovation: f64, [per_load, carried]: [f64; 2], motion: &Motion, dt: f64) {
        if motion.held {
            self.lifted = None;
        } else if !motion.open && !self.jumped && self.fast.abs() < 2.0 * UNEXPLAINED {
            self.lifted = Some(Lifted {
                payload: self.state[0],
                variance: self.covariance[0][0],
                left: 0.0,
                above: 0.0,
            });
        }
        if let Some(lifted) = &mut self.lifted {
            let beyond = innovation + per_load * (self.state[0] - lifted.payload);
            let share = (beyond / carried).clamp(-1.0, 1.0);
            lifted.above += (dt / FAST).min(1.0) * (share - lifted.above);
        }
    }

    /// The cylinders press with more than what was lifted.
    pub fn presses(&self, shown: &Shown, motion: &Motion) -> bool {
        self.lifted.is_some_and(|lifted| {
            let moment = |payload: f64| shown.empty + shown.per_load * payload;
            let known = moment(lifted.payload).abs();
            let std = moment(lifted.payload + sqrt(lifted.variance)).abs() - known;
            let moves = if motion.lifting || motion.settling {
                LIFTING
            } else {
                UNEXPLAINED
            };
            let usual = HEAVING_LEFT * self.heaving + moves * moves;
            // `above` is a share of what is shown now.
            let above = lifted.above / (1.0 - lifted.above.min(0.9)) * known;
            above > JUMPS * sqrt(std * std + usual * known * known)
        })
    }

    /// A stop carries: the bucket holds what was lifted, or what is left of it.
    pub fn stop(&mut self) {
        if let Some(lifted) = self.lifted {
            self.state[0] = lifted.payload;
            self.covariance[0] = [lifted.variance + lifted.left, 0.0];
            self.covariance[1][0] = 0.0;
        }
        (self.fast, self.swings, self.jumped) = (0.0, false, false);
    }

    /// The content may have become another one at once.
    pub fn open(&mut self, drawing: &Drawing) {
        let open = JUMP * drawing.capacity;
        self.covariance[0][0] += open * open;
        (self.fast, self.state[1]) = (0.0, 0.0);
    }

    /// Time passes over payload and rest of friction.
    pub fn walk(&mut self, drawing: &Drawing, seals: &Seals, motion: &Motion, dt: f64) {
        let walk = TURNING_WALK * TURNING_WALK * motion.changing + CARRIED_WALK * CARRIED_WALK;
        let variance = walk * drawing.capacity * drawing.capacity * dt;
        self.covariance[0][0] += variance;
        if let Some(lifted) = &mut self.lifted {
            lifted.left += variance;
        }
        let unknown = seals.unknown() * drawing.values[FRICTION];
        let time = if motion.lifting {
            REST_MOVING
        } else {
            REST_STILL
        };
        let kept = 1.0 - (dt / time).min(1.0);
        self.state[1] *= kept;
        self.covariance[0][1] *= kept;
        self.covariance[1][0] *= kept;
        self.covariance[1][1] =
            kept * kept * self.covariance[1][1] + (1.0 - kept * kept) * unknown * unknown;
    }

    fn variance(&self, [a, b]: [f64; 2]) -> f64 {
        let p = &self.covariance;
        a * a * p[0][0] + 2.0 * a * b * p[0][1] + b * b * p[1][1]
    }

    /// Follows the innovation, as a share of the moment.
    fn listen(&mut self, innovation: f64, expected: f64, motion: &Motion, dt: f64) {
        let innovation = innovation.clamp(-1.0, 1.0);
        self.fast += (dt / FAST).min(1.0) * (innovation - self.fast);
        if motion.settling || motion.held {
            return;
        }
        let away = innovation - self.fast;
        let square = away * away;
        // An arm that starts or stops rocks its load as a machine does.
        let rocking = (square - expected).max(0.0);
        self.rocking += (dt / ROCKING).min(1.0) * (rocking - self.rocking);
        if !motion.lifting {
            self.heaving += (dt / MEMORY).min(1.0) * (square.min(MOST_HEAVING) - self.heaving);
        }
    }

    /// Variance of what heaves, as a share of the moment: usually, or now.
    fn heaves(&self) -> f64 {
        self.heaving.max(self.rocking)
    }

    fn is_jump(&self, [carried, predicted, noise]: [f64; 3], heaves: f64) -> bool {
        let square = carried * carried;
        let usual = HEAVING_LEFT * heaves * square
            + NOISE_LEFT * noise * noise
            + UNEXPLAINED * UNEXPLAINED * square;
        self.fast * self.fast * square > JUMPS * JUMPS * (predicted + usual)
    }

    /// The rest of friction is more than that of any seals.
    fn is_no_friction(&self, drawing: &Drawing, unknown: f64) -> bool {
        let (friction, std) = (unknown * drawing.values[FRICTION], drawing.std[FRICTION]);
        self.state[1] * self.state[1] > JUMPS * JUMPS * (friction * friction + std * std)
    }

    /// The ground carries a part: the content may become anything.
    pub fn dig(&mut self, drawing: &Drawing, dt: f64) {
        let capacity = drawing.capacity;
        let (walk, most) = (DUG_WALK * capacity, DUG * capacity);
        let variance = &mut self.covariance[0][0];
        if *variance < most * most {
            *variance = (*variance + walk * walk * dt).min(most * most);
        }
    }

    fn correct(&mut self, by: [f64; 2], innovation: f64, variance: f64) {
        let told = Measurement::of(&self.covariance, &by, innovation, variance);
        if told.variance > 0.0 && told.variance.is_finite() && innovation.is_finite() {
            told.take(&mut self.state, &mut self.covariance);
        }
    }

    /// The arm's own moment and that of a kilogram are other ones than was thought: the same moment is another payload.
    pub fn redraw(&mut self, [before, after]: [(f64, f64); 2]) {
        let by = before.1 / after.1;
        self.state[0] = by * self.state[0] + (before.0 - after.0) / after.1;
        self.covariance[0][0] *= by * by;
        self.covariance[0][1] *= by;
        self.covariance[1][0] *= by;
    }

    /// What the bucket holds, as far as the rows tell [kg].
    pub fn payload(&self) -> Quantity {
        Quantity {
            value: self.state[0],
            std: sqrt(self.covariance[0][0].max(0.0)),
        }
    }

    /// Rest of friction, as a share of the full force.
    pub fn rest(&self) -> f64 {
        self.state[1]
    }

    /// The machine rocks, or the content is another one: half a second of rows tells which.
    pub fn swings(&self) -> bool {
        self.swings
    }

    /// The moment jumped in this row, and no bucket turned.
    pub fn jumped(&self) -> bool {
        self.jumped
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loader::lift_arm::tests::settings;

    #[test]
    fn a_load_that_rocks_while_the_arm_lifts_is_weighed_less_surely_for_a_moment() {
        let drawing = Drawing::of(&settings()).expect("a described arm");
        let mut scale = Scale::new(&drawing);
        let mut listen = |lifting, amplitude: f64| {
            let motion = Motion {
                turning: false,
                changing: 0.0,
                lifting,
                settling: false,
                held: false,
                open: false,
            };
            // An arm that starts or stops rocks on its oil at 1.3 Hz.
            for k in 0..100 {
                let swing = amplitude * (0.08 * f64::from(k)).sin();
                scale.listen(swing, 0.0, &motion, 0.01);
            }
            (sqrt(scale.heaves()), sqrt(scale.heaving))
        };
        let (now, usual) = listen(true, 0.3);
        assert!((0.12..0.3).contains(&now), "{now}");
        assert_eq!(usual, FIRST_HEAVING, "lifts say nothing of the drive");
        let (now, _) = listen(false, 0.0);
        assert!(now < 0.05, "{now}");
    }
}

//! Kalman filter of payload m_p and residual friction e, from the moment of the lift cylinders.
//!
//! ```text
//! tau_row = empty + m_p k + r F (s f + e) + noise      k: moment of a kilogram; r: lever; F: full force; f, s: friction and its direction
//! ```
//! While the bucket turns, m_p is a random walk of the size of the capacity; where it turns slowly, in proportion to its rate; otherwise m_p
//! is almost constant. e decays to 0, with the deviation that the seals leave unknown. An e larger than friction can be is content that
//! comes or goes: it counts as a jump, however slow.
//!
//! The noise is that of the pressures and of the heaving load while the machine drives. It is estimated from the innovations, as a share of
//! the expected moment, and is correlated for some tenths of a second. Errors of the drawing are no noise: they are added to the answer
//! (`doubt`).

use super::content::Motion;
use super::drawing::Drawing;
use super::geometry::Shown;
use super::numbers::FRICTION;
use super::seals::Seals;
use crate::Quantity;
use crate::linear::Measurement;
use crate::math::sqrt;

/// Correlation time of the noise by heaving, lifting and settling [s].
const TOGETHER: f64 = 0.3;
/// Time constant of the smoothed innovation, which detects jumps [s].
const FAST: f64 = 0.3;
/// Averaging time of the usual heaving [s].
const MEMORY: f64 = 3.0;
/// Standard deviation of heaving, initial and least, as shares of the moment.
const FIRST_HEAVING: f64 = 0.02;
const LEAST_HEAVING: f64 = 0.004;
/// Added to the moment that shares refer to, as a share of the moment at full force: an arm without moment heaves too.
const ARM_ALONE: f64 = 0.03;
/// Averaging time of the present heaving [s]: a load swings for some periods of half a second after machine or arm stops.
const ROCKING: f64 = 0.2;
/// Limit of a squared innovation in the usual heaving: a fifth of the moment.
const MOST_HEAVING: f64 = 0.04;
/// Standard deviations added by an accelerated arm, and by a settling content, as shares of the moment.
const LIFTING: f64 = 0.08;
const SETTLING: f64 = 0.15;
/// Standard deviation added where there is no accelerometer, as a share of the moment.
const ACCELERATED: f64 = 0.05;
/// Random walk of the content, turning and carried, as shares of the capacity [1/s^.5].
const TURNING_WALK: f64 = 0.8;
const CARRIED_WALK: f64 = 3e-4;
/// Random walk of the content in the ground, and its largest standard deviation, as shares of the capacity [1/s^.5], [1].
const DUG_WALK: f64 = 0.7;
const DUG: f64 = 0.45;
/// Standard deviation added to the content by a jump of the moment, as a share of the capacity; also the mean of the prior.
const JUMP: f64 = 0.25;
/// Standard deviations of the smoothed innovation beyond which it is a jump.
const JUMPS: f64 = 3.5;
/// Shares of the variances of heaving and of noise that remain after smoothing with `FAST`.
const HEAVING_LEFT: f64 = 0.6;
const NOISE_LEFT: f64 = 0.04;
/// Standard deviation of a smoothed innovation by drawing and friction, as a share of the moment.
const UNEXPLAINED: f64 = 0.015;
/// Prior standard deviation of residual friction, as a share of the friction.
const UNKNOWN_REST: f64 = 1.5;
/// Time constant of residual friction while the rod moves, and while it stands [s].
const REST_MOVING: f64 = 0.3;
const REST_STILL: f64 = 3.0;

/// State of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Scale {
    /// Payload [kg], and residual friction as a share of the full force.
    state: [f64; 2],
    covariance: [[f64; 2]; 2],
    /// Smoothed innovation, and variance of the usual heaving, as shares of the moment.
    fast: f64,
    heaving: f64,
    /// Variance of the present heaving, averaged over `ROCKING` beyond what is predicted, and not limited by `MOST_HEAVING`.
    rocking: f64,
    /// The smoothed innovation exceeds the usual heaving: the machine rocks, or the content has changed.
    swings: bool,
    /// The moment has jumped in this row.
    jumped: bool,
    /// Payload last known in the air, until the ground may carry the bucket.
    lifted: Option<Lifted>,
}

/// A payload known in the air, where nothing enters a bucket.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Lifted {
    /// Value [kg] and variance [kg^2].
    payload: f64,
    variance: f64,
    /// Variance by what may have left the bucket since [kg^2].
    left: f64,
    /// Smoothed excess of the moment over that of this payload, as a share of the expected moment.
    above: f64,
}

impl Scale {
    /// Prior: a bucket with any content.
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

    /// Resets payload and friction to the prior; the heaving is retained.
    pub fn forget(&mut self, drawing: &Drawing) {
        let heaving = self.heaving;
        *self = Self {
            heaving,
            ..Self::new(drawing)
        };
    }

    /// Updates with a row. `accelerated`: an accelerometer is there.
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
        // The expected friction is taken from the moment already; the residual is a state.
        let by = [per_load, full];
        let innovation = lifting - empty - per_load * self.state[0] - full * self.state[1];
        let predicted = self.variance(by);
        // Shares of the expected moment: of the measured one, low readings of a heaving load would count more than high ones.
        let moment = lifting - innovation;
        let carried = sqrt(moment * moment + predicted) + ARM_ALONE * full;
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

    /// Updates the payload known in the air, and the excess of the moment over it.
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

    /// The moment exceeds that of the payload known in the air: the cylinders press against a stop.
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
            lifted.above * known > JUMPS * sqrt(std * std + usual * known * known)
        })
    }

    /// A stop carries: the payload returns to the one known in the air, with the variance of what may have left.
    pub fn stop(&mut self) {
        if let Some(lifted) = self.lifted {
            self.state[0] = lifted.payload;
            self.covariance[0] = [lifted.variance + lifted.left, 0.0];
            self.covariance[1][0] = 0.0;
        }
        (self.fast, self.swings, self.jumped) = (0.0, false, false);
    }

    /// Widens the payload after a jump: the content may have changed at once.
    pub fn open(&mut self, drawing: &Drawing) {
        let open = JUMP * drawing.capacity;
        self.covariance[0][0] += open * open;
        (self.fast, self.state[1]) = (0.0, 0.0);
    }

    /// Predicts payload and residual friction over `dt`.
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
        let decay = 1.0 - (dt / time).min(1.0);
        self.state[1] *= decay;
        self.covariance[0][1] *= decay;
        self.covariance[1][0] *= decay;
        self.covariance[1][1] =
            decay * decay * self.covariance[1][1] + (1.0 - decay * decay) * unknown * unknown;
    }

    /// Predicted variance of the moment [N^2 m^2].
    fn variance(&self, [a, b]: [f64; 2]) -> f64 {
        let p = &self.covariance;
        a * a * p[0][0] + 2.0 * a * b * p[0][1] + b * b * p[1][1]
    }

    /// Updates smoothed innovation and heaving. Innovation, and its predicted variance, are shares of the moment.
    fn listen(&mut self, innovation: f64, expected: f64, motion: &Motion, dt: f64) {
        let innovation = innovation.clamp(-1.0, 1.0);
        self.fast += (dt / FAST).min(1.0) * (innovation - self.fast);
        if motion.settling || motion.held {
            return;
        }
        let away = innovation - self.fast;
        let square = away * away;
        // An arm that starts or stops rocks its load, so lifting counts here.
        let rocking = (square - expected).max(0.0);
        self.rocking += (dt / ROCKING).min(1.0) * (rocking - self.rocking);
        if !motion.lifting {
            self.heaving += (dt / MEMORY).min(1.0) * (square.min(MOST_HEAVING) - self.heaving);
        }
    }

    /// Variance of the heaving, as a share of the moment: usual or present, whichever is larger.
    fn heaves(&self) -> f64 {
        self.heaving.max(self.rocking)
    }

    /// The smoothed innovation exceeds what state, pressures, this heaving and drawing explain.
    fn is_jump(&self, [carried, predicted, noise]: [f64; 3], heaves: f64) -> bool {
        let square = carried * carried;
        let usual = HEAVING_LEFT * heaves * square
            + NOISE_LEFT * noise * noise
            + UNEXPLAINED * UNEXPLAINED * square;
        self.fast * self.fast * square > JUMPS * JUMPS * (predicted + usual)
    }

    /// The residual friction exceeds what seals can have.
    fn is_no_friction(&self, drawing: &Drawing, unknown: f64) -> bool {
        let (friction, std) = (unknown * drawing.values[FRICTION], drawing.std[FRICTION]);
        self.state[1] * self.state[1] > JUMPS * JUMPS * (friction * friction + std * std)
    }

    /// Predicts the payload while the ground may carry a part: the content may change to any value.
    pub fn dig(&mut self, drawing: &Drawing, dt: f64) {
        let capacity = drawing.capacity;
        let (walk, most) = (DUG_WALK * capacity, DUG * capacity);
        let variance = &mut self.covariance[0][0];
        if *variance < most * most {
            *variance = (*variance + walk * walk * dt).min(most * most);
        }
    }

    /// Kalman update.
    fn correct(&mut self, by: [f64; 2], innovation: f64, variance: f64) {
        let found = Measurement::of(&self.covariance, &by, innovation, variance);
        if found.variance > 0.0 && found.variance.is_finite() && innovation.is_finite() {
            found.take(&mut self.state, &mut self.covariance);
        }
    }

    /// Converts the state to new moments (of the empty arm, of a kilogram), the measured moment being unchanged.
    pub fn redraw(&mut self, [before, after]: [(f64, f64); 2]) {
        let by = before.1 / after.1;
        self.state[0] = by * self.state[0] + (before.0 - after.0) / after.1;
        self.covariance[0][0] *= by * by;
        self.covariance[0][1] *= by;
        self.covariance[1][0] *= by;
    }

    /// Payload by the rows, without errors of the drawing [kg].
    pub fn payload(&self) -> Quantity {
        Quantity {
            value: self.state[0],
            std: sqrt(self.covariance[0][0].max(0.0)),
        }
    }

    /// Residual friction, as a share of the full force.
    pub fn rest(&self) -> f64 {
        self.state[1]
    }

    /// The machine rocks, or the content has changed: some tenths of a second of rows decide.
    pub fn swings(&self) -> bool {
        self.swings
    }

    /// The moment has jumped in this row, without a turning bucket.
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

//! Whether the machine is as heavy as stated: force over acceleration, of late.
//!
//! ```text
//! a = kappa u - c sgn(v),   u = (T_f + T_r)/(r m_stated)
//! ```
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | kappa | `gain` | stated mass over true mass, times true over stated torque | 1 |
//! | c | - | rolling and whatever else resists | m/s^2 |
//!
//! A Kalman filter of both, with signals smoothed over 0.2 s and a random walk by which the last ten seconds count. A sound
//! machine shows 0.95 to 1.03; a full bucket that nobody tells 0.75 to 0.8, and so does a mass that is reported late. A step of
//! kappa means that a load came or went: what was learnt of the centre of gravity is of another machine.

use crate::math::sqrt;

/// Smoothing of the signals [s].
const SMOOTH: f64 = 0.2;
/// Noise of the smoothed acceleration in rows that tell the same for 0.3 s [m/s^2].
pub(super) const NOISE: f64 = 0.05;
pub(super) const TOGETHER: f64 = 0.3;
/// Random walk of kappa and of c [1/sqrt(s)], [m/s^2/sqrt(s)].
const WALK: [f64; 2] = [0.02, 0.01];
/// Standard deviations at the start; c starts at a usual rolling resistance [m/s^2].
const START: [f64; 2] = [0.1, 0.1];
const ROLLING: f64 = 0.2;
/// An innovation beyond this is a bad row or a force, no load [m/s^2].
const LARGEST: f64 = 0.4;
/// Without news kappa is 1 again after so long [s].
const FADES: f64 = 30.0;
/// Tolerances of mass, torques and wheels that explain a kappa beside 1.
const TOLERANCE: f64 = 0.05;
/// A step of kappa that means another load, and in standard deviations.
const STEP: (f64, f64) = (0.08, 3.0);

/// Memory of force and acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Inertia {
    /// Smoothed acceleration, force over mass, and direction.
    smooth: [f64; 3],
    /// kappa and c.
    state: [f64; 2],
    covariance: [[f64; 2]; 2],
    /// kappa when the load changed last.
    anchor: f64,
    stepped: bool,
    /// Time since the last step [s].
    since: f64,
}

impl Default for Inertia {
    fn default() -> Self {
        Self {
            smooth: [0.0; 3],
            state: [1.0, ROLLING],
            covariance: [[START[0] * START[0], 0.0], [0.0, START[1] * START[1]]],
            anchor: 1.0,
            stepped: false,
            since: f64::INFINITY,
        }
    }
}

/// What a row shows of the mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Push {
    /// Acceleration with gravity's share of the slope [m/s^2].
    pub acceleration: f64,
    /// Force of the torques over the stated mass [m/s^2].
    pub pull: f64,
    /// Speed [m/s].
    pub speed: f64,
}

impl Inertia {
    /// Takes a row in which the torques alone move the machine, where it `counts`. A step to a lighter machine needs rows that no
    /// brakes touch to say so: `may_be_lighter`.
    pub fn see(&mut self, row: &Push, counts: bool, may_be_lighter: bool, dt: f64) {
        let direction = if row.speed >= 0.0 { 1.0 } else { -1.0 };
        let weight = (dt / SMOOTH).min(1.0);
        let signals = [row.acceleration, row.pull, direction];
        for (smooth, new) in self.smooth.iter_mut().zip(signals) {
            *smooth += weight * (new - *smooth);
        }
        self.stepped = false;
        self.since += dt;
        self.fade(dt);
        if !counts {
            return;
        }
        let [acceleration, pull, direction] = self.smooth;
        self.covariance[0][0] += WALK[0] * WALK[0] * dt;
        self.covariance[1][1] += WALK[1] * WALK[1] * dt;
        let by = [pull, -direction];
        let p = self.covariance;
        let cross = [
            p[0][0] * by[0] + p[0][1] * by[1],
            p[1][0] * by[0] + p[1][1] * by[1],
        ];
        let noise = NOISE * NOISE * (TOGETHER / dt).max(1.0);
        let total = by[0] * cross[0] + by[1] * cross[1] + noise;
        let innovation = acceleration - by[0] * self.state[0] - by[1] * self.state[1];
        if innovation.abs() > LARGEST {
            // What was found was of bad rows, or of a force that begins: anew.
            let Self { smooth, since, .. } = *self;
            *self = Self {
                smooth,
                since,
                ..Self::default()
            };
            return;
        }
        for i in 0..2 {
            self.state[i] += cross[i] / total * innovation;
            for j in 0..2 {
                self.covariance[i][j] = p[i][j] - cross[i] * cross[j] / total;
            }
        }
        let away = (self.state[0] - self.anchor).abs();
        let braked = self.state[0] > 1.0 + TOLERANCE && !may_be_lighter;
        if away > STEP.0.max(STEP.1 * self.std()) && !braked {
            self.anchor = self.state[0];
            self.stepped = true;
            self.since = 0.0;
        }
    }

    /// What was found fades to what is usual: nothing is remembered for ever.
    fn fade(&mut self, dt: f64) {
        let kept = 1.0 - (dt / FADES).min(1.0);
        let fresh = START[0] * START[0];
        self.state[0] = 1.0 + kept * (self.state[0] - 1.0);
        self.covariance[0][1] *= kept;
        self.covariance[1][0] *= kept;
        self.covariance[0][0] = kept * kept * self.covariance[0][0] + (1.0 - kept * kept) * fresh;
    }

    /// kappa.
    pub fn gain(&self) -> f64 {
        self.state[0]
    }

    /// kappa and c [-, m/s^2].
    pub fn known(&self) -> [f64; 2] {
        self.state
    }

    fn std(&self) -> f64 {
        sqrt(self.covariance[0][0].max(0.0))
    }

    /// A load came or went with this row, and nobody reported it.
    pub fn stepped(&self) -> bool {
        self.stepped
    }

    /// Time since then [s].
    pub fn since_step(&self) -> f64 {
        self.since
    }

    /// By how much kappa lies beside 1 beyond tolerances and chance, with its sign.
    pub fn excess(&self) -> f64 {
        let away = self.state[0] - 1.0;
        (away.abs() - 2.0 * self.std() - TOLERANCE)
            .max(0.0)
            .copysign(away)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Drives to and fro with what the torques say of this stated mass over the true one; the largest and the last excess, and the
    /// number of steps.
    fn drive(inertia: &mut Inertia, kappa: f64) -> (f64, u32) {
        let mut steps = 0;
        for k in 0..4000 {
            let t = f64::from(k) * 0.01;
            let pull = f64::sin(0.8 * t) + 0.2;
            let row = Push {
                acceleration: kappa * pull - 0.2,
                pull,
                speed: 3.0,
            };
            inertia.see(&row, true, true, 0.01);
            steps += u32::from(inertia.stepped());
        }
        (inertia.excess(), steps)
    }

    #[test]
    fn a_load_that_nobody_tells_is_found_and_a_sound_machine_is_left_alone() {
        let mut inertia = Inertia::default();
        assert_eq!(drive(&mut inertia, 0.97), (-0.0, 0));
        let (loaded, steps) = drive(&mut inertia, 0.77);
        assert!(loaded < -0.06 && steps >= 1, "{loaded} {steps}");
        assert!((inertia.gain() - 0.77).abs() < 0.02);
        let (empty, steps) = drive(&mut inertia, 0.99);
        assert!(empty == 0.0 && steps >= 1, "{empty} {steps}");
    }
}

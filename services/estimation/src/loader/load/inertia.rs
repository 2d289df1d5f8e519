//! Whether the machine is as heavy as stated: force over acceleration, of late.
//!
//! ```text
//! a = kappa u - c sgn(v) + z,   u = (T_f + T_r)/(r m_stated)
//! ```
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | kappa | `gain` | stated mass over true mass, times true over stated torque | 1 |
//! | c | - | rolling and whatever else resists | m/s^2 |
//! | z | - | zero of the accelerometer, with gravity's share where load or mounting pitch it | m/s^2 |
//!
//! A Kalman filter of the three, with signals smoothed over 0.2 s and a random walk by which the last ten seconds count. A sound
//! machine shows 0.95 to 1.03; a full bucket that nobody tells 0.75 to 0.8, and so does a mass that is reported late. A step of
//! kappa means that a load came or went: what was learnt of the centre of gravity is of another machine.
//! Without z a machine that turns round seems to resist by 2 z more or less at once, and while it only accelerates, heavier or lighter.
//! Where the mass is reported with its load, that is likelier than a load of which nobody knows, and z is a state; where it is not,
//! z is nothing and such a row speaks for a load: after each stop there may be one.

use crate::linear::{Measurement, diagonal, dot};
use crate::math::sqrt;

/// Smoothing of the signals [s].
const SMOOTH: f64 = 0.2;
/// Noise of the smoothed acceleration in rows that tell the same for 0.3 s [m/s^2].
const NOISE: f64 = 0.05;
const TOGETHER: f64 = 0.3;
/// kappa, c and z.
pub const STATES: usize = 3;
/// Random walk of kappa, c and z [1/sqrt(s)], [m/s^2/sqrt(s)].
const WALK: [f64; STATES] = [0.02, 0.01, 0.01];
/// Standard deviations at the start; c starts at a usual rolling resistance [m/s^2].
const START: [f64; STATES] = [0.1, 0.1, 1e-6];
/// Standard deviation of z: a third of a degree [m/s^2].
pub const ZERO_STD: f64 = 0.06;
const ROLLING: f64 = 0.2;
/// An innovation beyond this is a bad row or a force, no load [m/s^2].
pub const LARGEST: f64 = 0.4;
/// Without news kappa is 1 again after so long [s].
const FADES: f64 = 30.0;
/// Tolerances of mass, torques and wheels that explain a kappa beside 1.
const TOLERANCE: f64 = 0.05;
/// A step of kappa that means another load, and the same in standard deviations.
const STEP: f64 = 0.08;
const STEP_STDS: f64 = 3.0;

/// kappa, c and z, as rows have told them so far.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Force {
    pub state: [f64; STATES],
    pub covariance: [[f64; STATES]; STATES],
}

impl Default for Force {
    fn default() -> Self {
        Self {
            state: [1.0, ROLLING, 0.0],
            covariance: diagonal(START),
        }
    }
}

impl Force {
    /// Whatever it may be that changes the first states, by these random walks, goes on for `dt`.
    pub fn walk(&mut self, walks: &[f64], dt: f64) {
        for (i, walk) in walks.iter().enumerate() {
            self.covariance[i][i] += walk * walk * dt;
        }
    }

    /// kappa is as at the start.
    pub fn open_gain(&mut self) {
        self.covariance[0][0] += START[0] * START[0];
    }

    /// The accelerometer's zero is not known.
    pub fn open_zero(&mut self) {
        self.covariance[2][2] += ZERO_STD * ZERO_STD;
    }

    /// Takes smoothed acceleration, force over mass and direction, `dt` after the last: innovation and its variance. One that is
    /// too large changes nothing.
    pub fn see(&mut self, [acceleration, pull, direction]: [f64; 3], dt: f64) -> [f64; 2] {
        let by = [pull, -direction, 1.0];
        let noise = NOISE * NOISE * (TOGETHER / dt).max(1.0);
        let innovation = acceleration - dot(&self.state, &by);
        let told = Measurement::of(&self.covariance, &by, innovation, noise);
        if innovation.abs() <= LARGEST {
            told.take(&mut self.state, &mut self.covariance);
        }
        [innovation, told.variance]
    }
}

/// Memory of force and acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Inertia {
    /// Smoothed acceleration, force over mass, and direction.
    smooth: [f64; 3],
    force: Force,
    /// kappa when the load changed last.
    anchor: f64,
    stepped: bool,
    /// Time since the last step [s].
    since: f64,
    /// The mass has been reported with its load.
    mass_reported: bool,
}

impl Default for Inertia {
    fn default() -> Self {
        Self {
            smooth: [0.0; 3],
            force: Force::default(),
            anchor: 1.0,
            stepped: false,
            since: f64::INFINITY,
            mass_reported: false,
        }
    }
}

/// What a row shows of the mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
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
        let walks = if self.mass_reported { 3 } else { 2 };
        self.force.walk(&WALK[..walks], dt);
        let [innovation, _] = self.force.see(self.smooth, dt);
        if innovation.abs() > LARGEST {
            // What was found was of bad rows, or of a force that begins: anew.
            let Self {
                smooth,
                since,
                mass_reported,
                ..
            } = *self;
            *self = Self {
                smooth,
                since,
                ..Self::default()
            };
            if mass_reported {
                self.mass_is_reported();
            }
            return;
        }
        let away = (self.force.state[0] - self.anchor).abs();
        let braked = self.force.state[0] > 1.0 + TOLERANCE && !may_be_lighter;
        if away > STEP.max(STEP_STDS * self.std()) && !braked {
            self.anchor = self.force.state[0];
            self.stepped = true;
            self.since = 0.0;
        }
    }

    /// The mass is reported with its load.
    pub fn mass_is_reported(&mut self) {
        if !self.mass_reported {
            self.force.open_zero();
        }
        self.mass_reported = true;
    }

    /// What was found fades to what is usual: nothing is remembered for ever.
    fn fade(&mut self, dt: f64) {
        let kept = 1.0 - (dt / FADES).min(1.0);
        let fresh = START[0] * START[0];
        self.force.state[0] = 1.0 + kept * (self.force.state[0] - 1.0);
        for i in 1..STATES {
            self.force.covariance[0][i] *= kept;
            self.force.covariance[i][0] *= kept;
        }
        self.force.covariance[0][0] =
            kept * kept * self.force.covariance[0][0] + (1.0 - kept * kept) * fresh;
    }

    /// kappa.
    pub fn gain(&self) -> f64 {
        self.force.state[0]
    }

    /// kappa, c and z with their covariance.
    pub fn known(&self) -> &Force {
        &self.force
    }

    /// Acceleration, force over mass and direction, smoothed.
    pub fn signals(&self) -> [f64; 3] {
        self.smooth
    }

    fn std(&self) -> f64 {
        sqrt(self.force.covariance[0][0].max(0.0))
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
        let away = self.force.state[0] - 1.0;
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

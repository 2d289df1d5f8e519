//! Stated over true mass of the machine, from wheel force and acceleration, with a memory of about ten seconds.
//!
//! ```text
//! a = kappa u - c sgn(v) + z,   u = (T_f + T_r)/(r m_stated)
//! ```
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | kappa | `gain` | stated mass over true mass, times true over stated torque | 1 |
//! | c | - | rolling and other resistance | m/s^2 |
//! | z | - | zero of the accelerometer, with gravity's share where load or mounting pitch it | m/s^2 |
//!
//! A Kalman filter estimates the three, with signals smoothed over 0.2 s. Its random walk limits the memory to about ten seconds. kappa is
//! 0.95 to 1.03 on a sound machine, and 0.75 to 0.8 with an unreported full bucket, or with a mass that is reported late. A step of kappa
//! shows that the load has changed: the centre of gravity estimated so far is that of another machine.
//!
//! An unmodelled z changes the apparent resistance by 2 z when the direction of travel reverses, and kappa while the machine only
//! accelerates. Where the mass is reported with its load, such an error is more probable than an unreported load, and z is a state.
//! Otherwise z is fixed at 0 and such a row counts as evidence of a load: one may come at each stop.

use crate::linear::{Measurement, diagonal, dot};
use crate::math::sqrt;

/// Time constant of the smoothed signals [s].
const SMOOTH: f64 = 0.2;
/// Standard deviation [m/s^2] and correlation time [s] of the noise of the smoothed acceleration.
const NOISE: f64 = 0.05;
const TOGETHER: f64 = 0.3;
/// Number of states: kappa, c and z.
pub const STATES: usize = 3;
/// Random walk of kappa [1/sqrt(s)], c and z [m/s^2/sqrt(s)].
const WALK: [f64; STATES] = [0.02, 0.01, 0.01];
/// Initial standard deviations of kappa, c and z [1, m/s^2, m/s^2]; z is fixed until it is opened by `ZERO_STD`.
const START: [f64; STATES] = [0.1, 0.1, 1e-6];
/// Prior standard deviation of z [m/s^2]: a third of a degree.
pub const ZERO_STD: f64 = 0.06;
/// Initial value of c [m/s^2]: a usual rolling resistance.
const ROLLING: f64 = 0.2;
/// Gate of the innovation [m/s^2]: a larger one is a bad row or an external force.
pub const LARGEST: f64 = 0.4;
/// Time constant with which kappa decays to 1 [s].
const FADES: f64 = 30.0;
/// Difference of kappa from 1 that tolerances of mass, torques and wheels explain.
const TOLERANCE: f64 = 0.05;
/// Threshold of a step of kappa that shows another load, absolute and in standard deviations.
const STEP: f64 = 0.08;
const STEP_STDS: f64 = 3.0;

/// Kalman filter of kappa, c and z.
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
    /// Predicts over `dt`: the first states walk by these random walks.
    pub fn walk(&mut self, walks: &[f64], dt: f64) {
        for (i, walk) in walks.iter().enumerate() {
            self.covariance[i][i] += walk * walk * dt;
        }
    }

    /// Raises the variance of kappa to the initial one.
    pub fn reopen_gain(&mut self) {
        self.covariance[0][0] = self.covariance[0][0].max(START[0] * START[0]);
    }

    /// Adds the prior variance to that of z.
    pub fn open_zero(&mut self) {
        self.covariance[2][2] += ZERO_STD * ZERO_STD;
    }

    /// Updates with smoothed acceleration, force over mass and direction, `dt` after the last. Returns innovation and its variance. An
    /// innovation beyond `LARGEST` changes no state.
    pub fn see(&mut self, signals: [f64; 3], dt: f64) -> [f64; 2] {
        let found = self.measure(&signals, dt);
        if found.innovation.abs() <= LARGEST {
            found.take(&mut self.state, &mut self.covariance);
        }
        [found.innovation, found.variance]
    }

    /// Innovation of a row and its variance, without an update.
    pub fn expects(&self, signals: &[f64; 3], dt: f64) -> [f64; 2] {
        let found = self.measure(signals, dt);
        [found.innovation, found.variance]
    }

    fn measure(&self, &[acceleration, pull, direction]: &[f64; 3], dt: f64) -> Measurement<STATES> {
        let by = [pull, -direction, 1.0];
        let noise = NOISE * NOISE * (TOGETHER / dt).max(1.0);
        let innovation = acceleration - dot(&self.state, &by);
        Measurement::of(&self.covariance, &by, innovation, noise)
    }
}

/// State of the filter, and of the detector of steps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Inertia {
    /// Smoothed acceleration, force over mass, and direction.
    smooth: [f64; 3],
    force: Force,
    /// kappa at the last step.
    anchor: f64,
    /// kappa has stepped in this row.
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

/// Signals of a row that determine the mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// Specific force along the body: acceleration and gravity's share by the slope [m/s^2].
    pub acceleration: f64,
    /// Force of the torques over the stated mass [m/s^2].
    pub pull: f64,
    /// Speed [m/s].
    pub speed: f64,
}

impl Inertia {
    /// Updates with a row; it `counts` where the torques alone move the machine. Brakes look like a lighter machine, so a step to a kappa
    /// beyond 1 + `TOLERANCE` needs evidence from rows without brakes: `may_be_lighter`.
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
            // The estimate is of bad rows, or an external force begins: reset.
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

    /// Opens z, once: the mass is reported with its load.
    pub fn mass_is_reported(&mut self) {
        if !self.mass_reported {
            self.force.open_zero();
        }
        self.mass_reported = true;
    }

    /// kappa decays to 1, and its variance to the initial one.
    fn fade(&mut self, dt: f64) {
        let decay = 1.0 - (dt / FADES).min(1.0);
        let prior = START[0] * START[0];
        self.force.state[0] = 1.0 + decay * (self.force.state[0] - 1.0);
        for i in 1..STATES {
            self.force.covariance[0][i] *= decay;
            self.force.covariance[i][0] *= decay;
        }
        self.force.covariance[0][0] =
            decay * decay * self.force.covariance[0][0] + (1.0 - decay * decay) * prior;
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

    /// Standard deviation of kappa.
    fn std(&self) -> f64 {
        sqrt(self.force.covariance[0][0].max(0.0))
    }

    /// An unreported load has come or gone with this row.
    pub fn stepped(&self) -> bool {
        self.stepped
    }

    /// Time since the last step [s].
    pub fn since_step(&self) -> f64 {
        self.since
    }

    /// Difference of kappa from 1 beyond tolerances and two standard deviations, with its sign.
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

    /// Drives with this kappa. Returns the last excess, and the number of steps.
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
    fn an_unreported_load_is_found_and_a_sound_machine_is_left_alone() {
        let mut inertia = Inertia::default();
        assert_eq!(drive(&mut inertia, 0.97), (-0.0, 0));
        let (loaded, steps) = drive(&mut inertia, 0.77);
        assert!(loaded < -0.06 && steps >= 1, "{loaded} {steps}");
        assert!((inertia.gain() - 0.77).abs() < 0.02);
        let (empty, steps) = drive(&mut inertia, 0.99);
        assert!(empty == 0.0 && steps >= 1, "{empty} {steps}");
    }
}

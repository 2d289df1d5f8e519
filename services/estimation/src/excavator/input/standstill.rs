//! Detects standstill of the upper body.
//!
//! At standstill Coulomb friction balances any torque up to its limit, so the equation of motion carries no
//! information about the inertia. A filter would take noise for information. Standstill ends with a measured
//! velocity (whose mean becomes the state) or with a torque above friction.

use crate::excavator::grid::{PERIOD, alike};
use crate::excavator::settings::Settings;
use crate::math::{exp, ln, sqrt};

/// Number of samples of the entry test (0.12 s at 100 Hz).
const ENTRY: usize = 12;
/// Number of samples of the release test (0.04 s).
const RELEASE: usize = 4;
/// Single velocity that is an outlier at standstill [rad/s].
const OUTLIER: f64 = 0.12;
/// Velocity noise to which the thresholds refer [rad/s].
const REFERENCE_STD: f64 = 0.005;
/// Least mean of differenced velocities that is not noise, in its standard deviations.
const CHANCE: f64 = 4.0;
/// Share of the smoothed torque that remains after `TORQUE_TIME` [s].
const TORQUE_DECAY: f64 = 0.65;
const TORQUE_TIME: f64 = 0.01;
/// Least smoothed torque that is not noise, in its standard deviations.
const TORQUE_CHANCE: f64 = 3.0;
/// Mean velocity that ends a standstill, while the torque is quiet and while it is not [rad/s].
const RELEASED_QUIET: f64 = 0.012;
const RELEASED: f64 = 0.03;
/// Mean velocity below which a machine stands [rad/s], if the scatter of the velocity is less than `SCATTER` standard deviations.
const STANDING: f64 = 0.006;
const SCATTER: f64 = 2.0;

/// Weight of a new value in the smoothed torque, after a tick of this length [s].
#[inline(always)]
pub(super) fn torque_share(period: f64) -> f64 {
    1.0 - exp(ln(TORQUE_DECAY) * period / TORQUE_TIME)
}

/// Smoothing of the torque for one length of tick; most ticks have the same length.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Smoothing {
    period: f64,
    /// Weight of a new value.
    share: f64,
    /// Standard deviation of the smoothed noise over that of one value.
    noise: f64,
}

impl Smoothing {
    fn of(period: f64) -> Self {
        let share = torque_share(period);
        Self {
            period,
            share,
            noise: sqrt(share / (2.0 - share)),
        }
    }
}

/// Standard deviation of the released velocity, by its age and the acceleration since [rad/s].
const SETTING_OFF: f64 = 0.02;

/// Variance of the velocity of [`Phase::Released`]; `velocity`: variance of a single velocity [(rad/s)^2].
pub(in crate::excavator) fn released_variance(velocity: f64) -> f64 {
    velocity / RELEASE as f64 + SETTING_OFF * SETTING_OFF
}

/// Phase of the motion at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) enum Phase {
    /// Moving: predict and correct.
    #[default]
    Moving,
    /// Standing: hold.
    Held,
    /// Setting off with this velocity: restart the velocity state.
    Released(f64),
}

/// Standstill detector; it starts at standstill.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Standstill {
    still: bool,
    ring: [f64; ENTRY],
    valid: usize,
    /// Sign of the last velocity if it was an outlier at standstill, else 0.
    large: f64,
    torque: Option<f64>,
    smoothing: Smoothing,
    friction: f64,
    torque_std: f64,
    velocity_std: f64,
    /// Velocities are differences of an encoder's angle: a mean depends only on the first and the last angle.
    differences: bool,
    held_for: f64,
    seen: bool,
}

impl Standstill {
    /// Uses noise of velocity and torque, and friction. `differences`: velocities are differences of an angle.
    pub(in crate::excavator) fn new(settings: &Settings, differences: bool) -> Self {
        Self {
            still: true,
            ring: [0.0; ENTRY],
            valid: 0,
            large: 0.0,
            torque: None,
            smoothing: Smoothing::of(PERIOD),
            friction: settings.coulomb_friction,
            torque_std: settings.sensors.swing_torque_std,
            velocity_std: settings.sensors.swing_velocity_std,
            differences,
            held_for: 0.0,
            seen: false,
        }
    }

    /// Takes one velocity of the grid with its variance; `torque` is the last valid torque, `None` if there is none.
    pub(in crate::excavator) fn step(
        &mut self,
        (velocity, variance): (Option<f64>, f64),
        torque: Option<f64>,
        period: f64,
    ) -> Phase {
        if self.differences && velocity.is_some() {
            self.velocity_std = sqrt(variance);
        }
        let velocity = velocity.filter(|&y| !self.is_outlier(y));
        if let Some(y) = velocity {
            self.ring[self.valid % ENTRY] = y;
            self.valid += 1;
        }
        let quiet = self.quiet(torque, period);
        let phase = if self.still {
            self.leave(quiet)
        } else {
            self.enter(quiet, velocity.is_some())
        };
        if self.still && !self.seen {
            self.seen = self.looks_still();
        }
        phase
    }

    /// Duration of standstill before this sample [s]; counts the samples passed to [`Self::count`].
    pub(in crate::excavator) fn held_for(&self) -> f64 {
        self.held_for
    }

    /// Adds to the duration of standstill; call once per sample, after `held_for` was used.
    pub(in crate::excavator) fn count(&mut self, phase: Phase, period: f64) {
        self.held_for = match phase {
            Phase::Held => self.held_for + period,
            _ => 0.0,
        };
    }

    /// Whether measurements have ever shown a standstill (at the start it is only assumed).
    pub(in crate::excavator) fn seen(&self) -> bool {
        self.seen
    }

    /// Records a standstill that was detected by other means.
    pub(in crate::excavator) fn confirm(&mut self) {
        self.seen = true;
    }

    /// Threshold for a mean of `n` velocities, from the threshold at the reference noise [rad/s].
    fn threshold(&self, reference: f64, n: usize) -> f64 {
        if self.differences {
            reference.max(CHANCE * self.velocity_std / n as f64)
        } else {
            reference * self.velocity_std / REFERENCE_STD
        }
    }

    /// Whether the smoothed torque is below friction or its own noise; true without a torque.
    fn quiet(&mut self, torque: Option<f64>, period: f64) -> bool {
        let Some(torque) = torque else { return true };
        if !alike(period, self.smoothing.period) {
            self.smoothing = Smoothing::of(period);
        }
        let Smoothing { share, noise, .. } = self.smoothing;
        let smoothed = self.torque.unwrap_or(0.0);
        let smoothed = smoothed + share * (torque - smoothed);
        self.torque = Some(smoothed);
        smoothed.abs() < self.friction.max(TORQUE_CHANCE * self.torque_std * noise)
    }

    /// Whether a velocity is too large for a machine that sets off; two in a row with equal sign are accepted.
    fn is_outlier(&mut self, y: f64) -> bool {
        let large = if y.abs() > self.threshold(OUTLIER, 1) {
            y.signum()
        } else {
            0.0
        };
        let accepted = large == 0.0 || large == self.large;
        self.large = large;
        self.still && !accepted
    }

    fn leave(&mut self, quiet: bool) -> Phase {
        if self.valid < RELEASE {
            return Phase::Held;
        }
        let mean = self.mean(RELEASE);
        let threshold = self.threshold(if quiet { RELEASED_QUIET } else { RELEASED }, RELEASE);
        if mean.abs() > threshold {
            self.still = false;
            Phase::Released(mean)
        } else if quiet {
            Phase::Held
        } else {
            self.still = false;
            Phase::Moving
        }
    }

    fn enter(&mut self, quiet: bool, measured: bool) -> Phase {
        if quiet && measured && self.looks_still() {
            self.still = true;
            self.seen = true;
            Phase::Held
        } else {
            Phase::Moving
        }
    }

    fn looks_still(&self) -> bool {
        if self.valid < ENTRY {
            return false;
        }
        let mean = self.mean(ENTRY);
        let square: f64 = self.ring.iter().map(|y| (y - mean) * (y - mean)).sum();
        let std = sqrt(square / (ENTRY - 1) as f64);
        mean.abs() < self.threshold(STANDING, ENTRY) && std < SCATTER * self.velocity_std
    }

    fn mean(&self, n: usize) -> f64 {
        (1..=n)
            .map(|back| self.ring[(self.valid - back) % ENTRY])
            .sum::<f64>()
            / n as f64
    }
}

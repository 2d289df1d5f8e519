//! Linear Kalman filters of the swing motion (Oh, Yi, Seo, Kim, Lee 2017, Eqs. 1-10).
//!
//! Velocity w and acceleration a; the acceleration is a random walk:
//!
//! ```text
//! w_k = w_{k-1} + T a_{k-1},   a_k = a_{k-1} + noise of variance q,   y_k = w_k + noise of variance R
//! ```
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | w, a | `velocity`, `acceleration` | state | rad/s, rad/s^2 |
//! | T | `period` | sampling period | s |
//! | q | `process_variance` | variance added to the acceleration per step | (rad/s^2)^2 |
//! | R | `measurement_variance` | variance of one velocity sample | (rad/s)^2 |
//! | K | `Gain` | gain after prediction | -, 1/s |
//!
//! Misprints of the source: it calls the model a "double integrator" and leaves G undefined (Eqs.
//! 1, 7; here G = I and Q = diag(0, q)), and writes equality where distributions are meant (Eqs. 3,
//! 4). It gives one Q without a sampling period: q is the variance per step, so for the same motion it is
//! proportional to T.

use crate::math::sqrt;
use nalgebra::{Matrix3, Vector3};

/// Innovation of a measurement with its predicted variance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Innovation {
    /// Measured minus predicted; 0 where nothing was measured.
    pub value: f64,
    /// Its predicted variance.
    pub variance: f64,
}

impl Innovation {
    /// Normalised innovation squared; 0 where nothing was measured.
    pub fn nis(&self) -> f64 {
        if self.variance > 0.0 {
            self.value * self.value / self.variance
        } else {
            0.0
        }
    }

    /// Innovation over its predicted standard deviation.
    pub fn normalised(&self) -> f64 {
        if self.variance > 0.0 {
            self.value / sqrt(self.variance)
        } else {
            0.0
        }
    }
}

/// Kalman filter of velocity and acceleration from a measured velocity.
///
/// ```
/// use estimation::kalman::VelocityFilter;
///
/// let mut filter = VelocityFilter::new(0.0, 1e-6);
/// for row in 1..=200 {
///     filter.predict(0.01, 1e-4);
///     filter.correct(Some(0.5 * 0.01 * f64::from(row)), 1e-6); // 0.5 rad/s^2
/// }
/// assert!((filter.acceleration() - 0.5).abs() < 0.01);
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VelocityFilter {
    velocity: f64,
    acceleration: f64,
    p11: f64,
    p12: f64,
    p22: f64,
}

impl VelocityFilter {
    /// Starts at the first sample's velocity (0 where it is missing) with P = diag(R, 0.01).
    pub fn new(velocity: f64, measurement_variance: f64) -> Self {
        Self::with_acceleration_variance(velocity, measurement_variance, 0.01)
    }

    /// Starts with another variance of the acceleration [(rad/s^2)^2].
    pub fn with_acceleration_variance(velocity: f64, measurement_variance: f64, p22: f64) -> Self {
        Self {
            velocity,
            acceleration: 0.0,
            p11: measurement_variance,
            p12: 0.0,
            p22,
        }
    }

    /// Moves the state forward by `period` seconds.
    #[inline]
    pub fn predict(&mut self, period: f64, process_variance: f64) {
        let t = period;
        self.velocity += t * self.acceleration; // (5)
        let p12 = self.p12 + t * self.p22; // (6)
        self.p11 += t * (self.p12 + p12);
        self.p12 = p12;
        self.p22 += process_variance;
    }

    /// Returns the innovation that `velocity` would have; changes nothing.
    #[inline]
    pub fn innovation(&self, velocity: Option<f64>, measurement_variance: f64) -> Innovation {
        Innovation {
            value: velocity.map_or(0.0, |y| y - self.velocity),
            variance: self.p11 + measurement_variance,
        }
    }

    /// Corrects with a measured velocity; a missing one changes nothing.
    #[inline]
    pub fn correct(&mut self, velocity: Option<f64>, measurement_variance: f64) -> Innovation {
        let innovation = self.innovation(velocity, measurement_variance);
        if velocity.is_some() {
            let k1 = self.p11 / innovation.variance; // (8)
            let k2 = self.p12 / innovation.variance;
            self.velocity += k1 * innovation.value; // (9)
            self.acceleration += k2 * innovation.value;
            self.p22 -= k2 * self.p12; // (10)
            self.p12 = k2 * measurement_variance; // P H' = K R: no cancellation
            self.p11 = k1 * measurement_variance;
        }
        innovation
    }

    /// Velocity [rad/s].
    pub fn velocity(&self) -> f64 {
        self.velocity
    }

    /// Acceleration [rad/s^2].
    pub fn acceleration(&self) -> f64 {
        self.acceleration
    }

    /// Covariance (P11, P12, P22).
    pub fn covariance(&self) -> [f64; 3] {
        [self.p11, self.p12, self.p22]
    }
}

/// The steady state of [`VelocityFilter`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gain {
    /// Gain of the velocity.
    pub velocity: f64,
    /// Gain of the acceleration [1/s].
    pub acceleration: f64,
    /// Covariance after the correction (P11, P12, P22).
    pub covariance: [f64; 3],
}

impl Gain {
    /// The steady gain in closed form.
    ///
    /// The poles z of the steady filter solve `R u^2 + q T^2 = 0` with `u = (1 - z)(1 - 1/z)`, that
    /// is `s^2 - i c s + i c = 0` for `s = 1 - z`, `c = T sqrt(q/R)`; then `K1 = 1 - |z|^2` and
    /// `K2 = |s|^2 / T`.
    pub fn steady(period: f64, process_variance: f64, measurement_variance: f64) -> Self {
        let c = period * sqrt(process_variance / measurement_variance);
        // s = (i c + root) / 2 with root^2 = -c^2 - 4 i c; the root with positive real part has |z| < 1.
        let (re2, im2) = (-c * c, -4.0 * c);
        let modulus = sqrt(re2 * re2 + im2 * im2);
        let re = sqrt(im2 * im2 / (2.0 * (modulus - re2)));
        let im = im2 / (2.0 * re);
        let (s_re, s_im) = (0.5 * re, 0.5 * (c + im));
        let square = s_re * s_re + s_im * s_im;
        let k1 = 2.0 * s_re - square;
        let k2 = square / period;
        let (p11, p12) = (k1 * measurement_variance, k2 * measurement_variance);
        let p22 = p12 * k1 / ((1.0 - k1) * period);
        Self {
            velocity: k1,
            acceleration: k2,
            covariance: [p11, p12, p22],
        }
    }

    /// Time until the estimated acceleration is within 5 % of a step of the true one \[s\].
    ///
    /// The paper leaves this delay to an offline test; here it follows from the gain: the error
    /// obeys e <- (I - K H) F e from e = (0, 1).
    pub fn convergence_delay(&self, period: f64) -> f64 {
        // |e| has decayed below 1e-3 after ten time constants; K2 T = (wn T)^2.
        let natural = sqrt(self.acceleration * period) / period;
        let steps = (10.0 / (natural * period)).clamp(10.0, 20_000.0) as usize;
        let (mut e1, mut e2, mut last) = (0.0, 1.0_f64, 0);
        for n in 1..=steps {
            let predicted = e1 + period * e2;
            e1 = (1.0 - self.velocity) * predicted;
            e2 -= self.acceleration * predicted;
            if e2.abs() > 0.05 {
                last = n;
            }
        }
        period * (1 + last) as f64
    }
}

/// Kalman filter of angle, velocity and acceleration from an encoder's angle; the acceleration is a
/// random walk as in [`VelocityFilter`].
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AngleFilter {
    x: Vector3<f64>,
    p: Matrix3<f64>,
}

impl AngleFilter {
    /// Starts at rest at the first angle \[rad\]; `rate_std` [rad/s] and `acceleration_std`
    /// [rad/s^2] are the standard deviations about rest.
    pub fn new(angle: f64, angle_variance: f64, rate_std: f64, acceleration_std: f64) -> Self {
        Self {
            x: Vector3::new(angle, 0.0, 0.0),
            p: Matrix3::from_diagonal(&Vector3::new(
                angle_variance,
                rate_std * rate_std,
                acceleration_std * acceleration_std,
            )),
        }
    }

    /// Moves the state forward by `period` seconds.
    pub fn predict(&mut self, period: f64, process_variance: f64) {
        let t = period;
        let f = Matrix3::new(1.0, t, 0.5 * t * t, 0.0, 1.0, t, 0.0, 0.0, 1.0);
        self.x = f * self.x;
        self.p = f * self.p * f.transpose();
        self.p[(2, 2)] += process_variance;
    }

    /// Corrects with a measured angle; a missing one changes nothing.
    pub fn correct(&mut self, angle: Option<f64>, angle_variance: f64) -> Innovation {
        let innovation = Innovation {
            value: angle.map_or(0.0, |y| y - self.x[0]),
            variance: self.p[(0, 0)] + angle_variance,
        };
        if angle.is_some() {
            let gain = self.p.column(0) / innovation.variance;
            self.x += gain * innovation.value;
            self.p -= gain * self.p.row(0);
            self.p = (self.p + self.p.transpose()) * 0.5;
        }
        innovation
    }

    /// Angle \[rad\].
    pub fn angle(&self) -> f64 {
        self.x[0]
    }

    /// Velocity [rad/s].
    pub fn velocity(&self) -> f64 {
        self.x[1]
    }

    /// Acceleration [rad/s^2].
    pub fn acceleration(&self) -> f64 {
        self.x[2]
    }

    /// Variances of velocity and acceleration.
    pub fn variances(&self) -> [f64; 2] {
        [self.p[(1, 1)], self.p[(2, 2)]]
    }
}

//! The problems on which filters are compared, and their data.
//!
//! | problem | states | measurements | model |
//! |---|---|---|---|
//! | `kf_2_1` | velocity, acceleration | velocity | acceleration is a random walk |
//! | `rls_3` | inertia, damping, torque | - | 0 = J a + b w - T, a forgetting factor each |
//! | `srukf_6_3`, `ekf_6_3` | v, w_f, w_r, K, h, lambda | v, w_f, w_r | [`Rover`], some 40 flops with 3 divisions |
//!
//! `Rover` is a wheel loader simplified until every peer can run it: explicit Euler, no limits, no law of the rolling resistance.
//! The cost of the real loader is measured separately.

use estimation::model::Model;
use estimation::scalar::Scalar;

/// Samples in one pass over the data of a problem.
pub const SAMPLES: usize = 512;

/// A filter on a problem with `N` states and samples of type `Z`.
pub trait Filter<Z, const N: usize> {
    /// One prediction and one update.
    fn step(&mut self, sample: &Z);
    /// The state after it.
    fn state(&self) -> [f64; N];
}

/// Parameters of the Kalman filter problem.
#[derive(Debug, Clone, Copy)]
pub struct VelocityProblem {
    /// Sampling period \[s\].
    pub period: f64,
    /// Variance of the acceleration's step [rad^2/s^4].
    pub process_variance: f64,
    /// Variance of the measured velocity [rad^2/s^2].
    pub measurement_variance: f64,
    /// Initial variances.
    pub initial_variance: [f64; 2],
}

/// The swing of an excavator at 100 Hz.
pub const VELOCITY: VelocityProblem = VelocityProblem {
    period: 0.01,
    process_variance: 4.7e-5,
    measurement_variance: 2.5e-5,
    initial_variance: [2.5e-5, 0.01],
};

/// A measured swing velocity [rad/s], one per sample.
pub fn velocity_data() -> Vec<f64> {
    let mut noise = Noise::new(1);
    (0..SAMPLES)
        .map(|k| {
            0.5 * (std::f64::consts::TAU * k as f64 / SAMPLES as f64).sin() + 0.005 * noise.next()
        })
        .collect()
}

/// Parameters of the recursive least squares problem.
#[derive(Debug, Clone, Copy)]
pub struct RegressionProblem {
    /// Initial parameters: inertia [kg m^2], damping [N m s], torque [N m].
    pub parameters: [f64; 3],
    /// Initial variances.
    pub covariance: [f64; 3],
    /// Forgetting factors.
    pub forgetting: [f64; 3],
}

/// The paper's regression.
pub const REGRESSION: RegressionProblem = RegressionProblem {
    parameters: [6000.0, 1500.0, 2500.0],
    covariance: [1e2, 1e2, 1e6],
    forgetting: [0.99, 0.69, 0.1],
};

/// Regressors (acceleration, velocity, -1) of a swing.
pub fn regression_data() -> Vec<[f64; 3]> {
    let mut noise = Noise::new(2);
    let phase = |k: usize| std::f64::consts::TAU * k as f64 / SAMPLES as f64;
    (0..SAMPLES)
        .map(|k| {
            [
                0.4 * phase(k).cos() + 0.02 * noise.next(),
                0.5 * phase(k).sin() + 0.005 * noise.next(),
                -1.0,
            ]
        })
        .collect()
}

/// One sample of the [`Rover`]: torques of the axles [N m per kg], measured v [m/s], w_f and w_r [rad/s].
#[derive(Debug, Clone, Copy)]
pub struct RoverSample {
    /// Front and rear torque.
    pub torque: [f64; 2],
    /// Measurements.
    pub measured: [f64; 3],
}

/// A two-axle vehicle per unit of mass: slip, load transfer, explicit Euler.
#[derive(Debug, Clone, Copy)]
pub struct Rover {
    /// Sampling period \[s\].
    pub period: f64,
    /// Wheel radius \[m\].
    pub radius: f64,
    /// Gravity [m/s^2].
    pub gravity: f64,
    /// One over the wheelbase [1/m].
    pub per_wheelbase: f64,
    /// Sampling period over the inertia of an axle per unit of mass [s/m^2].
    pub gain: f64,
    /// Resistance per unit of mass [m/s^2].
    pub resistance: f64,
    /// Torques of the step [m^2/s^2].
    pub torque: [f64; 2],
}

impl Rover {
    /// The vehicle at 100 Hz, torques zero.
    pub const NEW: Rover = Rover {
        period: 0.01,
        radius: 0.5,
        gravity: 9.81,
        per_wheelbase: 0.5,
        gain: 0.01,
        resistance: 0.2,
        torque: [0.0; 2],
    };

    /// The same vehicle with other torques.
    #[inline(always)]
    pub fn under(&self, torque: [f64; 2]) -> Self {
        Self { torque, ..*self }
    }

    /// The dynamic states a period later.
    #[inline(always)]
    pub fn advance<T: Scalar>(&self, x: &[T; 6]) -> [T; 3] {
        self.advance_with(x, self.torque.map(T::constant))
    }

    /// The same with torques of the state's type, which may differ from lane to lane.
    #[inline(always)]
    pub fn advance_with<T: Scalar>(&self, x: &[T; 6], torque: [T; 2]) -> [T; 3] {
        let [v, front, rear, stiffness, height, share] = *x;
        let grip_front = stiffness * ((front * self.radius) / v - 1.0);
        let grip_rear = stiffness * ((rear * self.radius) / v - 1.0);
        let difference = grip_front - grip_rear;
        let lever = height * self.per_wheelbase;
        let drive = (share * difference + grip_rear) * self.gravity - self.resistance;
        let acceleration = drive / (lever * difference + 1.0);
        let transfer = share * self.gravity - lever * acceleration;
        let force_front = grip_front * transfer;
        let force_rear = grip_rear * (-transfer + self.gravity);
        [
            v + acceleration * self.period,
            front + (torque[0] - force_front * self.radius) * self.gain,
            rear + (torque[1] - force_rear * self.radius) * self.gain,
        ]
    }

    /// The whole state a period later, in `f64`, for peers.
    #[inline(always)]
    pub fn next(&self, x: &[f64; 6]) -> [f64; 6] {
        let [v, front, rear] = self.advance(x);
        [v, front, rear, x[3], x[4], x[5]]
    }

    /// The first three rows of the Jacobian of [`Rover::next`], written by hand, for peers; the others are unit rows.
    #[inline(always)]
    pub fn jacobian(&self, x: &[f64; 6]) -> [[f64; 6]; 3] {
        let [v, front, rear, k, height, share] = *x;
        let (g, reciprocal, lever) = (self.gravity, 1.0 / v, height * self.per_wheelbase);
        let (ratio_front, ratio_rear) = (
            self.radius * front * reciprocal,
            self.radius * rear * reciprocal,
        );
        let (slip_front, slip_rear) = (ratio_front - 1.0, ratio_rear - 1.0);
        let (grip_front, grip_rear) = (k * slip_front, k * slip_rear);
        let difference = grip_front - grip_rear;
        let scale = 1.0 / (lever * difference + 1.0);
        let a = ((share * difference + grip_rear) * g - self.resistance) * scale;
        let transfer = share * g - lever * a;
        let (by_speed, by_wheel) = (-k * reciprocal, k * self.radius * reciprocal);
        let d_front = [by_speed * ratio_front, by_wheel, 0.0, slip_front, 0.0, 0.0];
        let d_rear = [by_speed * ratio_rear, 0.0, by_wheel, slip_rear, 0.0, 0.0];
        let d_lever = [0.0, 0.0, 0.0, 0.0, self.per_wheelbase, 0.0];
        let d_share = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let gain = -self.radius * self.gain;
        let mut rows = [[0.0; 6]; 3];
        for i in 0..6 {
            let d_difference = d_front[i] - d_rear[i];
            let d_drive = (d_rear[i] + share * d_difference + d_share[i] * difference) * g;
            let d_a = (d_drive - a * (lever * d_difference + d_lever[i] * difference)) * scale;
            let d_transfer = d_share[i] * g - d_lever[i] * a - lever * d_a;
            rows[0][i] = self.period * d_a;
            rows[1][i] = gain * (d_front[i] * transfer + grip_front * d_transfer);
            rows[2][i] = gain * (d_rear[i] * (g - transfer) - grip_rear * d_transfer);
        }
        for (i, row) in rows.iter_mut().enumerate() {
            row[i] += 1.0;
        }
        rows
    }
}

impl Model<6, 3> for Rover {
    const DYNAMIC: usize = 3;
    const DIRECT: std::ops::Range<usize> = 0..3;

    #[inline(always)]
    fn predict<T: Scalar>(&self, state: &[T; 6]) -> ([T; 6], [T; 3]) {
        let next = self.advance(state);
        let [v, front, rear] = next;
        ([v, front, rear, state[3], state[4], state[5]], next)
    }
}

/// Noise and start of a filter on the [`Rover`], as standard deviations.
#[derive(Debug, Clone, Copy)]
pub struct RoverProblem {
    /// The vehicle.
    pub rover: Rover,
    /// Initial state.
    pub state: [f64; 6],
    /// Its initial standard deviations.
    pub initial_std: [f64; 6],
    /// Process noise of a step.
    pub process_std: [f64; 6],
    /// Measurement noise.
    pub measurement_std: [f64; 3],
}

/// The comparison's rover, with an initial error.
pub const ROVER: RoverProblem = RoverProblem {
    rover: Rover::NEW,
    state: [1.5, 3.05, 3.05, 6.0, 0.8, 0.5],
    initial_std: [0.05, 0.05, 0.05, 1.0, 0.1, 0.05],
    process_std: [5e-4, 1e-3, 1e-3, 3e-4, 3e-5, 3e-5],
    measurement_std: [0.02, 0.05, 0.05],
};

/// A drive of the rover with alternating torque, measured with noise.
pub fn rover_data() -> Vec<RoverSample> {
    let mut noise = Noise::new(3);
    let mut state = [1.5, 3.02, 3.02, 5.0, 0.9, 0.45];
    (0..SAMPLES)
        .map(|k| {
            let push = if (k / 64) % 2 == 0 { 0.3 } else { -0.1 };
            let torque = [0.06 + push, 0.05 + push];
            state = Rover::NEW.under(torque).next(&state);
            let measured =
                std::array::from_fn(|j| state[j] + ROVER.measurement_std[j] * noise.next());
            RoverSample { torque, measured }
        })
        .collect()
}

/// Deterministic noise of unit variance, sufficiently normal for a benchmark: the sum of twelve uniform numbers.
struct Noise(u64);

impl Noise {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use estimation::dual::Dual;

    #[test]
    fn the_hand_written_jacobian_is_the_derivative() {
        let x = [1.4, 3.1, 2.9, 5.5, 0.85, 0.47];
        let rover = Rover::NEW.under([0.3, 0.2]);
        let seeded: [Dual<6>; 6] = std::array::from_fn(|i| {
            Dual::new(x[i], std::array::from_fn(|j| f64::from(u8::from(i == j))))
        });
        for (row, dual) in rover.jacobian(&x).iter().zip(rover.advance(&seeded)) {
            for (mine, exact) in row.iter().zip(dual.derivative) {
                // Both are exact to rounding.
                assert!((mine - exact).abs() < 1e-13, "{mine} {exact}");
            }
        }
    }

    #[test]
    fn the_drive_stays_where_the_model_holds() {
        assert!(
            rover_data()
                .iter()
                .all(|sample| sample.measured[0] > 0.5 && sample.measured[0] < 5.0)
        );
    }
}

//! A user's own model in two filters, a pendulum with measured angle: `cargo run -p estimation --example own_filter`.
//!
//! The model is written once. The extended Kalman filter differentiates it exactly; the square-root unscented filter
//! evaluates it at sigma points.

use estimation::ekf::Ekf;
use estimation::model::Model;
use estimation::scalar::Scalar;
use estimation::sigma_points::Spread;
use estimation::srukf::SquareRootUkf;

/// Time between two rows [s], gravity over length [1/s^2].
const PERIOD: f64 = 0.01;
const STIFFNESS: f64 = 9.81;

/// Angle [rad] and rate [rad/s]; the angle is measured.
struct Pendulum;

impl Model<2, 1> for Pendulum {
    fn predict<T: Scalar>(&self, [angle, rate]: &[T; 2]) -> ([T; 2], [T; 1]) {
        let next = *angle + *rate * PERIOD;
        (
            [next, *rate - Scalar::sin(*angle) * (STIFFNESS * PERIOD)],
            [next],
        )
    }
}

fn main() {
    // The filters start at rest, half a radian off.
    let (start, std) = ([0.5, 0.0], [1.0, 1.0]);
    let mut ekf = Ekf::<2, 1>::new(start, &std);
    let mut ukf = SquareRootUkf::<2, 1>::new(start, &std, Spread::UNIT);
    let (process_std, measurement_std) = ([1e-4, 1e-3], [0.02]);
    let mut truth = [1.0, 0.0];
    for row in 1..=500_u32 {
        (truth, _) = Pendulum.predict(&truth);
        // Sensor error that resembles noise and is the same in each run.
        let noise = 0.02 * (f64::from(row) * 12.9898).sin();
        let measured = [truth[0] + noise];
        ekf.step(&Pendulum, &process_std, &measured, &measurement_std);
        ukf.step(&Pendulum, &process_std, &measured, &measurement_std);
        if row % 100 == 0 {
            println!(
                "{:4.1} s  truth {:7.4} rad  EKF {:7.4}  UKF {:7.4}",
                f64::from(row) * PERIOD,
                truth[0],
                ekf.state[0],
                ukf.state[0]
            );
        }
    }
}

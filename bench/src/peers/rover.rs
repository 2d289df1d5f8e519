//! Common parts of the peers on the rover: noise in the form of each, sigma points, and the rover for kfilter.

use kfilter::measurement::LinearMeasurement;
use kfilter::system::{InputSystem, LinearisableSystem, System};
use nalgebra::{Matrix3, Matrix6, Vector6};
use nalgebra_of_kfilter as older;

use crate::problem::{ROVER, Rover};

pub(super) fn variances<const N: usize>(std: &[f64; N]) -> [f64; N] {
    std.map(|std| std * std)
}

/// Covariances at the start, of the process and of the measurements.
pub(super) fn covariances() -> (Matrix6<f64>, Matrix6<f64>, Matrix3<f64>) {
    (
        Matrix6::from_diagonal(&variances(&ROVER.initial_std).into()),
        Matrix6::from_diagonal(&variances(&ROVER.process_std).into()),
        Matrix3::from_diagonal(&variances(&ROVER.measurement_std).into()),
    )
}

/// The sigma points of a mean and a lower root of its covariance, the mean first; alpha = 1, kappa = 0.
pub(super) fn sigma_points(x: Vector6<f64>, root: Matrix6<f64>) -> [Vector6<f64>; 13] {
    let scaled = root * 6f64.sqrt();
    let mut points = [x; 13];
    for i in 0..6 {
        points[1 + i] += scaled.column(i);
        points[7 + i] -= scaled.column(i);
    }
    points
}

/// The whole Jacobian, row by row.
pub(super) fn jacobian(rover: &Rover, x: &[f64; 6]) -> [[f64; 6]; 6] {
    let [v, front, rear] = rover.jacobian(x);
    let unit = |i: usize| std::array::from_fn(|j| f64::from(u8::from(i == j)));
    [v, front, rear, unit(3), unit(4), unit(5)]
}

/// A diagonal matrix for numeris.
pub(super) fn diagonal<const N: usize>(values: [f64; N]) -> numeris::Matrix<f64, N, N> {
    let mut matrix = numeris::Matrix::zeros();
    for (i, value) in values.into_iter().enumerate() {
        matrix[(i, i)] = value;
    }
    matrix
}

/// The rover as a system of kfilter, whose unscented filter needs no derivative.
pub(super) struct KfilterRover {
    rover: Rover,
    x: older::Vector6<f64>,
    q: older::Matrix6<f64>,
    f: older::Matrix6<f64>,
    f_transposed: older::Matrix6<f64>,
}

impl KfilterRover {
    /// The rover with its initial covariance.
    pub(super) fn start() -> (Self, older::Matrix6<f64>) {
        let system = Self {
            rover: ROVER.rover,
            x: ROVER.state.into(),
            q: older::Matrix6::from_diagonal(&variances(&ROVER.process_std).into()),
            f: older::Matrix6::identity(),
            f_transposed: older::Matrix6::identity(),
        };
        let covariance = older::Matrix6::from_diagonal(&variances(&ROVER.initial_std).into());
        (system, covariance)
    }
}

impl System<f64, 6, 2> for KfilterRover {
    fn covariance(&self) -> &older::Matrix6<f64> {
        &self.q
    }
    fn state(&self) -> &older::Vector6<f64> {
        &self.x
    }
    fn state_mut(&mut self) -> &mut older::Vector6<f64> {
        &mut self.x
    }
}

impl LinearisableSystem<f64, 6, 2> for KfilterRover {
    fn transition(&self) -> &older::Matrix6<f64> {
        &self.f
    }
    fn transition_transpose(&self) -> &older::Matrix6<f64> {
        &self.f_transposed
    }
}

impl InputSystem<f64, 6, 2> for KfilterRover {
    fn step(&mut self, u: older::Vector2<f64>) -> &older::Vector6<f64> {
        let rover = self.rover.under(u.into());
        let x = self.x.into();
        // Column by column, so the flat rows are the transposed matrix.
        self.f_transposed = older::Matrix6::from_column_slice(jacobian(&rover, &x).as_flattened());
        self.f = self.f_transposed.transpose();
        self.x = rover.next(&x).into();
        &self.x
    }

    fn predict(&self, x: &older::Vector6<f64>, u: &older::Vector2<f64>) -> older::Vector6<f64> {
        self.rover.under((*u).into()).next(&(*x).into()).into()
    }
}

/// kfilter's measurement of the rover.
pub(super) fn kfilter_measurement() -> LinearMeasurement<f64, 6, 3> {
    LinearMeasurement::new(
        older::Matrix3x6::identity(),
        older::Matrix3::from_diagonal(&variances(&ROVER.measurement_std).into()),
        older::Vector3::zeros(),
    )
}

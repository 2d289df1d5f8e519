//! Extended Kalman filters, all with a hand-written Jacobian.

use super::rover::{KfilterRover, covariances, diagonal, jacobian, kfilter_measurement, variances};
use crate::problem::{Filter, ROVER, Rover, RoverSample};
use kfilter::{KalmanFilter as _, KalmanPredictInput, KalmanUpdate};
use nalgebra::{Matrix3, Matrix3x6, Matrix6, Vector3, Vector6};

/// The textbook form in nalgebra.
pub struct Textbook {
    rover: Rover,
    x: Vector6<f64>,
    p: Matrix6<f64>,
    q: Matrix6<f64>,
    h: Matrix3x6<f64>,
    r: Matrix3<f64>,
}

impl Default for Textbook {
    fn default() -> Self {
        let (p, q, r) = covariances();
        Self {
            rover: ROVER.rover,
            x: ROVER.state.into(),
            p,
            q,
            h: Matrix3x6::identity(),
            r,
        }
    }
}

impl Filter<RoverSample, 6> for Textbook {
    fn step(&mut self, sample: &RoverSample) {
        let rover = self.rover.under(sample.torque);
        let x = self.x.into();
        let f = Matrix6::from_row_slice(jacobian(&rover, &x).as_flattened());
        self.x = rover.next(&x).into();
        self.p = f * self.p * f.transpose() + self.q;
        let s = self.h * self.p * self.h.transpose() + self.r;
        let Some(inverse) = s.try_inverse() else {
            return;
        };
        let k = self.p * self.h.transpose() * inverse;
        self.x += k * (Vector3::from(sample.measured) - self.h * self.x);
        self.p = ((Matrix6::identity() - k * self.h) * self.p).symmetric_part();
    }

    fn state(&self) -> [f64; 6] {
        self.x.into()
    }
}

/// smelly, fixed size. It has no process function, so the state is advanced by hand and the prediction updates the covariance.
pub struct Smelly {
    filter: smelly::SExtendedKalmanFilter<f64, 6, 3>,
    rover: Rover,
}

impl Default for Smelly {
    fn default() -> Self {
        let start = Textbook::default();
        let mut filter = smelly::SExtendedKalmanFilter::new();
        let set = filter
            .set_state(start.x)
            .and_then(|()| filter.set_covariance(start.p))
            .and_then(|()| filter.set_process_noise(start.q))
            .and_then(|()| filter.set_measurement_noise(start.r));
        assert!(set.is_ok(), "fixed sizes always fit");
        Self {
            filter,
            rover: ROVER.rover,
        }
    }
}

impl Filter<RoverSample, 6> for Smelly {
    fn step(&mut self, sample: &RoverSample) {
        let rover = self.rover.under(sample.torque);
        let x = (*self.filter.state()).into();
        let _ = self
            .filter
            .set_transition(Matrix6::from_row_slice(jacobian(&rover, &x).as_flattened()));
        let _ = self.filter.predict();
        let _ = self.filter.set_state(rover.next(&x).into());
        let _ = self.filter.update(
            &sample.measured.into(),
            |x| Vector3::new(x[0], x[1], x[2]),
            |_| Matrix3x6::identity(),
        );
    }

    fn state(&self) -> [f64; 6] {
        (*self.filter.state()).into()
    }
}

/// kfilter.
pub struct Kfilter {
    filter: kfilter::Kalman<f64, 6, 2, KfilterRover>,
    measurement: kfilter::measurement::LinearMeasurement<f64, 6, 3>,
}

impl Default for Kfilter {
    fn default() -> Self {
        let (system, covariance) = KfilterRover::start();
        Self {
            filter: kfilter::Kalman::new_custom(system, covariance),
            measurement: kfilter_measurement(),
        }
    }
}

impl Filter<RoverSample, 6> for Kfilter {
    fn step(&mut self, sample: &RoverSample) {
        self.measurement.z = sample.measured.into();
        let _ = self.filter.predict(sample.torque.into());
        let _ = self.filter.update(&self.measurement);
    }

    fn state(&self) -> [f64; 6] {
        (*self.filter.state()).into()
    }
}

/// numeris, Joseph form.
pub struct Numeris {
    filter: numeris::estimate::Ekf<f64, 6, 3>,
    rover: Rover,
    q: numeris::Matrix<f64, 6, 6>,
    h: numeris::Matrix<f64, 3, 6>,
    r: numeris::Matrix<f64, 3, 3>,
}

impl Default for Numeris {
    fn default() -> Self {
        let mut h = numeris::Matrix::zeros();
        for j in 0..3 {
            h[(j, j)] = 1.0;
        }
        Self {
            filter: numeris::estimate::Ekf::new(
                numeris::Vector::from_array(ROVER.state),
                diagonal(variances(&ROVER.initial_std)),
            ),
            rover: ROVER.rover,
            q: diagonal(variances(&ROVER.process_std)),
            h,
            r: diagonal(variances(&ROVER.measurement_std)),
        }
    }
}

impl Filter<RoverSample, 6> for Numeris {
    fn step(&mut self, sample: &RoverSample) {
        let rover = self.rover.under(sample.torque);
        let array = |x: &numeris::Vector<f64, 6>| std::array::from_fn(|i| x[i]);
        self.filter.predict(
            |x| numeris::Vector::from_array(rover.next(&array(x))),
            |x| numeris::Matrix::new(jacobian(&rover, &array(x))),
            Some(&self.q),
        );
        let h = self.h;
        let measured = numeris::Vector::from_array(sample.measured);
        let _ = self.filter.update(
            &measured,
            |x| numeris::Vector::from_array([x[0], x[1], x[2]]),
            |_| h,
            &self.r,
        );
    }

    fn state(&self) -> [f64; 6] {
        std::array::from_fn(|i| self.filter.x[i])
    }
}

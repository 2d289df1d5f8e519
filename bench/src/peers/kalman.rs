//! Kalman filters with two states and one measurement.

use crate::problem::{Filter, VELOCITY, VelocityProblem};
use adskalman::{
    KalmanFilterNoControl, ObservationModel, StateAndCovariance, TransitionModelLinearNoControl,
};
use kfilter::{KalmanFilter as _, KalmanPredict, KalmanUpdate};
use minikalman::prelude::*;
use minikalman::regular::builder::{
    KalmanFilterBuilder, KalmanFilterObservationType, KalmanFilterType,
};
use nalgebra::{Matrix1, Matrix1x2, Matrix2, OMatrix, OVector, SVector, U1, U2, Vector1, Vector2};
use nalgebra_of_kfilter as older;

fn transition(problem: &VelocityProblem) -> Matrix2<f64> {
    Matrix2::new(1.0, problem.period, 0.0, 1.0)
}

/// The textbook form in nalgebra: P = (I - K H) P.
pub struct Textbook {
    x: Vector2<f64>,
    p: Matrix2<f64>,
    f: Matrix2<f64>,
    q: Matrix2<f64>,
    h: Matrix1x2<f64>,
    r: Matrix1<f64>,
}

impl Default for Textbook {
    fn default() -> Self {
        Self {
            x: Vector2::zeros(),
            p: Matrix2::from_diagonal(&VELOCITY.initial_variance.into()),
            f: transition(&VELOCITY),
            q: Matrix2::from_diagonal(&Vector2::new(0.0, VELOCITY.process_variance)),
            h: Matrix1x2::new(1.0, 0.0),
            r: Matrix1::new(VELOCITY.measurement_variance),
        }
    }
}

impl Filter<f64, 2> for Textbook {
    fn step(&mut self, z: &f64) {
        self.x = self.f * self.x;
        self.p = self.f * self.p * self.f.transpose() + self.q;
        let s = self.h * self.p * self.h.transpose() + self.r;
        let k = self.p * self.h.transpose() / s[0];
        self.x += k * (Vector1::new(*z) - self.h * self.x);
        self.p = (Matrix2::identity() - k * self.h) * self.p;
    }

    fn state(&self) -> [f64; 2] {
        self.x.into()
    }
}

/// smelly, fixed size.
pub struct Smelly(smelly::SKalmanFilter<f64, 2, 1>);

impl Default for Smelly {
    fn default() -> Self {
        let mut filter = smelly::SKalmanFilter::new();
        let start = Textbook::default();
        let set = filter
            .set_covariance(start.p)
            .and_then(|()| filter.set_transition(start.f))
            .and_then(|()| filter.set_process_noise(start.q))
            .and_then(|()| filter.set_measurement(start.h))
            .and_then(|()| filter.set_measurement_noise(start.r));
        assert!(set.is_ok(), "fixed sizes always fit");
        Self(filter)
    }
}

impl Filter<f64, 2> for Smelly {
    fn step(&mut self, z: &f64) {
        let _ = self.0.predict();
        let _ = self.0.update(&SVector::<f64, 1>::new(*z));
    }

    fn state(&self) -> [f64; 2] {
        (*self.0.state()).into()
    }
}

/// kfilter.
pub struct Kfilter {
    filter: kfilter::KalmanLinearNoInput<f64, 2>,
    measurement: kfilter::measurement::LinearMeasurement<f64, 2, 1>,
}

impl Default for Kfilter {
    fn default() -> Self {
        let [v, a] = VELOCITY.initial_variance;
        Self {
            filter: kfilter::Kalman::new(
                older::Matrix2::new(1.0, VELOCITY.period, 0.0, 1.0),
                older::Matrix2::new(0.0, 0.0, 0.0, VELOCITY.process_variance),
                older::Vector2::zeros(),
                older::Matrix2::new(v, 0.0, 0.0, a),
            ),
            measurement: kfilter::measurement::LinearMeasurement::new(
                older::Matrix1x2::new(1.0, 0.0),
                older::Matrix1::new(VELOCITY.measurement_variance),
                older::Vector1::zeros(),
            ),
        }
    }
}

impl Filter<f64, 2> for Kfilter {
    fn step(&mut self, z: &f64) {
        self.measurement.z[0] = *z;
        let _ = self.filter.predict();
        let _ = self.filter.update(&self.measurement);
    }

    fn state(&self) -> [f64; 2] {
        (*self.filter.state()).into()
    }
}

/// minikalman, buffers on the stack.
pub struct Minikalman {
    filter: KalmanFilterType<2, f64>,
    measurement: KalmanFilterObservationType<2, 1, f64>,
}

impl Default for Minikalman {
    fn default() -> Self {
        let builder = KalmanFilterBuilder::<2, f64>::default();
        let (mut filter, mut measurement) = (builder.build(), builder.observations().build::<1>());
        filter.state_transition_mut().apply(|f| {
            f.make_identity();
            f.set_at(0, 1, VELOCITY.period);
        });
        filter.estimate_covariance_mut().apply(|p| {
            p.set_at(0, 0, VELOCITY.initial_variance[0]);
            p.set_at(1, 1, VELOCITY.initial_variance[1]);
        });
        filter
            .direct_process_noise_mut()
            .apply(|q| q.set_at(1, 1, VELOCITY.process_variance));
        measurement
            .observation_matrix_mut()
            .apply(|h| h.set_at(0, 0, 1.0));
        measurement
            .measurement_noise_covariance_mut()
            .apply(|r| r.set_at(0, 0, VELOCITY.measurement_variance));
        Self {
            filter,
            measurement,
        }
    }
}

impl Filter<f64, 2> for Minikalman {
    fn step(&mut self, z: &f64) {
        self.filter.predict();
        self.measurement
            .measurement_vector_mut()
            .apply(|vector| vector[0] = *z);
        self.filter.correct(&mut self.measurement);
    }

    fn state(&self) -> [f64; 2] {
        let state = self.filter.state_vector();
        [state[0], state[1]]
    }
}

/// numeris: its EKF with a linear model, as it has no linear filter. Joseph form.
pub struct Numeris {
    filter: numeris::estimate::Ekf<f64, 2, 1>,
    f: numeris::Matrix<f64, 2, 2>,
    q: numeris::Matrix<f64, 2, 2>,
    h: numeris::Matrix<f64, 1, 2>,
    r: numeris::Matrix<f64, 1, 1>,
}

impl Default for Numeris {
    fn default() -> Self {
        let [v, a] = VELOCITY.initial_variance;
        Self {
            filter: numeris::estimate::Ekf::new(
                numeris::Vector::from_array([0.0; 2]),
                numeris::Matrix::new([[v, 0.0], [0.0, a]]),
            ),
            f: numeris::Matrix::new([[1.0, VELOCITY.period], [0.0, 1.0]]),
            q: numeris::Matrix::new([[0.0, 0.0], [0.0, VELOCITY.process_variance]]),
            h: numeris::Matrix::new([[1.0, 0.0]]),
            r: numeris::Matrix::new([[VELOCITY.measurement_variance]]),
        }
    }
}

impl Filter<f64, 2> for Numeris {
    fn step(&mut self, z: &f64) {
        let (f, h) = (self.f, self.h);
        self.filter.predict(|x| f * *x, |_| f, Some(&self.q));
        let _ = self.filter.update(
            &numeris::Vector::from_array([*z]),
            |x| h * *x,
            |_| h,
            &self.r,
        );
    }

    fn state(&self) -> [f64; 2] {
        [self.filter.x[0], self.filter.x[1]]
    }
}

/// adskalman, the optimal form made symmetric.
pub struct Adskalman {
    estimate: StateAndCovariance<f64, U2>,
    transition: Transition,
    observation: Observation,
}

struct Transition {
    f: OMatrix<f64, U2, U2>,
    f_transposed: OMatrix<f64, U2, U2>,
    q: OMatrix<f64, U2, U2>,
}

#[allow(non_snake_case)]
impl TransitionModelLinearNoControl<f64, U2> for Transition {
    fn F(&self) -> &OMatrix<f64, U2, U2> {
        &self.f
    }
    fn FT(&self) -> &OMatrix<f64, U2, U2> {
        &self.f_transposed
    }
    fn Q(&self) -> &OMatrix<f64, U2, U2> {
        &self.q
    }
}

struct Observation {
    h: OMatrix<f64, U1, U2>,
    h_transposed: OMatrix<f64, U2, U1>,
    r: OMatrix<f64, U1, U1>,
}

#[allow(non_snake_case)]
impl ObservationModel<f64, U2, U1> for Observation {
    fn H(&self) -> &OMatrix<f64, U1, U2> {
        &self.h
    }
    fn HT(&self) -> &OMatrix<f64, U2, U1> {
        &self.h_transposed
    }
    fn R(&self) -> &OMatrix<f64, U1, U1> {
        &self.r
    }
}

impl Default for Adskalman {
    fn default() -> Self {
        let start = Textbook::default();
        Self {
            estimate: StateAndCovariance::new(start.x, start.p),
            transition: Transition {
                f: start.f,
                f_transposed: start.f.transpose(),
                q: start.q,
            },
            observation: Observation {
                h: start.h,
                h_transposed: start.h.transpose(),
                r: start.r,
            },
        }
    }
}

impl Filter<f64, 2> for Adskalman {
    fn step(&mut self, z: &f64) {
        let filter = KalmanFilterNoControl::new(&self.transition, &self.observation);
        let method = adskalman::CovarianceUpdateMethod::OptimalKalmanForcedSymmetric;
        if let Ok(estimate) =
            filter.step_with_options(&self.estimate, &OVector::<f64, U1>::new(*z), method)
        {
            self.estimate = estimate;
        }
    }

    fn state(&self) -> [f64; 2] {
        (*self.estimate.state()).into()
    }
}

//! Plain unscented filters: a covariance that is factored in each step. alpha = 1, beta = 1, kappa = 0.

use super::rover::{
    KfilterRover, covariances, diagonal, kfilter_measurement, sigma_points, variances,
};
use crate::problem::{Filter, ROVER, Rover, RoverSample};
use kfilter::{KalmanFilter as _, KalmanPredictInput, KalmanUpdate};
use minikalman::prelude::*;
use minikalman::unscented::builder::{
    KalmanFilterBuilder, KalmanFilterObservationType, KalmanFilterType,
};
use nalgebra::{Cholesky, Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};

/// The textbook form in nalgebra.
pub struct Textbook {
    rover: Rover,
    x: Vector6<f64>,
    p: Matrix6<f64>,
    q: Matrix6<f64>,
    r: Matrix3<f64>,
    weight: f64,
    redraw: bool,
}

impl Default for Textbook {
    fn default() -> Self {
        Self::new(true)
    }
}

impl Textbook {
    /// With or without redrawing the sigma points after the process noise. Without, the noise is missing in the innovation
    /// covariance; minikalman works this way.
    pub fn new(redraw: bool) -> Self {
        let (p, q, r) = covariances();
        Self {
            rover: ROVER.rover,
            x: ROVER.state.into(),
            p,
            q,
            r,
            weight: 1.0 / 12.0,
            redraw,
        }
    }

    fn points(&self) -> Option<[Vector6<f64>; 13]> {
        Some(sigma_points(self.x, Cholesky::new(self.p)?.l()))
    }

    fn spread<const L: usize>(
        &self,
        images: &[SVector<f64, L>; 13],
        noise: &SMatrix<f64, L, L>,
    ) -> (SVector<f64, L>, SMatrix<f64, L, L>) {
        let mean = images[1..].iter().sum::<SVector<f64, L>>() * self.weight;
        let mut covariance = (images[0] - mean) * (images[0] - mean).transpose() + noise;
        for image in &images[1..] {
            covariance += (image - mean) * (image - mean).transpose() * self.weight;
        }
        (mean, covariance)
    }

    fn update(&mut self, sample: &RoverSample) -> Option<()> {
        let rover = self.rover.under(sample.torque);
        let mut points = self.points()?.map(|x| Vector6::from(rover.next(&x.into())));
        (self.x, self.p) = self.spread(&points, &self.q);
        if self.redraw {
            points = self.points()?;
        }
        let measured = points.map(|x| Vector3::new(x[0], x[1], x[2]));
        let (mean, covariance) = self.spread(&measured, &self.r);
        let mut cross = (points[0] - self.x) * (measured[0] - mean).transpose();
        for (x, z) in points[1..].iter().zip(&measured[1..]) {
            cross += (x - self.x) * (z - mean).transpose() * self.weight;
        }
        let gain = Cholesky::new(covariance)?
            .solve(&cross.transpose())
            .transpose();
        self.x += gain * (Vector3::from(sample.measured) - mean);
        self.p = (self.p - gain * covariance * gain.transpose()).symmetric_part();
        Some(())
    }
}

impl Filter<RoverSample, 6> for Textbook {
    fn step(&mut self, sample: &RoverSample) {
        let _ = self.update(sample);
    }

    fn state(&self) -> [f64; 6] {
        self.x.into()
    }
}

/// smelly, fixed size.
pub struct Smelly {
    filter: smelly::SUnscentedKalmanFilter<f64, 6, 3>,
    rover: Rover,
}

impl Default for Smelly {
    fn default() -> Self {
        let start = Textbook::default();
        let mut filter =
            smelly::SUnscentedKalmanFilter::new(smelly::MerweScaledSigmaPoints::new(1.0, 1.0, 0.0));
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
        let _ = self.filter.predict(|x| rover.next(&(*x).into()).into());
        let _ = self
            .filter
            .update(&sample.measured.into(), |x| Vector3::new(x[0], x[1], x[2]));
    }

    fn state(&self) -> [f64; 6] {
        (*self.filter.state()).into()
    }
}

/// kfilter.
pub struct Kfilter {
    filter: kfilter::UnscentedKalman<f64, 6, 2, 13, KfilterRover>,
    measurement: kfilter::measurement::LinearMeasurement<f64, 6, 3>,
}

impl Default for Kfilter {
    fn default() -> Self {
        let (system, covariance) = KfilterRover::start();
        let parameters = kfilter::UKFParameters {
            alpha: 1.0,
            beta: 1.0,
            kappa: 0.0,
        };
        Self {
            filter: kfilter::UnscentedKalman::new_custom_with_params(
                system, covariance, parameters,
            ),
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

/// minikalman. It reuses the propagated points for the measurement: fewer operations than the others, and other numbers.
pub struct Minikalman {
    filter: KalmanFilterType<6, 13, f64>,
    measurement: KalmanFilterObservationType<6, 3, 13, f64>,
    rover: Rover,
}

impl Default for Minikalman {
    fn default() -> Self {
        let builder = KalmanFilterBuilder::<6, f64>::default();
        let (mut filter, mut measurement) = (
            builder.build::<13>(),
            builder.observations().build::<3, 13>(),
        );
        filter.set_alpha(1.0);
        filter.set_beta(1.0);
        filter.set_kappa(0.0);
        for i in 0..6 {
            filter.state_vector_mut().apply(|x| x[i] = ROVER.state[i]);
            filter
                .estimate_covariance_mut()
                .apply(|p| p.set_at(i, i, variances(&ROVER.initial_std)[i]));
            filter
                .direct_process_noise_mut()
                .apply(|q| q.set_at(i, i, variances(&ROVER.process_std)[i]));
        }
        for (j, variance) in variances(&ROVER.measurement_std).into_iter().enumerate() {
            measurement
                .measurement_noise_covariance_mut()
                .apply(|r| r.set_at(j, j, variance));
        }
        Self {
            filter,
            measurement,
            rover: ROVER.rover,
        }
    }
}

impl Filter<RoverSample, 6> for Minikalman {
    fn step(&mut self, sample: &RoverSample) {
        let rover = self.rover.under(sample.torque);
        self.filter.predict_nonlinear(|x| {
            let now: [f64; 6] = std::array::from_fn(|i| x[i]);
            for (i, value) in rover.next(&now).into_iter().enumerate() {
                x[i] = value;
            }
        });
        self.measurement
            .measurement_vector_mut()
            .apply(|z| (0..3).for_each(|j| z[j] = sample.measured[j]));
        self.filter
            .correct_sigma_point(&mut self.measurement, |points, observed| {
                for i in 0..3 * 13 {
                    observed[i] = points[i];
                }
            });
    }

    fn state(&self) -> [f64; 6] {
        let state = self.filter.state_vector();
        std::array::from_fn(|i| state[i])
    }
}

/// numeris: the plain filter, or the one named square-root, which forms the covariance and factors it in each step.
pub struct Numeris<F> {
    filter: F,
    rover: Rover,
    q: numeris::Matrix<f64, 6, 6>,
    r: numeris::Matrix<f64, 3, 3>,
}

/// The two filters of numeris.
pub type NumerisUkf = Numeris<numeris::estimate::Ukf<f64, 6, 3>>;
/// Square-root by name.
pub type NumerisSrUkf = Numeris<numeris::estimate::SrUkf<f64, 6, 3>>;

impl<F> Numeris<F> {
    fn with(filter: F) -> Self {
        let (q, r) = (
            diagonal(variances(&ROVER.process_std)),
            diagonal(variances(&ROVER.measurement_std)),
        );
        Self {
            filter,
            rover: ROVER.rover,
            q,
            r,
        }
    }
}

impl Default for NumerisUkf {
    fn default() -> Self {
        let covariance = diagonal(variances(&ROVER.initial_std));
        let start = numeris::Vector::from_array(ROVER.state);
        Self::with(numeris::estimate::Ukf::with_params(
            start, covariance, 1.0, 1.0, 0.0,
        ))
    }
}

impl Default for NumerisSrUkf {
    fn default() -> Self {
        let start = numeris::Vector::from_array(ROVER.state);
        Self::with(numeris::estimate::SrUkf::with_params(
            start,
            diagonal(ROVER.initial_std),
            1.0,
            1.0,
            0.0,
        ))
    }
}

macro_rules! numeris_steps {
    ($filter:ty) => {
        impl Filter<RoverSample, 6> for $filter {
            fn step(&mut self, sample: &RoverSample) {
                let rover = self.rover.under(sample.torque);
                let process = |x: &numeris::Vector<f64, 6>| {
                    numeris::Vector::from_array(rover.next(&std::array::from_fn(|i| x[i])))
                };
                let measure =
                    |x: &numeris::Vector<f64, 6>| numeris::Vector::from_array([x[0], x[1], x[2]]);
                let _ = self.filter.predict(process, Some(&self.q));
                let _ = self.filter.update(
                    &numeris::Vector::from_array(sample.measured),
                    measure,
                    &self.r,
                );
            }

            fn state(&self) -> [f64; 6] {
                std::array::from_fn(|i| self.filter.state()[i])
            }
        }
    };
}

numeris_steps!(NumerisUkf);
numeris_steps!(NumerisSrUkf);

//! This project's filters on the problems of the comparison.

use crate::problem::{
    Filter, REGRESSION, ROVER, RegressionProblem, Rover, RoverSample, VELOCITY, VelocityProblem,
};
use estimation::ekf::Ekf;
use estimation::kalman::VelocityFilter;
use estimation::rls::MultipleForgettingRls;
use estimation::sigma_points::Spread;
use estimation::srukf::SquareRootUkf;

/// Kalman filter 2/1.
pub struct Kalman {
    filter: VelocityFilter,
    problem: VelocityProblem,
}

impl Default for Kalman {
    fn default() -> Self {
        let [v, a] = VELOCITY.initial_variance;
        Self {
            filter: VelocityFilter::with_acceleration_variance(0.0, v, a),
            problem: VELOCITY,
        }
    }
}

impl Filter<f64, 2> for Kalman {
    #[inline(always)]
    fn step(&mut self, z: &f64) {
        self.filter
            .predict(self.problem.period, self.problem.process_variance);
        self.filter
            .correct(Some(*z), self.problem.measurement_variance);
    }

    fn state(&self) -> [f64; 2] {
        [self.filter.velocity(), self.filter.acceleration()]
    }
}

/// RLS with a factor for each parameter, in closed form or (`SOLVE`) by the 3x3 system.
pub struct Regression<const SOLVE: bool> {
    filter: MultipleForgettingRls<3>,
    problem: RegressionProblem,
}

impl<const SOLVE: bool> Default for Regression<SOLVE> {
    fn default() -> Self {
        let filter = MultipleForgettingRls::new(REGRESSION.parameters, REGRESSION.covariance);
        Self {
            filter,
            problem: REGRESSION,
        }
    }
}

impl<const SOLVE: bool> Filter<[f64; 3], 3> for Regression<SOLVE> {
    #[inline(always)]
    fn step(&mut self, regressor: &[f64; 3]) {
        if SOLVE {
            self.filter
                .update_by_solve(regressor, 0.0, &self.problem.forgetting);
        } else {
            self.filter.update(regressor, 0.0, &self.problem.forgetting);
        }
    }

    fn state(&self) -> [f64; 3] {
        self.filter.parameters
    }
}

macro_rules! on_rover {
    ($( #[$doc:meta] $name:ident: $filter:ty = $start:expr; )*) => { $(
        #[$doc]
        pub struct $name {
            filter: $filter,
            rover: Rover,
            process_std: [f64; 6],
            measurement_std: [f64; 3],
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    filter: $start,
                    rover: ROVER.rover,
                    process_std: ROVER.process_std,
                    measurement_std: ROVER.measurement_std,
                }
            }
        }

        impl Filter<RoverSample, 6> for $name {
            #[inline(always)]
            fn step(&mut self, sample: &RoverSample) {
                let rover = self.rover.under(sample.torque);
                self.filter.step(&rover, &self.process_std, &sample.measured, &self.measurement_std);
            }

            fn state(&self) -> [f64; 6] {
                self.filter.state
            }
        }
    )* };
}

on_rover! {
    /// Square-root unscented filter 6/3.
    Unscented: SquareRootUkf<6, 3> = SquareRootUkf::new(ROVER.state, &ROVER.initial_std, Spread::UNIT);
    /// Extended Kalman filter 6/3, on the covariance, with the derivatives from dual numbers.
    Extended: Ekf<6, 3> = Ekf::new(ROVER.state, &ROVER.initial_std);
}

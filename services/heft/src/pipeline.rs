//! The steps of the pipeline: the same for `heft run`, `heft estimate`, `heft replay` and the tests.

use config::Description;
use messages::{ExcavatorEstimate, ExcavatorSensors, LoaderEstimate, LoaderSensors, SwingMotion};
use runtime::Step;
use steps::{excavator, loader};

use crate::failure::Failure;
use crate::plan::Plan;
use crate::sources::{excavator_source, loader_source};

/// Methods that the `rls` process offers, the first by default.
pub const REGRESSIONS: [&str; 2] = ["svf-rls", "multi-forgetting-rls"];

/// Filter stage of the excavator.
pub fn excavator_filter(
    d: &config::Excavator,
) -> Result<impl Step<Input = ExcavatorSensors, Output = SwingMotion>, Failure> {
    excavator::FilterStep::new(d).map_err(refused)
}

/// Regression of the excavator.
pub fn excavator_regression(
    d: &config::Excavator,
    method: &str,
) -> Result<impl Step<Input = SwingMotion, Output = ExcavatorEstimate>, Failure> {
    excavator::RegressionStep::new(d, method).map_err(refused)
}

/// State-space estimator of the excavator.
pub fn excavator_estimator(
    d: &config::Excavator,
    method: &str,
) -> Result<impl Step<Input = ExcavatorSensors, Output = ExcavatorEstimate>, Failure> {
    excavator::EstimatorStep::new(d, method).map_err(refused)
}

/// Whether a method can work with a source that has these columns.
pub fn check_columns(
    d: &config::Excavator,
    method: &str,
    first: &ExcavatorSensors,
) -> Result<(), Failure> {
    use estimation::excavator::SwingEstimator;
    use messages::excavator_bits::{SWING_ANGLE, SWING_TORQUE, SWING_VELOCITY};
    let columns = first.columns;
    let missing = |column: &str| {
        Failure::input(
            format!("the method {method} needs the column {column}, which the input does not have"),
            "--method",
            "choose another method, or name the column in a signal map (--map)",
        )
    };
    if columns & (SWING_VELOCITY | SWING_ANGLE) == 0 {
        return Err(missing("swing_velocity or swing_angle"));
    }
    match method {
        "svf-rls" if columns & SWING_TORQUE == 0 => Err(missing("swing_torque")),
        m if REGRESSIONS.contains(&m) => Ok(()),
        m => {
            let method = excavator::method(m).map_err(refused)?;
            let columns = excavator::columns(first);
            let estimator = SwingEstimator::new(&excavator::settings(d), method, columns);
            estimator.map(drop).map_err(refused)
        }
    }
}

/// Extended Kalman filter of the loader.
pub fn loader_baseline(
    d: &config::Loader,
) -> Result<impl Step<Input = LoaderSensors, Output = LoaderEstimate>, Failure> {
    loader::EstimatorStep::new(d, "ekf").map_err(refused)
}

/// Unscented Kalman filter of the loader.
pub fn loader_estimator(
    d: &config::Loader,
    method: &str,
) -> Result<impl Step<Input = LoaderSensors, Output = LoaderEstimate>, Failure> {
    loader::EstimatorStep::new(d, method).map_err(refused)
}

fn refused(error: impl std::fmt::Display) -> Failure {
    Failure::input(
        error,
        "the description or --method",
        "`heft check FILE --print` shows every key with its range; the README lists the methods",
    )
}

/// Builds every part of the plan once, so that a mistake is told before any process starts.
pub fn check(plan: &Plan) -> Result<(), Failure> {
    match plan.description()? {
        Description::Excavator(d) => {
            excavator_filter(&d)?;
            excavator_regression(&d, &plan.first_method)?;
            excavator_estimator(&d, &plan.second_method)?;
            excavator_source(plan).map(drop)
        }
        Description::Loader(d) => {
            loader_baseline(&d)?;
            loader_estimator(&d, &plan.second_method)?;
            loader_source(plan).map(drop)
        }
    }
}

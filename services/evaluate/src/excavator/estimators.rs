//! Estimators of the tables, with the columns that each of them receives.

use super::case::Case;
use crate::Error;
use estimation::excavator::{
    Columns, Estimate, Method, MotionFilter, Regression, Sample, Settings, SwingEstimator, Variant,
};
use sim::excavator::{Row, Sensors, Truth};
use statistics::judge::{FAR, is_covered};

/// An estimator with its settings and its columns.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// Name in the tables.
    pub name: &'static str,
    /// The method.
    pub method: Method,
    /// Its settings.
    pub settings: Settings,
    /// The columns that it receives.
    pub columns: Columns,
}

/// One sample's truth and estimate.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Time \[s\].
    pub time: f64,
    /// True values.
    pub truth: Truth,
    /// Estimated values.
    pub estimate: Estimate,
}

impl Point {
    /// The relative error of the inertia [%].
    pub fn error(&self) -> f64 {
        100.0 * (self.estimate.inertia / self.truth.inertia - 1.0)
    }

    /// Whether the error of the inertia exceeds the limit for trusted values, whatever its interval. The tables with this count
    /// have a separate column for the intervals.
    pub fn is_far(&self) -> bool {
        self.error().abs() > 100.0 * FAR
    }

    /// Whether the 95 % interval holds the truth.
    pub fn covered(&self) -> bool {
        let estimate = &self.estimate;
        is_covered(estimate.inertia, estimate.inertia_std, self.truth.inertia)
    }
}

impl Setup {
    fn new(name: &'static str, method: Method, torque: bool, posture: bool) -> Self {
        let columns = Columns {
            velocity: true,
            angle: false,
            torque,
            posture,
        };
        Self {
            name,
            method,
            settings: Settings::calibrated(),
            columns,
        }
    }

    /// Any method on a machine at work.
    pub fn working(name: &'static str, method: Method, settings: Settings) -> Self {
        Self {
            settings,
            ..Self::new(name, method, true, true)
        }
    }

    fn variant(mut self, variant: Variant) -> Self {
        self.settings.estimator.variant = variant;
        self
    }

    /// The default with torque and posture: payload that may change.
    pub fn auto() -> Self {
        Self::new("D_auto", Method::Auto, true, true)
    }

    /// Torque and posture, damping and torque calibrated.
    pub fn known() -> Self {
        Self::new("D_known", Method::PostureTorque, true, true).variant(Variant::Known)
    }

    /// Torque and posture, damping within 20 %, constant payload.
    pub fn tolerant() -> Self {
        Self::new("D_tol", Method::PostureTorque, true, true).variant(Variant::Tolerant)
    }

    /// Torque, damping calibrated.
    pub fn torque() -> Self {
        Self::new("BM_known", Method::Torque, true, false).variant(Variant::Known)
    }

    /// Torque, damping within 20 %.
    pub fn torque_tolerant() -> Self {
        Self::new("BM_tol", Method::Torque, true, false).variant(Variant::Tolerant)
    }

    /// Torque, uncalibrated: the damping is not estimated, its uncertainty is in the interval.
    pub fn torque_auto() -> Self {
        Self::new("BM_auto", Method::Torque, true, false)
    }

    /// Posture without torque, damping calibrated.
    pub fn posture() -> Self {
        Self::new("C", Method::Posture, false, true).variant(Variant::Known)
    }

    /// Posture without torque, uncalibrated.
    pub fn posture_auto() -> Self {
        Self::new("C_auto", Method::Posture, false, true)
    }

    /// Velocity alone.
    pub fn velocity() -> Self {
        Self::new("A", Method::Velocity, false, false)
    }

    /// Velocity alone, the inertia declared constant, damping calibrated.
    pub fn velocity_constant() -> Self {
        let mut setup =
            Self::new("A_const", Method::Velocity, false, false).variant(Variant::Known);
        setup.settings.estimator.constant_inertia = true;
        setup
    }

    /// Measured torque, both sides of the regression equally filtered.
    pub fn svf() -> Self {
        Self::new("svf-rls", Method::SvfRls, true, false)
    }

    /// The paper's estimator in its tuned configuration, started at `inertia` [kg m^2].
    pub fn paper(inertia: f64) -> Self {
        let paper = Self::new("paper", Method::MultiForgettingRls, false, false);
        Self {
            settings: Settings::paper(inertia),
            ..paper
        }
    }

    /// Runs the estimator over the samples of one seed.
    pub fn run(&self, rows: &[Row]) -> Result<Vec<Point>, Error> {
        let mut step = self.estimator()?;
        Ok(rows.iter().map(|row| self.point(row, &mut step)).collect())
    }

    fn point(&self, row: &Row, step: &mut Step) -> Point {
        Point {
            time: row.time,
            truth: row.truth,
            estimate: step(&self.sample(row)),
        }
    }

    /// The part of a row that the estimator receives.
    pub(super) fn sample(&self, row: &Row) -> Sample {
        let Columns {
            velocity,
            angle,
            torque,
            posture,
        } = self.columns;
        Sample {
            time: row.time,
            velocity: row.swing_velocity.filter(|_| velocity),
            angle: row.swing_angle.filter(|_| angle),
            torque: row.swing_torque.filter(|_| torque),
            posture: row.posture.map(|joint| joint.filter(|_| posture)),
            inclination: row.inclination,
            boom_head_pressure: row.pressures[0],
            boom_rod_pressure: row.pressures[1],
            ..Sample::default()
        }
    }

    fn estimator(&self) -> Result<Step, Error> {
        let settings = &self.settings;
        if self.method.is_regression() {
            let mut filter = MotionFilter::new(settings, self.columns).map_err(Error::refused)?;
            let mut regression = Regression::new(settings, self.method).map_err(Error::refused)?;
            return Ok(Box::new(move |sample| {
                regression.step(&filter.step(sample))
            }));
        }
        let estimator = SwingEstimator::new(settings, self.method, self.columns);
        let mut estimator = estimator.map_err(Error::refused)?;
        Ok(Box::new(move |sample| estimator.step(sample)))
    }
}

type Step = Box<dyn FnMut(&Sample) -> Estimate>;

/// Truth and estimates of one seed, for a figure.
pub fn series(case: &Case, setup: &Setup, seed: u64) -> Result<Vec<Point>, Error> {
    setup.run(&case.rows(seed, Sensors::default(), &[])?)
}

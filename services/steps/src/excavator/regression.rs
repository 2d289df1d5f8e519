//! The excavator's regressions as a step.

use config::Excavator as Description;
use estimation::excavator::{Method, Motion, Regression, Settings};
use kalman::{ExcavatorError, SourceWatch, excavator_message, excavator_settings};
use messages::{ExcavatorEstimate, SwingMotion, excavator_bits as bits};
use runtime::Step;

/// `multi-forgetting-rls` or `svf-rls`: swing motion in, inertia out.
#[derive(Clone, Debug)]
pub struct Excavator {
    settings: Settings,
    method: Method,
    regression: Regression,
    source: SourceWatch,
    /// Time since the last torque; none has been seen while it is infinite [s].
    torque_age: f64,
    started: bool,
}

impl Excavator {
    /// A regression by the name of its method.
    ///
    /// # Errors
    /// The name is unknown, belongs to another service, or the description has a value that the
    /// method cannot use.
    pub fn new(description: &Description, method: &str) -> Result<Self, ExcavatorError> {
        let method =
            Method::parse(method).ok_or_else(|| ExcavatorError::UnknownMethod(method.into()))?;
        let settings = excavator_settings(description);
        Ok(Self {
            settings,
            method,
            regression: Regression::new(&settings, method).map_err(ExcavatorError::Settings)?,
            source: SourceWatch::default(),
            torque_age: f64::INFINITY,
            started: false,
        })
    }
}

impl Step for Excavator {
    type Input = SwingMotion;
    type Output = ExcavatorEstimate;

    fn step(&mut self, input: &SwingMotion) -> ExcavatorEstimate {
        // The settings have been checked: this cannot fail.
        if self.source.is_new(&input.stamp)
            && let Ok(regression) = Regression::new(&self.settings, self.method)
        {
            self.regression = regression;
            self.torque_age = f64::INFINITY;
        }
        let refused = input.flags & bits::REFUSED != 0;
        if !refused {
            self.torque_age = if input.valid & bits::SWING_TORQUE != 0 {
                0.0
            } else {
                self.torque_age + input.period
            };
            self.started = true;
        }
        excavator_message(&self.regression.step(&self.motion(input)), self.started)
    }
}

impl Excavator {
    /// The motion in a message.
    fn motion(&self, m: &SwingMotion) -> Motion {
        let has_torque = self.torque_age.is_finite();
        Motion {
            time: m.stamp.time,
            period: m.period,
            velocity: m.velocity,
            velocity_std: m.velocity_std,
            acceleration: m.acceleration,
            acceleration_std: m.acceleration_std,
            innovation: m.innovation,
            innovation_std: m.innovation_std,
            filtered_velocity: m.filtered_velocity,
            filtered_acceleration: m.filtered_acceleration,
            filtered_torque: m.filtered_torque,
            filtered_direction: m.filtered_direction,
            filtered_one: m.filtered_one,
            convergence_delay: m.convergence_delay,
            age: m.age,
            torque_age: if has_torque { self.torque_age } else { 0.0 },
            measured: m.innovation_std > 0.0,
            has_torque,
            manoeuvre: m.flags & bits::MANOEUVRE != 0,
            standstill: m.flags & bits::STANDSTILL != 0,
            refused: m.flags & bits::REFUSED != 0,
        }
    }
}

//! Filter stage: sensors in, swing motion out (process `kalman`).
//!
//! The Kalman filter of Eqs. 1-10 gives velocity and acceleration. A bank of equal filters gives velocity,
//! acceleration, torque and friction direction with equal delay. A regression with measured torque requires this:
//! filtering only one side causes errors of tens of percent. With an encoder the angle replaces the velocity: the
//! Kalman filter then has three states, and the bank one more stage.

use crate::excavator::change::{ChangeDetector, Gate};
use crate::excavator::encoder::{Aligned, Aligner};
use crate::excavator::estimate::{Columns, Sample};
use crate::excavator::grid::Grid;
use crate::excavator::grid::LONG_GAP;
use crate::excavator::screen::Screen;
use crate::excavator::settings::Settings;
use crate::excavator::settings_error::SettingsError;
use crate::excavator::standstill::{Phase, Standstill};
use crate::excavator::svf::{Lowpass, Shape};
use crate::kalman::{AngleFilter, Gain, Innovation, VelocityFilter};
use crate::math::{exp, ln, sqrt, tanh};

/// Swing motion at one sample: all inputs of [`crate::excavator::Regression`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Motion {
    /// Time of the measurement \[s\].
    pub time: f64,
    /// Sampling period that led to this sample \[s\].
    pub period: f64,
    /// Velocity of the Kalman filter [rad/s].
    pub velocity: f64,
    /// Standard deviation of the velocity [rad/s].
    pub velocity_std: f64,
    /// Acceleration of the Kalman filter [rad/s^2].
    pub acceleration: f64,
    /// Standard deviation of the acceleration [rad/s^2].
    pub acceleration_std: f64,
    /// Innovation of the Kalman filter [rad/s], of the angle filter \[rad\]; 0 where nothing was accepted.
    pub innovation: f64,
    /// Predicted standard deviation of the innovation.
    pub innovation_std: f64,
    /// Velocity behind the equal filters [rad/s].
    pub filtered_velocity: f64,
    /// Acceleration behind them [rad/s^2].
    pub filtered_acceleration: f64,
    /// Torque behind them [N m].
    pub filtered_torque: f64,
    /// Friction direction tanh(w / width) behind them.
    pub filtered_direction: f64,
    /// A constant 1 behind them, the regressor of an offset.
    pub filtered_one: f64,
    /// Convergence delay of the Kalman filter's acceleration \[s\].
    pub convergence_delay: f64,
    /// Time since the last accepted velocity or angle \[s\].
    pub age: f64,
    /// A velocity or angle was accepted at this sample.
    pub measured: bool,
    /// A torque was measured at this sample.
    pub torque_measured: bool,
    /// A torque change was detected less than a convergence delay ago.
    pub manoeuvre: bool,
    /// The machine stands still.
    pub standstill: bool,
    /// The row was refused; all other fields repeat the last result.
    pub refused: bool,
}

impl Motion {
    fn is_finite(&self) -> bool {
        let state = [
            self.velocity,
            self.velocity_std,
            self.acceleration,
            self.acceleration_std,
            self.innovation,
            self.innovation_std,
        ];
        let filtered = [
            self.filtered_velocity,
            self.filtered_acceleration,
            self.filtered_torque,
            self.filtered_direction,
            self.filtered_one,
        ];
        state.iter().chain(&filtered).all(|x| x.is_finite())
    }
}

#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Filter {
    Waiting,
    Velocity(VelocityFilter),
    Angle(AngleFilter),
}

#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Bank {
    motion: Lowpass,
    torque: Lowpass,
    direction: Lowpass,
    one: Lowpass,
}

/// Kalman filter and bank of equal filters.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MotionFilter {
    settings: Settings,
    angle: bool,
    screen: Screen,
    filter: Filter,
    gate: Gate,
    shape: Shape,
    bank: Option<Bank>,
    input: [f64; 2],
    /// For an encoder.
    aligner: Option<Aligner>,
    grid: Grid,
    detector: ChangeDetector,
    standstill: Standstill,
    standing: bool,
    delay: Delay,
    window_end: f64,
    last: Motion,
}

impl MotionFilter {
    /// Checks the settings; `columns` states whether there is a velocity, or only an angle.
    pub fn new(settings: &Settings, columns: Columns) -> Result<Self, SettingsError> {
        settings.check()?;
        if !(columns.velocity || columns.angle) {
            return Err(SettingsError::MissingColumn {
                method: "kalman",
                column: "swing_velocity",
            });
        }
        let (s, e) = (&settings.sensors, &settings.estimator);
        let angle = !columns.velocity;
        let period = 1.0 / s.rate;
        Ok(Self {
            settings: *settings,
            angle,
            screen: Screen::new(s),
            filter: Filter::Waiting,
            gate: Gate::new(e.reject, e.q_c),
            shape: Shape {
                frequency: e.filter_frequency,
                damping: e.filter_damping,
                third_order: angle,
            },
            bank: None,
            input: [0.0; 2],
            aligner: angle.then(|| Aligner::new(settings)),
            grid: Grid::new(settings, angle),
            detector: ChangeDetector::new(e.reject, e.q_c, s.swing_velocity_std),
            standstill: Standstill::new(settings, angle),
            standing: true,
            delay: Delay::new(settings, angle, period),
            window_end: f64::NEG_INFINITY,
            last: Motion {
                convergence_delay: e.convergence_delay.unwrap_or(0.0),
                standstill: true,
                ..Motion::default()
            },
        })
    }

    /// The settings as stated.
    pub fn described(&self) -> Settings {
        self.settings
    }

    /// Takes one row and always returns a motion. A row whose time does not increase is refused and changes nothing,
    /// unless one stamp was wrong or the clock was permanently set back. After a gap of more than a second the
    /// filter restarts.
    pub fn step(&mut self, sample: &Sample) -> Motion {
        let mut sample = of_swing(sample);
        let Some(row) = self.screen.accept(&mut sample) else {
            return Motion {
                refused: true,
                ..self.last
            };
        };
        let period = row.period;
        if row.set_back || period > LONG_GAP {
            self.restart(row.set_back && self.angle);
        }
        let innovation = self.kalman(&sample, period);
        let measured = innovation.variance > 0.0;
        self.equal_filters(&sample, measured, period);
        self.watch(&sample, measured, period);
        let motion = self.motion(&sample, innovation, period);
        if !motion.is_finite() {
            // A state that is not finite does not recover.
            self.restart(true);
            return Motion {
                time: sample.time,
                period,
                measured: false,
                innovation: 0.0,
                innovation_std: 0.0,
                age: self.last.age + period,
                ..self.last
            };
        }
        self.last = motion;
        self.last
    }

    /// Restarts the Kalman filter. `all`: the filters of the regression too, since earlier times or angles are no longer
    /// valid.
    fn restart(&mut self, all: bool) {
        self.filter = Filter::Waiting;
        self.window_end = f64::NEG_INFINITY;
        if all {
            self.bank = None;
            self.aligner = self.angle.then(|| Aligner::new(&self.settings));
            self.grid = Grid::new(&self.settings, self.angle);
        }
    }

    /// Variance of one measurement of velocity or angle.
    fn measurement_variance(&self) -> f64 {
        let std = if self.angle {
            self.settings.sensors.swing_angle_std
        } else {
            self.settings.sensors.swing_velocity_std
        };
        std * std
    }

    /// One step of the Kalman filter; the variance of the returned innovation is 0 where nothing
    /// was accepted.
    fn kalman(&mut self, sample: &Sample, period: f64) -> Innovation {
        let r = self.measurement_variance();
        let q = self.settings.estimator.q_c * period;
        let (velocity, _) = self.gate.step(sample.velocity, r, period);
        let (measured, innovation) = match &mut self.filter {
            Filter::Velocity(filter) => {
                filter.predict(period, q);
                (velocity.is_some(), filter.correct(velocity, r))
            }
            Filter::Angle(filter) => {
                filter.predict(period, q);
                (sample.angle.is_some(), filter.correct(sample.angle, r))
            }
            Filter::Waiting => self.start(sample, r),
        };
        if measured {
            innovation
        } else {
            Innovation::default()
        }
    }

    fn start(&mut self, sample: &Sample, r: f64) -> (bool, Innovation) {
        if self.angle {
            let Some(angle) = sample.angle else {
                return (false, Innovation::default());
            };
            let e = &self.settings.estimator;
            let mut filter = AngleFilter::new(angle, r, 1.0, sqrt(e.q_c.max(1e-12)).max(1.0));
            let innovation = filter.correct(Some(angle), r);
            self.filter = Filter::Angle(filter);
            return (true, innovation);
        }
        let Some(velocity) = sample.velocity else {
            return (false, Innovation::default());
        };
        let mut filter = VelocityFilter::new(velocity, r);
        let innovation = filter.correct(Some(velocity), r);
        self.filter = Filter::Velocity(filter);
        (true, innovation)
    }

    fn equal_filters(&mut self, sample: &Sample, measured: bool, period: f64) {
        let motion = if self.angle {
            sample.angle
        } else {
            sample.velocity
        };
        if let (true, Some(value)) = (measured, motion) {
            self.input[0] = value;
        }
        if let Some(torque) = sample.torque {
            self.input[1] = torque;
        }
        if self.angle && matches!(self.filter, Filter::Waiting) {
            return;
        }
        let [motion, torque] = self.input;
        let aligned = match &mut self.aligner {
            Some(aligner) => aligner.push(sample.time, motion, torque),
            None => Aligned {
                angle: motion,
                torque,
                velocity: motion,
            },
        };
        let direction = tanh(aligned.velocity / self.settings.estimator.svf_friction_width);
        let start = if self.angle { aligned.angle } else { 0.0 };
        let bank = self.bank.get_or_insert_with(|| Bank {
            // The encoder's angle has an arbitrary start.
            motion: Lowpass::settled(start),
            ..Bank::default()
        });
        let shape = &self.shape;
        bank.motion.step(shape, aligned.angle, period);
        bank.torque.step(shape, aligned.torque, period);
        bank.direction.step(shape, direction, period);
        bank.one.step(shape, 1.0, period);
    }

    /// Updates standstill and change windows, on the grid of about 100 Hz for which they were tuned.
    fn watch(&mut self, sample: &Sample, measured: bool, period: f64) {
        self.delay.update(&self.settings, self.angle, period);
        let mut accepted = *sample;
        if !measured {
            accepted.velocity = None;
            accepted.angle = None;
        }
        let Some(fill) = self.grid.push(&accepted, period) else {
            return;
        };
        for tick in fill.ticks() {
            let gated = self
                .detector
                .step(tick.velocity, tick.velocity_variance, tick.period);
            let velocity = (gated.velocity, tick.velocity_variance);
            let phase = self
                .standstill
                .step(velocity, self.grid.torque(), tick.period);
            self.standing = phase == Phase::Held;
            if gated.event {
                self.window_end = tick.time + self.delay.value;
            }
        }
    }

    fn motion(&self, sample: &Sample, innovation: Innovation, period: f64) -> Motion {
        let measured = innovation.variance > 0.0;
        let (velocity, acceleration, variances) = match &self.filter {
            Filter::Velocity(f) => {
                let [p11, _, p22] = f.covariance();
                (f.velocity(), f.acceleration(), [p11, p22])
            }
            Filter::Angle(f) => (f.velocity(), f.acceleration(), f.variances()),
            Filter::Waiting => (0.0, 0.0, [0.0; 2]),
        };
        let bank = self.bank.unwrap_or_default();
        let (filtered_velocity, filtered_acceleration) = if self.angle {
            (bank.motion.rate, bank.motion.curvature)
        } else {
            (bank.motion.value, bank.motion.rate)
        };
        Motion {
            time: sample.time,
            period,
            velocity,
            velocity_std: sqrt(variances[0].max(0.0)),
            acceleration,
            acceleration_std: sqrt(variances[1].max(0.0)),
            innovation: innovation.value,
            innovation_std: sqrt(innovation.variance),
            filtered_velocity,
            filtered_acceleration,
            filtered_torque: bank.torque.value,
            filtered_direction: bank.direction.value,
            filtered_one: bank.one.value,
            convergence_delay: self.delay.value,
            age: if measured {
                0.0
            } else {
                self.last.age + period
            },
            measured,
            torque_measured: sample.torque.is_some(),
            manoeuvre: sample.time < self.window_end,
            standstill: self.standing,
            refused: false,
        }
    }
}

/// Signals of a row that this stage uses: those of the swing.
fn of_swing(sample: &Sample) -> Sample {
    Sample {
        time: sample.time,
        velocity: sample.velocity,
        angle: sample.angle,
        torque: sample.torque,
        ..Sample::default()
    }
}

/// Convergence delay of the acceleration; recomputed when the sampling period has changed permanently.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Delay {
    value: f64,
    period: f64,
    odd: u32,
}

impl Delay {
    fn new(settings: &Settings, angle: bool, period: f64) -> Self {
        Self {
            value: delay(settings, angle, period),
            period,
            odd: 0,
        }
    }

    fn update(&mut self, settings: &Settings, angle: bool, period: f64) {
        let same = (0.8 * self.period..1.25 * self.period).contains(&period);
        self.odd = if same { 0 } else { self.odd + 1 };
        if self.odd >= 10 {
            *self = Self::new(settings, angle, period);
        }
    }
}

fn delay(settings: &Settings, angle: bool, period: f64) -> f64 {
    let (s, e) = (&settings.sensors, &settings.estimator);
    if let Some(delay) = e.convergence_delay {
        return delay;
    }
    if !angle {
        let r = s.swing_velocity_std * s.swing_velocity_std;
        return Gain::steady(period, e.q_c * period, r).convergence_delay(period);
    }
    // Three states: poles of a third-order Butterworth filter of frequency (q_c / (R T))^(1/6);
    // after a step of the true acceleration its error stays within 5 % from 5.95 / wn on.
    let r = s.swing_angle_std * s.swing_angle_std;
    5.95 / exp(ln(e.q_c / (r * period)) / 6.0)
}

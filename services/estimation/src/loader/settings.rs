//! What the estimator is told: the machine, its sensors, the prior, and the tuning. SI units.

use core::fmt;

use super::Method;

/// The machine, from its data sheet and its calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine {
    /// Mass with its load [kg]; a measured mass overrides it.
    pub mass: f64,
    /// Nominal rolling radius r of the wheels [m].
    pub wheel_radius: f64,
    /// Moment of inertia I of one axle with its wheels [kg m^2].
    pub axle_inertia: f64,
    /// Distance l between the axles [m].
    pub wheelbase: f64,
    /// Distance l_c from the front axle to the bucket tip [m].
    pub bucket_reach: f64,
    /// Rolling resistance f per axle load.
    pub rolling_resistance: f64,
    /// Wheel torque over motor torque. The samples carry wheel torques, so the estimator does not use it.
    pub gear_ratio: f64,
    /// Friction limit mu of tyre on ground; infinite for the paper's linear tyre.
    pub friction: f64,
    /// Relative decrease rho of the rolling radius when an axle load grows by half the weight.
    pub radius_load_sensitivity: f64,
    /// Standard deviation of rho: it cannot be learnt on line and widens the reported interval.
    pub radius_load_sensitivity_std: f64,
}

impl Default for Machine {
    fn default() -> Self {
        Self {
            mass: 4700.0,
            wheel_radius: 0.55,
            axle_inertia: 3.33,
            wheelbase: 2.3,
            bucket_reach: 1.7,
            rolling_resistance: 0.02,
            gear_ratio: 20.0,
            friction: 0.8,
            radius_load_sensitivity: 0.01,
            radius_load_sensitivity_std: 0.001,
        }
    }
}

/// Standard deviations of the sensors, per sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors {
    /// Speed [m/s].
    pub speed_std: f64,
    /// Wheel speeds [rad/s].
    pub wheel_speed_std: f64,
    /// Slope [rad]. Its noise acts through the process noise of the speed, so it is not used by itself.
    pub slope_std: f64,
    /// Specific force [m/s^2].
    pub acceleration_std: f64,
    /// Relative error of each axle's torque; their ratio cannot be learnt on line and widens the interval.
    pub torque_gain_std: f64,
}

impl Default for Sensors {
    fn default() -> Self {
        Self {
            speed_std: 0.02,
            wheel_speed_std: 0.002,
            slope_std: 0.002,
            acceleration_std: 0.05,
            torque_gain_std: 0.005,
        }
    }
}

/// What is believed before the first row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Slip stiffness K.
    pub slip_stiffness: f64,
    /// Its standard deviation.
    pub slip_stiffness_std: f64,
    /// Height of the centre of gravity [m].
    pub cg_height: f64,
    /// Its standard deviation [m].
    pub cg_height_std: f64,
    /// Share of the static weight on the front axle.
    pub cg_ratio: f64,
    /// Its standard deviation.
    pub cg_ratio_std: f64,
    /// Standard deviation of the speed at the start [m/s].
    pub speed_std: f64,
    /// Standard deviation of the wheel speeds at the start [rad/s].
    pub wheel_speed_std: f64,
    /// Relative error of each rolling radius; 5e-4 when the radii are calibrated.
    pub radius_std: f64,
    /// Unknown part of the spade force [N].
    pub spade_force_x_std: f64,
    /// Bias of the slope sensor [rad].
    pub slope_bias_std: f64,
}

impl Default for Prior {
    fn default() -> Self {
        Self {
            slip_stiffness: 19.0,
            slip_stiffness_std: 2.0,
            cg_height: 0.9,
            cg_height_std: 0.1,
            cg_ratio: 0.45,
            cg_ratio_std: 0.05,
            speed_std: 0.05,
            wheel_speed_std: 0.05,
            radius_std: 0.005,
            spade_force_x_std: 300.0,
            slope_bias_std: 0.01,
        }
    }
}

/// Sign of the load transfer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LoadTransfer {
    /// Accelerating unloads the front axle.
    #[default]
    Physical,
    /// As (6), (7), (10), (11) are printed: accelerating loads the front axle. For comparison only.
    Printed,
}

/// How the process model is integrated over a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integration {
    /// Linearly implicit: stable at every speed.
    #[default]
    Implicit,
    /// Explicit Euler (18): unstable for a real machine. For comparison only.
    Euler,
}

/// Process noise, standard deviation per 10 ms step; scaled with the root of the step length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProcessNoise {
    /// Speed [m/s].
    pub speed: f64,
    /// Wheel speeds [rad/s].
    pub wheel_speed: f64,
    /// Slip stiffness.
    pub slip_stiffness: f64,
    /// Height [m].
    pub cg_height: f64,
    /// Ratio.
    pub cg_ratio: f64,
    /// Unknown part of the spade force [N].
    pub spade_force_x: f64,
    /// Relative radius errors.
    pub radius: f64,
    /// Bias of the slope sensor [rad].
    pub slope_bias: f64,
}

/// Disturbances that act on the wheels like extra measurement noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inflation {
    /// Relative axle-load ripple acting through the slip (cb); 0 is off.
    pub load_ripple: f64,
    /// Relative axle-load ripple acting through the rolling radius (crho); 0 is off.
    pub radius_ripple: f64,
    /// Share of the not yet settled tyre torque (ct); 0 is off.
    pub torque_lag: f64,
    /// Least standard deviation of the wheel speeds while slow or digging [rad/s]; 0 is off.
    pub frozen_wheel_speed_std: f64,
}

/// Treatment of single innovations, in units of their predicted standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gates {
    /// Above: the measurement is de-weighted.
    pub soft: f64,
    /// From here on: the measurement is dropped.
    pub hard: f64,
}

/// When digging holds the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Digging {
    /// Spade force that counts as digging [N].
    pub force: f64,
    /// How long digging outlasts the force [s].
    pub hold: f64,
    /// After digging the bucket may be full: height and ratio reopen to this multiple of the prior; 0 is off.
    pub reopen: f64,
    /// Multiple of the parameter noise while the boom moves; 1 is off.
    pub boom_gain: f64,
}

/// Bounds of the estimated parameters: the mean is clamped, the covariance is not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clamps {
    /// Slip stiffness.
    pub slip_stiffness: (f64, f64),
    /// Height [m].
    pub cg_height: (f64, f64),
    /// Ratio.
    pub cg_ratio: (f64, f64),
}

/// When the filter restarts by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reset {
    /// Running mean of the normalised innovation squared above which the covariance restarts.
    pub level: f64,
    /// Time constant of that mean [s].
    pub time_constant: f64,
    /// Shortest time between the start, or a reset, and the next reset [s].
    pub hold_off: f64,
}

/// Numerical and statistical choices; each method has its own defaults, see [`Tuning::of`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Process noise.
    pub noise: ProcessNoise,
    /// Smallest speed in a slip denominator, v_min [m/s].
    pub minimum_speed: f64,
    /// Use the mean of two neighbouring input samples; otherwise the older one is held.
    pub midpoint_inputs: bool,
    /// Use the friction limit and the load sensitivity of the machine; otherwise the linear, rigid tyre.
    pub real_tyre: bool,
    /// Integration of the process model.
    pub integration: Integration,
    /// Equal parts into which one step is divided, at least 1.
    pub substeps: u32,
    /// Spread alpha of the sigma points: 1, or 0.01 as the paper has it.
    pub spread: f64,
    /// Weight beta of (22): acts in the printed form only.
    pub beta: f64,
    /// Kappa of (21).
    pub kappa: f64,
    /// Sign of the load transfer.
    pub load_transfer: LoadTransfer,
    /// Measure with a linearised model (EKF) instead of sigma points.
    pub linearised: bool,
    /// Extra wheel noise.
    pub inflation: Inflation,
    /// Below this speed the parameters are held and the wheel rows weak [m/s]; 0 is off.
    pub freeze_speed: f64,
    /// Innovation gates; `None` is off.
    pub gates: Option<Gates>,
    /// Parameter bounds; `None` is off.
    pub clamps: Option<Clamps>,
    /// Digging rule; `None` is off.
    pub digging: Option<Digging>,
    /// Gap after which speeds are re-anchored [s]; infinite is off.
    pub gap: f64,
    /// Reset rule; `None` is off.
    pub reset: Option<Reset>,
}

impl Tuning {
    /// The tuning that a method has when nothing else is asked for.
    pub const fn of(method: Method) -> Self {
        match method {
            Method::Full => Self::recommended(),
            _ => Self::paper(),
        }
    }

    /// The protected filter on a real machine.
    pub const fn recommended() -> Self {
        Self {
            noise: ProcessNoise {
                speed: 5e-4,
                wheel_speed: 1e-3,
                slip_stiffness: 3e-4,
                cg_height: 3e-5,
                cg_ratio: 3e-5,
                spade_force_x: 150.0,
                radius: 1e-7,
                slope_bias: 1e-5,
            },
            minimum_speed: 0.3,
            midpoint_inputs: true,
            real_tyre: true,
            integration: Integration::Implicit,
            substeps: 1,
            spread: 1.0,
            beta: 2.0,
            kappa: 0.0,
            load_transfer: LoadTransfer::Physical,
            linearised: false,
            inflation: Inflation {
                load_ripple: 0.1,
                radius_ripple: 0.1,
                torque_lag: 0.5,
                frozen_wheel_speed_std: 0.3,
            },
            freeze_speed: 0.5,
            gates: Some(Gates {
                soft: 5.0,
                hard: 20.0,
            }),
            clamps: Some(Clamps::WIDE),
            digging: Some(Digging {
                force: 2500.0,
                hold: 0.5,
                reopen: 2.0,
                boom_gain: 40.0,
            }),
            gap: 0.25,
            reset: Some(Reset {
                level: 6.0,
                time_constant: 2.0,
                hold_off: 3.0,
            }),
        }
    }

    /// The paper's six states: no protection, linear tyre, held inputs, alpha 0.01.
    pub const fn paper() -> Self {
        Self {
            noise: ProcessNoise {
                speed: 5e-3,
                wheel_speed: 1e-2,
                slip_stiffness: 1e-3,
                cg_height: 1e-4,
                cg_ratio: 1e-4,
                ..Self::recommended().noise
            },
            midpoint_inputs: false,
            real_tyre: false,
            spread: 0.01,
            inflation: Inflation {
                load_ripple: 0.0,
                radius_ripple: 0.0,
                torque_lag: 0.0,
                frozen_wheel_speed_std: 0.0,
            },
            freeze_speed: 0.0,
            gates: None,
            clamps: None,
            digging: None,
            gap: f64::INFINITY,
            reset: None,
            ..Self::recommended()
        }
    }

    /// The six states tuned: small process noise, real tyre, mid-point inputs, clamps; no gates and no resets.
    pub const fn tuned() -> Self {
        Self {
            spread: 0.01,
            inflation: Inflation {
                load_ripple: 0.1,
                radius_ripple: 0.0,
                torque_lag: 0.5,
                frozen_wheel_speed_std: 0.3,
            },
            gates: None,
            digging: None,
            gap: f64::INFINITY,
            reset: None,
            ..Self::recommended()
        }
    }
}

impl Clamps {
    /// Bounds that no wheel loader leaves.
    pub const WIDE: Self = Self {
        slip_stiffness: (4.0, 80.0),
        cg_height: (0.3, 2.5),
        cg_ratio: (0.1, 0.9),
    };
}

/// What the report adds to the filter's standard deviations, and the limits of the verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// Error of the height that cannot be learnt on line [m].
    pub cg_height_floor: f64,
    /// Relative error of the ratio that remains with everything calibrated.
    pub cg_ratio_floor: f64,
    /// Variation of the total torque that excites the ratio [N m].
    pub excited_torque: f64,
    /// Variation of the acceleration that excites the height [m/s^2].
    pub excited_acceleration: f64,
    /// Age of the last accepted speed and wheel speeds that is still fresh [s].
    pub fresh: f64,
    /// Running mean of the normalised innovation squared that is still consistent.
    pub consistent_nis: f64,
    /// Reported relative standard deviation at which the ratio has converged.
    pub converged_ratio: f64,
    /// Reported standard deviation at which the height has converged [m].
    pub converged_height: f64,
}

impl Default for Verdict {
    fn default() -> Self {
        Self {
            cg_height_floor: 0.04,
            cg_ratio_floor: 0.011,
            excited_torque: 300.0,
            excited_acceleration: 0.3,
            fresh: 0.25,
            consistent_nis: 2.0,
            converged_ratio: 0.03,
            converged_height: 0.08,
        }
    }
}

impl Verdict {
    fn check(&self) -> Result<(), SettingsError> {
        not_negative("estimator.cg_height_floor", self.cg_height_floor)?;
        not_negative("estimator.cg_ratio_floor", self.cg_ratio_floor)?;
        not_negative("estimator.excited_torque", self.excited_torque)?;
        not_negative("estimator.excited_acceleration", self.excited_acceleration)?;
        positive("estimator.fresh", self.fresh)?;
        positive("estimator.consistent_nis", self.consistent_nis)?;
        positive("estimator.converged_ratio", self.converged_ratio)?;
        positive("estimator.converged_height", self.converged_height)
    }
}

/// Everything the estimator is told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// The machine.
    pub machine: Machine,
    /// Its sensors.
    pub sensors: Sensors,
    /// The prior.
    pub prior: Prior,
    /// Floors and limits of the verdict.
    pub verdict: Verdict,
    /// Choices other than the method's own; `None` takes [`Tuning::of`].
    pub tuning: Option<Tuning>,
}

/// A setting that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettingsError {
    /// The key, as in the description file.
    pub key: &'static str,
    /// What it must be.
    pub must_be: &'static str,
    /// What it is.
    pub value: f64,
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} is {}, it must be {}",
            self.key, self.value, self.must_be
        )
    }
}

impl core::error::Error for SettingsError {}

const POSITIVE: &str = "positive and finite";
const NOT_NEGATIVE: &str = "zero or positive, and finite";

impl Settings {
    /// The tuning in effect for a method.
    pub fn tuning(&self, method: Method) -> Tuning {
        self.tuning.unwrap_or(Tuning::of(method))
    }

    pub(super) fn check(&self, method: Method) -> Result<(), SettingsError> {
        self.machine.check()?;
        self.sensors.check()?;
        self.prior.check()?;
        self.verdict.check()?;
        self.tuning(method).check()
    }
}

fn positive(key: &'static str, value: f64) -> Result<(), SettingsError> {
    require(key, POSITIVE, value, value > 0.0 && value.is_finite())
}

fn not_negative(key: &'static str, value: f64) -> Result<(), SettingsError> {
    require(key, NOT_NEGATIVE, value, value >= 0.0 && value.is_finite())
}

fn require(
    key: &'static str,
    must_be: &'static str,
    value: f64,
    holds: bool,
) -> Result<(), SettingsError> {
    if holds {
        Ok(())
    } else {
        Err(SettingsError {
            key,
            must_be,
            value,
        })
    }
}

impl Machine {
    fn check(&self) -> Result<(), SettingsError> {
        positive("machine.mass", self.mass)?;
        positive("machine.wheel_radius", self.wheel_radius)?;
        positive("machine.axle_inertia", self.axle_inertia)?;
        positive("machine.wheelbase", self.wheelbase)?;
        not_negative("machine.bucket_reach", self.bucket_reach)?;
        not_negative("machine.rolling_resistance", self.rolling_resistance)?;
        positive("machine.gear_ratio", self.gear_ratio)?;
        require(
            "machine.friction",
            "positive",
            self.friction,
            self.friction > 0.0,
        )?;
        let rho = self.radius_load_sensitivity;
        require(
            "machine.radius_load_sensitivity",
            "within -0.2 .. 0.2",
            rho,
            rho.abs() <= 0.2,
        )?;
        not_negative(
            "machine.radius_load_sensitivity_std",
            self.radius_load_sensitivity_std,
        )
    }
}

impl Sensors {
    fn check(&self) -> Result<(), SettingsError> {
        positive("sensors.speed_std", self.speed_std)?;
        positive("sensors.wheel_speed_std", self.wheel_speed_std)?;
        not_negative("sensors.slope_std", self.slope_std)?;
        positive("sensors.acceleration_std", self.acceleration_std)?;
        not_negative("sensors.torque_gain_std", self.torque_gain_std)
    }
}

impl Prior {
    fn check(&self) -> Result<(), SettingsError> {
        positive("prior.slip_stiffness", self.slip_stiffness)?;
        positive("prior.slip_stiffness_std", self.slip_stiffness_std)?;
        positive("prior.cg_height", self.cg_height)?;
        positive("prior.cg_height_std", self.cg_height_std)?;
        let ratio = self.cg_ratio;
        require(
            "prior.cg_ratio",
            "between 0 and 1",
            ratio,
            ratio > 0.0 && ratio < 1.0,
        )?;
        positive("prior.cg_ratio_std", self.cg_ratio_std)?;
        positive("prior.speed_std", self.speed_std)?;
        positive("prior.wheel_speed_std", self.wheel_speed_std)?;
        positive("prior.radius_std", self.radius_std)?;
        positive("prior.spade_force_std", self.spade_force_x_std)?;
        positive("prior.slope_bias_std", self.slope_bias_std)
    }
}

impl Tuning {
    fn check(&self) -> Result<(), SettingsError> {
        let substeps = f64::from(self.substeps);
        require(
            "estimator.substeps",
            "1 .. 1000",
            substeps,
            (1..=1000).contains(&self.substeps),
        )?;
        require(
            "estimator.alpha",
            "within 1e-4 .. 10",
            self.spread,
            (1e-4..=10.0).contains(&self.spread),
        )?;
        require("estimator.beta", "finite", self.beta, self.beta.is_finite())?;
        // alpha^2 (n + kappa) must be positive for the smallest n, 6.
        let kappa = self.kappa;
        require(
            "estimator.kappa",
            "within -5 .. 100",
            kappa,
            (-5.0..=100.0).contains(&kappa),
        )?;
        positive("estimator.v_min", self.minimum_speed)?;
        self.noise.check()?;
        self.inflation.check()?;
        not_negative("estimator.v_freeze", self.freeze_speed)?;
        require("estimator.gap", "positive", self.gap, self.gap > 0.0)?;
        self.check_rules()
    }

    fn check_rules(&self) -> Result<(), SettingsError> {
        if let Some(gates) = self.gates {
            positive("estimator.gate", gates.soft)?;
            require(
                "estimator.reject",
                "above estimator.gate",
                gates.hard,
                gates.hard > gates.soft,
            )?;
        }
        if let Some(clamps) = self.clamps {
            for (key, (low, high)) in [
                ("estimator.slip_stiffness_min", clamps.slip_stiffness),
                ("estimator.cg_height_min", clamps.cg_height),
                ("estimator.cg_ratio_min", clamps.cg_ratio),
            ] {
                require(key, "below its maximum", low, low < high)?;
            }
        }
        if let Some(digging) = self.digging {
            positive("estimator.dig_force", digging.force)?;
            not_negative("estimator.dig_hold", digging.hold)?;
            not_negative("estimator.reopen", digging.reopen)?;
            not_negative("estimator.boom_gain", digging.boom_gain)?;
        }
        if let Some(reset) = self.reset {
            positive("estimator.reset_nis", reset.level)?;
            positive("estimator.reset_time_constant", reset.time_constant)?;
            not_negative("estimator.reset_hold_off", reset.hold_off)?;
        }
        Ok(())
    }
}

impl ProcessNoise {
    fn check(&self) -> Result<(), SettingsError> {
        not_negative("estimator.q_speed", self.speed)?;
        not_negative("estimator.q_wheel_speed", self.wheel_speed)?;
        not_negative("estimator.q_slip_stiffness", self.slip_stiffness)?;
        not_negative("estimator.q_cg_height", self.cg_height)?;
        not_negative("estimator.q_cg_ratio", self.cg_ratio)?;
        not_negative("estimator.q_spade_force", self.spade_force_x)?;
        not_negative("estimator.q_radius", self.radius)?;
        not_negative("estimator.q_slope_bias", self.slope_bias)
    }
}

impl Inflation {
    fn check(&self) -> Result<(), SettingsError> {
        not_negative("estimator.c_b", self.load_ripple)?;
        not_negative("estimator.c_rho", self.radius_ripple)?;
        not_negative("estimator.c_t", self.torque_lag)?;
        not_negative(
            "estimator.frozen_wheel_speed_std",
            self.frozen_wheel_speed_std,
        )
    }
}

//! The compared filters: method, settings, inputs.

use estimation::loader::settings::Estimator;
use estimation::loader::{
    CgEstimator, Columns, LoadTransfer, Machine, Method, Payload, Prior, Sample, Sensors, Settings,
    SettingsError,
};
use sim::loader::{Grade, Nominal, Row};

/// One of the compared filters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// Name in the tables.
    pub name: &'static str,
    method: Method,
    /// Settings without statements about the machine.
    settings: Settings,
    /// Start from the truth instead of the initial guess.
    start_at_truth: bool,
    /// Whether the wheel speeds are corrected with radii calibrated before.
    warm: bool,
    /// Standard deviation of the load sensitivity of the rolling radius; 0 where it is stated exactly.
    load_sensitivity_std: f64,
    /// The payload is reported by the weighing system.
    weighed: bool,
}

/// Prior of the methods with six states, as specified: the error of the initial guess only.
const PAPER_PRIOR: Prior = Prior {
    slip_stiffness_std: 2.0,
    cg_height_std: 0.10,
    cg_ratio_std: 0.05,
    ..Prior::DEFAULT
};

impl Candidate {
    const fn new(name: &'static str, method: Method, settings: Settings) -> Self {
        Self {
            name,
            method,
            settings,
            start_at_truth: false,
            warm: false,
            load_sensitivity_std: LOAD_SENSITIVITY_STD,
            weighed: false,
        }
    }

    /// With six states.
    const fn six(name: &'static str, method: Method, settings: Settings) -> Self {
        let settings = Settings {
            prior: PAPER_PRIOR,
            ..settings
        };
        Self::new(name, method, settings)
    }

    /// The paper's filter as printed.
    pub const PRINTED: Self = Self::six("ISR-UKF printed", Method::IsrUkfPrinted, Settings::PAPER);
    /// The paper's filter with gain and covariance that agree.
    pub const JOINT: Self = Self::six("ISR-UKF", Method::IsrUkf, Settings::PAPER);
    /// The paper's baseline.
    pub const EKF: Self = Self::six("EKF", Method::Ekf, Settings::PAPER);
    /// Six states with the tuning that suits an exactly known machine.
    pub const TUNED: Self = Self::six("tuned 6 states", Method::IsrUkf, KNOWN_MACHINE);
    /// The default filter, nothing calibrated.
    pub const COLD: Self = Self::new("full, cold", Method::Full, Settings::DEFAULT);
    /// The default filter on a machine known by its data sheet only.
    pub const DATA_SHEET: Self = Self {
        load_sensitivity_std: Machine::DEFAULT.radius_load_sensitivity_std,
        ..Self::COLD
    };
    /// The default filter in its extended form, linearised by the model's tangent.
    pub const TANGENT: Self = Self::new("full-ekf, cold", Method::FullEkf, Settings::DEFAULT);
    /// The default filter with rolling radii known to 5e-4.
    pub const WARM: Self = Self {
        warm: true,
        ..Self::new("full, warm", Method::Full, CALIBRATED_RADII)
    };
    /// The default filter with the one known tolerance that it cannot estimate and that moves the ratio most.
    pub const CALIBRATED: Self = Self {
        load_sensitivity_std: 0.0,
        name: "full, load sensitivity known",
        ..Self::COLD
    };
    /// The default filter with a reported payload.
    pub const WEIGHED: Self = Self {
        weighed: true,
        ..Self::new("full, weighed", Method::Full, WEIGHED)
    };

    /// The same by another method.
    pub const fn by(self, method: Method) -> Self {
        Self { method, ..self }
    }

    /// The filter that demonstrates the sign of the load transfer: height fixed, everything else known.
    pub const fn sign(load_transfer: LoadTransfer) -> Self {
        let settings = Settings {
            estimator: Estimator {
                load_transfer,
                q_speed: 1e-3,
                q_wheel_speed: 2e-3,
                q_slip_stiffness: 1e-4,
                q_cg_height: 1e-6,
                q_cg_ratio: 1e-3,
                // No bounds.
                slip_stiffness_min: 0.01,
                slip_stiffness_max: 1e4,
                cg_height_min: 0.0,
                cg_height_max: 20.0,
                cg_ratio_min: 0.0,
                cg_ratio_max: 1.0,
                ..Settings::TUNED.estimator
            },
            prior: Prior {
                cg_height_std: 0.01,
                ..PAPER_PRIOR
            },
            ..Settings::TUNED
        };
        let name = match load_transfer {
            LoadTransfer::Physical => "physical",
            LoadTransfer::Printed => "printed",
        };
        Self {
            start_at_truth: true,
            ..Self::new(name, Method::IsrUkf, settings)
        }
    }

    /// The machine's data for this filter.
    pub fn nominal(&self, nominal: &Nominal, machine: &sim::loader::Machine) -> Nominal {
        let mut nominal = *nominal;
        if self.load_sensitivity_std == 0.0 {
            nominal.radius_load_sensitivity = machine.radius_load_sensitivity;
        }
        nominal
    }

    /// The settings from the stated values.
    pub fn settings(&self, nominal: &Nominal, first: &Row) -> Settings {
        let mut prior = prior(nominal, &self.settings.prior);
        if self.start_at_truth {
            prior.slip_stiffness = first.truth.slip_stiffness;
            prior.cg_height = first.truth.cg_height;
            prior.cg_ratio = first.truth.cg_ratio;
        }
        let mut machine = machine(nominal, &self.settings.machine);
        machine.radius_load_sensitivity_std = self.load_sensitivity_std;
        Settings {
            machine,
            sensors: sensors(nominal.grade),
            prior,
            ..self.settings
        }
    }

    /// A filter before its first row.
    pub fn estimator(&self, settings: &Settings) -> Result<CgEstimator, SettingsError> {
        let columns = Columns { acceleration: true };
        CgEstimator::new(settings, self.method, columns)
    }

    /// The part of a row that this filter receives.
    pub fn sample(&self, nominal: &Nominal, row: &Row) -> Sample {
        let mut sample = sample(row);
        if self.warm {
            let scale = |value: &mut Option<f64>, by: f64| *value = value.map(|v| v * by);
            // The same rim speed and the same tyre force on a wheel of nominal radius.
            let front = 1.0 + nominal.front_radius_error;
            let rear = 1.0 + nominal.rear_radius_error;
            scale(&mut sample.front_wheel_speed, front);
            scale(&mut sample.rear_wheel_speed, rear);
            scale(&mut sample.front_torque, 1.0 / front);
            scale(&mut sample.rear_torque, 1.0 / rear);
        }
        sample.boom_moving &= !self.weighed;
        sample
    }

    /// The payload that the weighing system reports to this filter before a row.
    pub fn payload(&self, row: &Row) -> Option<Payload> {
        let p = &row.payload;
        self.weighed
            .then(|| Payload::new(p.mass, p.height, p.reach))
    }
}

/// An exactly known machine needs little process noise: a third of that of [`Settings::TUNED`], which lets the ratio drift by 1 %
/// within a work cycle. Rows with a changing torque count half.
const KNOWN_MACHINE: Settings = Settings {
    estimator: Estimator {
        q_slip_stiffness: 1e-4,
        q_cg_height: 1e-5,
        q_cg_ratio: 1e-5,
        c_t: 1.0,
        ..Settings::TUNED.estimator
    },
    ..Settings::TUNED
};

const CALIBRATED_RADII: Settings = Settings {
    prior: Prior {
        radius_std: 5e-4,
        ..Prior::DEFAULT
    },
    ..Settings::DEFAULT
};

/// A reported payload changes no state, so the covariance is not reopened.
const WEIGHED: Settings = Settings {
    estimator: Estimator {
        reopen: 0.0,
        boom_gain: 1.0,
        ..Settings::DEFAULT.estimator
    },
    ..Settings::DEFAULT
};

/// Standard deviation of the load sensitivity that the tables assume for the tyres.
const LOAD_SENSITIVITY_STD: f64 = 0.001;

/// The statements of a competent user about the machine.
pub(super) fn described(nominal: &Nominal) -> config::Loader {
    config::Loader {
        machine: machine(nominal, &Machine::DEFAULT),
        sensors: sensors(nominal.grade),
        prior: prior(nominal, &Prior::DEFAULT),
        ..config::Loader::default()
    }
}

fn prior(nominal: &Nominal, known: &Prior) -> Prior {
    Prior {
        slip_stiffness: nominal.slip_stiffness,
        cg_height: nominal.cg_height.max(0.3),
        cg_ratio: nominal.cg_ratio,
        ..*known
    }
}

fn machine(nominal: &Nominal, known: &Machine) -> Machine {
    Machine {
        mass: nominal.mass,
        wheel_radius: nominal.wheel_radius,
        axle_inertia: nominal.axle_inertia,
        wheelbase: nominal.wheelbase,
        bucket_reach: nominal.bucket_reach,
        rolling_resistance: nominal.rolling_resistance,
        friction: nominal.friction,
        radius_load_sensitivity: nominal.radius_load_sensitivity,
        ..*known
    }
}

fn sensors(grade: Grade) -> Sensors {
    Sensors {
        speed_std: grade.speed_std(),
        wheel_speed_std: grade.wheel_speed_std(),
        slope_std: grade.slope_std(),
        acceleration_std: grade.acceleration_std(),
        ..Sensors::default()
    }
}

/// A row in the form of the estimator.
pub(super) fn sample(row: &Row) -> Sample {
    Sample {
        time: row.time,
        speed: Some(row.speed),
        front_wheel_speed: Some(row.front_wheel_speed),
        rear_wheel_speed: Some(row.rear_wheel_speed),
        front_torque: Some(row.front_torque),
        rear_torque: Some(row.rear_torque),
        slope: Some(row.slope),
        acceleration: Some(row.acceleration),
        mass: row.mass,
        spade_force_x: row.spade_force_x,
        spade_force_z: row.spade_force_z,
        boom_moving: row.boom_moving.unwrap_or(false),
        articulation: row.articulation,
        yaw_rate: row.yaw_rate,
        brake: row.brake.unwrap_or(false),
        ..Sample::default()
    }
}

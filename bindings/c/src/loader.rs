//! The table of the wheel loader.

use core::fmt;

use estimation::loader::{
    CgEstimator, Columns, Estimate, Method, Sample, Settings, SettingsError, Status, Tuning,
};

use crate::table::{Bit, Key, Machine, Signal, Value, keys, present, rows};

/// Any method of the wheel loader.
#[derive(Clone)]
pub struct Loader(CgEstimator);

/// Settings with the tuning of the method `full`; the methods with six states have the paper's.
pub struct Described(Settings, Tuning);

impl Default for Described {
    fn default() -> Self {
        Self(Settings::default(), Tuning::product())
    }
}

/// An estimate with the time of its row.
pub struct Timed {
    time: f64,
    estimate: Estimate,
}

/// Why a loader's estimator cannot start.
enum Refusal {
    NoSuchMethod,
    Settings(SettingsError),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchMethod => f.write_str("the loader has no method of this number"),
            Self::Settings(error) => error.fmt(f),
        }
    }
}

/// Position of the specific force in [`Machine::SIGNALS`], the time not counted.
const ACCELERATION: u32 = 6;

impl Machine for Loader {
    const NAME: &'static str = "loader";
    type Settings = Described;
    type Sample = Sample;
    type Estimate = Timed;

    const KEYS: &'static [Key<Described>] = keys! { s;
        "machine" {
            mass = s.0.machine.mass;
            wheel_radius = s.0.machine.wheel_radius;
            axle_inertia = s.0.machine.axle_inertia;
            wheelbase = s.0.machine.wheelbase;
            bucket_reach = s.0.machine.bucket_reach;
            rolling_resistance = s.0.machine.rolling_resistance;
            friction = s.0.machine.friction;
            radius_load_sensitivity = s.0.machine.radius_load_sensitivity;
            radius_load_sensitivity_std = s.0.machine.radius_load_sensitivity_std;
            relaxation_length = s.0.machine.relaxation_length;
        }
        "sensors" {
            speed_std = s.0.sensors.speed_std;
            wheel_speed_std = s.0.sensors.wheel_speed_std;
            slope_std = s.0.sensors.slope_std;
            acceleration_std = s.0.sensors.acceleration_std;
            torque_gain_std = s.0.sensors.torque_gain_std;
        }
        "prior" {
            slip_stiffness = s.0.prior.slip_stiffness;
            slip_stiffness_std = s.0.prior.slip_stiffness_std;
            cg_height = s.0.prior.cg_height;
            cg_height_std = s.0.prior.cg_height_std;
            cg_ratio = s.0.prior.cg_ratio;
            cg_ratio_std = s.0.prior.cg_ratio_std;
            speed_std = s.0.prior.speed_std;
            wheel_speed_std = s.0.prior.wheel_speed_std;
            spade_force_std = s.0.prior.spade_force_x_std;
            radius_std = s.0.prior.radius_std;
            slope_bias_std = s.0.prior.slope_bias_std;
        }
        "estimator" {
            q_speed = s.1.noise.speed;
            q_wheel_speed = s.1.noise.wheel_speed;
            q_slip_stiffness = s.1.noise.slip_stiffness;
            q_cg_height = s.1.noise.cg_height;
            q_cg_ratio = s.1.noise.cg_ratio;
            q_spade_force = s.1.noise.spade_force_x;
            q_radius = s.1.noise.radius;
            q_slope_bias = s.1.noise.slope_bias;
            v_min = s.1.minimum_speed;
            v_freeze = s.1.freeze_speed;
            c_b = s.1.inflation.load_ripple;
            c_rho = s.1.inflation.radius_ripple;
            c_t = s.1.inflation.torque_lag;
            gap = s.1.gap;
            cg_height_floor = s.0.verdict.cg_height_floor;
            cg_ratio_floor = s.0.verdict.cg_ratio_floor;
            excited_torque = s.0.verdict.excited_torque;
            excited_acceleration = s.0.verdict.excited_acceleration;
            fresh = s.0.verdict.fresh;
            consistent_nis = s.0.verdict.consistent_nis;
            converged_ratio = s.0.verdict.converged_ratio;
            converged_height = s.0.verdict.converged_height;
        }
    };

    const SIGNALS: &'static [Signal<Sample>] = rows! { Signal, put:
        t = |s, x| s.time = x;
        speed = |s, x| s.speed = present(x);
        front_wheel_speed = |s, x| s.front_wheel_speed = present(x);
        rear_wheel_speed = |s, x| s.rear_wheel_speed = present(x);
        front_torque = |s, x| s.front_torque = present(x);
        rear_torque = |s, x| s.rear_torque = present(x);
        slope = |s, x| s.slope = present(x);
        acceleration = |s, x| s.acceleration = present(x);
        mass = |s, x| s.mass = present(x);
        spade_force_x = |s, x| s.spade_force_x = present(x);
        spade_force_z = |s, x| s.spade_force_z = present(x);
        boom_moving = |s, x| s.boom_moving = x > 0.0;
    };

    const REQUIRED: &'static [&'static [&'static str]] = &[
        &["speed"],
        &["front_wheel_speed"],
        &["rear_wheel_speed"],
        &["front_torque"],
        &["rear_torque"],
        &["slope"],
    ];

    const VALUES: &'static [Value<Timed>] = rows! { Value, get:
        t = |e| e.time;
        speed = |e| e.estimate.speed;
        front_wheel_speed = |e| e.estimate.front_wheel_speed;
        rear_wheel_speed = |e| e.estimate.rear_wheel_speed;
        slip_stiffness = |e| e.estimate.slip_stiffness.value;
        slip_stiffness_std = |e| e.estimate.slip_stiffness.std;
        cg_height = |e| e.estimate.cg_height.value;
        cg_height_std = |e| e.estimate.cg_height.std;
        cg_ratio = |e| e.estimate.cg_ratio.value;
        cg_ratio_std = |e| e.estimate.cg_ratio.std;
        cg_distance = |e| e.estimate.cg_distance;
        spade_force_x = |e| e.estimate.spade_force_x.unwrap_or_default().value;
        spade_force_x_std = |e| e.estimate.spade_force_x.unwrap_or_default().std;
        slope_bias = |e| e.estimate.slope_bias.unwrap_or_default();
        front_radius_scale = |e| e.estimate.front_radius_scale.unwrap_or_default();
        rear_radius_scale = |e| e.estimate.rear_radius_scale.unwrap_or_default();
        nis = |e| e.estimate.nis;
    };

    const FLAGS: &'static [Bit<Timed>] = rows! { Bit, get:
        excited_ratio = |e| e.estimate.excited_ratio;
        excited_height = |e| e.estimate.excited_height;
        consistent = |e| e.estimate.consistent;
        fresh = |e| e.estimate.fresh;
        converged_ratio = |e| e.estimate.converged_ratio;
        converged_height = |e| e.estimate.converged_height;
        frozen = |e| e.estimate.frozen;
        reset = |e| e.estimate.reset;
        trusted_ratio = |e| e.estimate.trusted_ratio;
        trusted_height = |e| e.estimate.trusted_height;
        refused = |e| e.estimate.status == Status::Refused;
        diverged = |e| e.estimate.status == Status::Diverged;
    };

    const ESTIMATED: &'static [Bit<Timed>] = rows! { Bit, get:
        state = |e| e.estimate.started;
        spade_force_x = |e| e.estimate.started && e.estimate.spade_force_x.is_some();
        slope_bias = |e| e.estimate.started && e.estimate.slope_bias.is_some();
        radius_scales = |e| e.estimate.started && e.estimate.front_radius_scale.is_some();
    };

    const METHODS: &'static [&'static str] = &["full", "isr-ukf-printed", "isr-ukf", "ekf"];

    fn new(
        Described(settings, tuning): &Described,
        method: usize,
        columns: u32,
    ) -> Result<Self, impl fmt::Display> {
        let method = *Method::ALL.get(method).ok_or(Refusal::NoSuchMethod)?;
        let tuning = match method {
            Method::Full => *tuning,
            _ => Tuning {
                minimum_speed: tuning.minimum_speed,
                ..Tuning::paper()
            },
        };
        let mut settings = Settings {
            tuning: Some(tuning),
            ..*settings
        };
        // As in a description: 0 leaves the tyre force unlimited.
        if settings.machine.friction <= 0.0 {
            settings.machine.friction = f64::INFINITY;
        }
        let columns = Columns {
            acceleration: columns & (1 << ACCELERATION) != 0,
            ..Columns::default()
        };
        CgEstimator::new(&settings, method, columns)
            .map(Self)
            .map_err(Refusal::Settings)
    }

    fn step(&mut self, sample: &Sample) -> Timed {
        Timed {
            time: if sample.time.is_finite() {
                sample.time
            } else {
                0.0
            },
            estimate: self.0.step(sample),
        }
    }

    fn method(estimate: &Timed) -> usize {
        let method = estimate.estimate.method;
        Method::ALL.iter().position(|m| *m == method).unwrap_or(0)
    }

    fn refused(estimate: &Timed) -> u64 {
        estimate.estimate.refused
    }
}

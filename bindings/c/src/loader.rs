//! The table of the wheel loader.

use core::fmt;

use estimation::loader::keys::Description;
use estimation::loader::{
    CgEstimator, Columns, Estimate, Method, Sample, Settings, SettingsError, Status,
};

use crate::table::{Bit, Machine, Signal, Value, present, rows};

/// Any method of the wheel loader.
#[derive(Clone)]
pub struct Loader(CgEstimator);

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
    type Settings = Description;
    type Sample = Sample;
    type Estimate = Timed;

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
        articulation = |s, x| s.articulation = present(x);
        yaw_rate = |s, x| s.yaw_rate = present(x);
        brake = |s, x| s.brake = x > 0.0;
        lift_angle = |s, x| s.lift_angle = present(x);
        tilt_angle = |s, x| s.tilt_angle = present(x);
        lift_head_pressure = |s, x| s.lift_head_pressure = present(x);
        lift_rod_pressure = |s, x| s.lift_rod_pressure = present(x);
        truck = |s, x| s.truck = present(x);
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
        speed_delay = |e| e.estimate.speed_delay.unwrap_or_default().value;
        speed_delay_std = |e| e.estimate.speed_delay.unwrap_or_default().std;
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
        identifiable_ratio = |e| e.estimate.identifiable_ratio;
        identifiable_height = |e| e.estimate.identifiable_height;
    };

    const ESTIMATED: &'static [Bit<Timed>] = rows! { Bit, get:
        state = |e| e.estimate.started;
        spade_force_x = |e| e.estimate.started && e.estimate.spade_force_x.is_some();
        slope_bias = |e| e.estimate.started && e.estimate.slope_bias.is_some();
        radius_scales = |e| e.estimate.started && e.estimate.front_radius_scale.is_some();
        speed_delay = |e| e.estimate.started && e.estimate.speed_delay.is_some();
    };

    const METHODS: &'static [&'static str] = Method::NAMES;

    fn new(
        description: &Description,
        method: usize,
        columns: u32,
    ) -> Result<Self, impl fmt::Display> {
        let method = *Method::ALL.get(method).ok_or(Refusal::NoSuchMethod)?;
        let settings = Settings::of(description, method);
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
        method.index() as usize
    }

    fn reason(estimate: &Timed) -> u32 {
        estimate.estimate.reason as u32
    }

    fn refused(estimate: &Timed) -> u64 {
        estimate.estimate.refused
    }
}

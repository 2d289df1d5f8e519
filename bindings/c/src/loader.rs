//! The table of the wheel loader.

use core::fmt;

use estimation::loader::keys::Description;
use estimation::loader::{CgEstimator, Columns, Estimate, Method, Sample, Settings, SettingsError};

use crate::table::{Bit, Machine, Value, flags, rows, signals};

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

    sheet::loader_signals!(signals);

    const REQUIRED: &'static [&'static [&'static str]] = sheet::loader::REQUIRED;

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

    sheet::loader_flags!(flags);

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

//! The table of the excavator.

use core::fmt;

use estimation::excavator::keys::Description;
use estimation::excavator::{
    Columns, Estimate, Method, MotionFilter, Regression, Sample, Settings, SettingsError,
    SwingEstimator,
};

use crate::table::{Bit, Machine, Value, flags, rows, signals};

/// Any method of the excavator.
#[derive(Clone)]
pub struct Excavator {
    stage: Stage,
    started: bool,
}

#[derive(Clone)]
#[allow(clippy::large_enum_variant)] // no allocator
enum Stage {
    Regression(MotionFilter, Regression),
    StateSpace(SwingEstimator),
}

/// An estimate with the time of its row.
pub struct Timed {
    time: f64,
    estimate: Estimate,
    started: bool,
}

/// Why an excavator's estimator cannot start.
enum Refusal {
    NoSuchMethod,
    Settings(SettingsError),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchMethod => f.write_str("the excavator has no method of this number"),
            Self::Settings(error) => error.fmt(f),
        }
    }
}

impl From<SettingsError> for Refusal {
    fn from(error: SettingsError) -> Self {
        Self::Settings(error)
    }
}

/// Bits of the columns: positions in [`Machine::SIGNALS`], the time not counted.
fn columns(bits: u32) -> Columns {
    let all = |mask: u32| bits & mask == mask;
    Columns {
        velocity: all(1),
        angle: all(1 << 1),
        torque: all(1 << 2),
        posture: all(0b111 << 3),
    }
}

impl Machine for Excavator {
    const NAME: &'static str = "excavator";
    type Settings = Description;
    type Sample = Sample;
    type Estimate = Timed;

    sheet::excavator_signals!(signals);

    const REQUIRED: &'static [&'static [&'static str]] = sheet::excavator::REQUIRED;

    const VALUES: &'static [Value<Timed>] = rows! { Value, get:
        t = |e| e.time;
        inertia = |e| e.estimate.inertia;
        inertia_std = |e| e.estimate.inertia_std;
        damping = |e| e.estimate.damping.unwrap_or_default().value;
        damping_std = |e| e.estimate.damping.unwrap_or_default().std;
        torque = |e| e.estimate.torque.unwrap_or_default().value;
        torque_std = |e| e.estimate.torque.unwrap_or_default().std;
        payload = |e| e.estimate.payload.unwrap_or_default().value;
        payload_std = |e| e.estimate.payload.unwrap_or_default().std;
        velocity = |e| e.estimate.velocity;
        acceleration = |e| e.estimate.acceleration;
        friction = |e| e.estimate.friction.unwrap_or_default().value;
        friction_std = |e| e.estimate.friction.unwrap_or_default().std;
        offset = |e| e.estimate.offset.unwrap_or_default().value;
        offset_std = |e| e.estimate.offset.unwrap_or_default().std;
        nis = |e| e.estimate.nis;
        forgetting_inertia = |e| e.estimate.forgetting[0];
        forgetting_damping = |e| e.estimate.forgetting[1];
        forgetting_torque = |e| e.estimate.forgetting[2];
    };

    sheet::excavator_flags!(flags);

    const ESTIMATED: &'static [Bit<Timed>] = rows! { Bit, get:
        damping = |e| e.started && e.estimate.damping.is_some();
        torque = |e| e.started && e.estimate.torque.is_some();
        payload = |e| e.started && e.estimate.payload.is_some();
        friction = |e| e.started && e.estimate.friction.is_some();
        offset = |e| e.started && e.estimate.offset.is_some();
        inertia = |e| e.started;
        acceleration = |e| e.started;
    };

    const METHODS: &'static [&'static str] = Method::NAMES;

    fn new(description: &Description, method: usize, bits: u32) -> Result<Self, impl fmt::Display> {
        let method = *Method::ALL.get(method).ok_or(Refusal::NoSuchMethod)?;
        let (settings, columns) = (Settings::of(description), columns(bits));
        let stage = if method.is_regression() {
            let filter = MotionFilter::new(&settings, columns)?;
            Stage::Regression(filter, Regression::new(&settings, method)?)
        } else {
            Stage::StateSpace(SwingEstimator::new(&settings, method, columns)?)
        };
        Ok::<_, Refusal>(Self {
            stage,
            started: false,
        })
    }

    fn step(&mut self, sample: &Sample) -> Timed {
        let estimate = match &mut self.stage {
            Stage::Regression(filter, regression) => regression.step(&filter.step(sample)),
            Stage::StateSpace(estimator) => estimator.step(sample),
        };
        self.started |= !estimate.flags.refused;
        Timed {
            time: if sample.time.is_finite() {
                sample.time
            } else {
                0.0
            },
            estimate,
            started: self.started,
        }
    }

    fn method(estimate: &Timed) -> usize {
        estimate.estimate.method.index() as usize
    }

    fn reason(estimate: &Timed) -> u32 {
        estimate.estimate.reason.code()
    }

    fn refused(estimate: &Timed) -> u64 {
        estimate.estimate.refused
    }
}

//! The table of the excavator.

use core::fmt;

use estimation::excavator::keys::Description;
use estimation::excavator::{
    Columns, Estimate, Method, MotionFilter, Regression, Sample, Settings, SettingsError,
    SwingEstimator,
};

use estimation::loads;

use crate::table::{Machine, flags, quantities, signals};

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

impl Timed {
    fn started(&self) -> bool {
        self.started
    }
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
            #[cfg(feature = "std")]
            Self::Settings(error) => error.fmt(f),
            // Formatting a number as text takes 15 kB of code.
            #[cfg(not(feature = "std"))]
            Self::Settings(error) => match error {
                SettingsError::OutOfRange { key, .. } => write!(f, "{key} is outside its range"),
                SettingsError::Correlations => {
                    f.write_str("machine.*_correlation contradict each other")
                }
                SettingsError::MissingColumn { method, column } => {
                    write!(f, "the method {method} needs the column {column}")
                }
                SettingsError::WrongStage { method } => write!(f, "no method {method} here"),
            },
        }
    }
}

impl From<SettingsError> for Refusal {
    fn from(error: SettingsError) -> Self {
        Self::Settings(error)
    }
}

/// Bits of the columns: positions in [`Machine::SIGNALS`], without the time.
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

    sheet::excavator_quantities!(quantities);
    sheet::excavator_flags!(flags);

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

    fn loads(description: &Description) -> loads::Settings {
        description.loads()
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

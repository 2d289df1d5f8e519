//! The table of the wheel loader.

use core::fmt;

#[cfg(not(feature = "std"))]
use estimation::loader::MustBe;
use estimation::loader::keys::Description;
use estimation::loader::{CgEstimator, Columns, Estimate, Method, Sample, Settings, SettingsError};

use estimation::loads;

use crate::table::{Machine, flags, quantities, signals};

/// Any method of the wheel loader.
#[derive(Clone)]
pub struct Loader(CgEstimator);

/// An estimate with the time of its row.
pub struct Timed {
    time: f64,
    estimate: Estimate,
}

impl Timed {
    fn started(&self) -> bool {
        self.estimate.started
    }
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
            #[cfg(feature = "std")]
            Self::Settings(error) => error.fmt(f),
            // Formatting a number as text takes 15 kB of code.
            #[cfg(not(feature = "std"))]
            Self::Settings(error) => match error.must_be {
                MustBe::Within(_) => write!(f, "{} is outside its range", error.key),
                MustBe::Below(other) => write!(f, "{} must be below {other}", error.key),
                MustBe::FullEkf => f.write_str("this library has no method but full-ekf"),
            },
        }
    }
}

/// Position of the specific force in [`Machine::SIGNALS`], without the time.
const ACCELERATION: u32 = 6;

impl Machine for Loader {
    const NAME: &'static str = "loader";
    type Settings = Description;
    type Sample = Sample;
    type Estimate = Timed;

    sheet::loader_signals!(signals);

    const REQUIRED: &'static [&'static [&'static str]] = sheet::loader::REQUIRED;

    sheet::loader_quantities!(quantities);
    sheet::loader_flags!(flags);

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
        };
        CgEstimator::new(&settings, method, columns)
            .map(Self)
            .map_err(Refusal::Settings)
    }

    fn loads(description: &Description) -> loads::Settings {
        description.loads()
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

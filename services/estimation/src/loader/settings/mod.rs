//! What the estimator is told. SI units.
//!
//! | file | idea |
//! |---|---|
//! | `machine` | the machine, its sensors, the prior |
//! | `described` | what a description means |
//! | `tuning`, `presets`, `check` | numerical and statistical choices, by method, and which can be used |
//! | `verdict` | floors of the reported intervals, limits of the verdict |

use core::fmt;

use super::Method;

mod check;
mod described;
mod machine;
mod presets;
mod tuning;
mod verdict;

pub use machine::{Machine, Prior, Sensors};
pub use tuning::{
    Clamps, Digging, Gates, Inflation, Integration, LoadTransfer, ProcessNoise, Relearning, Reset,
    Tuning,
};
pub use verdict::Verdict;

/// Everything the estimator is told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

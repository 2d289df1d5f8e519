//! A parameter to be identified: its prior and its limits.

/// Scale on which the prior of a parameter is normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// The value itself.
    Linear,
    /// Its logarithm; `std` is then relative.
    Logarithmic,
}

/// Source of a prior.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The description with its tolerances, which calibration is to improve.
    Description,
    /// A measurement that belongs to the recordings, such as a weighed load: it counts as data.
    Measured,
}

/// One parameter of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Key of the description, or a name of its own where it is not part of it.
    pub key: String,
    /// Name in sentences: "the torque gain".
    pub words: String,
    /// SI unit.
    pub unit: &'static str,
    /// Prior mean.
    pub mean: f64,
    /// Prior standard deviation; of the logarithm under [`Law::Logarithmic`].
    pub std: f64,
    /// Smallest and largest value.
    pub range: (f64, f64),
    /// Scale on which the prior is normal.
    pub law: Law,
    /// Source of the prior.
    pub source: Source,
}

impl Parameter {
    /// A parameter with the described value of a key and its tolerance.
    pub(crate) fn described(
        key: &str,
        words: &str,
        unit: &'static str,
        mean: f64,
        std: f64,
        range: (f64, f64),
    ) -> Self {
        Self {
            key: key.into(),
            words: words.into(),
            unit,
            mean,
            std,
            range,
            law: Law::Linear,
            source: Source::Description,
        }
    }

    /// A noise parameter; `std` is the standard deviation of its logarithm.
    pub(crate) fn noise(key: &str, words: &str, unit: &'static str, mean: f64, std: f64) -> Self {
        Self {
            law: Law::Logarithmic,
            ..Self::described(key, words, unit, mean, std, (1e-3 * mean, 1e3 * mean))
        }
    }

    /// The value at `x` prior standard deviations from the prior mean, within the range.
    pub fn value(&self, x: f64) -> f64 {
        let free = match self.law {
            Law::Linear => self.mean + self.std * x,
            Law::Logarithmic => self.mean * (self.std * x).exp(),
        };
        free.clamp(self.range.0, self.range.1)
    }

    /// Place of a value, in prior standard deviations from the prior mean.
    pub fn place(&self, value: f64) -> f64 {
        let value = value.clamp(self.range.0, self.range.1);
        match self.law {
            Law::Linear => (value - self.mean) / self.std,
            Law::Logarithmic => (value / self.mean).ln() / self.std,
        }
    }

    /// Standard deviation of the value at `x`, given that of `x`.
    pub fn value_std(&self, x: f64, std: f64) -> f64 {
        match self.law {
            Law::Linear => self.std * std,
            Law::Logarithmic => self.value(x) * self.std * std,
        }
    }
}

/// Described parameters, one row each: role, key, words, unit, mean, standard deviation, range.
macro_rules! rows {
    ($( $role:expr, $key:expr, $words:expr, $unit:expr, $mean:expr, $std:expr, $range:expr; )*) => {
        [$( ($role, $crate::parameter::Parameter::described($key, $words, $unit, $mean, $std, $range)) ),*]
    };
}
pub(crate) use rows;

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(law: Law) -> Parameter {
        Parameter {
            key: "k".into(),
            words: "k".into(),
            unit: "",
            mean: 2.0,
            std: 0.5,
            range: (0.1, 5.0),
            law,
            source: Source::Description,
        }
    }

    #[test]
    fn place_undoes_value_within_the_range() {
        for law in [Law::Linear, Law::Logarithmic] {
            let p = parameter(law);
            for x in [-1.0, 0.0, 1.5] {
                assert!((p.place(p.value(x)) - x).abs() < 1e-12);
            }
            assert_eq!(p.value(100.0), 5.0);
        }
    }
}

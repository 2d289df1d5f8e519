//! Consistency tests: whether innovations agree with their predicted variance.
//!
//! The normalised innovation squared (NIS) of a scalar measurement is chi-square with one degree
//! of freedom, mean 1, where model and noise are right.

/// Mean of the last `N` normalised innovations squared. Each is limited, so that a single outlier does not decide.
///
/// ```
/// use estimation::consistency::NisWindow;
///
/// let mut window = NisWindow::<4>::new(9.0);
/// [1.0, 1.0, 1.0, 1e6].map(|nis| window.push(nis));
/// assert_eq!(window.mean(), 3.0, "the outlier counts as 9");
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NisWindow<const N: usize> {
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    values: [f64; N],
    next: usize,
    filled: usize,
    limit: f64,
    mean: f64,
}

/// Limit of a normalised innovation squared in a mean: four standard deviations.
pub const MOST_NIS: f64 = 16.0;

impl<const N: usize> NisWindow<N> {
    /// An empty window whose entries are limited to `limit`.
    pub fn new(limit: f64) -> Self {
        Self {
            values: [0.0; N],
            next: 0,
            filled: 0,
            limit,
            mean: 1.0,
        }
    }

    /// Adds one value.
    pub fn push(&mut self, nis: f64) {
        self.values[self.next] = nis.min(self.limit);
        self.next = (self.next + 1) % N;
        self.filled = (self.filled + 1).min(N);
        self.mean = self.values[..self.filled].iter().sum::<f64>() / self.filled as f64;
    }

    /// Mean of what is in the window; 1, the expected value, while it is empty.
    pub fn mean(&self) -> f64 {
        self.mean
    }
}

/// Two-sided cumulative sum of normalised innovations: detects a small lasting shift of their mean
/// that no single sample shows.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Cusum {
    drift: f64,
    threshold: f64,
    up: f64,
    down: f64,
}

impl Cusum {
    /// Subtracts `drift` per sample and alarms above `threshold`, both in standard deviations.
    pub fn new(drift: f64, threshold: f64) -> Self {
        Self {
            drift,
            threshold,
            up: 0.0,
            down: 0.0,
        }
    }

    /// Adds one normalised innovation. An alarm sets both sums back to zero.
    pub fn push(&mut self, z: f64) -> bool {
        self.up = (self.up + z - self.drift).max(0.0);
        self.down = (self.down - z - self.drift).max(0.0);
        let alarm = self.level() > self.threshold;
        if alarm {
            self.clear();
        }
        alarm
    }

    /// The larger of the two sums.
    pub fn level(&self) -> f64 {
        self.up.max(self.down)
    }

    /// Resets both sums.
    pub fn clear(&mut self) {
        self.up = 0.0;
        self.down = 0.0;
    }
}

/// Variance that limits an innovation to `gate` standard deviations: outliers still move the
/// state, but no further than the gate.
pub fn gated_variance(innovation: f64, variance: f64, gate: f64) -> f64 {
    variance.max(innovation * innovation / (gate * gate))
}

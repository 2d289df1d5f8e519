//! Equal filters: the same second-order low-pass on all signals of an equation preserves the equation, and its
//! states are the filtered derivatives.
//!
//! ```text
//! z'' + 2 zeta wn z' + wn^2 z = wn^2 u
//! ```
//!
//! integrated with at least four symplectic Euler steps per sample, with the input held.

/// One low-pass filter; `value` is z, `rate` is z'.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Lowpass {
    pub(in crate::excavator) value: f64,
    pub(in crate::excavator) rate: f64,
    /// z'' during the last substep.
    pub(in crate::excavator) curvature: f64,
    /// Output of the optional first-order stage in front.
    pub(in crate::excavator) before: f64,
}

/// Frequency and damping, shared by all filters of a bank.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Shape {
    pub(in crate::excavator) frequency: f64,
    pub(in crate::excavator) damping: f64,
    /// Adds a first-order stage of the same frequency in front. An angle is differentiated twice; without this
    /// stage the noise of the second derivative is unbounded.
    pub(in crate::excavator) third_order: bool,
}

/// Substeps for one sample, or `None` where the gap is too long to bridge.
fn substeps(shape: &Shape, period: f64) -> Option<usize> {
    let needed = shape.frequency * period / 0.2;
    (needed < 200.0).then(|| (needed as usize + 1).max(4))
}

impl Lowpass {
    /// At rest at `input`.
    pub(in crate::excavator) fn settled(input: f64) -> Self {
        Self {
            value: input,
            before: input,
            ..Self::default()
        }
    }

    /// Takes one sample. After a gap that is too long to bridge the filter restarts, settled.
    pub(in crate::excavator) fn step(&mut self, shape: &Shape, input: f64, period: f64) {
        let Some(n) = substeps(shape, period) else {
            *self = Self::settled(input);
            return;
        };
        let h = period / n as f64;
        let (wn, zeta) = (shape.frequency, shape.damping);
        for _ in 0..n {
            let u = if shape.third_order {
                self.before += h * wn * (input - self.before) / (1.0 + h * wn);
                self.before
            } else {
                input
            };
            self.curvature = wn * wn * (u - self.value) - 2.0 * zeta * wn * self.rate;
            self.rate += h * self.curvature;
            self.value += h * self.rate;
        }
    }
}

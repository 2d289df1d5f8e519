//! Correlation and ratio of two related quantities.

/// Sums of squares and products of two quantities.
#[derive(Clone, Copy, Default)]
pub(super) struct Pair {
    pub(super) squares: [f64; 2],
    product: f64,
}

impl Pair {
    pub(super) fn see(&mut self, x: f64, y: f64) {
        // A missing sensor gives NaN.
        if x.is_finite() && y.is_finite() {
            self.squares[0] += x * x;
            self.squares[1] += y * y;
            self.product += x * y;
        }
    }

    pub(super) fn correlation(&self) -> f64 {
        self.product / (self.squares[0] * self.squares[1]).sqrt()
    }

    /// Root mean square of the first over that of the second.
    pub(super) fn ratio(&self) -> f64 {
        (self.squares[0] / self.squares[1]).sqrt()
    }
}

/// Whether a ratio is 1 within a factor.
pub(super) fn about(ratio: f64, factor: f64) -> bool {
    (1.0 / factor..=factor).contains(&ratio)
}

//! A least-squares regression over blocks. The last regressor is the one that matters.

/// Sums of squares and products of `N - 1` regressors and the response, and number of blocks.
pub(super) struct Regression<const N: usize> {
    sums: [[f64; N]; N],
    pub(super) rows: f64,
}

impl<const N: usize> Default for Regression<N> {
    fn default() -> Self {
        Self {
            sums: [[0.0; N]; N],
            rows: 0.0,
        }
    }
}

impl<const N: usize> Regression<N> {
    /// Takes a block; one without a sensor (NaN) is skipped.
    pub(super) fn see(&mut self, row: [f64; N]) {
        if !row.iter().all(|x| x.is_finite()) {
            return;
        }
        for (sums, x) in self.sums.iter_mut().zip(row) {
            sums.iter_mut().zip(row).for_each(|(sum, y)| *sum += x * y);
        }
        self.rows += 1.0;
    }

    /// The sums after elimination of all regressors but the last.
    fn eliminated(&self) -> [[f64; N]; N] {
        let mut s = self.sums;
        for pivot in 0..N - 2 {
            for row in pivot + 1..N {
                let share = s[row][pivot] / s[pivot][pivot];
                let above = s[pivot];
                let both = s[row].iter_mut().zip(above);
                both.for_each(|(x, y)| *x -= share * y);
            }
        }
        s
    }

    /// Root of the mean square of the last regressor that the others leave.
    pub(super) fn left(&self) -> f64 {
        (self.eliminated()[N - 2][N - 2] / self.rows).sqrt()
    }

    /// Partial correlation of the last regressor with the response, given the others.
    pub(super) fn correlation(&self) -> f64 {
        let s = self.eliminated();
        s[N - 2][N - 1] / (s[N - 2][N - 2] * s[N - 1][N - 1]).sqrt()
    }

    /// The last coefficient over its standard deviation.
    pub(super) fn significance(&self) -> f64 {
        let s = self.eliminated();
        let [x, y] = [N - 2, N - 1];
        let left = s[y][y] - s[x][y] * s[x][y] / s[x][x];
        s[x][y] / (s[x][x] * left / (self.rows - y as f64)).sqrt()
    }
}

impl Regression<4> {
    /// Coefficients of the second and the third regressor.
    pub(super) fn coefficients(&self) -> [f64; 2] {
        let s = self.eliminated();
        let third = s[2][3] / s[2][2];
        [(s[1][3] - s[1][2] * third) / s[1][1], third]
    }
}

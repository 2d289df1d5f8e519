//! A least-squares regression on three regressors over blocks.

/// Sums of squares and products of three regressors and the response, and number of blocks.
#[derive(Default)]
pub(super) struct Regression {
    sums: [[f64; 4]; 4],
    pub(super) rows: f64,
}

impl Regression {
    /// Takes a block; one without a sensor (NaN) is skipped.
    pub(super) fn see(&mut self, row: [f64; 4]) {
        if !row.iter().all(|x| x.is_finite()) {
            return;
        }
        for (sums, x) in self.sums.iter_mut().zip(row) {
            sums.iter_mut().zip(row).for_each(|(sum, y)| *sum += x * y);
        }
        self.rows += 1.0;
    }

    /// The sums after elimination of the first two regressors.
    fn eliminated(&self) -> [[f64; 4]; 4] {
        let mut s = self.sums;
        for pivot in 0..2 {
            for row in pivot + 1..4 {
                let share = s[row][pivot] / s[pivot][pivot];
                let above = s[pivot];
                let both = s[row].iter_mut().zip(above);
                both.for_each(|(x, y)| *x -= share * y);
            }
        }
        s
    }

    /// Coefficients of the second and the third regressor.
    pub(super) fn coefficients(&self) -> [f64; 2] {
        let s = self.eliminated();
        let third = s[2][3] / s[2][2];
        [(s[1][3] - s[1][2] * third) / s[1][1], third]
    }

    /// Root of the mean square of the third regressor that the first two leave.
    pub(super) fn left(&self) -> f64 {
        (self.eliminated()[2][2] / self.rows).sqrt()
    }

    /// Partial correlation of the third regressor with the response, given the first two.
    pub(super) fn correlation(&self) -> f64 {
        let s = self.eliminated();
        s[2][3] / (s[2][2] * s[3][3]).sqrt()
    }

    /// The third coefficient over its standard deviation.
    pub(super) fn significance(&self) -> f64 {
        let s = self.eliminated();
        let left = s[3][3] - s[2][3] * s[2][3] / s[2][2];
        s[2][3] / (s[2][2] * left / (self.rows - 3.0)).sqrt()
    }
}

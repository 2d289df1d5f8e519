//! The square-root unscented filter of the textbooks, in nalgebra: QR, rank-one updates and downdates of Cholesky factors.

use super::rover::sigma_points;
use crate::problem::{Filter, ROVER, Rover, RoverSample};
use nalgebra::{Cholesky, Const, DimMin, Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};

/// van der Merwe's SR-UKF with additive noise, alpha = 1, beta = 1, kappa = 0, sigma points redrawn before the update.
pub struct Textbook {
    rover: Rover,
    x: Vector6<f64>,
    s: Matrix6<f64>,
    process_root: Matrix6<f64>,
    measurement_root: Matrix3<f64>,
    weight: f64,
    center_weight: f64,
}

impl Default for Textbook {
    fn default() -> Self {
        Self {
            rover: ROVER.rover,
            x: ROVER.state.into(),
            s: Matrix6::from_diagonal(&ROVER.initial_std.into()),
            process_root: Matrix6::from_diagonal(&ROVER.process_std.into()),
            measurement_root: Matrix3::from_diagonal(&ROVER.measurement_std.into()),
            weight: 1.0 / 12.0,
            center_weight: 1.0,
        }
    }
}

impl Textbook {
    /// Mean and lower root of images of the points; `ROWS` is 12 + `L`.
    fn spread<const L: usize, const ROWS: usize>(
        &self,
        images: &[SVector<f64, L>; 13],
        noise_root: &SMatrix<f64, L, L>,
    ) -> (SVector<f64, L>, SMatrix<f64, L, L>)
    where
        Const<ROWS>: DimMin<Const<L>, Output = Const<L>> + nalgebra::ToTypenum,
        Const<L>: DimMin<Const<L>, Output = Const<L>>,
    {
        let mean = images[1..].iter().sum::<SVector<f64, L>>() * self.weight;
        let mut rows = SMatrix::<f64, ROWS, L>::zeros();
        let root_weight = self.weight.sqrt();
        for (i, image) in images[1..].iter().enumerate() {
            rows.row_mut(i)
                .copy_from(&((image - mean) * root_weight).transpose());
        }
        rows.fixed_rows_mut::<L>(12).copy_from(noise_root);
        let mut root = rows.qr().unpack_r().transpose();
        for j in 0..L {
            if root[(j, j)] < 0.0 {
                root.column_mut(j).neg_mut();
            }
        }
        let mut factor = Cholesky::pack_dirty(root);
        factor.rank_one_update(&(images[0] - mean), self.center_weight);
        (mean, factor.l())
    }
}

impl Filter<RoverSample, 6> for Textbook {
    fn step(&mut self, sample: &RoverSample) {
        let rover = self.rover.under(sample.torque);
        let images = sigma_points(self.x, self.s).map(|x| Vector6::from(rover.next(&x.into())));
        (self.x, self.s) = self.spread::<6, 18>(&images, &self.process_root);
        let points = sigma_points(self.x, self.s);
        let measured = points.map(|x| Vector3::new(x[0], x[1], x[2]));
        let (mean, root) = self.spread::<3, 15>(&measured, &self.measurement_root);
        let mut cross = SMatrix::<f64, 6, 3>::zeros();
        for (x, z) in points[1..].iter().zip(&measured[1..]) {
            cross += (x - self.x) * (z - mean).transpose() * self.weight;
        }
        let half = root.solve_lower_triangular(&cross.transpose());
        let Some(gain) = half.and_then(|half| root.tr_solve_lower_triangular(&half)) else {
            return;
        };
        let gain = gain.transpose();
        self.x += gain * (Vector3::from(sample.measured) - mean);
        let downdate = gain * root;
        let mut factor = Cholesky::pack_dirty(self.s);
        for column in downdate.column_iter() {
            factor.rank_one_update(&column, -1.0);
        }
        self.s = factor.l();
    }

    fn state(&self) -> [f64; 6] {
        self.x.into()
    }
}

//! Belief as a covariance root, propagated by sigma points.

use super::Belief;
use crate::ekf::add;
use crate::images::Images;
use crate::loader::physics::cg_model::CgModel;
use crate::prediction::Prediction;
use crate::root::triangularise;
use crate::sigma_points::Spread;
use crate::srukf::SquareRootUkf;

impl<const N: usize, const M: usize> Belief<N, M> for SquareRootUkf<N, M> {
    type Ahead = Images<CgModel, N, M>;
    type Expected = Prediction<CgModel, N, M>;

    fn new(state: [f64; N], std: &[f64; N], spread: Spread) -> Self {
        Self::new(state, std, spread)
    }

    fn state(&self) -> &[f64; N] {
        &self.state
    }

    fn state_mut(&mut self) -> &mut [f64; N] {
        &mut self.state
    }

    fn variance(&self, i: usize) -> f64 {
        self.root[i][..=i].iter().map(|x| x * x).sum()
    }

    fn is_sound(&self) -> bool {
        // Entries far below overflow have a finite sum.
        let mut sum = self.state;
        for row in &self.root {
            add(&mut sum, 1.0, row);
        }
        sum.iter().sum::<f64>().is_finite()
    }

    fn separate(&mut self, states: &[(usize, f64)], process_std: &[f64; N]) {
        let mut rows = self.root.map(|row| [row]);
        let mut process = *process_std;
        for &(i, std) in states {
            rows[i] = [[0.0; N]];
            process[i] = std;
        }
        self.root = triangularise(&mut rows, &process);
    }

    // Not inlined, nor is `predict`: within the rest of a row they have too few registers.
    #[inline(never)]
    fn ahead(&self, model: &CgModel) -> Self::Ahead {
        self.images(model)
    }

    fn state_ahead(ahead: &Self::Ahead) -> &[f64; N] {
        &ahead.state
    }

    #[inline(never)]
    fn predict(
        &mut self,
        ahead: &mut Self::Ahead,
        _: &CgModel,
        process_std: &[f64; N],
    ) -> Self::Expected {
        ahead.predict(process_std)
    }

    fn measurement(expected: &Self::Expected) -> &[f64; M] {
        &expected.measurement
    }

    fn measurement_std(expected: &Self::Expected, j: usize) -> f64 {
        expected.measurement_std(j)
    }

    fn difference_variance(expected: &Self::Expected, of: [usize; 2]) -> f64 {
        expected.difference_variance(of)
    }

    #[inline(always)]
    fn update(
        &mut self,
        expected: &mut Self::Expected,
        innovation: &[f64; M],
        std: &[f64; M],
        accepted: &[bool; M],
    ) -> f64 {
        let update = expected.absorb(innovation, std, accepted);
        self.accept(expected);
        update.nis()
    }

    fn sigma_points(&mut self) -> Option<&mut SquareRootUkf<N, M>> {
        Some(self)
    }
}

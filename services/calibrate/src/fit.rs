//! Maximum a posteriori estimate: maximises likelihood times prior.
//!
//! With innovations nu of variance S and the parameters x in prior standard deviations from the prior mean,
//! ```text
//! cost(x) = 1/2 sum [ rho(nu^2/S) + ln S ] + 1/2 sum x^2
//! rho(u) = u up to the gate c^2, then 2 c sqrt(u) - c^2       (Huber, the estimators' gate)
//! ```
//! Scoring (Fisher 1925) uses the expected curvature, which is a product of first derivatives. With the
//! weight w of an innovation (1 inside the gate, c/|z| outside) and z = nu/sqrt(S), two rows each
//! ```text
//! sqrt(w) dnu/dx / sqrt(S),   right side  sqrt(w) z
//! dS/dx / (sqrt(2) S),        right side  (w z^2 - 1)(-1/sqrt(2))
//! ```
//! give gradient J'r and curvature J'J. The step solves J dx = -r by QR with rows sqrt(mu) dx = 0 below
//! (Levenberg 1944, Marquardt 1963), and is cut at the limits of the parameters. Derivatives are central
//! differences: a filter over 12 000 rows costs about a millisecond.

use std::sync::atomic::{AtomicBool, Ordering};

use faer::Mat;

use crate::algebra;
use crate::model::{Innovation, Model};
use crate::parallel;

/// Gate in standard deviations: larger innovations have less weight, as in the estimators.
pub const GATE: f64 = 4.0;
/// Step of the central differences, in prior standard deviations.
const DIFFERENCE: f64 = 1e-3;
/// Largest number of steps.
const STEPS: usize = 60;
/// Least decrease of the cost per step of a fit to the last digit.
pub const EXACT: f64 = 1e-5;
/// The same of a fit that is accurate to some hundredths of a standard deviation.
pub const GOOD: f64 = 1e-2;

/// Information of one block: the triangular factor of its rows, with the right side as last column.
pub type Information = Mat<f64>;

/// Progress of a fit.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// Steps taken.
    pub step: usize,
    /// Cost after them.
    pub cost: f64,
}

/// A fit to be made.
pub struct Task<'a, M> {
    /// The model.
    pub model: &'a M,
    /// The blocks that are used.
    pub blocks: &'a [usize],
    /// Flag of each parameter: it is held.
    pub fixed: &'a [bool],
    /// The fit ends when the cost falls by less in a step.
    pub least_gain: f64,
    /// Stop request: the result is the best place so far.
    pub stop: &'a AtomicBool,
    /// Called at every step.
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

/// Stop request of a fit that is never stopped.
pub static UNSTOPPED: AtomicBool = AtomicBool::new(false);

/// Result of a fit.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Place of the maximum, in prior standard deviations from the prior mean.
    pub place: Vec<f64>,
    /// Cost there.
    pub cost: f64,
    /// Information of each block of the task, in its order.
    pub information: Vec<Information>,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
}

impl<M: Model> Task<'_, M> {
    /// Returns the maximum, from a start.
    pub fn run(&self, start: &[f64]) -> Fit {
        let mut place = self.inside(start);
        let mut cost = self.cost(&place);
        let mut information = self.information(&place);
        let mut damping = 1e-3;
        let mut interrupted = false;
        for step in 0..STEPS {
            if self.stop.load(Ordering::Relaxed) {
                interrupted = true;
                break;
            }
            (self.progress)(Progress { step, cost });
            let Some((next, lower)) = self.improve(&place, cost, &information, &mut damping) else {
                break;
            };
            let gain = cost - lower;
            (place, cost) = (next, lower);
            information = self.information(&place);
            if gain < self.least_gain {
                break;
            }
        }
        Fit {
            place,
            cost,
            information,
            interrupted,
        }
    }

    /// A place of lower cost, by steps with increasing damping.
    fn improve(
        &self,
        place: &[f64],
        cost: f64,
        information: &[Information],
        damping: &mut f64,
    ) -> Option<(Vec<f64>, f64)> {
        let rows = algebra::triangle(&algebra::stacked(&information.iter().collect::<Vec<_>>()));
        for _ in 0..12 {
            let next = self.inside(&self.step(place, &rows, *damping));
            let lower = self.cost(&next);
            if lower < cost {
                *damping = (*damping * 0.1).max(1e-9);
                return Some((next, lower));
            }
            *damping = (*damping * 10.0).max(1e-6);
        }
        None
    }

    /// Place after a damped step; parameters that would cross their limit stay there.
    fn step(&self, place: &[f64], rows: &Mat<f64>, damping: f64) -> Vec<f64> {
        let mut held = self.fixed.to_vec();
        loop {
            let free: Vec<usize> = (0..place.len()).filter(|&i| !held[i]).collect();
            if free.is_empty() {
                return place.to_vec();
            }
            let delta = damped(place, rows, &free, damping);
            let mut next = place.to_vec();
            for (&i, d) in free.iter().zip(&delta) {
                next[i] += d;
            }
            let crossed: Vec<usize> = free
                .into_iter()
                .filter(|&i| self.at_limit(i, place[i], next[i]))
                .collect();
            if crossed.is_empty() {
                return next;
            }
            crossed.into_iter().for_each(|i| held[i] = true);
        }
    }

    fn at_limit(&self, i: usize, now: f64, next: f64) -> bool {
        let p = &self.model.parameters()[i];
        let (low, high) = (p.place(p.range.0), p.place(p.range.1));
        (next < low && now <= low + 1e-12) || (next > high && now >= high - 1e-12)
    }

    pub(crate) fn inside(&self, place: &[f64]) -> Vec<f64> {
        let parameters = self.model.parameters().iter();
        parameters
            .zip(place)
            .map(|(p, &x)| {
                let (low, high) = (p.place(p.range.0), p.place(p.range.1));
                if x.is_finite() {
                    x.clamp(low, high)
                } else {
                    0.0
                }
            })
            .collect()
    }

    /// The cost at a place.
    pub fn cost(&self, place: &[f64]) -> f64 {
        let values = values(self.model, place);
        let costs: Vec<f64> = parallel::map(self.blocks.len(), |at| {
            let mut innovations = Vec::new();
            self.model
                .innovations(self.blocks[at], &values, &mut innovations);
            innovations.iter().map(|i| 0.5 * contribution(i)).sum()
        });
        costs.iter().sum::<f64>() + 0.5 * place.iter().map(|x| x * x).sum::<f64>()
    }

    /// The information of every block at a place.
    pub fn information(&self, place: &[f64]) -> Vec<Information> {
        parallel::map(self.blocks.len(), |at| {
            information(self.model, self.blocks[at], place, self.fixed)
        })
    }
}

/// Twice the negative log-likelihood of an innovation, without its constant.
fn contribution(innovation: &Innovation) -> f64 {
    let square = innovation.value * innovation.value / innovation.variance;
    let rho = if square > GATE * GATE {
        2.0 * GATE * square.sqrt() - GATE * GATE
    } else {
        square
    };
    rho + innovation.variance.ln()
}

/// The values of the parameters at a place.
pub fn values<M: Model + ?Sized>(model: &M, place: &[f64]) -> Vec<f64> {
    let parameters = model.parameters().iter();
    parameters.zip(place).map(|(p, &x)| p.value(x)).collect()
}

fn information<M: Model>(model: &M, block: usize, place: &[f64], fixed: &[bool]) -> Information {
    let n = place.len();
    let at = |place: &[f64]| {
        let mut innovations = Vec::new();
        model.innovations(block, &values(model, place), &mut innovations);
        innovations
    };
    let base = at(place);
    let mut rows = Mat::zeros(2 * base.len(), n + 1);
    for (k, innovation) in base.iter().enumerate() {
        let square = innovation.value * innovation.value / innovation.variance;
        let weight = (GATE / square.sqrt()).min(1.0);
        rows[(2 * k, n)] = (weight * square).sqrt().copysign(innovation.value);
        rows[(2 * k + 1, n)] = (1.0 - weight * square) * core::f64::consts::FRAC_1_SQRT_2;
    }
    for i in (0..n).filter(|&i| !fixed[i] && model.acts(i, block)) {
        let moved = |by: f64| {
            let mut moved = place.to_vec();
            moved[i] += by;
            at(&moved)
        };
        let (above, below) = (moved(DIFFERENCE), moved(-DIFFERENCE));
        for (k, innovation) in base.iter().enumerate() {
            let (Some(above), Some(below)) = (above.get(k), below.get(k)) else {
                continue;
            };
            let slope = (above.value - below.value) / (2.0 * DIFFERENCE);
            let spread = (above.variance - below.variance) / (2.0 * DIFFERENCE);
            let weight = (GATE * innovation.variance.sqrt() / innovation.value.abs()).min(1.0);
            rows[(2 * k, i)] = slope * (weight / innovation.variance).sqrt();
            rows[(2 * k + 1, i)] = spread / innovation.variance * core::f64::consts::FRAC_1_SQRT_2;
        }
    }
    algebra::triangle(&rows)
}

/// Damped step of the free parameters.
fn damped(place: &[f64], rows: &Mat<f64>, free: &[usize], damping: f64) -> Vec<f64> {
    let n = place.len();
    let (above, count) = (rows.nrows(), free.len());
    let matrix = Mat::from_fn(above + 2 * count, count, |i, j| {
        if i < above {
            rows[(i, free[j])]
        } else if i < above + count {
            f64::from(i - above == j)
        } else {
            // Damped by the curvature of each parameter, the prior's included.
            let column = (0..above).map(|k| rows[(k, free[j])].powi(2)).sum::<f64>();
            f64::from(i - above - count == j) * (damping * (1.0 + column)).sqrt()
        }
    });
    let right: Vec<f64> = (0..above + 2 * count)
        .map(|i| {
            if i < above {
                -rows[(i, n)]
            } else if i < above + count {
                -place[free[i - above]]
            } else {
                0.0
            }
        })
        .collect();
    algebra::least_squares(&matrix, &right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::{Law, Parameter, Source};

    /// A straight line in white noise of unknown variance.
    struct Line {
        parameters: Vec<Parameter>,
        points: Vec<(f64, f64)>,
    }

    fn parameter(mean: f64, std: f64, range: (f64, f64), law: Law) -> Parameter {
        Parameter {
            key: String::new(),
            words: String::new(),
            unit: "",
            mean,
            std,
            range,
            law,
            source: Source::Description,
        }
    }

    impl Line {
        fn new(outlier: f64) -> Self {
            // Noise of standard deviation 0.1 whose sums with 1 and with t nearly vanish.
            let mut points: Vec<(f64, f64)> = (0..400)
                .map(|i| {
                    let noise = 0.1 * [1.0, -1.0, -1.0, 1.0][i % 4];
                    (i as f64 * 0.01, 2.0 + 0.5 * i as f64 * 0.01 + noise)
                })
                .collect();
            points[200].1 += outlier;
            Self {
                parameters: vec![
                    parameter(0.0, 10.0, (-100.0, 100.0), Law::Linear),
                    parameter(0.0, 10.0, (-100.0, 100.0), Law::Linear),
                    parameter(1.0, 2.0, (1e-6, 1e6), Law::Logarithmic),
                ],
                points,
            }
        }

        fn fit(&self) -> Vec<f64> {
            let task = Task {
                model: self,
                blocks: &[0, 1, 2, 3],
                fixed: &[false; 3],
                least_gain: EXACT,
                stop: &UNSTOPPED,
                progress: &|_| {},
            };
            values(self, &task.run(&[0.0; 3]).place)
        }
    }

    impl Model for Line {
        fn parameters(&self) -> &[Parameter] {
            &self.parameters
        }
        fn blocks(&self) -> usize {
            4
        }
        fn recording(&self, _: usize) -> usize {
            0
        }
        fn acts(&self, _: usize, _: usize) -> bool {
            true
        }
        fn innovations(&self, block: usize, values: &[f64], out: &mut Vec<Innovation>) {
            let points = &self.points[100 * block..100 * (block + 1)];
            out.extend(points.iter().map(|(t, y)| Innovation {
                value: y - values[0] - values[1] * t,
                variance: values[2] * values[2],
            }));
        }
    }

    #[test]
    fn a_line_and_the_size_of_its_noise_are_found() {
        let found = Line::new(0.0).fit();
        for (found, true_value) in found.iter().zip([2.0, 0.5, 0.1]) {
            assert!((found - true_value).abs() < 2e-3, "{found} {true_value}");
        }
    }

    #[test]
    fn an_outlier_of_ten_noises_moves_the_line_little() {
        let (clean, dirty) = (Line::new(0.0).fit(), Line::new(50.0).fit());
        // One of 400 samples, held at the gate: at most 4 sigma / 400.
        assert!((clean[0] - dirty[0]).abs() < 0.005, "{clean:?} {dirty:?}");
    }

    #[test]
    fn a_limit_holds_and_the_others_settle_around_it() {
        let mut line = Line::new(0.0);
        line.parameters[1].range = (-100.0, 0.2);
        let found = line.fit();
        assert_eq!(found[1], 0.2);
        assert!((found[0] - (2.0 + 0.3 * 2.0)).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn a_fit_that_is_stopped_keeps_the_best_so_far() {
        let line = Line::new(0.0);
        let stop = AtomicBool::new(false);
        let task = Task {
            model: &line,
            blocks: &[0, 1, 2, 3],
            fixed: &[false; 3],
            least_gain: EXACT,
            stop: &stop,
            progress: &|p: Progress| stop.store(p.step >= 1, Ordering::Relaxed),
        };
        let start = task.cost(&[0.0; 3]);
        let fit = task.run(&[0.0; 3]);
        assert!(fit.interrupted && fit.cost < start);
    }
}

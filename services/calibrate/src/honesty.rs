//! Identifiability and uncertainty of a fit.
//!
//! * **Directions that the data do not determine.** The singular values of the Jacobian, its columns in
//!   prior standard deviations: below 1, the data are less informative of a direction than the
//!   description is.
//! * **Scatter between blocks.** Swings that disagree by more than their noise allows widen all intervals:
//!   the delete-one jackknife (Efron, Stein 1981), each fit without one block by one step from the whole
//!   one. The errors of a swing gear, a slope, a boom that bends are not white noise.
//! * **Held parameters** (not free, but with a tolerance) add the effect of their errors (Schmidt).
//! * **Profiles**: along the two weakest parameters, the cost with all others fitted again.
//! * **Unseen data**: whiteness, size and coverage of the innovations of swings that were not fitted.

use estimation::HALF_WIDTH_95;
use faer::Mat;

use crate::algebra;
use crate::fit::{Fit, GOOD, Information, Task, values};
use crate::model::{Innovation, Model};
use crate::parameter::{Law, Parameter, Source};

/// Singular value of a measured load: it counts as data, for itself only.
const STATED_WEIGHT: f64 = 2.0;

/// A direction in the space of the parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Singular value: information of the data relative to the prior; 1 is as much.
    pub information: f64,
    /// Share of each parameter, in prior standard deviations; length 1.
    pub shares: Vec<f64>,
}

impl Direction {
    /// The parameters with large shares, the largest first.
    pub fn members(&self) -> Vec<usize> {
        let largest = self.shares.iter().fold(0.0, |l: f64, s| l.max(s.abs()));
        let mut members: Vec<usize> = (0..self.shares.len())
            .filter(|&i| self.shares[i].abs() > 0.25 * largest)
            .collect();
        members.sort_by(|a, b| self.shares[*b].abs().total_cmp(&self.shares[*a].abs()));
        members
    }

    /// Text that it is not determined, and what to record.
    pub fn undetermined(&self, parameters: &[Parameter], remedy: &str) -> String {
        let members = self.members();
        let names: Vec<&str> = members.iter().map(|&i| &*parameters[i].words).collect();
        let what = match names.as_slice() {
            [first @ .., last] if !first.is_empty() => format!(
                "{} and {last} cannot be distinguished by these recordings",
                first.join(", ")
            ),
            _ => format!("{} is not determined by these recordings", names.concat()),
        };
        // The inverse variances of prior and data add up.
        let narrowed = 100.0 / (1.0 + self.information * self.information).sqrt();
        format!("{what} (its uncertainty stays {narrowed:.0} % of that before); {remedy}")
    }
}

/// The directions of which the data are less informative than the prior, the weakest first. Measured loads
/// count as data.
pub fn undetermined(
    information: &[Information],
    parameters: &[Parameter],
    fixed: &[bool],
) -> Vec<Direction> {
    let free: Vec<usize> = (0..parameters.len()).filter(|&i| !fixed[i]).collect();
    if free.is_empty() {
        return Vec::new();
    }
    let rows = data(information, parameters.len());
    let stated: Vec<usize> = (0..free.len())
        .filter(|&j| parameters[free[j]].source == Source::Measured)
        .collect();
    let matrix = Mat::from_fn(rows.nrows() + stated.len(), free.len(), |i, j| {
        if i < rows.nrows() {
            rows[(i, free[j])]
        } else {
            STATED_WEIGHT * f64::from(stated[i - rows.nrows()] == j)
        }
    });
    let mut found: Vec<Direction> = algebra::directions(&matrix)
        .into_iter()
        .filter(|(value, _)| *value < 1.0)
        .map(|(information, direction)| {
            let mut shares = vec![0.0; parameters.len()];
            for (&i, share) in free.iter().zip(direction) {
                shares[i] = share;
            }
            Direction {
                information,
                shares,
            }
        })
        .collect();
    found.sort_by(|a, b| a.information.total_cmp(&b.information));
    found
}

/// Triangular factor of all blocks, with the right side as last column.
fn data(information: &[Information], parameters: usize) -> Mat<f64> {
    if information.is_empty() {
        return Mat::zeros(parameters + 1, parameters + 1);
    }
    algebra::triangle(&algebra::stacked(&information.iter().collect::<Vec<_>>()))
}

/// Joint uncertainty of the parameters, in prior standard deviations.
#[derive(Debug, Clone)]
pub struct Uncertainty {
    /// Widened covariance; zero rows for parameters that are held without a tolerance.
    pub covariance: Mat<f64>,
    /// Standard deviations from noise alone.
    pub noise: Vec<f64>,
    /// Factor by which the scatter between blocks widens the standard deviations.
    pub widened: f64,
}

impl Uncertainty {
    /// Standard deviation of a parameter, in prior standard deviations.
    pub fn std(&self, i: usize) -> f64 {
        self.covariance[(i, i)].max(0.0).sqrt()
    }

    /// Widens a parameter by a difference between recordings, in prior standard deviations: nothing tells which of them is right.
    pub fn widen(&mut self, i: usize, difference: f64) {
        self.covariance[(i, i)] += difference * difference;
    }

    /// Correlation of two parameters.
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        let size = self.std(i) * self.std(j);
        if size > 0.0 {
            self.covariance[(i, j)] / size
        } else {
            0.0
        }
    }
}

/// The uncertainty of a fit; `held` is the tolerance of each parameter that was not free, in prior standard
/// deviations (0 for none). `None` where the information is singular.
pub fn uncertainty(
    fit: &Fit,
    parameters: &[Parameter],
    fixed: &[bool],
    held: &[f64],
) -> Option<Uncertainty> {
    let n = fixed.len();
    let free: Vec<usize> = (0..n).filter(|&i| !fixed[i]).collect();
    let normal = |rows: &Mat<f64>| {
        Mat::from_fn(free.len(), free.len(), |i, j| {
            (0..rows.nrows())
                .map(|k| rows[(k, free[i])] * rows[(k, free[j])])
                .sum()
        })
    };
    let whole = data(&fit.information, n);
    let curvature = normal(&whole) + Mat::<f64>::identity(free.len(), free.len());
    let noise = algebra::inverse(&curvature)?;
    let left_out = jackknife(fit, &free, &curvature, &normal);
    // The scatter of noise parameters has another law and carries no information about the machine.
    let machine: Vec<usize> = (0..free.len())
        .filter(|&j| parameters[free[j]].law == Law::Linear)
        .collect();
    let (wide, widened) = widen(&noise, &left_out, &machine);
    let across = Mat::from_fn(free.len(), n, |i, j| {
        let tolerance = if fixed[j] { held[j] } else { 0.0 };
        tolerance
            * (0..whole.nrows())
                .map(|k| whole[(k, free[i])] * whole[(k, j)])
                .sum::<f64>()
    });
    let considered = &noise * across;
    let wide = wide + &considered * considered.transpose();
    let mut covariance = Mat::zeros(n, n);
    let mut alone = vec![0.0; n];
    for (a, &i) in free.iter().enumerate() {
        alone[i] = noise[(a, a)].max(0.0).sqrt();
        for (b, &j) in free.iter().enumerate() {
            covariance[(i, j)] = wide[(a, b)];
        }
    }
    for j in (0..n).filter(|&j| fixed[j]) {
        covariance[(j, j)] = held[j] * held[j];
    }
    Some(Uncertainty {
        covariance,
        noise: alone,
        widened,
    })
}

/// Difference of the fit without each block to the whole one.
fn jackknife(
    fit: &Fit,
    free: &[usize],
    curvature: &Mat<f64>,
    normal: &impl Fn(&Mat<f64>) -> Mat<f64>,
) -> Vec<Vec<f64>> {
    let blocks = fit.information.iter();
    blocks
        .filter_map(|rows| {
            let last = rows.ncols() - 1;
            let gradient = Mat::from_fn(free.len(), 1, |i, _| {
                (0..rows.nrows())
                    .map(|k| rows[(k, free[i])] * rows[(k, last)])
                    .sum::<f64>()
            });
            let step = algebra::inverse(&(curvature - normal(rows)))? * gradient;
            Some((0..free.len()).map(|i| step[(i, 0)]).collect())
        })
        .collect()
}

/// Widens the covariance by the jackknife: by its mean ratio to the noise over all directions of these
/// parameters, and further where one parameter scatters by more than chance allows for this number of blocks.
fn widen(noise: &Mat<f64>, left_out: &[Vec<f64>], of: &[usize]) -> (Mat<f64>, f64) {
    let (n, count) = (noise.nrows(), left_out.len() as f64);
    if left_out.len() < 4 {
        return (noise.to_owned(), 1.0);
    }
    let mean: Vec<f64> = (0..n)
        .map(|i| left_out.iter().map(|d| d[i]).sum::<f64>() / count)
        .collect();
    let scatter = Mat::from_fn(n, n, |i, j| {
        let sum: f64 = left_out
            .iter()
            .map(|d| (d[i] - mean[i]) * (d[j] - mean[j]))
            .sum();
        sum * (count - 1.0) / count
    });
    let ratios: Vec<f64> = (0..n)
        .map(|i| scatter[(i, i)] / noise[(i, i)].max(f64::MIN_POSITIVE))
        .collect();
    // A variance from n blocks has a relative standard deviation of sqrt(2/n).
    let chance = 1.0 + 2.0 * (2.0 / count).sqrt();
    let part = Mat::from_fn(of.len(), of.len(), |i, j| noise[(of[i], of[j])]);
    let common = match algebra::inverse(&part) {
        Some(curvature) if !of.is_empty() => {
            let pairs = (0..of.len()).flat_map(|i| (0..of.len()).map(move |j| (i, j)));
            let trace: f64 = pairs
                .map(|(i, j)| curvature[(i, j)] * scatter[(of[j], of[i])])
                .sum();
            (trace / of.len() as f64).max(1.0)
        }
        _ => 1.0,
    };
    let root: Vec<f64> = ratios
        .iter()
        .enumerate()
        .map(|(i, r)| {
            if of.contains(&i) { common } else { 1.0 }
                .max(r / chance)
                .sqrt()
        })
        .collect();
    let wide = Mat::from_fn(n, n, |i, j| root[i] * root[j] * noise[(i, j)]);
    (wide, common.sqrt())
}

/// Cost along one parameter, all others fitted again: places, and costs above the minimum.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// The parameter.
    pub parameter: usize,
    /// Place, in prior standard deviations, and cost above the minimum.
    pub points: Vec<(f64, f64)>,
}

/// The profile at -2, -1, 0, 1, 2 standard deviations of a parameter.
pub fn profile<M: Model>(
    task: &Task<'_, M>,
    fit: &Fit,
    uncertainty: &Uncertainty,
    parameter: usize,
) -> Profile {
    let mut fixed = task.fixed.to_vec();
    fixed[parameter] = true;
    let without = Task {
        fixed: &fixed,
        least_gain: task.least_gain.max(GOOD),
        progress: &|_| {},
        ..*task
    };
    // Start of the other parameters: they follow by their correlation.
    let variance = uncertainty.covariance[(parameter, parameter)];
    let follows = |i: usize| uncertainty.covariance[(i, parameter)] / variance;
    let points = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| {
        let step = k * variance.sqrt();
        let mut place = fit.place.clone();
        for (i, x) in place.iter_mut().enumerate() {
            *x += if i == parameter {
                step
            } else {
                step * follows(i)
            };
        }
        // The place is limited to the range of the parameter.
        let place = task.inside(&place);
        let cost = if k == 0.0 {
            fit.cost
        } else {
            without.run(&place).cost
        };
        (place[parameter], cost - fit.cost)
    });
    Profile {
        parameter,
        points: points.into(),
    }
}

/// Agreement of innovations with their predicted variance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Agreement {
    /// Number of innovations.
    pub count: usize,
    /// Mean of their squares over the predicted variances; 1 if the filter is right.
    pub nis: f64,
    /// Correlation of successive innovations; 0 if they are white.
    pub correlation: f64,
    /// Share inside the 95 % interval of the predicted variance.
    pub covered: f64,
}

/// The agreement over some blocks at a place. The true parameters are unknown: coverage is that of the innovations, each by its own
/// predicted variance.
pub fn agreement<M: Model + ?Sized>(model: &M, blocks: &[usize], place: &[f64]) -> Agreement {
    let values = values(model, place);
    let (mut count, mut squares, mut products, mut inside) = (0_usize, 0.0, 0.0, 0_usize);
    for &block in blocks {
        let mut innovations = Vec::new();
        model.innovations(block, &values, &mut innovations);
        let mut last = None;
        for Innovation { value, variance } in innovations {
            let z = value / variance.sqrt();
            count += 1;
            squares += z * z;
            products += last.map_or(0.0, |l: f64| l * z);
            inside += usize::from(z.abs() < HALF_WIDTH_95);
            last = Some(z);
        }
    }
    if count == 0 {
        return Agreement::default();
    }
    Agreement {
        count,
        nis: squares / count as f64,
        correlation: if squares > 0.0 {
            products / squares
        } else {
            0.0
        },
        covered: inside as f64 / count as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    fn parameter(source: Source) -> Parameter {
        Parameter {
            key: String::new(),
            words: String::new(),
            unit: "",
            mean: 0.0,
            std: 1.0,
            range: (-1e9, 1e9),
            law: Law::Linear,
            source,
        }
    }

    /// Blocks whose rows depend on the sum of two parameters only.
    fn of_the_sum(errors: &[f64]) -> Vec<Information> {
        let blocks = errors
            .iter()
            .map(|e| Mat::from_fn(1, 3, |_, j| if j == 2 { *e } else { 5.0 }));
        blocks.map(|rows| algebra::triangle(&rows)).collect()
    }

    #[test]
    fn a_sum_leaves_the_difference_undetermined() {
        let both = [
            parameter(Source::Description),
            parameter(Source::Description),
        ];
        let found = undetermined(&of_the_sum(&[0.0; 4]), &both, &[false; 2]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].members().len(), 2);
        assert!(found[0].shares[0] * found[0].shares[1] < 0.0);
        // With one of them held, or measured, the other is determined.
        assert!(undetermined(&of_the_sum(&[0.0; 4]), &both, &[false, true]).is_empty());
        let stated = [parameter(Source::Description), parameter(Source::Measured)];
        assert!(undetermined(&of_the_sum(&[0.0; 4]), &stated, &[false; 2]).is_empty());
    }

    #[test]
    fn blocks_that_disagree_widen_the_interval_and_others_do_not() {
        let fit = |errors: &[f64]| Fit {
            place: vec![0.0; 2],
            cost: 0.0,
            information: of_the_sum(errors),
            interrupted: false,
        };
        let fixed = [false, true];
        let both = [
            parameter(Source::Description),
            parameter(Source::Description),
        ];
        let std =
            |errors: &[f64]| uncertainty(&fit(errors), &both, &fixed, &[0.0; 2]).map(|u| u.std(0));
        let quiet = std(&[1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0]).expect("information");
        let loud = std(&[5.0, -5.0, 5.0, -5.0, 5.0, -5.0, 5.0, -5.0]).expect("information");
        assert!((3.0..7.0).contains(&(loud / quiet)), "{loud} {quiet}");
        // A held tolerance of one counts fully: the sum is known, the other parameter is not.
        let held = uncertainty(&fit(&[0.0; 8]), &both, &fixed, &[0.0, 1.0]).expect("information");
        assert!((held.std(0) - 1.0).abs() < 0.1, "{}", held.std(0));
    }
}

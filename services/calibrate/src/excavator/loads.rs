//! Loads in the bucket: finds the swings of a loaded recording that carry the load, and checks the
//! stated loads.

use estimation::Quantity;
use faer::Mat;

use super::filter;
use super::series::Load;
use super::swings::{Role, Swings};
use crate::algebra;
use crate::column::percentile;
use crate::fit::{Task, values};
use crate::model::Model;

/// Share of the load below which a swing has an empty bucket.
const EMPTY: f64 = 0.35;
/// Share of the stated load below which there is none; the contradiction is reported later.
const NOTHING: f64 = 0.1;
/// Relative difference of a swing's load up to which it is the same load.
const SAME: f64 = 0.25;
/// Share of swings with another load above which the recording has more than one load.
const MIXED: f64 = 0.3;

/// Finds the swings with an empty bucket in recordings of a load, such as the return from a dump. Removes
/// those that are neither loaded nor empty. `place` is a first fit of all other parameters. Returns a fault.
pub fn sort(swings: &mut Swings, place: &[f64]) -> Option<String> {
    let values = values(swings, place);
    for recording in 0..swings.series.len() {
        let Some(stated) = swings.stated[recording].filter(|t| t.value > 0.0) else {
            continue;
        };
        let found = weigh(swings, recording, &values, stated.value);
        let large = percentile(found.iter().map(|m| m.value).collect(), 0.9);
        let loaded = found.iter().filter(|m| m.value > 0.5 * large);
        let load = percentile(loaded.map(|m| m.value).collect(), 0.5);
        let series = &mut swings.series[recording];
        if load <= NOTHING * stated.value {
            continue;
        }
        let is_load = |m: &Quantity| (m.value - load).abs() < (SAME * load).max(4.0 * m.std);
        let is_empty = |m: &Quantity| m.value < EMPTY * load && m.std <= SAME * load;
        let others = found.iter().filter(|m| !is_load(m) && !is_empty(m)).count();
        if others as f64 > MIXED * found.len() as f64 {
            let (low, high) = (
                percentile(found.iter().map(|m| m.value).collect(), 0.05),
                percentile(found.iter().map(|m| m.value).collect(), 0.95),
            );
            return Some(format!(
                "the load of {} changes from swing to swing, about {low:.0} to {high:.0} kg; record one weighed load in every swing",
                series.name
            ));
        }
        let mut each = found.iter();
        series.swings.retain_mut(|swing| {
            let Some(mass) = each.next() else {
                return true;
            };
            if is_load(mass) {
                true
            } else {
                swing.load = Load::Empty;
                is_empty(mass)
            }
        });
    }
    swings.count_blocks();
    None
}

/// The load of each swing of a recording, starting at a guess. Each swing has its own load, and the ground one slope with its
/// prior. Each step is a Gauss-Newton step with the loads eliminated.
fn weigh(swings: &Swings, recording: usize, values: &[f64], guess: f64) -> Vec<Quantity> {
    let slopes = [Role::Across(recording), Role::Along(recording)];
    let slopes = slopes.map(|role| swings.index(role));
    let mut values = values.to_vec();
    let blocks = swings.blocks_of(recording);
    let mut loads = vec![guess; blocks.len()];
    let mut stds = vec![f64::INFINITY; blocks.len()];
    for _ in 0..3 {
        let each = blocks.iter().zip(&loads);
        let stated: Vec<[[f64; 4]; 3]> = each
            .map(|(&block, &load)| products(swings, block, &values, load, slopes))
            .collect();
        // The slope, in prior standard deviations.
        let place = slopes.map(|s| s.map_or(0.0, |s| swings.parameters[s].place(values[s])));
        let mut matrix = Mat::<f64>::identity(2, 2);
        let mut right = Mat::from_fn(2, 1, |i, _| -place[i]);
        for p in stated.iter().filter(|p| p[0][0] > 0.0) {
            for i in 0..2 {
                let share = p[0][i + 1] / p[0][0];
                right[(i, 0)] -= p[i + 1][3] - share * p[0][3];
                for j in 0..2 {
                    matrix[(i, j)] += p[i + 1][j + 1] - share * p[0][j + 1];
                }
            }
        }
        let Some(covariance) = algebra::inverse(&matrix) else {
            break;
        };
        let step = &covariance * &right;
        for ((load, std), p) in loads.iter_mut().zip(&mut stds).zip(&stated) {
            if p[0][0] > 0.0 {
                let across = Mat::from_fn(2, 1, |i, _| p[0][i + 1] / p[0][0]);
                let moved = (across.transpose() * &step)[(0, 0)];
                let doubt = (across.transpose() * &covariance * &across)[(0, 0)];
                *load -= p[0][3] / p[0][0] + moved;
                *std = (1.0 / p[0][0] + doubt).sqrt();
            }
        }
        for (i, slope) in slopes.into_iter().enumerate() {
            if let Some(s) = slope {
                values[s] = swings.parameters[s].value(place[i] + step[(i, 0)]);
            }
        }
    }
    let found = loads.into_iter().zip(stds);
    found.map(|(value, std)| Quantity { value, std }).collect()
}

/// Products of the derivatives of a swing's innovations with respect to load and slope, with each other and with the innovations.
fn products(
    swings: &Swings,
    block: usize,
    values: &[f64],
    load: f64,
    slopes: [Option<usize>; 2],
) -> [[f64; 4]; 3] {
    const STEPS: [f64; 3] = [1.0, 1e-2, 1e-2];
    let (series, swing) = swings.swing(block);
    let at = |moved: Option<usize>| {
        let mut values = values.to_vec();
        let mut payload = load;
        match moved {
            Some(0) => payload += STEPS[0],
            Some(i) => {
                if let Some(s) = slopes[i - 1] {
                    values[s] += STEPS[i] * swings.parameters[s].std;
                }
            }
            None => {}
        }
        let guess = filter::Guess {
            payload,
            ..swings.guess(swings.recording(block), &values)
        };
        let mut innovations = Vec::new();
        filter::innovations(series, swing, &guess, &mut innovations);
        innovations
    };
    let (here, there) = (at(None), [0, 1, 2].map(|i| at(Some(i))));
    let mut sums = [[0.0; 4]; 3];
    for (k, a) in here.iter().enumerate() {
        let mut row = [0.0, 0.0, 0.0, a.value];
        for i in 0..3 {
            row[i] = there[i]
                .get(k)
                .map_or(0.0, |b| (b.value - a.value) / STEPS[i]);
        }
        for i in 0..3 {
            for j in 0..4 {
                sums[i][j] += row[i] * row[j] / a.variance;
            }
        }
    }
    sums
}

/// Whether at least two loads of the swings differ, so that they fix the scale.
#[must_use]
pub fn differ(swings: &Swings) -> bool {
    let mut loads = Vec::new();
    for block in 0..swings.blocks() {
        let (_, swing) = swings.swing(block);
        match (swing.load, swings.stated[swings.recording(block)]) {
            (Load::Empty, _) => loads.push(Quantity::default()),
            (Load::Stated, Some(stated)) => loads.push(stated),
            (Load::Stated, None) => {}
        }
    }
    let far = |a: &Quantity, b: &Quantity| distance(a, b) > 5.0 && (a.value - b.value).abs() > 5e-9;
    loads.iter().any(|load| far(load, &loads[0]))
}

/// The load of a recording, as stated and as identified with the masses and torque of the description.
#[derive(Debug, Clone, PartialEq)]
pub struct Doubt {
    /// Name of the recording.
    pub name: String,
    /// Stated load \[kg\].
    pub stated: Quantity,
    /// Load from the description's masses and torque \[kg\].
    pub found: Quantity,
}

impl Doubt {
    /// Distance of the two, in standard deviations.
    #[must_use]
    pub fn distance(&self) -> f64 {
        distance(&self.stated, &self.found)
    }
}

/// Distance of two weights, in standard deviations.
fn distance(a: &Quantity, b: &Quantity) -> f64 {
    (a.value - b.value).abs() / (a.std.powi(2) + b.std.powi(2)).sqrt()
}

/// The stated load that the description contradicts most, if it does so clearly.
pub fn doubt(task: &Task<'_, Swings>) -> Option<Doubt> {
    let swings = task.model;
    let heaviest = swings
        .stated
        .iter()
        .flatten()
        .fold(0.0, |h: f64, t| h.max(t.value));
    let mut doubts: Vec<Doubt> = Vec::new();
    for (recording, stated) in swings.stated.iter().enumerate() {
        let Some(stated) = *stated else { continue };
        if stated.value <= 0.0 {
            continue;
        }
        let Some(found) = weigh_by_description(task, recording, stated, heaviest) else {
            continue;
        };
        doubts.push(Doubt {
            name: swings.series[recording].name.clone(),
            stated,
            found,
        });
    }
    doubts
        .retain(|d| d.distance() > 3.5 && (d.stated.value - d.found.value).abs() > 0.08 * heaviest);
    doubts
        .into_iter()
        .max_by(|a, b| a.distance().total_cmp(&b.distance()))
}

fn weigh_by_description(
    task: &Task<'_, Swings>,
    recording: usize,
    stated: Quantity,
    heaviest: f64,
) -> Option<Quantity> {
    let mut open = task.model.clone();
    let wide = Quantity {
        value: stated.value,
        std: heaviest.max(stated.value).max(task.model.full_bucket),
    };
    let at = open.release(recording, wide);
    let mut fixed = task.fixed.to_vec();
    if at == fixed.len() {
        fixed.push(false);
    }
    fixed[at] = false;
    // Starts at the description, instead of where a wrong load has led.
    let start = vec![0.0; fixed.len()];
    let released = Task {
        model: &open,
        blocks: task.blocks,
        least_gain: task.least_gain,
        fixed: &fixed,
        stop: task.stop,
        progress: &|_| {},
    };
    let fit = released.run(&start);
    let held = vec![0.0; fixed.len()];
    let uncertainty = crate::honesty::uncertainty(&fit, &open.parameters, &fixed, &held)?;
    let parameter = &open.parameters[at];
    Some(Quantity {
        value: parameter.value(fit.place[at]),
        std: parameter.value_std(fit.place[at], uncertainty.std(at)),
    })
}

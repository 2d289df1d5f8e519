//! Loads in the bucket: finds the swings of a loaded recording that carry the load.

use estimation::Quantity;
use faer::Mat;

use super::filter;
use super::series::Load;
use super::stated_load::distance;
use super::swings::{Role, Swings};
use super::words;
use crate::algebra;
use crate::column::percentile;
use crate::fit::values;
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
    let has_empty = swings.stated.iter().flatten().any(|t| t.value == 0.0);
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
            return Some(words::changing_load(&series.name, [low, high], has_empty));
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

/// Parameters that a recording has of its own while its swings are weighed: slopes of the ground; damping and friction of its oil.
const OWN: usize = 4;

/// The load of each swing of a recording, starting at a guess. Each swing has its own load, and the recording its own slopes, damping and
/// friction with their priors. Each step is a Gauss-Newton step with the loads eliminated.
fn weigh(swings: &Swings, recording: usize, values: &[f64], guess: f64) -> Vec<Quantity> {
    let own = [
        Role::Across(recording),
        Role::Along(recording),
        Role::Damping,
        Role::Friction,
    ];
    let own = own.map(|role| swings.index(role));
    let mut values = values.to_vec();
    let blocks = swings.blocks_of(recording);
    let mut loads = vec![guess; blocks.len()];
    let mut stds = vec![f64::INFINITY; blocks.len()];
    let places =
        |values: &[f64]| own.map(|i| i.map_or(0.0, |i| swings.parameters[i].place(values[i])));
    // Level ground; damping and friction as in the first fit.
    let mut mean = places(&values);
    mean[..2].fill(0.0);
    for _ in 0..3 {
        let each = blocks.iter().zip(&loads);
        let stated: Vec<Products> = each
            .map(|(&block, &load)| products(swings, block, &values, load, own))
            .collect();
        // In prior standard deviations.
        let place = places(&values);
        let mut matrix = Mat::<f64>::identity(OWN, OWN);
        let mut right = Mat::from_fn(OWN, 1, |i, _| mean[i] - place[i]);
        for p in stated.iter().filter(|p| p[0][0] > 0.0) {
            for i in 0..OWN {
                let share = p[0][i + 1] / p[0][0];
                right[(i, 0)] -= p[i + 1][OWN + 1] - share * p[0][OWN + 1];
                for j in 0..OWN {
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
                let across = Mat::from_fn(OWN, 1, |i, _| p[0][i + 1] / p[0][0]);
                let moved = (across.transpose() * &step)[(0, 0)];
                let doubt = (across.transpose() * &covariance * &across)[(0, 0)];
                *load -= p[0][OWN + 1] / p[0][0] + moved;
                *std = (1.0 / p[0][0] + doubt).sqrt();
            }
        }
        for (i, own) in own.into_iter().enumerate() {
            if let Some(s) = own {
                values[s] = swings.parameters[s].value(place[i] + step[(i, 0)]);
            }
        }
    }
    let found = loads.into_iter().zip(stds);
    found.map(|(value, std)| Quantity { value, std }).collect()
}

/// Products of the derivatives of a swing's innovations with respect to its load and the parameters of the recording, with each other and,
/// in the last column, with the innovations.
type Products = [[f64; OWN + 2]; OWN + 1];

fn products(
    swings: &Swings,
    block: usize,
    values: &[f64],
    load: f64,
    own: [Option<usize>; OWN],
) -> Products {
    const STEPS: [f64; OWN + 1] = [1.0, 1e-2, 1e-2, 1e-2, 1e-2];
    let (series, swing) = swings.swing(block);
    let at = |moved: Option<usize>| {
        let mut values = values.to_vec();
        let mut payload = load;
        match moved {
            Some(0) => payload += STEPS[0],
            Some(i) => {
                if let Some(s) = own[i - 1] {
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
    let here = at(None);
    let there: [_; OWN + 1] = std::array::from_fn(|i| at(Some(i)));
    let mut sums = [[0.0; OWN + 2]; OWN + 1];
    for (k, a) in here.iter().enumerate() {
        let mut row = [0.0; OWN + 2];
        row[OWN + 1] = a.value;
        for i in 0..=OWN {
            row[i] = there[i]
                .get(k)
                .map_or(0.0, |b| (b.value - a.value) / STEPS[i]);
        }
        for i in 0..=OWN {
            for j in 0..OWN + 2 {
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

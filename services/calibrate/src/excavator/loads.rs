//! What is in the bucket: which swings of a loaded recording carry the load, and whether the told loads
//! fit together.

use estimation::Quantity;

use super::filter;
use super::series::{Load, percentile};
use super::swings::{Role, Swings};
use crate::fit::{Task, values};
use crate::model::Model;

/// A swing with less than this share of the load is one with an empty bucket.
const EMPTY: f64 = 0.35;
/// A load may differ by this share from the others and still be the same.
const SAME: f64 = 0.25;
/// More swings than this share with another load: the recording is not of one load.
const MIXED: f64 = 0.3;

/// Finds the swings with an empty bucket in recordings of a load, such as the ways back from a dump, and
/// takes out those with neither; `place` is a first guess of everything else. Says what is wrong.
pub fn sort(swings: &mut Swings, place: &[f64]) -> Option<String> {
    let values = values(swings, place);
    for recording in 0..swings.series.len() {
        let Some(told) = swings.told[recording].filter(|t| t.value > 0.0) else {
            continue;
        };
        let found: Vec<Quantity> = swings
            .blocks_of(recording)
            .into_iter()
            .map(|block| weigh(swings, block, &values, told.value))
            .collect();
        let large = percentile(found.iter().map(|m| m.value).collect(), 0.9);
        let loaded = found.iter().filter(|m| m.value > 0.5 * large);
        let load = percentile(loaded.map(|m| m.value).collect(), 0.5);
        let series = &mut swings.series[recording];
        if load <= 0.0 {
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

/// The load of one swing, everything else given, from a guess.
fn weigh(swings: &Swings, block: usize, values: &[f64], guess: f64) -> Quantity {
    const STEP: f64 = 1.0;
    let (series, swing) = swings.swing(block);
    let mut load = guess;
    let mut information = 0.0;
    for _ in 0..3 {
        let at = |payload: f64| {
            let guess = filter::Guess {
                payload,
                ..swings.guess(swings.recording(block), values)
            };
            let mut innovations = Vec::new();
            filter::innovations(series, swing, &guess, &mut innovations);
            innovations
        };
        let (here, there) = (at(load), at(load + STEP));
        let mut gradient = 0.0;
        information = 0.0;
        for (a, b) in here.iter().zip(&there) {
            let slope = (b.value - a.value) / STEP;
            gradient += slope * a.value / a.variance;
            information += slope * slope / a.variance;
        }
        if information > 0.0 {
            load -= gradient / information;
        }
    }
    let std = if information > 0.0 {
        information.sqrt().recip()
    } else {
        f64::INFINITY
    };
    Quantity { value: load, std }
}

/// The loads that swings carry, of which at least two differ if they fix the scale [kg].
#[must_use]
pub fn differ(swings: &Swings) -> bool {
    let mut loads = Vec::new();
    for block in 0..swings.blocks() {
        let (_, swing) = swings.swing(block);
        match (swing.load, swings.told[swings.recording(block)]) {
            (Load::Empty, _) => loads.push(Quantity::default()),
            (Load::Told, Some(told)) => loads.push(told),
            (Load::Told, None) => {}
        }
    }
    let far =
        |a: &Quantity, b: &Quantity| (a.value - b.value).abs() > 5.0 * a.std.hypot(b.std).max(1e-9);
    loads.iter().any(|load| far(load, &loads[0]))
}

/// The load of a recording by the description alone: told, and found with all of it free.
#[derive(Debug, Clone, PartialEq)]
pub struct Doubt {
    /// Name of the recording.
    pub name: String,
    /// As told [kg].
    pub told: Quantity,
    /// As the description's masses and torque say [kg].
    pub found: Quantity,
}

impl Doubt {
    /// How far the two are apart, in standard deviations.
    #[must_use]
    pub fn distance(&self) -> f64 {
        (self.told.value - self.found.value).abs() / self.told.std.hypot(self.found.std)
    }
}

/// The told load that the description contradicts most, if it does clearly.
pub fn doubt(task: &Task<'_, Swings>, place: &[f64]) -> Option<Doubt> {
    let swings = task.model;
    let heaviest = swings
        .told
        .iter()
        .flatten()
        .fold(0.0, |h: f64, t| h.max(t.value));
    let mut doubts: Vec<Doubt> = Vec::new();
    for (recording, told) in swings.told.iter().enumerate() {
        let Some(told) = *told else { continue };
        if told.value <= 0.0 {
            continue;
        }
        let Some(found) = weigh_by_description(task, place, recording, told, heaviest) else {
            continue;
        };
        doubts.push(Doubt {
            name: swings.series[recording].name.clone(),
            told,
            found,
        });
    }
    doubts.retain(|d| d.distance() > 3.5 && (d.told.value - d.found.value).abs() > 0.08 * heaviest);
    doubts
        .into_iter()
        .max_by(|a, b| a.distance().total_cmp(&b.distance()))
}

fn weigh_by_description(
    task: &Task<'_, Swings>,
    place: &[f64],
    recording: usize,
    told: Quantity,
    heaviest: f64,
) -> Option<Quantity> {
    let mut open = task.model.clone();
    let wide = Quantity {
        value: told.value,
        std: heaviest.max(told.value),
    };
    let at = open.release(recording, wide);
    let mut fixed = task.fixed.to_vec();
    let mut start = place.to_vec();
    if at == fixed.len() {
        fixed.push(false);
        start.push(0.0);
    } else {
        start[at] = 0.0;
    }
    fixed[at] = false;
    // From the description: gain and masses near what it says, the load wherever that leads.
    for (x, role) in start.iter_mut().zip(&open.roles) {
        if matches!(role, Role::Gain | Role::Links | Role::Inertia) {
            *x = 0.0;
        }
    }
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

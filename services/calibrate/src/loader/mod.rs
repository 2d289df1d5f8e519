//! Calibration of a wheel loader from drives with known masses.

mod brakes;
mod doubts;
mod drive;
mod drives;
mod guess;
mod known;
mod lift;
#[cfg(test)]
mod lift_tests;
#[cfg(test)]
mod made;
mod noise;
mod out_and_back;
mod residuals;
mod result;
mod role;
#[cfg(test)]
mod tests;
mod wheels;
mod words;

use std::sync::atomic::AtomicBool;

use config::Loader as Description;
use estimation::GRAVITY;
use estimation::Quantity;
use estimation::loader::{Method, Sample, Settings};

pub use drive::Drive;
pub use drives::Drives;
pub use lift::CylinderFit;
use noise::Noises;
pub use role::{Role, StatedLoad};

use crate::fit::{EXACT, Fit, Progress, Task, UNSTOPPED, values};
use crate::honesty::{self, Direction};
use crate::model::Model;
use crate::outcome::{FitResult, NOTHING, STOPPED, Summary, no_such_key};
use crate::output::Pen;

/// Initial value of the scatter parameters, in prior standard deviations above their prior.
const LARGE_SCATTER: f64 = 2.0;

/// A recording and the stated values of its load.
#[derive(Debug, Clone)]
pub struct Input {
    /// Its name, for sentences.
    pub name: String,
    /// Its rows.
    pub samples: Vec<Sample>,
    /// Stated values of its load; empty for the described machine.
    pub stated: StatedLoad,
    /// Load in the bucket \[kg\], where it was weighed; for the lift cylinders.
    pub payload: Option<Quantity>,
}

/// Settings of a calibration.
pub struct Options<'a> {
    /// Prior description.
    pub description: &'a Description,
    /// Axle weights of the described machine.
    pub weighed: StatedLoad,
    /// Pairs of recordings of the same path, out and back with the machine turned round.
    pub out_and_back: &'a [[usize; 2]],
    /// Whether profiles of the likelihood are computed; they take as long as the rest.
    pub slices: bool,
    /// Keys to identify; `None`: the usual ones.
    pub free: Option<&'a [String]>,
    /// Stop request: the result is the best place so far.
    pub stop: &'a AtomicBool,
    /// Called at every step.
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

impl<'a> Options<'a> {
    /// The usual keys of a machine without axle weights, never stopped, without progress.
    pub fn of(description: &'a Description) -> Self {
        Self {
            description,
            weighed: StatedLoad::default(),
            out_and_back: &[],
            slices: false,
            free: None,
            stop: &UNSTOPPED,
            progress: &|_| {},
        }
    }
}

/// Result of a calibration.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Recordings, parameters, blocks.
    pub drives: Drives,
    /// Flag of each parameter: it was held.
    pub fixed: Vec<bool>,
    /// The fit; `None` if the recordings cannot be fitted at all.
    pub found: Option<FitResult>,
    /// Noises of the sensors.
    pub noises: Vec<(&'static str, Quantity)>,
    /// Why the result is not to be trusted; empty if it is.
    pub faults: Vec<String>,
    /// Remarks for the reader.
    pub remarks: Vec<String>,
    /// Fit of the lift cylinders.
    pub lift: Option<CylinderFit>,
    /// Turn of the bucket per turn of the arm, where it was not stated.
    turn: Option<Quantity>,
    /// Recordings in which the machine stands and lifts its arm.
    lifting: Vec<String>,
}

impl Outcome {
    /// Summary for display.
    pub fn summary(&self) -> Summary<'_> {
        let drives = &self.drives.drives;
        Summary {
            machine: "loader",
            block: "stretch",
            model: &self.drives,
            recordings: match drives.as_slice() {
                [] => self.lifting.clone(),
                driven => driven.iter().map(|d| d.name.clone()).collect(),
            },
            contents: drives
                .iter()
                .map(|d| format!("{:.0} s of driving", d.driving_time()))
                .collect(),
            fixed: &self.fixed,
            loads: self
                .drives
                .roles
                .iter()
                .map(|role| role.load().is_some_and(|load| load > 0))
                .collect(),
            found: self.found.as_ref(),
            faults: &self.faults,
            remarks: &self.remarks,
        }
    }

    /// Value and standard deviation of a parameter.
    pub fn quantity(&self, role: Role) -> Option<Quantity> {
        self.summary().quantity(self.drives.index(role)?)
    }
}

/// Identifies the parameters.
///
/// # Errors
/// A key of `free` that cannot be identified; the error names those that can.
pub fn calibrate(inputs: &[Input], options: &Options<'_>) -> Result<Outcome, String> {
    let machine = &options.description.machine;
    let weight = machine.mass * GRAVITY;
    let settings = Settings::of(options.description, Method::Full);
    let drive = |i: &Input| Drive::new(&i.name, &i.samples, weight, machine.wheelbase);
    let (driven, lifting): (Vec<_>, Vec<_>) = inputs
        .iter()
        .enumerate()
        .map(|(i, input)| (i, input, drive(input)))
        .partition(|(_, input, drive)| {
            !(words::stands(drive) && lift::lifts(&lift::moments(&settings, &input.samples)))
        });
    let stated: Vec<StatedLoad> = driven
        .iter()
        .map(|(_, input, _)| lift::stated(options.description, input))
        .collect();
    let (numbers, mut drives): (Vec<usize>, Vec<Drive>) =
        driven.into_iter().map(|(i, _, drive)| (i, drive)).unzip();
    let mut remarks = Vec::new();
    for drive in &mut drives {
        let time = drive.leave_out_spin(machine.wheel_radius);
        if time > 0.0 {
            remarks.push(words::spun(&drive.name, time));
        }
    }
    let drives = Drives::new(drives, &stated, options.weighed, options.description);
    let fixed = held(&drives, options.free)?;
    let faults = words::before(&drives);
    let noises = match options.free {
        None => {
            let driving: Vec<&Input> = numbers.iter().map(|i| &inputs[*i]).collect();
            Noises::of(&driving, options.description)
        }
        Some(_) => Noises::default(),
    };
    remarks.extend(noises.remarks);
    let mut outcome = Outcome {
        drives,
        fixed,
        found: None,
        noises: noises.found,
        faults,
        remarks,
        lift: None,
        turn: lift::bucket_turn(options.description, inputs),
        lifting: lifting
            .iter()
            .map(|(_, input, _)| input.name.clone())
            .collect(),
    };
    if outcome.faults.is_empty() && !numbers.is_empty() {
        let driven = |pair: &[usize; 2]| {
            let at = |file: usize| numbers.iter().position(|i| *i == file);
            Some([at(pair[0])?, at(pair[1])?])
        };
        let pairs: Vec<[usize; 2]> = options.out_and_back.iter().filter_map(driven).collect();
        find(
            &mut outcome,
            &Options {
                out_and_back: &pairs,
                ..*options
            },
        );
    }
    // Not where only some keys are requested.
    if options.free.is_none() {
        learn_lift(
            &mut outcome,
            options.description,
            inputs,
            numbers.is_empty(),
        );
    }
    if numbers.is_empty() && outcome.lift.is_some() {
        outcome.remarks.push(words::ONLY_LIFTS.into());
    }
    Ok(outcome)
}

/// The parameters of the lift cylinders; that they cannot be found is a fault where nothing else is calibrated.
fn learn_lift(outcome: &mut Outcome, description: &Description, inputs: &[Input], is_all: bool) {
    let mut linked = Pen::new(description.clone());
    if let Some(turn) = outcome.turn {
        lift::write_turn(turn, &mut linked);
    }
    let Some(learnt) = lift::learn(&linked.description, inputs) else {
        return;
    };
    let words = learnt.as_ref().map_or_else(String::clone, lift::words);
    if is_all && learnt.is_err() {
        outcome.faults.push(words);
    } else {
        outcome.remarks.push(words);
    }
    outcome.lift = learnt.ok();
}

/// Parameters that are held: those that are not requested, except the noises. A free nuisance parameter would absorb errors of
/// the held ones; held, its tolerance counts as theirs do.
fn held(drives: &Drives, free: Option<&[String]>) -> Result<Vec<bool>, String> {
    let Some(free) = free else {
        return Ok(vec![false; drives.roles.len()]);
    };
    let mut fixed: Vec<bool> = drives.roles.iter().map(|r| !r.is_noise()).collect();
    for key in free {
        let at = drives.parameters.iter().position(|p| p.key == *key);
        let Some(at) = at else {
            let known: Vec<&str> = drives.parameters.iter().map(|p| p.key.as_str()).collect();
            return Err(no_such_key(key, &known));
        };
        fixed[at] = false;
    }
    Ok(fixed)
}

fn all(drives: &Drives) -> Vec<usize> {
    (0..drives.blocks()).collect()
}

/// The fit to the given blocks.
fn whole<'a>(
    model: &'a Drives,
    blocks: &'a [usize],
    fixed: &'a [bool],
    options: &Options<'a>,
) -> Task<'a, Drives> {
    Task {
        model,
        blocks,
        fixed,
        least_gain: EXACT,
        stop: options.stop,
        progress: options.progress,
    }
}

/// Matches the stated paths, and adds remarks on the result; returns whether there is one.
fn join(outcome: &mut Outcome, place: &[f64], pairs: &[[usize; 2]]) -> bool {
    let drives = &mut outcome.drives;
    let values = values(drives, place);
    for &recordings in pairs {
        let [there, back] = recordings.map(|r| drives.drives[r].name.clone());
        outcome.remarks.push(match drives.join(recordings, &values) {
            Ok(path) => format!(
                "{there} and {back} go the same way: over {:.0} m their slopes mirror each other (correlation {:.2})",
                path.length(),
                path.correlation
            ),
            Err(why) => format!(
                "{there} and {back} were stated as an out-and-back run, but are not used as such: {why}"
            ),
        });
    }
    outcome.fixed.resize(drives.roles.len(), false);
    !drives.paths.is_empty()
}

/// Texts about undetermined directions: those that matter, and the others.
fn undetermined(task: &Task<'_, Drives>, fit: &Fit) -> (Vec<String>, Vec<String>) {
    let drives = task.model;
    let mut open = honesty::undetermined(&fit.information, &drives.parameters, task.fixed);
    open.retain(|d| !words::is_nuisance(drives, d));
    let (matters, others): (Vec<_>, Vec<_>) = open.iter().partition(|d| words::matters(drives, d));
    let sentences = |directions: Vec<&Direction>| {
        let sentences = directions
            .into_iter()
            .map(|d| words::undetermined(drives, d));
        sentences.collect()
    };
    (sentences(matters), sentences(others))
}

/// The fit to all recordings, their stated paths matched.
fn fitted(outcome: &mut Outcome, options: &Options<'_>) -> Fit {
    let drives = &outcome.drives;
    // Residuals far too large for their scatter would all be weighted as outliers.
    let large = |role: &Role| f64::from(role.is_noise()) * LARGE_SCATTER;
    let begin: Vec<f64> = drives.roles.iter().map(large).collect();
    let first = whole(drives, &all(drives), &outcome.fixed, options).run(&begin);
    // The sensitivity of the slope sensor must be known before its slopes are compared.
    let joined = join(outcome, &first.place, options.out_and_back);
    let drives = &outcome.drives;
    let mut fit = if joined {
        let mut begin = first.place;
        begin.extend(drives.roles[begin.len()..].iter().map(large));
        whole(drives, &all(drives), &outcome.fixed, options).run(&begin)
    } else {
        first
    };
    // A nuisance parameter far from its prior would pull the others with it.
    let far = words::far_nuisances(drives, &fit.place, &outcome.fixed);
    if far.is_empty() || fit.interrupted {
        return fit;
    }
    for &i in &far {
        let place = fit.place[i];
        let sentence = words::widened(&outcome.drives, i, place);
        outcome.remarks.push(sentence);
        outcome.drives.parameters[i].std *= place.abs();
        fit.place[i] = place.signum();
    }
    let drives = &outcome.drives;
    whole(drives, &all(drives), &outcome.fixed, options).run(&fit.place)
}

fn find(outcome: &mut Outcome, options: &Options<'_>) {
    let roles = outcome.drives.roles.iter().zip(&outcome.fixed);
    let free: Vec<Role> = roles
        .filter(|(_, fixed)| !**fixed)
        .map(|(r, _)| *r)
        .collect();
    let mut faults = words::indistinguishable(&outcome.drives, &free);
    let fit = fitted(outcome, options);
    let drives = &outcome.drives;
    let all = all(drives);
    let task = whole(drives, &all, &outcome.fixed, options);
    if fit.interrupted {
        outcome.remarks.push(STOPPED.into());
    }
    // Faults that have been reported are not repeated as undetermined directions.
    if faults.is_empty() {
        let (open, remarks) = undetermined(&task, &fit);
        faults = open;
        outcome.remarks.extend(remarks);
    }
    if !fit.interrupted {
        // Unrecorded brakes would cause the other faults.
        if let Some(brakes) = brakes::differ(drives, &fit.place) {
            faults.push(brakes);
        } else {
            faults.extend(words::far(drives, &fit.place, &outcome.fixed));
            for (sentence, is_written) in words::at_limit(drives, &fit.place, &outcome.fixed) {
                if is_written {
                    faults.push(sentence);
                } else {
                    outcome.remarks.push(sentence);
                }
            }
            faults.extend(doubts::doubts(drives, &task, &fit));
        }
    }
    // Held parameters have the tolerance of the description, which widens the others.
    let held = vec![1.0; drives.roles.len()];
    let minor: Vec<bool> = drives
        .roles
        .iter()
        .map(|r| !options.slices || r.is_nuisance() || r.load().is_some_and(|load| load > 0))
        .collect();
    outcome.found = FitResult::of(&task, fit, &held, &minor);
    if outcome.found.is_none() {
        faults = vec![NOTHING.into()];
    }
    outcome.faults = faults;
}

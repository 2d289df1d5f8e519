//! Calibration of an excavator's swing from recordings with known loads.

mod filter;
mod loads;
mod result;
mod series;
mod start;
mod swings;
mod torque;
mod words;

use std::sync::atomic::AtomicBool;

use config::Excavator as Description;
use estimation::Quantity;
use estimation::excavator::{Geometry, Sample};

pub use loads::Doubt;
pub use series::{Load, Measured, Series, Swing};
pub use swings::{Role, Swings};
pub use torque::{Impulse, Torque};

use crate::description::number;
use crate::fit::{Fit, Progress, Task};
use crate::honesty::{self, Agreement, Profile, Uncertainty};
use crate::model::Model;

/// One of so many swings is kept from the fit that is judged on it.
const HELD_OUT: usize = 4;

/// A recording and what is known of it.
#[derive(Debug, Clone)]
pub struct Input {
    /// Its name, for sentences.
    pub name: String,
    /// Its rows.
    pub samples: Vec<Sample>,
    /// Load in the bucket, as weighed [kg].
    pub payload: Option<Quantity>,
}

/// How to calibrate.
pub struct Options<'a> {
    /// What is known beforehand.
    pub description: &'a Description,
    /// Keys to find; the usual ones if none.
    pub free: Option<&'a [String]>,
    /// Set it to stop with the best so far.
    pub stop: &'a AtomicBool,
    /// Hears of every step.
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

/// What came out.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Recordings, parameters, blocks.
    pub swings: Swings,
    /// Which parameters were held.
    pub fixed: Vec<bool>,
    /// The fit, from all swings; none if the recordings cannot be fitted at all.
    pub found: Option<Found>,
    /// Why the result must not be believed; empty if nothing speaks against it.
    pub faults: Vec<String>,
    /// What the reader should know.
    pub remarks: Vec<String>,
}

/// A fit and what it may claim.
#[derive(Debug, Clone)]
pub struct Found {
    /// The fit.
    pub fit: Fit,
    /// Its uncertainty.
    pub uncertainty: Uncertainty,
    /// Profiles of the two weakest parameters.
    pub profiles: Vec<Profile>,
    /// On swings that took no part in a fit to the others: with the description, and with that fit.
    pub unseen: [Agreement; 2],
}

impl Outcome {
    /// A parameter: value and standard deviation.
    #[must_use]
    pub fn quantity(&self, role: Role) -> Option<Quantity> {
        let found = self.found.as_ref()?;
        let i = self.swings.index(role)?;
        let parameter = &self.swings.parameters[i];
        Some(Quantity {
            value: parameter.value(found.fit.place[i]),
            std: parameter.value_std(found.fit.place[i], found.uncertainty.std(i)),
        })
    }
}

/// Finds the parameters.
///
/// # Errors
/// A key of `free` that cannot be found, with those that can.
pub fn calibrate(inputs: &[Input], options: &Options<'_>) -> Result<Outcome, String> {
    let geometry = Geometry::of(options.description);
    let series: Vec<Series> = inputs
        .iter()
        .map(|i| Series::new(&i.name, &i.samples, &geometry))
        .collect();
    let told = inputs.iter().map(|i| i.payload).collect();
    let swings = Swings::new(series, told, options.description);
    let fixed = held(&swings, options.free)?;
    let free: Vec<Role> = swings
        .roles
        .iter()
        .zip(&fixed)
        .filter(|(_, fixed)| !**fixed)
        .map(|(role, _)| *role)
        .collect();
    let (faults, remarks) = words::before(&swings);
    let mut outcome = Outcome {
        swings,
        fixed,
        found: None,
        faults,
        remarks,
    };
    if outcome.faults.is_empty() {
        outcome.faults = words::alike(&outcome.swings, &free);
        find(&mut outcome, &free, options);
    }
    Ok(outcome)
}

/// Which parameters stay as described.
fn held(swings: &Swings, free: Option<&[String]>) -> Result<Vec<bool>, String> {
    let Some(free) = free else {
        return Ok(vec![false; swings.roles.len()]);
    };
    let mut fixed: Vec<bool> = swings
        .roles
        .iter()
        .map(|role| !matches!(role, Role::Payload(_)))
        .collect();
    for key in free {
        let at = swings.parameters.iter().position(|p| answers(&p.key, key));
        let Some(at) = at else {
            let known: Vec<&str> = swings.parameters.iter().map(|p| p.key.as_str()).collect();
            return Err(format!(
                "{key} cannot be found from recordings; these can: {}",
                known.join(", ")
            ));
        };
        fixed[at] = false;
    }
    Ok(fixed)
}

/// Whether a parameter answers to a key: its own, one of the masses that share a scale, one of the
/// delays that are known as a difference only.
fn answers(own: &str, key: &str) -> bool {
    own == key
        || match own {
            "machine.geometry" => key.starts_with("machine.geometry.") && key.ends_with("mass"),
            "sensors.delay" => {
                matches!(
                    key,
                    "sensors.swing_torque_delay" | "sensors.swing_velocity_delay"
                )
            }
            "prior.inertia" => key == "machine.upper_inertia",
            _ => false,
        }
}

fn find(outcome: &mut Outcome, free: &[Role], options: &Options<'_>) {
    if outcome.swings.has_posture()
        && let Some(fault) = sort_loads(&mut outcome.swings, &outcome.fixed)
    {
        outcome.faults.push(fault);
        return;
    }
    if free.contains(&Role::Gain) && !loads::differ(&outcome.swings) {
        outcome.faults.push(words::ONE_LOAD.into());
    }
    let told = outcome.faults.clone();
    let swings = &outcome.swings;
    let all: Vec<usize> = (0..swings.blocks()).collect();
    let task = |blocks| Task {
        model: swings,
        blocks,
        fixed: &outcome.fixed,
        stop: options.stop,
        progress: options.progress,
    };
    let whole = task(&all);
    let mut fit = whole.run(&start::start(swings, &all, &outcome.fixed));
    if fit.interrupted {
        outcome
            .remarks
            .push("stopped before its end: the best so far".into());
    }
    let directions = honesty::undetermined(&fit.information, &swings.parameters, &outcome.fixed);
    // What has been said need not be said again in the words of algebra.
    let mut faults = told.clone();
    if told.is_empty() {
        faults.extend(directions.iter().map(|d| words::undetermined(swings, d)));
    }
    if free.contains(&Role::Gain)
        && told.is_empty()
        && !fit.interrupted
        && let Some(d) = loads::doubt(&whole, &fit.place)
    {
        faults.push(format!(
            "the load of {} was told as {:.0} kg, but with the masses and the torque gain of the description it weighs {:.0} ± {:.0} kg; weigh it again, or check which recording is which",
            d.name, d.told.value, d.found.value, d.found.std
        ));
    }
    let none = vec![false; outcome.fixed.len()];
    let everything = Task {
        fixed: &none,
        ..task(&all)
    };
    fit.information = everything.information(&fit.place);
    let held = tolerances(swings, options);
    let uncertainty = honesty::uncertainty(&fit, &swings.parameters, &outcome.fixed, &held);
    let Some(uncertainty) = uncertainty else {
        outcome.faults = vec!["the recordings determine nothing".into()];
        return;
    };
    let unseen = judge(&outcome.swings, &outcome.fixed, options, &fit);
    let profiles = weakest(&whole, &fit, &uncertainty);
    outcome.faults = faults;
    outcome.found = Some(Found {
        fit,
        uncertainty,
        profiles,
        unseen,
    });
}

/// A first fit of the recordings with nothing in the bucket tells which swings of the others are loaded. It is
/// not stopped: half of it would sort wrongly.
fn sort_loads(swings: &mut Swings, fixed: &[bool]) -> Option<String> {
    let empty: Vec<usize> = (0..swings.series.len())
        .filter(|&r| swings.told[r].is_some_and(|t| t.value == 0.0))
        .flat_map(|r| swings.blocks_of(r))
        .collect();
    let place = if empty.is_empty() {
        vec![0.0; fixed.len()]
    } else {
        let task = Task {
            model: swings,
            blocks: &empty,
            fixed,
            stop: &AtomicBool::new(false),
            progress: &|_| {},
        };
        task.run(&start::start(swings, &empty, fixed)).place
    };
    loads::sort(swings, &place)
}

/// What the description itself leaves open of a parameter that is held: only what it states.
fn tolerances(swings: &Swings, options: &Options<'_>) -> Vec<f64> {
    let d = options.description;
    let stated = |role: &Role| match role {
        Role::Damping => d.prior.damping_std,
        Role::Offset => d.prior.torque_offset_std,
        Role::Gain => number(d, "sensors.swing_torque_gain_std").unwrap_or(0.0),
        _ => 0.0,
    };
    let parameters = swings.roles.iter().zip(&swings.parameters);
    parameters.map(|(role, p)| stated(role) / p.std).collect()
}

/// Fits without one swing in four, and asks those.
fn judge(swings: &Swings, fixed: &[bool], options: &Options<'_>, whole: &Fit) -> [Agreement; 2] {
    let unseen: Vec<usize> = (0..swings.series.len())
        .flat_map(|r| {
            swings
                .blocks_of(r)
                .into_iter()
                .skip(HELD_OUT / 2)
                .step_by(HELD_OUT)
        })
        .collect();
    let seen: Vec<usize> = (0..swings.blocks())
        .filter(|b| !unseen.contains(b))
        .collect();
    let task = Task {
        model: swings,
        blocks: &seen,
        fixed,
        stop: options.stop,
        progress: &|_| {},
    };
    let fit = task.run(&whole.place);
    let before = vec![0.0; fixed.len()];
    [&before, &fit.place].map(|place| honesty::agreement(swings, &unseen, place))
}

/// Profiles of the two parameters that the data narrowed least.
fn weakest(task: &Task<'_, Swings>, fit: &Fit, uncertainty: &Uncertainty) -> Vec<Profile> {
    let roles = &task.model.roles;
    let mut order: Vec<usize> = (0..roles.len())
        .filter(|&i| !task.fixed[i])
        .filter(|&i| {
            !matches!(
                roles[i],
                Role::Payload(_) | Role::MotionNoise | Role::TorqueNoise
            )
        })
        .collect();
    order.sort_by(|a, b| uncertainty.std(*b).total_cmp(&uncertainty.std(*a)));
    order
        .into_iter()
        .take(2)
        .map(|i| honesty::profile(task, fit, i, uncertainty.std(i)))
        .collect()
}

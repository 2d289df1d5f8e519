//! Calibration of an excavator's swing from recordings with known loads.

mod cylinder;
mod filter;
mod loads;
mod result;
pub mod series;
mod start;
mod swinging;
mod swings;
mod torque;
mod words;

use std::sync::atomic::AtomicBool;

use config::{Excavator as Description, Tables as _};
use estimation::Quantity;
use estimation::excavator::{Geometry, Sample, Settings};

pub use cylinder::CylinderFit;
pub use loads::Doubt;
pub use series::{Load, Measured, Series, Swing};
pub use swings::{Role, Swings};
pub use torque::{Impulse, Torque};

use crate::fit::{EXACT, Fit, Progress, Task, UNSTOPPED};
use crate::honesty;
use crate::model::Model;
use crate::outcome::{FitResult, NOTHING, STOPPED, Summary, no_such_key};
use crate::parameter::Parameter;

/// A recording and its stated load.
#[derive(Debug, Clone)]
pub struct Input {
    /// Its name, for sentences.
    pub name: String,
    /// Its rows.
    pub samples: Vec<Sample>,
    /// Weighed load in the bucket \[kg\].
    pub payload: Option<Quantity>,
}

/// Settings of a calibration.
pub struct Options<'a> {
    /// Prior description.
    pub description: &'a Description,
    /// Keys to identify; `None`: the usual ones.
    pub free: Option<&'a [String]>,
    /// Stop request: the result is the best place so far.
    pub stop: &'a AtomicBool,
    /// Called at every step.
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

impl<'a> Options<'a> {
    /// The usual keys, never stopped, without progress.
    #[must_use]
    pub fn of(description: &'a Description) -> Self {
        Self {
            description,
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
    pub swings: Swings,
    /// Flag of each parameter: it was held.
    pub fixed: Vec<bool>,
    /// The fit to all swings; `None` if the recordings cannot be fitted at all.
    pub found: Option<FitResult>,
    /// Why the result is not to be trusted; empty if it is.
    pub faults: Vec<String>,
    /// Remarks for the reader.
    pub remarks: Vec<String>,
    /// Fit of the boom's cylinders.
    pub cylinder: Option<CylinderFit>,
}

impl Outcome {
    /// Summary for display.
    #[must_use]
    pub fn summary(&self) -> Summary<'_> {
        let series = &self.swings.series;
        Summary {
            machine: "excavator",
            block: "swing",
            model: &self.swings,
            recordings: series.iter().map(|s| s.name.clone()).collect(),
            contents: series
                .iter()
                .map(|s| {
                    let (left, right) = (s.moving_time(1.0), s.moving_time(-1.0));
                    format!("{left:.0} / {right:.0} s of swings left / right")
                })
                .collect(),
            fixed: &self.fixed,
            loads: self.swings.roles.iter().map(Role::is_load).collect(),
            found: self.found.as_ref(),
            faults: &self.faults,
            remarks: &self.remarks,
        }
    }

    /// A parameter: value and standard deviation.
    #[must_use]
    pub fn quantity(&self, role: Role) -> Option<Quantity> {
        self.summary().quantity(self.swings.index(role)?)
    }
}

/// Identifies the parameters.
///
/// # Errors
/// A key of `free` that cannot be identified; the error names those that can.
pub fn calibrate(inputs: &[Input], options: &Options<'_>) -> Result<Outcome, String> {
    let geometry = Geometry::of(options.description);
    let offsets = Settings::of(options.description).sensors.angle_offsets;
    let series: Vec<Series> = inputs
        .iter()
        .map(|i| Series::new(&i.name, &i.samples, &geometry, offsets))
        .collect();
    let stated = inputs.iter().map(|i| i.payload).collect();
    let swings = Swings::new(series, stated, options.description);
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
        cylinder: None,
    };
    if outcome.faults.is_empty() {
        outcome.faults = words::indistinguishable(&outcome.swings, &free);
        find(&mut outcome, &free, options);
    }
    // With the masses that the swings identify; not where only some keys are requested.
    if options.free.is_none()
        && outcome.faults.is_empty()
        && let Some((found, _)) = outcome.description(options.description, &[])
        && let Some(learnt) = cylinder::learn(&found, inputs)
    {
        let words = learnt.as_ref().map_or_else(String::clone, cylinder::words);
        outcome.remarks.push(words);
        outcome.cylinder = learnt.ok();
    }
    let needs_radius = outcome.found.is_some() && free.contains(&Role::Gain);
    if needs_radius && options.description.guessed_radius_std() > 0.0 {
        outcome.faults.push(words::GUESSED_PIN.into());
    }
    Ok(outcome)
}

/// Parameters that stay as described.
fn held(swings: &Swings, free: Option<&[String]>) -> Result<Vec<bool>, String> {
    let Some(free) = free else {
        let is_lever = |role: &Role| *role == Role::Lever;
        return Ok(swings.roles.iter().map(is_lever).collect());
    };
    let mut fixed: Vec<bool> = swings
        .roles
        .iter()
        .map(|role| role.is_described() || *role == Role::Lever)
        .collect();
    let all = swings.roles.iter().zip(&swings.parameters).enumerate();
    let named: Vec<(usize, &str)> = all
        .filter(|(_, (role, _))| role.is_described())
        .map(|(i, (_, p))| (i, p.key.as_str()))
        .collect();
    for key in free {
        let Some((at, _)) = named.iter().find(|(_, own)| answers(own, key)) else {
            let known: Vec<&str> = named.iter().map(|(_, own)| *own).collect();
            return Err(no_such_key(key, &known));
        };
        fixed[*at] = false;
    }
    Ok(fixed)
}

/// Whether a key means this parameter: its own key, one of the masses that share a scale, or one of the
/// delays of which only the difference is identified.
fn answers(own: &str, key: &str) -> bool {
    own == key
        || match own {
            // The names before the star are those of version 0.3.
            "machine.geometry.*_mass" => {
                key == "machine.geometry"
                    || key.starts_with("machine.geometry.") && key.ends_with("_mass")
            }
            "sensors.*_delay" => {
                matches!(
                    key,
                    "sensors.delay" | "sensors.swing_torque_delay" | "sensors.swing_velocity_delay"
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
    let swings = &outcome.swings;
    let all: Vec<usize> = (0..swings.blocks()).collect();
    let whole = Task {
        model: swings,
        blocks: &all,
        fixed: &outcome.fixed,
        least_gain: EXACT,
        stop: options.stop,
        progress: options.progress,
    };
    let fit = whole.run(&start::start(swings, &all, &outcome.fixed));
    if fit.interrupted {
        outcome.remarks.push(STOPPED.into());
    }
    // Faults that have been reported are not repeated as undetermined directions.
    let mut faults = outcome.faults.clone();
    if faults.is_empty() {
        faults = contradictions(&whole, &fit, free);
    }
    let held = tolerances(swings, options);
    let minor: Vec<bool> = swings
        .roles
        .iter()
        .map(|role| {
            matches!(
                role,
                Role::Payload(_) | Role::MotionNoise | Role::TorqueNoise
            ) || role.is_nuisance()
        })
        .collect();
    let Some(mut found) = FitResult::of(&whole, fit, &held, &minor) else {
        outcome.faults = vec![NOTHING.into()];
        return;
    };
    let disagreement = words::disagreement(swings, &found, &outcome.fixed);
    for (i, difference) in disagreement.widths {
        found.uncertainty.widen(i, difference);
    }
    if faults.is_empty() {
        faults.extend(disagreement.fault);
    }
    if faults.is_empty() && !found.fit.interrupted {
        let tolerance = options.description.machine.mass_tolerance;
        faults.extend(words::masses(swings, &found, &outcome.fixed, tolerance));
    }
    outcome.faults = faults;
    outcome.found = Some(found);
    outcome.remarks.extend(disagreement.remark);
    if outcome.faults.is_empty() {
        outcome.remarks.extend(words::ground(outcome));
    }
}

/// Contradictions between fit and description, or directions that the recordings leave undetermined.
fn contradictions(task: &Task<'_, Swings>, fit: &Fit, free: &[Role]) -> Vec<String> {
    let swings = task.model;
    let mut faults = words::far(swings, &fit.place, task.fixed);
    if faults.is_empty() {
        let mut open = honesty::undetermined(&fit.information, &swings.parameters, task.fixed);
        open.retain(|d| !words::is_nuisance(swings, d));
        faults.extend(open.iter().map(|d| words::undetermined(swings, d)));
    }
    if free.contains(&Role::Gain)
        && !fit.interrupted
        && let Some(doubt) = loads::doubt(task)
    {
        faults.insert(0, words::misstated_load(&doubt));
    }
    faults
}

/// Sorts the swings of loaded recordings into loaded and empty ones, from a first fit of the recordings with an empty bucket. This fit is
/// not stopped: a part of it would sort wrongly. Offsets of angles are held: they would absorb faults of a torque.
fn sort_loads(swings: &mut Swings, fixed: &[bool]) -> Option<String> {
    let is_offset = |role: &Role| matches!(role, Role::AngleOffset(_));
    let roles = swings.roles.iter().zip(fixed);
    let fixed: Vec<bool> = roles.map(|(role, f)| *f || is_offset(role)).collect();
    let fixed = fixed.as_slice();
    let empty: Vec<usize> = (0..swings.series.len())
        .filter(|&r| swings.stated[r].is_some_and(|t| t.value == 0.0))
        .flat_map(|r| swings.blocks_of(r))
        .collect();
    let place = if empty.is_empty() {
        vec![0.0; fixed.len()]
    } else {
        let task = Task {
            model: swings,
            blocks: &empty,
            fixed,
            least_gain: EXACT,
            stop: &UNSTOPPED,
            progress: &|_| {},
        };
        task.run(&start::start(swings, &empty, fixed)).place
    };
    loads::sort(swings, &place)
}

/// Stated tolerances of held parameters, in prior standard deviations.
fn tolerances(swings: &Swings, options: &Options<'_>) -> Vec<f64> {
    let d = options.description;
    let stated = |role: &Role, p: &Parameter| match role {
        Role::Lever | Role::AngleOffset(_) => p.std,
        Role::Damping => d.prior.damping_std,
        Role::Offset => d.prior.torque_offset_std,
        Role::Gain => d.number("sensors.swing_torque_gain_std").unwrap_or(0.0),
        Role::Friction
        | Role::Efficiency
        | Role::Inertia
        | Role::Links
        | Role::Delay
        | Role::MotionNoise
        | Role::TorqueNoise
        | Role::Payload(_)
        | Role::UpperMoment
        | Role::Swinging(_)
        | Role::Across(_)
        | Role::Along(_) => 0.0,
    };
    let parameters = swings.roles.iter().zip(&swings.parameters);
    parameters
        .map(|(role, p)| stated(role, p) / p.std)
        .collect()
}

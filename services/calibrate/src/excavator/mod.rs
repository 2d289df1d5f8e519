//! Calibration of an excavator's swing from recordings with known loads.

mod cylinder;
mod filter;
mod loads;
mod result;
pub mod series;
mod start;
mod stated_load;
mod swinging;
mod swings;
mod torque;
mod words;

use std::sync::atomic::AtomicBool;

use config::{Excavator as Description, Tables as _};
use estimation::Quantity;
use estimation::excavator::{Doubts, Geometry, Sample, Settings};

pub use cylinder::CylinderFit;
pub use series::{Load, Measured, Series, Swing};
pub use stated_load::Doubt;
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
    /// The stated loads beside what the machine weighs.
    pub doubts: Vec<Doubt>,
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
    let fixed = held(&swings, options)?;
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
        doubts: Vec::new(),
    };
    if outcome.faults.is_empty() {
        outcome.faults = words::indistinguishable(&outcome.swings, &free);
        find(&mut outcome, &free, options);
    }
    if outcome.faults.is_empty() {
        weigh(&mut outcome, options, inputs);
    }
    let needs_radius = outcome.found.is_some() && free.contains(&Role::Gain);
    if needs_radius && options.description.guessed_radius_std() > 0.0 {
        outcome.faults.push(words::GUESSED_PIN.into());
    }
    Ok(outcome)
}

/// Compares the stated loads with what motion and pressures weigh, and identifies the boom's cylinders.
fn weigh(outcome: &mut Outcome, options: &Options<'_>, inputs: &[Input]) {
    let found = outcome.description(options.description, &[]);
    // Not where only some keys are requested.
    let found = found.filter(|_| options.free.is_none());
    // Masses that were fitted with the stated loads would confirm them.
    let open = found
        .as_ref()
        .map(|(d, _)| result::with_masses(d, options.description));
    let mut known = inputs.to_vec();
    for doubt in &mut outcome.doubts {
        // The pressures are fitted with the load as the motion leaves it, and weigh it without its statement.
        if doubt.stated.std > 0.0 {
            known[doubt.recording].payload = Some(doubt.believed());
        }
        let by_pressures = |d| cylinder::weigh(d, inputs, doubt.recording);
        doubt.by_pressures = open.as_ref().and_then(by_pressures);
    }
    if let Some(doubt) = stated_load::misstated(&outcome.doubts) {
        outcome.faults.push(words::misstated_load(doubt));
        return;
    }
    for doubt in &outcome.doubts {
        if doubt.is_doubtful() {
            outcome.remarks.push(words::doubtful_load(doubt));
        }
        let at = outcome.swings.index(Role::Payload(doubt.recording));
        if let (Some(at), Some(found)) = (at, &mut outcome.found) {
            let parameter = &outcome.swings.parameters[at];
            let believed = doubt.believed();
            found.learn(
                at,
                parameter.place(believed.value),
                believed.std / parameter.std,
            );
        }
    }
    if let Some((d, _)) = found
        && let Some(learnt) = cylinder::learn(&d, &known)
    {
        let words = learnt.as_ref().map_or_else(String::clone, cylinder::words);
        outcome.remarks.push(words);
        outcome.cylinder = learnt.ok();
    }
}

/// Parameters that stay as described. The place of a load is fitted where it is guessed, or its deviation stated.
fn held(swings: &Swings, options: &Options<'_>) -> Result<Vec<bool>, String> {
    let Some(free) = options.free else {
        let is_open = options.description.load_centre_std() > 0.0;
        let is_held = |role: &Role| match role {
            Role::Lever => true,
            Role::Centre(_) => !is_open,
            _ => false,
        };
        return Ok(swings.roles.iter().map(is_held).collect());
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
        let meant = || named.iter().filter(|(_, own)| answers(own, key));
        if meant().next().is_none() {
            let known: Vec<&str> = named.iter().map(|(_, own)| *own).collect();
            return Err(no_such_key(key, &known));
        }
        meant().for_each(|(at, _)| fixed[*at] = false);
    }
    Ok(fixed)
}

/// Whether a key means this parameter: its own key, one of the masses that share a scale, or one of the
/// delays of which only the difference is identified.
fn answers(own: &str, key: &str) -> bool {
    own == key
        || match own {
            // The names before the star are those of version 0.3.
            "machine.geometry.*_mass" => matches!(
                key,
                "machine.geometry" | "machine.geometry.boom_mass" | "machine.geometry.arm_mass"
            ),
            "machine.geometry.bucket_mass" => {
                matches!(key, "machine.geometry" | "machine.geometry.*_mass")
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
    let held = tolerances(swings, options);
    // Faults that have been reported are not repeated as undetermined directions.
    let mut faults = outcome.faults.clone();
    let mut open = Vec::new();
    if faults.is_empty() {
        if free.contains(&Role::Gain) && !fit.interrupted {
            outcome.doubts = stated_load::doubts(&whole, &held);
        }
        faults = contradictions(&whole, &fit, &outcome.doubts);
        open = undetermined(&whole, &fit);
    }
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
    // A load lies differently in each recording; the deviations have what it does to all of them by `Role::Lever`.
    let roles = swings.roles.iter().zip(&held);
    let between: Vec<f64> = roles
        .map(|(role, &held)| {
            if matches!(role, Role::Centre(_)) {
                1.0
            } else {
                held
            }
        })
        .collect();
    let disagreement = words::disagreement(swings, &found, (&outcome.fixed, &between));
    for (i, difference) in disagreement.widths {
        found.uncertainty.widen(i, difference);
    }
    // Recordings that contradict each other look like noise, which leaves little determined.
    if faults.is_empty() {
        faults.extend(disagreement.fault);
    }
    if faults.is_empty() {
        faults = open;
    }
    if faults.is_empty() && !found.fit.interrupted {
        let d = options.description;
        let tolerances = [d.machine.mass_tolerance, Doubts::of(d).bucket_share];
        faults.extend(words::masses(swings, &found, &outcome.fixed, tolerances));
    }
    outcome.faults = faults;
    outcome.found = Some(found);
    outcome.remarks.extend(disagreement.remark);
    if outcome.faults.is_empty() {
        outcome.remarks.extend(words::ground(outcome));
    }
}

/// Contradictions between fit and description.
fn contradictions(task: &Task<'_, Swings>, fit: &Fit, doubts: &[Doubt]) -> Vec<String> {
    let mut faults = words::far(task.model, &fit.place, task.fixed);
    if let Some(doubt) = stated_load::misstated(doubts) {
        faults.insert(0, words::misstated_load(doubt));
    }
    faults
}

/// Directions that the recordings leave undetermined where the nuisance parameters are known: tolerances of these widen the others and refuse
/// nothing. Bucket and place of the load need not improve.
fn undetermined(task: &Task<'_, Swings>, fit: &Fit) -> Vec<String> {
    let swings = task.model;
    let is_nuisance =
        |role: &Role| role.is_nuisance() || matches!(role, Role::Bucket | Role::Centre(_));
    let roles = swings.roles.iter().zip(task.fixed);
    let held: Vec<bool> = roles.map(|(role, &f)| f || is_nuisance(role)).collect();
    let open = honesty::undetermined(&fit.information, &swings.parameters, &held);
    let open = open.iter();
    open.map(|d| words::undetermined(swings, d)).collect()
}

/// Sorts the swings of loaded recordings into loaded and empty ones, from a first fit of the recordings with an empty bucket, or of all
/// with their stated loads where there is none. This fit is not stopped: a part of it would sort wrongly. Offsets of angles are held: they
/// would absorb faults of a torque.
fn sort_loads(swings: &mut Swings, fixed: &[bool]) -> Option<String> {
    if !swings.stated.iter().flatten().any(|load| load.value > 0.0) {
        return None;
    }
    let is_offset = |role: &Role| matches!(role, Role::AngleOffset(_));
    let roles = swings.roles.iter().zip(fixed);
    let fixed: Vec<bool> = roles.map(|(role, f)| *f || is_offset(role)).collect();
    let fixed = fixed.as_slice();
    let empty: Vec<usize> = (0..swings.series.len())
        .filter(|&r| swings.stated[r].is_some_and(|t| t.value == 0.0))
        .flat_map(|r| swings.blocks_of(r))
        .collect();
    let all = || (0..swings.blocks()).collect();
    let known: Vec<usize> = if empty.is_empty() { all() } else { empty };
    let task = Task {
        model: swings,
        blocks: &known,
        fixed,
        least_gain: EXACT,
        stop: &UNSTOPPED,
        progress: &|_| {},
    };
    let place = task.run(&start::start(swings, &known, fixed)).place;
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
        | Role::Bucket
        | Role::Centre(_)
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

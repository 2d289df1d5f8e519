//! Calibration of a wheel loader from drives with known masses.

mod brakes;
mod doubts;
mod drive;
mod drives;
mod known;
mod noise;
mod residuals;
mod result;
mod words;

use std::sync::atomic::AtomicBool;

use config::Loader as Description;
use estimation::Quantity;
use estimation::loader::Sample;

pub use drive::Drive;
pub use drives::{Drives, Role, Told};
use noise::Noises;

use crate::fit::{EXACT, Progress, Task};
use crate::honesty;
use crate::model::Model;
use crate::outcome::{Found, Summary};

const GRAVITY: f64 = 9.81;
/// The fit begins with scatters this much larger than usual, in their tolerances.
const LARGE_SCATTER: f64 = 2.0;

/// A recording and what is known of its load.
#[derive(Debug, Clone)]
pub struct Input {
    /// Its name, for sentences.
    pub name: String,
    /// Its rows.
    pub samples: Vec<Sample>,
    /// What is told of its load; nothing for the machine as described.
    pub told: Told,
}

/// How to calibrate.
pub struct Options<'a> {
    /// What is known beforehand.
    pub description: &'a Description,
    /// What axle scales say of the machine as described.
    pub weighed: Told,
    /// Whether slices of the likelihood are wanted; they take as long as the rest.
    pub slices: bool,
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
    pub drives: Drives,
    /// Which parameters were held.
    pub fixed: Vec<bool>,
    /// The fit; none if the recordings cannot be fitted at all.
    pub found: Option<Found>,
    /// Noises of the sensors.
    pub noises: Vec<(&'static str, Quantity)>,
    /// Why the result must not be believed; empty if nothing speaks against it.
    pub faults: Vec<String>,
    /// What the reader should know.
    pub remarks: Vec<String>,
}

impl Outcome {
    /// To look at.
    #[must_use]
    pub fn summary(&self) -> Summary<'_> {
        let drives = &self.drives.drives;
        Summary {
            machine: "loader",
            block: "stretch",
            model: &self.drives,
            recordings: drives.iter().map(|d| d.name.clone()).collect(),
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

    /// A parameter: value and standard deviation.
    #[must_use]
    pub fn quantity(&self, role: Role) -> Option<Quantity> {
        self.summary().quantity(self.drives.index(role)?)
    }
}

/// Finds the parameters.
///
/// # Errors
/// A key of `free` that cannot be found, with those that can.
pub fn calibrate(inputs: &[Input], options: &Options<'_>) -> Result<Outcome, String> {
    let machine = &options.description.machine;
    let weight = machine.mass * GRAVITY;
    let drives: Vec<Drive> = inputs
        .iter()
        .map(|i| Drive::new(&i.name, &i.samples, weight, machine.wheelbase))
        .collect();
    let told: Vec<Told> = inputs.iter().map(|i| i.told).collect();
    let drives = Drives::new(drives, &told, options.weighed, options.description);
    let fixed = held(&drives, options.free)?;
    let faults = words::before(&drives);
    let noises = match options.free {
        None => Noises::of(inputs, options.description),
        Some(_) => Noises::default(),
    };
    let mut outcome = Outcome {
        drives,
        fixed,
        found: None,
        noises: noises.found,
        faults,
        remarks: noises.remarks,
    };
    if outcome.faults.is_empty() {
        find(&mut outcome, options);
    }
    Ok(outcome)
}

/// Which parameters stay as described.
fn held(drives: &Drives, free: Option<&[String]>) -> Result<Vec<bool>, String> {
    let Some(free) = free else {
        return Ok(vec![false; drives.roles.len()]);
    };
    let mut fixed: Vec<bool> = drives
        .roles
        .iter()
        .map(|r| r.load().is_none() && !r.is_nuisance())
        .collect();
    for key in free {
        let at = drives.parameters.iter().position(|p| p.key == *key);
        let Some(at) = at else {
            let known: Vec<&str> = drives.parameters.iter().map(|p| p.key.as_str()).collect();
            return Err(format!(
                "{key} cannot be found from recordings; these can: {}",
                known.join(", ")
            ));
        };
        fixed[at] = false;
    }
    Ok(fixed)
}

fn find(outcome: &mut Outcome, options: &Options<'_>) {
    let drives = &outcome.drives;
    let roles = drives.roles.iter().zip(&outcome.fixed);
    let free: Vec<Role> = roles
        .filter(|(_, fixed)| !**fixed)
        .map(|(r, _)| *r)
        .collect();
    let mut faults = words::alike(drives, &free);
    let all: Vec<usize> = (0..drives.blocks()).collect();
    let task = Task {
        model: drives,
        blocks: &all,
        fixed: &outcome.fixed,
        least_gain: EXACT,
        stop: options.stop,
        progress: options.progress,
    };
    // Residuals that seem far too large for their scatter would all be weakened as outliers.
    let begin = |role: &Role| f64::from(role.is_noise()) * LARGE_SCATTER;
    let fit = task.run(&drives.roles.iter().map(begin).collect::<Vec<_>>());
    if fit.interrupted {
        outcome
            .remarks
            .push("stopped before its end: the best so far".into());
    }
    // What has been said need not be said again in the words of algebra.
    if faults.is_empty() {
        for d in honesty::undetermined(&fit.information, &drives.parameters, &outcome.fixed) {
            if words::is_nuisance(drives, &d) {
                continue;
            }
            let sentence = words::undetermined(drives, &d);
            if words::matters(drives, &d) {
                faults.push(sentence);
            } else {
                outcome.remarks.push(sentence);
            }
        }
    }
    if !fit.interrupted {
        // What follows from brakes would be said of other things.
        if let Some(brakes) = brakes::differ(drives, &fit.place) {
            faults.push(brakes);
        } else {
            faults.extend(words::far(drives, &fit.place, &outcome.fixed));
            faults.extend(doubts::doubts(drives, &task, &fit));
        }
    }
    // What is held has the tolerance of the description, which the others carry.
    let held = vec![1.0; drives.roles.len()];
    let minor: Vec<bool> = drives
        .roles
        .iter()
        .map(|r| !options.slices || r.is_nuisance() || r.load().is_some_and(|load| load > 0))
        .collect();
    outcome.found = Found::of(&task, fit, &held, &minor);
    if outcome.found.is_none() {
        faults = vec!["the recordings determine nothing".into()];
    }
    outcome.faults = faults;
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::Tables;
    use residuals::tests::{guess, samples};

    fn run(inputs: &[Input], weighed: Told) -> Outcome {
        let options = Options {
            description: &Description::default(),
            weighed,
            slices: false,
            free: None,
            stop: &AtomicBool::new(false),
            progress: &|_| {},
        };
        calibrate(inputs, &options).expect("keys")
    }

    fn quantity(value: f64, std: f64) -> Option<Quantity> {
        Some(Quantity { value, std })
    }

    fn inputs(told: f64) -> [Input; 2] {
        let empty = guess();
        let loaded = residuals::Guess {
            mass: 6200.0,
            ratio: 0.7,
            ..empty
        };
        let input = |name: &str, g, mass| Input {
            name: name.into(),
            samples: samples(g, 0.2, 7),
            told: Told {
                mass,
                ..Told::default()
            },
        };
        [
            input("flat", &empty, None),
            input("loaded", &loaded, quantity(told, 30.0)),
        ]
    }

    const SCALES: Told = Told {
        mass: None,
        ratio: Some(Quantity {
            value: 0.45,
            std: 0.001,
        }),
        height: None,
    };

    #[test]
    fn a_machine_that_differs_from_its_description_is_found() {
        let outcome = run(&inputs(6200.0), SCALES);
        let truth = guess();
        for (role, value, within) in [
            (Role::LoadSensitivity, truth.load_sensitivity, 1e-3),
            (Role::FrontRadius, truth.radius_errors[0], 5e-4),
            (Role::RearRadius, truth.radius_errors[1], 5e-4),
            (Role::SpeedDelay, truth.speed_delay, 3e-3),
            (Role::SlopeBias, truth.slope_bias, 5e-4),
            (Role::SlopeDelay, truth.slope_delay, 0.01),
            (Role::SlopeFollows, truth.slope_follows, 0.01),
            (Role::FrontGain, truth.torque_gains[0], 0.01),
            (Role::StiffnessRatio, truth.stiffness_ratio, 0.03),
        ] {
            let found = outcome.quantity(role).expect("a fit");
            let error = (found.value - value).abs();
            assert!(
                error < f64::max(within, 3.0 * found.std) && error < 3.0 * within,
                "{role:?}: {found:?} {value}"
            );
        }
        let (description, text) = outcome
            .description(&Description::default(), &[])
            .expect("a fit");
        assert_eq!(Description::parse(&text, "t"), Ok(description));
    }

    /// The sentences of a run from changed recordings.
    fn faults(change: impl Fn(&mut Sample), told: f64, weighed: Told) -> String {
        let mut inputs = inputs(told);
        for input in &mut inputs {
            input.samples.iter_mut().for_each(&change);
        }
        run(&inputs, weighed).faults.join("\n")
    }

    #[test]
    fn what_cannot_be_believed_is_said() {
        let wrong = faults(|_| {}, 5450.0, SCALES);
        assert!(wrong.contains("was told as 5450 kg"), "{wrong}");
        let [flat, _] = inputs(6200.0);
        let one = run(&[flat], SCALES).faults.join("\n");
        assert!(one.contains("the same load"), "{one}");
        let still = faults(|s| s.speed = Some(0.01), 6200.0, SCALES);
        assert!(still.contains("stands still"), "{still}");
        let coasting = |s: &mut Sample| {
            if s.front_torque.is_some_and(|t| t < 0.0) {
                s.brake = true;
            }
        };
        let one_way = faults(coasting, 6200.0, SCALES);
        assert!(one_way.contains("never brakes"), "{one_way}");
        let gentle = |s: &mut Sample| {
            s.front_torque = s.front_torque.map(|t| 0.02 * t);
            s.rear_torque = s.rear_torque.map(|t| 0.02 * t);
        };
        let rolling = faults(gentle, 6200.0, SCALES);
        assert!(rolling.contains("rolls without pulling"), "{rolling}");
        let slow_wheel = |s: &mut Sample| {
            s.front_wheel_speed = s.front_wheel_speed.map(|w| 0.9 * w);
        };
        let far = faults(slow_wheel, 6200.0, SCALES);
        assert!(far.contains("was expected"), "{far}");
    }

    #[test]
    fn equal_torques_leave_the_gains_untold_and_as_described() {
        let mut inputs = inputs(6200.0);
        let empty = guess();
        let loaded = residuals::Guess {
            mass: 6200.0,
            ratio: 0.7,
            ..empty
        };
        for (input, g) in inputs.iter_mut().zip([empty, loaded]) {
            input.samples = samples(&g, 0.0, 7);
        }
        let outcome = run(&inputs, SCALES);
        let said = [&outcome.faults[..], &outcome.remarks[..]]
            .concat()
            .join("\n");
        assert!(said.contains("torque on one axle"), "{said}");
        let before = Description::default();
        let (after, _) = outcome.description(&before, &[]).expect("a fit");
        let wide = |role: Role| {
            let i = outcome.drives.index(role).expect("a parameter");
            let std = outcome.quantity(role).expect("a fit").std;
            std > result::NARROWED * outcome.drives.parameters[i].std
        };
        assert_eq!(
            wide(Role::FrontGain),
            after.sensors.front_torque_gain == before.sensors.front_torque_gain
        );
        assert!(!wide(Role::FrontRadius) && after.prior.front_radius_error != 0.0);
    }

    #[test]
    fn what_is_held_with_a_tolerance_widens_what_is_found() {
        let free = ["prior.front_radius_error", "prior.rear_radius_error"].map(String::from);
        let options = Options {
            description: &Description::default(),
            weighed: SCALES,
            slices: false,
            free: Some(&free),
            stop: &AtomicBool::new(false),
            progress: &|_| {},
        };
        let few = calibrate(&inputs(6200.0), &options).expect("keys");
        let all = run(&inputs(6200.0), SCALES);
        let std = |o: &Outcome| o.quantity(Role::FrontRadius).expect("a fit").std;
        assert!(std(&few) > 5.0 * std(&all), "{} {}", std(&few), std(&all));
        let error =
            few.quantity(Role::FrontRadius).expect("a fit").value - guess().radius_errors[0];
        assert!(error.abs() < 3.0 * std(&few), "{error} {}", std(&few));
    }
}

//! What is wrong with the recordings of a loader, in sentences that say what to record.

use super::drives::{Drives, Role};
use crate::honesty::Direction;

/// Least time of driving with a load [s].
const LEAST_DRIVING: f64 = 20.0;
/// The middle of the tractive forces while driving and braking differs at least by this share of the weight.
const LEAST_PULL: f64 = 0.05;

/// What the recordings lack before any fit.
#[must_use]
pub fn before(model: &Drives) -> Vec<String> {
    let mut faults = Vec::new();
    for drive in &model.drives {
        let wheels = drive.wheels.iter().flatten().any(|w| w.is_finite());
        if !wheels || !drive.speed.iter().any(|v| v.is_finite()) {
            faults.push(format!(
                "{}: speed and both wheel speeds are needed; check that the right columns are mapped",
                drive.name
            ));
        } else if drive.driving_time() < 0.5 * LEAST_DRIVING {
            faults.push(format!(
                "{}: only {:.1} s of straight driving faster than walking, without digging and braking; record two minutes of driving",
                drive.name,
                drive.driving_time()
            ));
        }
    }
    faults
}

/// What these recordings cannot tell, by what their drives are like.
#[must_use]
pub fn alike(model: &Drives, free: &[Role]) -> Vec<String> {
    let mut faults = Vec::new();
    if model.loads.len() < 2 && free.contains(&Role::LoadSensitivity) {
        faults.push(ONE_LOAD.into());
    }
    if pull_range(model) < LEAST_PULL {
        faults.push(
            "the machine rolls without pulling: slips are too small to tell the stiffness of the tyres; record hard acceleration and braking with the drive"
                .into(),
        );
    }
    faults
}

/// All recordings carry the same load.
pub const ONE_LOAD: &str = "all recordings carry the same load: rolling radii and their load sensitivity, torque gains and masses look alike; record one run with the bucket empty and one with a weighed load, and tell it: --mass FILE=KG±KG";

/// Between the strongest driving and braking, as a share of the weight.
fn pull_range(model: &Drives) -> f64 {
    let mut pulls = Vec::new();
    for drive in &model.drives {
        for k in drive.blocks.iter().flat_map(Clone::clone) {
            pulls.push(drive.torques[0][k] + drive.torques[1][k]);
        }
    }
    let share = |s: f64| crate::excavator::series::percentile(pulls.clone(), s);
    (share(0.97) - share(0.03)) / model.torque_of_weight()
}

/// Whether a direction that the data leave open makes the result one not to be believed; what the estimator's own
/// tolerances carry does not.
#[must_use]
pub fn matters(model: &Drives, direction: &Direction) -> bool {
    share(model, direction, |role| {
        matches!(
            role,
            Role::FrontRadius
                | Role::RearRadius
                | Role::LoadSensitivity
                | Role::Stiffness
                | Role::StiffnessRatio
                | Role::SpeedDelay
                | Role::Mass(_)
                | Role::Ratio(_)
        )
    }) > 0.5
}

/// Whether a direction is about noises, which have no use beyond the fit.
#[must_use]
pub fn is_noise(model: &Drives, direction: &Direction) -> bool {
    share(model, direction, Role::is_noise) > 0.5
}

/// Share of some parameters in a direction.
fn share(model: &Drives, direction: &Direction, of: impl Fn(Role) -> bool) -> f64 {
    let shares = model.roles.iter().zip(&direction.shares);
    let chosen = shares.filter(|(role, _)| of(**role));
    chosen.map(|(_, share)| share * share).sum()
}

/// A direction that the data do not determine, and what to record.
#[must_use]
pub fn undetermined(model: &Drives, direction: &Direction) -> String {
    let members = direction.members();
    let names: Vec<&str> = members
        .iter()
        .map(|&i| model.parameters[i].words.as_str())
        .collect();
    let has = |of: fn(Role) -> bool| members.iter().any(|&i| of(model.roles[i]));
    let remedy = if has(|r| matches!(r, Role::Ratio(_)))
        && has(|r| {
            matches!(
                r,
                Role::StiffnessRatio | Role::LoadExponent | Role::FrontGain | Role::RearGain
            )
        }) {
        "weigh both axles: --weigh scales.csv"
    } else if has(|r| matches!(r, Role::FrontGain | Role::RearGain)) {
        "drive for a while with the torque on one axle, and then on the other"
    } else if has(|r| matches!(r, Role::LoadSensitivity | Role::Mass(_))) {
        "record a run with a heavier weighed load"
    } else if has(|r| matches!(r, Role::Height(_) | Role::LoadExponent | Role::Relaxation)) {
        "record hard acceleration and braking"
    } else if has(|r| matches!(r, Role::SpeedDelay | Role::TorqueDelay)) {
        "record sharp changes of the speed"
    } else if has(|r| matches!(r, Role::SlopeBias | Role::SlopeDelay | Role::Rolling)) {
        "drive the same way there and back, over a slope"
    } else {
        "record longer"
    };
    let what = match names.as_slice() {
        [one] => format!("{one} is not determined by these recordings"),
        _ => format!("{} cannot be told apart by these recordings", join(&names)),
    };
    format!(
        "{what} (information {:.2} of what the description knows); {remedy}",
        direction.information
    )
}

fn join(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

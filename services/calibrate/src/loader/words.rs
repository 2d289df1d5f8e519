//! Texts about faults of a loader's recordings, with what to record instead.

use super::drive::Drive;
use super::drives::Drives;
use super::role::Role;
use crate::column::percentile;
use crate::honesty::Direction;

/// Least time of driving in a recording [s].
const LEAST_DRIVING: f64 = 20.0;
/// Largest speed of a machine that stands [m/s].
const STANDS: f64 = 0.2;
/// Least difference of strongest driving and braking, as a share of the weight; each is at least a fourth of it.
const LEAST_PULL: f64 = 0.05;
/// Distance from the description above which a value is implausible, in prior standard deviations.
const FAR: f64 = 4.0;

/// Remark: no recording drives.
pub const ONLY_LIFTS: &str = "the machine stands in all recordings, or has no wheel speeds: only its lift cylinders were calibrated";

fn has_wheels(drive: &Drive) -> bool {
    drive.wheels.iter().flatten().any(|w| w.is_finite())
}

/// Whether a recording carries no information about driving: the machine stands, or its wheels are not measured.
pub fn stands(drive: &Drive) -> bool {
    !has_wheels(drive) || drive.fastest() < STANDS
}

/// Remark on the rows that were left out because a wheel spins.
pub fn spun(name: &str, time: f64) -> String {
    format!(
        "{name}: a wheel spins for {time:.1} s, which are left out; pull less, or on firmer ground"
    )
}

/// Faults of the recordings before any fit.
pub fn before(model: &Drives) -> Vec<String> {
    let mut faults = Vec::new();
    for drive in &model.drives {
        if !has_wheels(drive) || !drive.speed.iter().any(|v| v.is_finite()) {
            faults.push(format!(
                "{}: speed and both wheel speeds are needed; check that the right columns are mapped",
                drive.name
            ));
        } else if drive.fastest() < STANDS {
            faults.push(format!(
                "{}: the machine stands still; drive straight on for two minutes, and check that the right columns are mapped",
                drive.name
            ));
        } else if drive.driving_time() < LEAST_DRIVING {
            faults.push(format!(
                "{}: only {:.1} s of straight driving faster than walking, without digging and braking; record two minutes of driving",
                drive.name,
                drive.driving_time()
            ));
        }
    }
    faults
}

/// Faults of the recordings that make parameters indistinguishable.
pub fn indistinguishable(model: &Drives, free: &[Role]) -> Vec<String> {
    let mut faults = Vec::new();
    if model.loads.len() < 2 && free.contains(&Role::LoadSensitivity) {
        faults.push(ONE_LOAD.into());
    }
    let [braking, driving] = pulls(model);
    if driving - braking < LEAST_PULL {
        faults.push(
            "the machine rolls without pulling: slips are too small to determine the stiffness of the tyres; record hard acceleration and braking with the drive"
                .into(),
        );
    } else if driving < 0.25 * LEAST_PULL || braking > -0.25 * LEAST_PULL {
        let [does, lacks] = if driving > -braking {
            ["drives and never brakes", "braking with the drive"]
        } else {
            ["brakes and never drives", "acceleration"]
        };
        faults.push(format!(
            "slips to one direction only: the machine {does}, and the errors of radii, speed and stiffness look alike; record hard {lacks} too"
        ));
    }
    faults
}

/// Values far from the description.
pub fn far(model: &Drives, place: &[f64], fixed: &[bool]) -> Vec<String> {
    let is_far = |&i: &usize| {
        // Stated masses are checked one by one.
        let judged =
            !model.roles[i].is_nuisance() && !matches!(model.roles[i], Role::Mass(l) if l > 0);
        judged && !fixed[i] && place[i].abs() > FAR
    };
    (0..place.len())
        .filter(is_far)
        .map(|i| {
            let p = &model.parameters[i];
            format!(
                "{} would be {:.4}, but {:.4} ± {:.4} was expected: {}, or the machine file is wrong",
                p.words,
                p.value(place[i]),
                p.mean,
                p.std,
                cause(model.roles[i])
            )
        })
        .collect()
}

/// What else makes a parameter leave its tolerance, and what to do.
fn cause(role: Role) -> &'static str {
    match role {
        Role::FrontRadius | Role::RearRadius => {
            "other tyres, tyre pressure or wear, or a speed or wheel speed with another scale (prior.radius_std)"
        }
        Role::FrontGain | Role::RearGain | Role::StiffnessRatio => {
            "a locked centre drive, or torques with another range or gear (sensors.torque_gain_std)"
        }
        Role::Rolling => "a friction brake, or ground that gives way",
        Role::Stiffness | Role::LoadSensitivity | Role::LoadExponent => {
            "other tyres, ground that gives way, or a locked centre drive"
        }
        Role::SlopeBias => {
            "the zero of the slope sensor, if it is mounted askew: state its tolerance (prior.slope_bias_std), or its value on level ground (prior.slope_bias)"
        }
        Role::AccelerationOffset => {
            "the zero of the accelerometer, if it is mounted askew: state its tolerance (sensors.acceleration_offset_std), or its value (sensors.acceleration_offset)"
        }
        Role::SlopeDelay | Role::SlopeFollows => {
            "a filter in the slope sensor (sensors.slope_delay_std, sensors.slope_acceleration_sensitivity_std)"
        }
        Role::SpeedDelay => "signals recorded with different delays (sensors.speed_delay_std)",
        Role::Mass(_) | Role::Ratio(_) | Role::Height(_) => {
            "another load in the recording than stated, or a scale that is off"
        }
        _ => "the machine does what the model does not know",
    }
}

/// Nuisance parameters far from their priors: they are not written, so they refuse nothing.
pub fn far_nuisances(model: &Drives, place: &[f64], fixed: &[bool]) -> Vec<usize> {
    let is_far = |&i: &usize| {
        let role = model.roles[i];
        role.is_nuisance() && !role.is_noise() && !fixed[i] && place[i].abs() > FAR
    };
    (0..place.len()).filter(is_far).collect()
}

/// Text about such a parameter before its prior is widened.
pub fn widened(model: &Drives, i: usize, place: f64) -> String {
    let p = &model.parameters[i];
    format!(
        "{} would be {:.4}, but {:.4} ± {:.4} was expected: it is not written to the machine file, and the rest is fitted with ± {:.4} for it",
        p.words,
        p.value(place),
        p.mean,
        p.std,
        p.std * place.abs()
    )
}

/// Values at the limit of their range, where the interval is meaningless, and whether each is written.
pub fn at_limit(model: &Drives, place: &[f64], fixed: &[bool]) -> Vec<(String, bool)> {
    let found = (0..place.len()).filter(|&i| !fixed[i]);
    found
        .filter_map(|i| {
            let (p, role) = (&model.parameters[i], model.roles[i]);
            let value = p.value(place[i]);
            (value <= p.range.0 || value >= p.range.1).then(|| {
                let sentence = format!(
                    "{} is at the limit of what is possible, {value:.4}: its interval means nothing, and another cause is likely",
                    p.words
                );
                let is_written = !role.is_nuisance() && role.load().is_none_or(|load| load == 0);
                (sentence, is_written)
            })
        })
        .collect()
}

/// Fault: all recordings carry the same load.
pub const ONE_LOAD: &str = "all recordings carry the same load, as far as it is stated: rolling radii and their load sensitivity, torque gains and masses cannot be distinguished; record one run with the bucket empty and one with a weighed load, and state the mass of the machine: --mass FILE=KG±KG";

/// Strongest braking and driving torques, as shares of the weight.
fn pulls(model: &Drives) -> [f64; 2] {
    let mut pulls = Vec::new();
    for drive in &model.drives {
        for k in drive.blocks.iter().flat_map(Clone::clone) {
            let torque = drive.torques[0][k] + drive.torques[1][k];
            pulls.push(torque * drive.speed[k].signum() / model.torque_of_weight());
        }
    }
    [0.03, 0.97].map(|share| percentile(pulls.clone(), share))
}

/// Whether an undetermined direction invalidates the result; a direction that the estimator's own
/// tolerances cover does not.
pub fn matters(model: &Drives, direction: &Direction) -> bool {
    share(model, direction, |role| {
        matches!(
            role,
            Role::FrontRadius
                | Role::RearRadius
                | Role::LoadSensitivity
                | Role::Stiffness
                | Role::StiffnessRatio
                | Role::LoadExponent
                | Role::SpeedDelay
                | Role::Mass(_)
                | Role::Ratio(_)
                | Role::Height(_)
        )
    }) > 0.5
}

/// Whether a direction consists of nuisance parameters.
pub fn is_nuisance(model: &Drives, direction: &Direction) -> bool {
    share(model, direction, Role::is_nuisance) > 0.5
}

/// Share of the selected parameters in a direction.
fn share(model: &Drives, direction: &Direction, of: impl Fn(Role) -> bool) -> f64 {
    let shares = model.roles.iter().zip(&direction.shares);
    let chosen = shares.filter(|(role, _)| of(**role));
    chosen.map(|(_, share)| share * share).sum()
}

/// Remedy that makes the torque gains distinguishable.
const EACH_AXLE: &str = "drive for a while with the torque on one axle, and then on the other";

/// Text about a direction that the data do not determine, with what to record.
pub fn undetermined(model: &Drives, direction: &Direction) -> String {
    let members = direction.members();
    let has = |of: fn(Role) -> bool| members.iter().any(|&i| of(model.roles[i]));
    let place = |r| matches!(r, Role::Ratio(_) | Role::Reach(_) | Role::Lift(_));
    let tyres = |r| matches!(r, Role::StiffnessRatio | Role::LoadExponent);
    let gain = |r| matches!(r, Role::FrontGain | Role::RearGain);
    // The leading parameter decides the remedy.
    let zero = |r| {
        matches!(
            r,
            Role::SlopeBias | Role::AccelerationOffset | Role::Rolling
        )
    };
    let remedy = if members.first().is_some_and(|&i| zero(model.roles[i])) {
        "drive the same path out and back, the machine turned round (--out-and-back FILE,FILE), or some of it in reverse"
    } else if members.first().is_some_and(|&i| gain(model.roles[i])) {
        EACH_AXLE
    } else if has(place) && has(tyres) {
        "weigh both axles, empty and loaded: --weigh scales.csv --weigh FILE=scales.csv"
    } else if has(gain) {
        EACH_AXLE
    } else if has(|r| matches!(r, Role::LoadSensitivity | Role::Mass(_))) {
        "record a run with a heavier weighed load"
    } else if has(|r| matches!(r, Role::Height(_) | Role::LoadExponent)) {
        "record hard acceleration and braking"
    } else if has(|r| matches!(r, Role::SpeedDelay)) {
        "record sharp changes of the speed"
    } else if has(|r| matches!(r, Role::SlopeDelay)) {
        "drive over humps and changes of the slope"
    } else if has(|r| matches!(r, Role::SlopeFollows)) {
        "accelerate and brake harder"
    } else {
        "record longer"
    };
    direction.undetermined(&model.parameters, remedy)
}

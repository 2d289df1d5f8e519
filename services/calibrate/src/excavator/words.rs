//! Texts about faults of an excavator's recordings, with what to record instead.

use estimation::Quantity;
use faer::Mat;

use super::Outcome;
use super::series::Series;
use super::stated_load::Doubt;
use super::swings::{Role, SWINGING_STD, Swings};
use crate::agreement::{Difference, differences};
use crate::algebra;
use crate::honesty::Direction;
use crate::model::Model;
use crate::outcome::FitResult;
use crate::output::rounded;

/// Least duration of motion for a calibration [s].
const LEAST_MOTION: f64 = 8.0;
/// Least share of each direction in the motion.
const LEAST_SHARE: f64 = 0.1;
/// Least variation of the attachment's inertia, as a share of the whole.
const LEAST_POSTURE: f64 = 0.04;
/// Share of rows out of order above which the recording is faulty.
const MANY_REFUSED: f64 = 0.1;
/// Distance from the description above which a value is implausible, in prior standard deviations.
const FAR: f64 = 4.0;
/// Sum of the squared deviations of one mass, and of two, in standard deviations, above which they are others, or another load was in the
/// bucket than stated: quantiles of chi-square with as many degrees of freedom, exceeded by chance once in 370.
const OTHER_MASSES: [f64; 2] = [9.0, 11.829];
/// Standard deviations above which a difference between recordings is clear, and share of the description's tolerance above which
/// it is material.
const CLEARLY: f64 = 4.0;
const MATERIAL: f64 = 0.5;
/// Joint whose angle is compared between recordings: offsets of arm and bucket take up errors of lengths and centres.
const BOOM: usize = 0;
/// Least reported slope [rad].
const CLEAR_SLOPE: f64 = 0.01;

/// Faults and remarks of the recordings before any fit.
#[must_use]
pub fn before(swings: &Swings) -> (Vec<String>, Vec<String>) {
    let (mut faults, mut remarks) = (Vec::new(), Vec::new());
    let any_posture = swings.series.iter().any(|s| s.has_posture);
    for series in &swings.series {
        let fault = if series.refused > MANY_REFUSED {
            "the time does not increase from row to row; check its column, and sort the rows"
        } else if !series.value.iter().any(|v| v.is_finite()) {
            "neither swing velocity nor angle is measured; check that the right columns are mapped"
        } else if series.torque.size() <= 0.0 {
            "no swing torque is measured; without it nothing but ratios can be found"
        } else if any_posture && !series.has_posture {
            "the three joint angles are not measured, as they are in another recording; check that the right columns are mapped"
        } else {
            continue;
        };
        faults.push(format!("{}: {fault}", series.name));
    }
    if !faults.is_empty() {
        return (faults, remarks);
    }
    let moving: f64 = swings
        .series
        .iter()
        .map(|s| s.moving_time(1.0) + s.moving_time(-1.0))
        .sum();
    for series in &swings.series {
        let (left, right) = (series.moving_time(1.0), series.moving_time(-1.0));
        if left + right < 0.5 * LEAST_MOTION {
            faults.push(format!(
                "{}: the machine stands still ({:.1} s of swinging); record at least ten swings to each side",
                series.name,
                left + right
            ));
        } else if left.min(right) < LEAST_SHARE * (left + right) {
            remarks.push(format!(
                "{}: the recording has swings to one side only",
                series.name
            ));
        }
    }
    if faults.is_empty() && moving < LEAST_MOTION {
        faults.push(format!(
            "only {moving:.1} s of swinging in all recordings; record at least ten swings to each side"
        ));
    }
    (faults, remarks)
}

/// Faults of the recordings that make parameters indistinguishable.
#[must_use]
pub fn indistinguishable(swings: &Swings, free: &[Role]) -> Vec<String> {
    let mut faults = Vec::new();
    let moving: f64 = swings
        .series
        .iter()
        .map(|s| s.moving_time(1.0) + s.moving_time(-1.0))
        .sum();
    let side = |d: f64| swings.series.iter().map(|s| s.moving_time(d)).sum::<f64>();
    let one_side = side(1.0).min(side(-1.0)) < LEAST_SHARE * moving;
    if one_side && free.contains(&Role::Offset) && free.contains(&Role::Friction) {
        faults.push(
            "the recordings have swings to one side only: friction and the offset of the torque look alike; record swings to both sides"
                .into(),
        );
    }
    if free.contains(&Role::Links) && free.contains(&Role::Inertia) && still_posture(swings) {
        faults.push(
            "boom and arm keep the same posture in all swings: the upper body and the attachment look alike; record swings with the arm stretched out and with the arm folded in"
                .into(),
        );
    }
    faults
}

fn still_posture(swings: &Swings) -> bool {
    let mut inertia: Vec<f64> = Vec::new();
    for block in 0..swings.blocks() {
        let (series, swing) = swings.swing(block);
        let rows = swing.rows.clone();
        let parts = series.links[rows.clone()].iter().zip(&series.bucket[rows]);
        inertia.extend(parts.map(|(links, bucket)| links + bucket));
    }
    let low = crate::column::percentile(inertia.clone(), 0.05);
    let high = crate::column::percentile(inertia, 0.95);
    let upper = swings
        .index(Role::Inertia)
        .map_or(0.0, |i| swings.parameters[i].mean);
    high - low < LEAST_POSTURE * (upper + high)
}

/// Values far from the description.
#[must_use]
pub fn far(swings: &Swings, place: &[f64], fixed: &[bool]) -> Vec<String> {
    let is_far = |&i: &usize| {
        let role = swings.roles[i];
        // A single share of a load may be all of what swings.
        let is_share = matches!(role, Role::Swinging(_));
        let asked = !fixed[i] && !role.is_load() && !role.is_noise() && !is_share;
        asked && place[i].abs() > FAR
    };
    let all = (0..place.len()).filter(is_far).map(|i| {
        let p = &swings.parameters[i];
        let cause = match swings.roles[i] {
            Role::AngleOffset(_) => "set the sensor, or state how well it is set (sensors.angle_offset_std)",
            _ => "a column of another unit or sign, recordings of another machine or another load than stated, or the machine file is wrong",
        };
        format!(
            "{} would be {:.4}, but {:.4} ± {:.4} {unit} was expected: {cause}",
            p.words, p.value(place[i]), p.mean, p.std, unit = p.unit
        )
    });
    let shares = (0..place.len()).filter(|&i| matches!(swings.roles[i], Role::Swinging(_)));
    let swinging: f64 = shares.map(|i| swings.parameters[i].value(place[i])).sum();
    let hangs = swinging.abs() > FAR * SWINGING_STD;
    let hangs = hangs.then(|| {
        format!(
            "{:.0} % of the load would swing: a load that hangs, or other faults; record one that lies in the bucket",
            100.0 * swinging
        )
    });
    all.chain(hangs).collect()
}

/// Fault of masses far from the description: the gain of the torque and the masses absorb a misstated load. `tolerances` are the relative
/// standard deviations of the described masses of boom and arm, and of the bucket. The swings tell their sum better than their
/// difference, so they are judged together.
#[must_use]
pub fn masses(
    swings: &Swings,
    found: &FitResult,
    fixed: &[bool],
    tolerances: [f64; 2],
) -> Option<String> {
    let names = ["the masses of boom and arm", "that of the bucket"];
    let each = [Role::Links, Role::Bucket].into_iter().zip(names);
    let free: Vec<_> = each
        .zip(tolerances)
        .filter_map(|((role, name), tolerance)| {
            let i = swings.index(role).filter(|&i| !fixed[i])?;
            let p = &swings.parameters[i];
            let by = p.value(found.fit.place[i]) / p.mean - 1.0;
            Some((i, name, tolerance, by))
        })
        .collect();
    let by: Vec<f64> = free.iter().map(|(.., by)| *by).collect();
    let covariance = Mat::from_fn(free.len(), free.len(), |a, b| {
        let ((i, _, tolerance, _), j) = (free[a], free[b].0);
        let scales = [i, j].map(|i| swings.parameters[i].std / swings.parameters[i].mean);
        let own = scales[0] * scales[1] * found.uncertainty.covariance[(i, j)];
        own + f64::from(a == b) * tolerance * tolerance
    });
    (tolerances[0] > 0.0 && are_others(&by, &covariance)).then(|| {
        let each = free.iter().map(|(_, name, tolerance, by)| {
            let [by, within] = [100.0 * by, 100.0 * tolerance];
            format!("{name} by {by:+.1} % (stated within {within:.1} %)")
        });
        format!(
            "the machine would differ from the machine file, {}: another load was in the bucket than stated, or the machine file is of another machine; weigh the load again, or state a larger machine.mass_tolerance or machine.bucket_tolerance",
            each.collect::<Vec<_>>().join(" and ")
        )
    })
}

/// Whether relative deviations of one or two masses with this covariance are larger than by chance.
fn are_others(by: &[f64], covariance: &Mat<f64>) -> bool {
    let right = Mat::from_fn(by.len(), 1, |i, _| by[i]);
    let Some(white) = algebra::whitened(covariance, &right) else {
        return false;
    };
    white.squared_norm_l2() > OTHER_MASSES[by.len().clamp(1, 2) - 1]
}

/// Parts of recordings that are inconsistent with the whole: a fault where the difference is large relative to
/// the description's tolerance, a remark where it is only clear. `held`: tolerances of fixed parameters, in prior standard deviations.
#[must_use]
pub fn disagreement(
    swings: &Swings,
    found: &FitResult,
    (fixed, held): (&[bool], &[f64]),
) -> Disagreement {
    if found.fit.interrupted {
        // The test holds at the maximum only.
        return Disagreement::default();
    }
    let (parts, names) = parts(swings);
    let is_compared = |role: &Role| {
        let takes_up_errors = match role {
            Role::AngleOffset(joint) => *joint != BOOM,
            Role::Bucket | Role::Centre(_) => true,
            _ => false,
        };
        role.is_described() && !role.is_noise() && !takes_up_errors
    };
    // A parameter at its limit is not at a maximum either.
    let is_inside = |i: usize| {
        let p = &swings.parameters[i];
        let value = p.value(found.fit.place[i]);
        p.range.0 < value && value < p.range.1
    };
    let asked: Vec<usize> = (0..fixed.len())
        .filter(|&i| is_compared(&swings.roles[i]) && is_inside(i))
        .collect();
    let all = differences(
        &found.fit,
        &found.uncertainty,
        (fixed, held),
        &parts,
        &asked,
    );
    let clear = |d: &&Difference| d.sizes.abs() > CLEARLY;
    let Some(worst) = all.iter().find(clear) else {
        return Disagreement::default();
    };
    let say = |d: &Difference| {
        let p = &swings.parameters[d.parameter];
        let x = found.fit.place[d.parameter];
        let unit = if p.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", p.unit)
        };
        let std = p.value_std(x, found.uncertainty.std(d.parameter));
        let [here, all] = [x + d.by, x].map(|x| rounded(p.value(x), 100.0 * std));
        format!(
            "{} does not fit the rest: {} would be {here} there, not {all}{}",
            names[d.part], p.words, unit
        )
    };
    match all.iter().filter(clear).find(|d| d.by.abs() > MATERIAL) {
        Some(d) => Disagreement {
            fault: Some(format!(
                "{}; {}",
                say(d),
                otherwise(swings.roles[d.parameter])
            )),
            ..Disagreement::default()
        },
        None => {
            let largest = |i: usize| {
                let of_it = all.iter().filter(clear).filter(|d| d.parameter == i);
                of_it.map(|d| d.by.abs()).fold(0.0, f64::max)
            };
            Disagreement {
                remark: Some(format!(
                    "{}; its interval is as much wider: {}",
                    say(worst),
                    otherwise(swings.roles[worst.parameter])
                )),
                widths: asked.iter().map(|&i| (i, largest(i))).collect(),
                ..Disagreement::default()
            }
        }
    }
}

/// Recordings and their halves, as sets of blocks, with their names.
fn parts(swings: &Swings) -> (Vec<Vec<usize>>, Vec<String>) {
    let mut parts = Vec::new();
    let mut names = Vec::new();
    for (r, series) in swings.series.iter().enumerate() {
        let blocks = swings.blocks_of(r);
        let (first, second) = blocks.split_at(blocks.len() / 2);
        for (part, name) in [
            (&blocks[..], String::new()),
            (first, "the first half of ".into()),
            (second, "the second half of ".into()),
        ] {
            parts.push(part.to_vec());
            names.push(format!("{name}{}", series.name));
        }
    }
    (parts, names)
}

/// Disagreement between parts of the recordings.
#[derive(Default)]
pub struct Disagreement {
    /// A material one.
    pub fault: Option<String>,
    /// One that is clear, and not material.
    pub remark: Option<String>,
    /// Parameters and the largest differences of the latter, in prior standard deviations.
    pub widths: Vec<(usize, f64)>,
}

/// Possible causes of a disagreement in a parameter, the likeliest first, and the remedy.
fn otherwise(role: Role) -> &'static str {
    match role {
        Role::Damping | Role::Friction | Role::Efficiency => {
            "oil that was cold, or another machine; work for twenty minutes, then record both on the same day"
        }
        Role::AngleOffset(_) => {
            "a sensor that has moved, or another machine; fasten it, then record both again"
        }
        Role::Gain | Role::Links | Role::Inertia => {
            "a load that spills or was stated wrong, another machine, oil that was cold; weigh the load again, and record both on the same day with the machine warm"
        }
        _ => {
            "another machine, a sensor that has moved, oil that was cold, a load that spills or was stated wrong; record both on the same day with the machine warm"
        }
    }
}

/// Fault: the swings of a recording do not carry one load.
pub fn changing_load(name: &str, [low, high]: [f64; 2], has_empty: bool) -> String {
    let remedy = if has_empty {
        "record one weighed load in every swing"
    } else {
        "no recording with an empty bucket shows which swings carry it: add one, with --payload FILE=0, or record one weighed load in every swing"
    };
    format!(
        "the load of {name} changes from swing to swing, about {low:.0} to {high:.0} kg; {remedy}"
    )
}

/// Remark on inclined ground, which the fit compensates.
#[must_use]
pub fn ground(outcome: &Outcome) -> Vec<String> {
    let inclined = |(r, series): (usize, &Series)| {
        let [across, along] = [Role::Across(r), Role::Along(r)].map(|role| outcome.quantity(role));
        let slopes = [across?, along?];
        let is_clear = |q: &Quantity| q.value.abs() > CLEAR_SLOPE.max(4.0 * q.std);
        let [across, along] = slopes.map(|q| q.value.to_degrees());
        slopes.iter().any(is_clear).then(|| {
            format!(
                "{}: the ground is inclined, by {:.1} degrees; this is taken out, but level ground is better",
                series.name,
                (across * across + along * along).sqrt()
            )
        })
    };
    let series = outcome.swings.series.iter().enumerate();
    series.filter_map(inclined).collect()
}

/// Fault: a decisive length is not stated.
pub const GUESSED_PIN: &str = "the distance of the boom's foot from the swing axis is guessed from the operating mass, and a load of known mass fixes gain and masses only at a known radius; measure it with a tape and state machine.geometry.boom_pin";

/// Fault: there is only one load.
pub const ONE_LOAD: &str = "no two recordings have different stated loads: torque, damping, friction and masses could all be larger by one factor, and only a known mass fixes it. Record one run with an empty bucket and one with a weighed load, and state both: --payload FILE=0 --payload FILE=KG±KG";

/// Fault: a stated load contradicts the machine file.
pub fn misstated_load(d: &Doubt) -> String {
    let tolerances = match d.by_pressures {
        Some(_) => {
            "sensors.swing_torque_gain_std, machine.mass_tolerance, machine.boom_cylinder.span_std"
        }
        None => "sensors.swing_torque_gain_std, machine.mass_tolerance",
    };
    format!(
        "the load of {} was stated as {:.0} kg, but {}; weigh it again, or check which recording is which; if it is right, state larger tolerances ({tolerances})",
        d.name,
        d.stated.value,
        weighed(d)
    )
}

/// What the machine weighs.
fn weighed(d: &Doubt) -> String {
    let [motion, std] = [d.by_motion.value, d.by_motion.std];
    let motion = format!(
        "with the masses and the torque gain of the machine file it weighs {motion:.0} ± {std:.0} kg"
    );
    d.by_pressures.map_or(motion.clone(), |p| {
        format!(
            "{motion}, and by the boom's cylinders {:.0} ± {:.0} kg",
            p.value, p.std
        )
    })
}

/// Remark: the machine doubts a stated load.
pub fn doubtful_load(d: &Doubt) -> String {
    format!(
        "the load of {} was stated as {:.0} ± {:.0} kg, but {}; the intervals are wider by this doubt: weigh it again",
        d.name,
        d.stated.value,
        d.stated.std,
        weighed(d)
    )
}

/// Text about a direction that the data do not determine, with what to record.
#[must_use]
pub fn undetermined(swings: &Swings, direction: &Direction) -> String {
    let members = direction.members();
    let has = |role: Role| members.iter().any(|&i| swings.roles[i] == role);
    let remedy =
        if has(Role::Gain) && (has(Role::Links) || has(Role::Inertia) || has(Role::Damping)) {
            "record a run with an empty bucket and one with a heavier weighed load"
        } else if has(Role::Offset) {
            "record swings to both sides"
        } else if has(Role::Links) || has(Role::Inertia) {
            "record swings with the arm stretched out and with the arm folded in"
        } else if has(Role::Efficiency) {
            "record swings that the drive accelerates and brakes strongly"
        } else if has(Role::Damping) || has(Role::Friction) {
            "record slow swings and fast ones"
        } else if has(Role::Delay) {
            "record swings that begin and end sharply"
        } else if members
            .iter()
            .any(|&i| matches!(swings.roles[i], Role::Payload(_)))
        {
            "state the load of each recording: --payload FILE=KG±KG"
        } else {
            "record more swings"
        };
    direction.undetermined(&swings.parameters, remedy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_are_others_where_both_together_are_beyond_chance() {
        // Exceeded by chance as often as three deviations of one.
        let chance = (-0.5 * OTHER_MASSES[1]).exp();
        assert!((chance - 0.002_700).abs() < 1e-6, "{chance}");
        let are_others = |by: &[f64], correlation: f64| {
            let of = |i, j| if i == j { 1.0 } else { correlation };
            super::are_others(by, &Mat::from_fn(by.len(), by.len(), of))
        };
        assert!(are_others(&[3.1], 0.0) && !are_others(&[2.9], 0.0));
        assert!(are_others(&[2.9, 2.9], 0.0) && !are_others(&[3.1, 0.0], 0.0));
        // One is heavier by as much as the other is lighter, which swings hardly tell.
        assert!(!are_others(&[2.9, -2.9], -0.9) && are_others(&[2.9, 2.9], -0.9));
        assert!(!are_others(&[], 0.0));
    }

    #[test]
    fn one_share_of_a_load_may_be_all_that_swings_and_most_of_it_may_not() {
        let swings = Swings::new(Vec::new(), Vec::new(), &config::Excavator::default());
        let fixed = vec![false; swings.roles.len()];
        let far_at = |places: &dyn Fn(usize) -> f64| {
            let place = |role: &Role| match role {
                Role::Swinging(i) => places(*i),
                _ => 0.0,
            };
            let place: Vec<f64> = swings.roles.iter().map(place).collect();
            far(&swings, &place, &fixed)
        };
        // A quarter of the load at one rate, and three quarters of it in total.
        assert_eq!(
            far_at(&|i| if i == 5 { 5.5 } else { 0.0 }),
            Vec::<String>::new()
        );
        let hanging = far_at(&|_| 1.5);
        assert!(
            hanging.len() == 1 && hanging[0].contains("% of the load would swing"),
            "{hanging:?}"
        );
    }
}

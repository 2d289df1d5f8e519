//! Share of wrong values among the trusted: loaders of three sizes at work, with ordinary physical effects that no description
//! contains, one at a time and all together.
//!
//! JSON: [`crate::honesty::json`]. Every machine has the tolerances of tier B; the estimator receives the data sheet, with noises
//! and floors scaled with the size, and the default of everything else. The loaders reverse as in real work. One that never
//! reverses does not show how its tyres deflect under a load, so its ratio is not trusted.

use estimation::Quantity;
use estimation::loader::{Estimate, Method, Settings};
use sim::loader::{CASES, Effects, PayloadReport, Row, Run, Size, Tier};

use super::candidate::Candidate;
use super::trial;
use crate::honesty::{JudgedRow, Line, Tally, json, text};
use crate::{Error, Options, Report, seeds};

/// Length of a record [s].
const DURATION: f64 = 120.0;
/// True speed above which the machine moves [m/s].
pub(super) const MOVING: f64 = 0.1;
/// Payload of a load cycle, as a share of the machine's mass.
const PAYLOAD: f64 = 0.25;

/// Targets of a line: least trusted share of the moving time, least coverage of all rows.
type Requirement = (f64, f64);

fn requirement(effect: &str) -> Requirement {
    match effect {
        "none" => (0.65, 0.93),
        "good machine" => (0.50, 0.93),
        _ => (0.0, 0.0),
    }
}

/// Name of the line of machines with random effects, and its largest share of wrong.
const BY_CHANCE: (&str, f64) = ("by chance", 0.10);

/// Name of the line of machines that never reverse.
const ONE_WAY: &str = "one way only";

/// Name of the line of a slope sensor with stated delay and acceleration sensitivity.
const CALIBRATED: &str = "slope sensor, calibrated";

/// Scales the default to the statements of a competent user for a machine of that size.
pub(super) fn scale(settings: &mut Settings, size: Size) {
    let (machine, reference) = (size.machine(), Size::Reference.machine());
    let heavy = machine.mass / reference.mass;
    let tall = machine.cg_height / reference.cg_height;
    let torque = heavy * machine.wheel_radius / reference.wheel_radius;
    settings.machine.relaxation_length = 0.12;
    settings.prior.cg_height_std *= tall;
    settings.prior.spade_force_std *= heavy;
    let keys = &mut settings.estimator;
    keys.excited_torque *= torque;
    keys.cg_height_floor *= tall;
    keys.converged_height *= tall;
    keys.q_spade_force *= heavy;
    keys.q_cg_height *= tall;
    keys.dig_force *= heavy;
    keys.cg_height_max *= tall;
}

/// A machine of one of the three sizes with these effects, reversing or not.
fn work(effects: Effects, reverses: bool, seed: u64) -> Run {
    let size = Size::REAL[(seed as usize - 1) % Size::REAL.len()];
    let loads = effects.payload_reported != PayloadReport::All;
    Run {
        seed,
        tier: Tier::B,
        size,
        duration: Some(DURATION),
        payload: loads.then(|| PAYLOAD * size.machine().mass),
        ..Run::at_work(Effects {
            reverses,
            ..effects
        })
    }
}

/// The judged methods, on the same rows.
const METHODS: [Method; 2] = [Method::Full, Method::FullEkf];

/// Runs the default filters; `adjust` changes their settings, `look` receives each answer with the index of its method.
fn drive(
    run: &Run,
    adjust: impl Fn(&mut Settings),
    look: impl FnMut(usize, &Row, &Estimate),
) -> Result<(), Error> {
    let candidates = METHODS.map(|method| Candidate::DATA_SHEET.by(method));
    let adjust = |settings: &mut Settings| {
        scale(settings, run.size);
        adjust(settings);
    };
    trial::each_row_adjusted(run, &candidates, adjust, look)
}

/// Counts of ratio and height for each method.
fn tally(run: &Run, calibrated: bool) -> Result<[[Tally; 2]; 2], Error> {
    let mut tallies: [[Tally; 2]; 2] = Default::default();
    let adjust = |settings: &mut Settings| {
        if calibrated {
            settings.sensors.slope_delay = run.effects.slope_lag;
            settings.sensors.slope_acceleration_sensitivity = run.effects.slope_follows;
        }
    };
    drive(run, adjust, |k, row, estimate| {
        for (tally, judged) in tallies[k].iter_mut().zip(judge(row, estimate)) {
            tally.push(&judged);
        }
    })?;
    Ok(tallies)
}

/// Rows of ratio and height.
pub(super) fn judge(row: &Row, estimate: &Estimate) -> [JudgedRow; 2] {
    let moving = row.truth.speed.abs() > MOVING;
    let judged = |truth: f64, quantity: Quantity, trusted: bool| JudgedRow {
        truth,
        estimate: quantity.value,
        std: quantity.std,
        trusted,
        moving,
        reason: estimate.reason.name(),
    };
    let (truth, e) = (&row.truth, estimate);
    [
        judged(truth.cg_ratio, e.cg_ratio, e.trusted_ratio),
        judged(truth.cg_height, e.cg_height, e.trusted_height),
    ]
}

/// Every effect at every severity, ratio and height; the sizes alternate with the seeds.
pub(super) fn evaluate(options: &Options) -> Result<Report, Error> {
    let mut lines = Vec::new();
    let listed = CASES.map(|(effect, severity, effects)| match (effect, severity) {
        ("reversing", "") => (ONE_WAY, "", Some(effects)),
        ("reversing", "radius sensitivity -.005") => ("radius sensitivity", "-.005", Some(effects)),
        _ => (effect, severity, Some(effects)),
    });
    let slope = listed.iter().find(|line| line.0 == "slope sensor follows");
    let calibrated = slope.map(|&(_, severity, effects)| (CALIBRATED, severity, effects));
    let more = calibrated.into_iter().chain([(BY_CHANCE.0, "", None)]);
    for (effect, severity, effects) in listed.into_iter().chain(more) {
        let found = seeds(options, &format!("{effect} {severity}"), |seed| {
            let effects = effects.unwrap_or_else(|| Effects::by_chance(seed));
            let run = work(effects, effect != ONE_WAY, seed);
            tally(&run, effect == CALIBRATED)
        })?;
        for (k, method) in METHODS.into_iter().enumerate() {
            for (i, what) in ["ratio", "height"].into_iter().enumerate() {
                let mut sum = Tally::default();
                found.iter().for_each(|both| sum.add(&both[k][i]));
                let what = match method {
                    Method::Full => what.to_owned(),
                    other => format!("{what}, {other}"),
                };
                let mut line = Line::new(effect, severity, &what, sum);
                (line.least_trusted, line.least_covered) = requirement(effect);
                if effect == BY_CHANCE.0 {
                    line.allowed = BY_CHANCE.1;
                }
                lines.push(line);
            }
        }
    }
    Ok(Report {
        text: format!(
            "Loaders at work that are not what their description says, {} seeds of {DURATION} s\n{}",
            options.seeds,
            text(&lines)
        ),
        json: json(&lines),
        met: lines.iter().all(Line::met),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::fault::Fault;
    use statistics::judge::is_covered;

    fn effects(name: &str, severity: &str) -> Effects {
        let found = CASES.into_iter().find(|c| (c.0, c.1) == (name, severity));
        found.unwrap().2
    }

    #[test]
    fn a_late_speed_is_learnt_and_nothing_wrong_is_trusted() {
        for [ratio, height] in
            tally(&work(effects("late speed", "100 ms"), true, 1), false).unwrap()
        {
            assert!(ratio.trusted() > 0.5, "{}", ratio.trusted());
            assert!(ratio.wrong() <= 0.05, "{}", ratio.wrong());
            assert!(ratio.covered() > 0.93 && height.covered() > 0.93);
        }
    }

    #[test]
    fn a_loader_that_reverses_learns_how_its_radii_give_and_stays_honest() {
        for seed in 1..=3 {
            let run = work(effects("reversing", "radius sensitivity -.005"), true, seed);
            for [ratio, height] in tally(&run, false).unwrap() {
                assert!(ratio.trusted() > 0.4, "{seed}: {}", ratio.trusted());
                assert!(ratio.wrong() <= 0.05, "{seed}: {}", ratio.wrong());
                assert!(ratio.covered() > 0.93, "{seed}: {}", ratio.covered());
                assert_eq!(height.trusted(), 0.0, "{seed}");
            }
        }
    }

    #[test]
    fn a_load_sensitivity_that_is_known_exactly_opens_nothing_when_the_loader_reverses() {
        let run = work(effects("reversing", "radius sensitivity -.005"), true, 1);
        // Largest increase of the height's standard deviation from row to row, around the time when the loader has been driven
        // both ways [m].
        let growth = |adjust: fn(&mut Settings)| {
            let (mut last, mut most, mut ways) = ([f64::INFINITY; 2], 0.0, [0; 2]);
            drive(&run, adjust, |k, row, estimate| {
                if row.truth.speed.abs() > 0.5 {
                    ways[usize::from(row.truth.speed > 0.0)] += 1;
                }
                let (std, rows) = (estimate.cg_height.std, ways[0].min(ways[1]) / METHODS.len());
                if (50..200).contains(&rows) {
                    most = f64::max(most, std - last[k]);
                }
                last[k] = std;
            })
            .unwrap();
            most
        };
        let known = growth(|settings| {
            settings.machine.radius_load_sensitivity_std = 0.0;
            settings.estimator.load_sensitivity_floor = 0.0;
        });
        let unknown = growth(|_| ());
        assert!(unknown > 0.03 && known < 0.003, "{unknown} {known}");
    }

    #[test]
    fn unsteady_slip_and_unstated_brakes_leave_trust_and_nothing_wrong_in_it() {
        for (effect, severity) in [
            ("rough road", "ISO 8608 D"),
            ("jitter", "10 ms"),
            ("brakes, not stated", "50 %"),
        ] {
            let run = work(effects(effect, severity), true, 4);
            for [ratio, _] in tally(&run, false).unwrap() {
                let (trusted, reason) = (ratio.trusted(), ratio.reason());
                assert!(trusted > 0.4, "{effect}: {trusted} {reason:?}");
                assert!(ratio.wrong() <= 0.05, "{effect}: {}", ratio.wrong());
                assert!(ratio.covered() > 0.93, "{effect}: {}", ratio.covered());
            }
        }
    }

    #[test]
    fn the_interval_of_the_digging_force_contains_what_else_acts_along_the_road() {
        for (effect, severity, effects) in CASES {
            let (mut rows, mut covered) = (0, 0);
            let run = work(effects, true, 2);
            drive(
                &run,
                |_| (),
                |_, row, estimate| {
                    let force = estimate.spade_force_x.expect("a state of both methods");
                    rows += 1;
                    covered +=
                        u32::from(is_covered(force.value, force.std, row.truth.spade_force_x));
                },
            )
            .unwrap();
            let covered = f64::from(covered) / f64::from(rows);
            assert!(covered > 0.95, "{effect} {severity}: {covered}");
        }
    }

    #[test]
    fn the_mass_of_a_load_is_enough_where_no_boom_motion_is_reported() {
        let run = work(effects("payload", "mass stated"), true, 13);
        for [ratio, _] in tally(&run, false).unwrap() {
            assert!(ratio.trusted() > 0.3, "{}", ratio.trusted());
            assert!(ratio.wrong() <= 0.05, "{}", ratio.wrong());
            assert!(ratio.covered() > 0.93, "{}", ratio.covered());
        }
    }

    #[test]
    fn a_machine_that_straightens_out_of_a_curve_learns_no_ratio_from_it() {
        // Machines of 20 t whose first evaluated rows follow a curve.
        for seed in [9, 15] {
            let run = work(effects("good machine", "all a little"), true, seed);
            for [ratio, _] in tally(&run, false).unwrap() {
                assert!(ratio.trusted() > 0.4, "{seed}: {}", ratio.trusted());
                assert!(ratio.wrong() <= 0.05, "{seed}: {}", ratio.wrong());
                assert!(ratio.covered() > 0.93, "{seed}: {}", ratio.covered());
            }
        }
    }

    #[test]
    fn axles_that_are_locked_are_named_and_nothing_is_trusted() {
        for seed in 1..=3 {
            let [both, by_tangent] =
                tally(&work(effects("locked drive", ""), true, seed), false).unwrap();
            for quantity in both.into_iter().chain(by_tangent) {
                assert_eq!(quantity.trusted(), 0.0);
                assert!(quantity.covered() > 0.93, "{}", quantity.covered());
                let (reason, share) = quantity.reason().unwrap();
                assert!(reason == "locked drive" && share > 0.5, "{reason} {share}");
            }
        }
    }

    #[test]
    fn a_signal_that_is_lost_or_never_changes_is_named_and_nothing_is_trusted() {
        for (fault, reason) in [
            ("front_torque:missing,from=40,to=50", "missing"),
            ("rear_torque:missing,from=40,to=50", "missing"),
            ("slope:missing,from=40,to=50", "missing"),
            ("acceleration:missing,from=40,to=50", "missing"),
            ("front_wheel_speed:hold,from=40,to=50", "stuck front wheel"),
            ("rear_wheel_speed:hold,from=40,to=50", "stuck rear wheel"),
            ("speed:hold,from=40,to=50", "stuck speed"),
            ("acceleration:hold,from=40,to=50", "stuck acceleration"),
        ] {
            let run = Run {
                faults: vec![Fault::parse(fault).unwrap()],
                duration: Some(70.0),
                ..work(effects("none", ""), true, 2)
            };
            let (mut named, mut wrong) = (0, 0);
            drive(
                &run,
                |_| (),
                |_, row, estimate| {
                    let gone = (40.6..49.9).contains(&row.time) && row.truth.speed > 1.0;
                    if gone {
                        assert!(!estimate.fresh, "{fault} at {}", row.time);
                        assert!(!estimate.trusted_ratio && !estimate.trusted_height);
                        named += u32::from(estimate.reason.name() == reason);
                    }
                    let away = (estimate.cg_ratio.value / row.truth.cg_ratio - 1.0).abs();
                    wrong += u32::from(estimate.trusted_ratio && away > 0.1);
                },
            )
            .unwrap();
            assert!(named > 1000 && wrong == 0, "{fault}: {named}, {wrong}");
        }
    }
}

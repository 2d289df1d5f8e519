//! A sensor of an excavator fails permanently during work: its values are not trusted, and the reason is reported.

mod estimates;

use config::Excavator;
use estimation::excavator::{Estimate, Method, Reason, Settings};
use evaluate::excavator::honesty_lines::described;
use sim::excavator::{Effects, Row, Run, Scenario, Simulation, Size, Work};

/// Begin of the fault [s], and number of rows of the work.
const FROM: f64 = 28.0;
const ROWS: usize = 6000;

/// Each row of a machine with its estimate. `wrong` changes the rows from the fault on.
fn estimates(seed: u64, wrong: impl Fn(&mut Row)) -> Vec<(Row, Estimate)> {
    let sizes = [Size::t13(), Size::t22(), Size::t36(), Size::reference()];
    let work = Work::new(sizes[seed as usize % 4], Effects::default(), seed);
    let settings = Settings::of(&described(&work));
    let rows = work.take(ROWS).map(|mut row| {
        if row.time >= FROM {
            wrong(&mut row);
        }
        row
    });
    estimates::estimates(rows, &settings, Method::Auto)
}

#[test]
fn a_joint_that_jumps_is_not_trusted_any_more_and_named() {
    for seed in 0..4 {
        for joint in 0..3 {
            for offset in [-0.4, 0.15] {
                let estimates = estimates(seed, |row| {
                    row.posture[joint] = row.posture[joint].map(|angle| angle + offset);
                });
                for (row, e) in estimates.iter().filter(|(row, _)| row.time > FROM + 0.25) {
                    let said = !e.flags.trusted() && e.reason == Reason::Jump;
                    assert!(said, "seed {seed}, joint {joint}, {} s: {e:?}", row.time);
                }
            }
        }
    }
}

#[test]
fn a_torque_or_velocity_that_is_wrong_by_a_factor_is_contradicted_within_a_cycle_and_then_the_interval_holds()
 {
    for seed in 0..4 {
        for gain in [0.5, 0.8, 2.0] {
            for velocity in [false, true] {
                let estimates = estimates(seed, |row| {
                    let wrong = |value: Option<f64>| value.map(|v| gain * v);
                    if velocity {
                        row.swing_velocity = wrong(row.swing_velocity);
                    } else {
                        row.swing_torque = wrong(row.swing_torque);
                    }
                });
                let later = estimates.iter().filter(|(row, _)| row.time > FROM + 14.0);
                for (row, e) in later.filter(|(_, e)| e.flags.trusted()) {
                    let away = (e.inertia - row.truth.inertia).abs();
                    assert!(
                        away < 3.0 * e.inertia_std || away < 0.04 * row.truth.inertia,
                        "seed {seed}, gain {gain}, velocity {velocity}, {} s: {e:?}",
                        row.time
                    );
                }
                let contradicted = estimates
                    .iter()
                    .filter(|(_, e)| e.reason == Reason::Contradiction);
                let mut rows = 0;
                for (row, e) in contradicted {
                    let away = (e.inertia - row.truth.inertia).abs();
                    assert!(
                        away < 1.96 * e.inertia_std,
                        "seed {seed}, gain {gain}, velocity {velocity}, {} s: {e:?}",
                        row.time
                    );
                    rows += 1;
                }
                // An emptied bucket that weighs less may be another bucket: then the reason names it, and no row is trusted.
                let mut later = estimates.iter().filter(|(row, _)| row.time > FROM);
                let another = later.clone().any(|(_, e)| e.reason == Reason::Attachment)
                    && later.all(|(_, e)| !e.flags.trusted());
                assert!(
                    rows > 0 || another,
                    "seed {seed}, gain {gain}, velocity {velocity}"
                );
            }
        }
    }
}

#[test]
fn nothing_contradicts_a_sound_machine() {
    for seed in 0..4 {
        let estimates = estimates(seed, |_| {});
        let against = [Reason::Jump, Reason::Contradiction];
        assert!(estimates.iter().all(|(_, e)| !against.contains(&e.reason)));
        let moving = |row: &Row| row.truth.velocity.abs() > 0.05;
        let moves = estimates.iter().filter(|(row, _)| moving(row)).count();
        let trusted = estimates.iter().filter(|(_, e)| e.flags.trusted()).count();
        assert!(trusted * 10 > moves * 7, "{trusted} of {moves}");
    }
}

#[test]
fn a_signal_that_is_away_for_ten_seconds_is_trusted_again_soon_after_it_is_back() {
    /// End of the loss of the signal [s].
    const BACK: f64 = FROM + 10.0;
    for seed in 0..4 {
        for signal in 0..4 {
            let estimates = estimates(seed, |row| match signal {
                _ if row.time >= BACK => {}
                3 => row.swing_torque = None,
                joint => row.posture[joint] = None,
            });
            let held = |(row, e): &&(Row, Estimate)| {
                (e.inertia - row.truth.inertia).abs() <= 1.96 * e.inertia_std
            };
            let covered = estimates.iter().filter(held).count();
            assert!(
                covered * 100 > estimates.len() * 97,
                "seed {seed}, signal {signal}: {covered}"
            );
            let later = estimates.iter().filter(|(row, _)| row.time > BACK + 6.0);
            let swings = later.filter(|(row, _)| row.truth.velocity.abs() > 0.05);
            let (mut rows, mut trusted) = (0, 0);
            for (_, e) in swings {
                rows += 1;
                trusted += u32::from(e.flags.trusted());
                assert_ne!(
                    e.reason,
                    Reason::Contradiction,
                    "seed {seed}, signal {signal}"
                );
            }
            assert!(
                trusted * 10 > rows * 6,
                "seed {seed}, signal {signal}: {trusted} of {rows}"
            );
        }
    }
}

#[test]
fn a_boom_angle_that_is_half_a_second_late_is_hardly_ever_trusted_and_wrong() {
    const LATE: usize = 50;
    let settings = Settings::of(&Excavator::default());
    let (mut trusted, mut wrong) = (0, 0);
    for seed in 1..25 {
        let mut run = Run::new(Scenario::Cycle);
        (run.duration, run.seed) = (60.0, seed);
        let rows: Vec<Row> = Simulation::new(&run).expect("a run").collect();
        let late = rows.iter().enumerate().map(|(k, row)| {
            let mut row = *row;
            row.posture[0] = rows[k.saturating_sub(LATE)].posture[0];
            row
        });
        let estimates = estimates::estimates(late, &settings, Method::Auto);
        for (row, e) in estimates.iter().filter(|(_, e)| e.flags.trusted()) {
            let away = (e.inertia - row.truth.inertia).abs();
            trusted += 1;
            wrong += i32::from(away > (1.96 * e.inertia_std).min(0.1 * row.truth.inertia));
        }
    }
    assert!(
        trusted > 100 && wrong * 20 <= trusted,
        "{wrong} of {trusted}"
    );
}

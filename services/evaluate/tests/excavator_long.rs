//! An excavator works for an hour and a half: what was trusted in the first minutes is trusted in the last ones.

use estimation::excavator::{Columns, Method, Sample, Settings, SwingEstimator};
use evaluate::excavator::honesty_lines::{describe_boom_cylinder, described};
use sim::excavator::{Effects, Size, Work};
use statistics::judge::{JudgedRow, Tally};

const COLUMNS: Columns = Columns {
    velocity: true,
    angle: false,
    torque: true,
    posture: true,
};
/// Rows of the work, and how many of them are judged at the end.
const ROWS: usize = 540_000;
const LAST: usize = 120_000;

/// What is said of the last rows.
fn last(size: Size, seed: u64, has_pressures: bool) -> Tally {
    let mut work = Work::new(size, Effects::default(), seed);
    if has_pressures {
        work = work.with_gauges(seed);
    }
    let mut description = described(&work);
    describe_boom_cylinder(&mut description, &work);
    let settings = Settings::of(&description);
    let mut estimator =
        SwingEstimator::new(&settings, Method::Auto, COLUMNS).expect("an estimator");
    let mut tally = Tally::default();
    for (n, row) in work.take(ROWS).enumerate() {
        let [head, rod, ..] = row.pressures;
        let estimate = estimator.step(&Sample {
            time: row.time,
            velocity: row.swing_velocity,
            torque: row.swing_torque,
            posture: row.posture,
            boom_head_pressure: head,
            boom_rod_pressure: rod,
            ..Sample::default()
        });
        if n >= ROWS - LAST {
            tally.push(&JudgedRow {
                truth: row.truth.inertia,
                estimate: estimate.inertia,
                std: estimate.inertia_std,
                trusted: estimate.flags.trusted(),
                moving: row.truth.velocity.abs() > 0.05,
                reason: "",
            });
        }
    }
    tally
}

#[test]
fn what_was_learnt_of_the_machine_does_not_wander_off_in_hours() {
    for has_pressures in [false, true] {
        for (size, seed) in [Size::t13(), Size::t22(), Size::t36()].into_iter().zip(1..) {
            let tally = last(size, seed, has_pressures);
            let said = format!("seed {seed}, pressures {has_pressures}: {tally:?}");
            assert!(tally.trusted() > 0.8, "{said}");
            assert!(tally.wrong() <= 0.05 && tally.covered() > 0.93, "{said}");
        }
    }
}

//! An excavator works for an hour and a half, or stands for a while: what was trusted in the first minutes is trusted in the last ones.

use estimation::excavator::{Columns, Method, Sample, Settings, SwingEstimator};
use evaluate::excavator::honesty_lines::{describe_boom_cylinder, described};
use sim::excavator::{Effects, Row, Size, Work};
use sim::noise::Noise;
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

/// Work before and after a stand, and the stand, in rows: 5 and 20 minutes.
const SHIFT: usize = 30_000;
const STAND: usize = 120_000;
/// Noise of a joint angle [rad], of a pressure [Pa].
const ANGLE: f64 = 1e-3;
const PRESSURE: f64 = 50e3;

/// The machine stands as it does in this row, its engine and its sensors on.
fn stands(work: &Work, row: &Row, noise: &mut Noise) -> Row {
    let size = work.size();
    let mut normal = |std: f64| std * noise.normal();
    Row {
        swing_velocity: Some(normal(size.gyro_noise)),
        swing_torque: Some(normal(size.torque_noise)),
        posture: row.posture.map(|angle| angle.map(|a| a + normal(ANGLE))),
        pressures: row.pressures.map(|p| p.map(|p| p + normal(PRESSURE))),
        ..*row
    }
}

/// What is said of work with pressures after a stand.
fn after_a_stand(size: Size, seed: u64) -> Tally {
    let work = Work::new(size, Effects::default(), seed).with_gauges(seed);
    let mut description = described(&work);
    describe_boom_cylinder(&mut description, &work);
    let settings = Settings::of(&description);
    let mut estimator =
        SwingEstimator::new(&settings, Method::Auto, COLUMNS).expect("an estimator");
    let mut step = |n: usize, row: &Row| {
        let [head, rod, ..] = row.pressures;
        estimator.step(&Sample {
            time: n as f64 * 0.01,
            velocity: row.swing_velocity,
            torque: row.swing_torque,
            posture: row.posture,
            boom_head_pressure: head,
            boom_rod_pressure: rod,
            ..Sample::default()
        })
    };
    let mut rows = work.clone();
    let is_at_rest =
        |row: &Row| row.truth.velocity == 0.0 && row.truth.payload < 0.1 * work.size().rated;
    let mut last = None;
    let mut n = 0;
    while n < SHIFT || !last.is_some_and(|row| is_at_rest(&row)) {
        last = rows.next();
        if let Some(row) = &last {
            step(n, row);
        }
        n += 1;
    }
    let (held, mut noise) = (last.expect("a row"), Noise::new(seed));
    for _ in 0..STAND {
        step(n, &stands(&work, &held, &mut noise));
        n += 1;
    }
    let mut tally = Tally::default();
    for row in rows.take(SHIFT) {
        let estimate = step(n, &row);
        n += 1;
        tally.push(&JudgedRow {
            truth: row.truth.inertia,
            estimate: estimate.inertia,
            std: estimate.inertia_std,
            trusted: estimate.flags.trusted(),
            moving: row.truth.velocity.abs() > 0.05,
            reason: "",
        });
    }
    tally
}

#[test]
fn a_machine_that_stands_with_its_engine_on_is_trusted_when_it_works_again() {
    for (size, seed) in [Size::t13(), Size::t22(), Size::t36()].into_iter().zip(1..) {
        let tally = after_a_stand(size, seed);
        let said = format!("seed {seed}: {tally:?}");
        assert!(tally.trusted() > 0.8, "{said}");
        assert!(tally.wrong() <= 0.05 && tally.covered() > 0.93, "{said}");
    }
}

/// Work before a fault, the fault, and the work after it that is judged once five minutes have passed, in rows.
const BEFORE: usize = 60_000;
const FAULT: usize = 18_000;
const AFTER: usize = 90_000;

/// A row of a machine with a sensor that is wrong.
type Fault = fn(&mut Row);

const FAULTS: [(&str, bool, Fault); 4] = [
    ("torque x 1.25", false, |row| {
        row.swing_torque = row.swing_torque.map(|torque| 1.25 * torque);
    }),
    ("torque x .8", true, |row| {
        row.swing_torque = row.swing_torque.map(|torque| 0.8 * torque);
    }),
    ("velocity x 1.2", false, |row| {
        row.swing_velocity = row.swing_velocity.map(|velocity| 1.2 * velocity);
    }),
    ("head pressure x 1.5", true, |row| {
        row.pressures[0] = row.pressures[0].map(|pressure| 1.5 * pressure);
    }),
];

/// What is said of the work while a sensor is wrong, and after that.
fn with_fault(size: Size, seed: u64, has_pressures: bool, fault: Fault) -> [Tally; 2] {
    let mut work = Work::new(size, Effects::default(), seed);
    if has_pressures {
        work = work.with_gauges(seed);
    }
    let mut description = described(&work);
    describe_boom_cylinder(&mut description, &work);
    let settings = Settings::of(&description);
    let mut estimator =
        SwingEstimator::new(&settings, Method::Auto, COLUMNS).expect("an estimator");
    let mut tallies = [Tally::default(), Tally::default()];
    for (n, mut row) in work.take(BEFORE + FAULT + AFTER).enumerate() {
        let is_wrong = (BEFORE..BEFORE + FAULT).contains(&n);
        if is_wrong {
            fault(&mut row);
        }
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
        let judged = JudgedRow {
            truth: row.truth.inertia,
            estimate: estimate.inertia,
            std: estimate.inertia_std,
            trusted: estimate.flags.trusted(),
            moving: row.truth.velocity.abs() > 0.05,
            reason: "",
        };
        if is_wrong {
            tallies[0].push(&judged);
        } else if n > BEFORE + FAULT + SHIFT {
            tallies[1].push(&judged);
        }
    }
    tallies
}

#[test]
fn a_fault_that_passes_does_not_end_trust() {
    for (name, has_pressures, fault) in FAULTS {
        for (size, seed) in [Size::t13(), Size::t22(), Size::t36()].into_iter().zip(1..) {
            let [during, after] = with_fault(size, seed, has_pressures, fault);
            let said = format!("{name}, seed {seed}: {during:?}, {after:?}");
            assert!(during.trusted() * during.wrong() < 0.1, "{said}");
            assert!(after.trusted() > 0.8, "{said}");
            assert!(after.wrong() <= 0.05 && after.covered() > 0.93, "{said}");
        }
    }
}

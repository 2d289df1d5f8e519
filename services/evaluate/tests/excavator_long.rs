//! An excavator works for an hour and a half, stands for a while, or has a temporary fault: the estimates of the last minutes
//! are trusted as in the first ones.

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
/// Machines and their seeds.
const MACHINES: [(fn() -> Size, u64); 3] = [(Size::t13, 1), (Size::t22, 2), (Size::t36, 3)];

/// An estimator with the settings that a competent user states.
struct Estimator(SwingEstimator);

impl Estimator {
    fn of(work: &Work) -> Self {
        let mut description = described(work);
        describe_boom_cylinder(&mut description, work);
        let settings = Settings::of(&description);
        Self(SwingEstimator::new(&settings, Method::Auto, COLUMNS).expect("an estimator"))
    }

    /// Takes a row at this time \[s\].
    fn step(&mut self, time: f64, row: &Row) -> JudgedRow {
        let [head, rod, ..] = row.pressures;
        let estimate = self.0.step(&Sample {
            time,
            velocity: row.swing_velocity,
            torque: row.swing_torque,
            posture: row.posture,
            boom_head_pressure: head,
            boom_rod_pressure: rod,
            ..Sample::default()
        });
        JudgedRow {
            truth: row.truth.inertia,
            estimate: estimate.inertia,
            std: estimate.inertia_std,
            trusted: estimate.flags.trusted(),
            moving: row.truth.velocity.abs() > 0.05,
            reason: "",
        }
    }
}

fn working(size: Size, seed: u64, has_pressures: bool) -> Work {
    let work = Work::new(size, Effects::default(), seed);
    if has_pressures {
        work.with_gauges(seed)
    } else {
        work
    }
}

fn assert_is_trusted(tally: &Tally, said: &str) {
    assert!(tally.trusted() > 0.8, "{said}");
    assert!(tally.wrong() <= 0.05 && tally.covered() > 0.93, "{said}");
}

/// Number of rows of the work, and of those at its end that are judged.
const ROWS: usize = 540_000;
const LAST: usize = 120_000;

#[test]
fn what_was_learnt_of_the_machine_does_not_wander_off_in_hours() {
    for has_pressures in [false, true] {
        for (size, seed) in MACHINES {
            let work = working(size(), seed, has_pressures);
            let mut estimator = Estimator::of(&work);
            let mut tally = Tally::default();
            for (n, row) in work.take(ROWS).enumerate() {
                let judged = estimator.step(row.time, &row);
                if n >= ROWS - LAST {
                    tally.push(&judged);
                }
            }
            let said = format!("seed {seed}, pressures {has_pressures}: {tally:?}");
            assert_is_trusted(&tally, &said);
        }
    }
}

/// Number of rows of the work before and after a stand (5 minutes), and of the stand (20 minutes).
const SHIFT: usize = 30_000;
const STAND: usize = 120_000;
/// Standard deviation of the noise of a joint angle [rad], and of a pressure [Pa].
const ANGLE: f64 = 1e-3;
const PRESSURE: f64 = 50e3;

/// A row of the machine at rest in the state of `row`, with engine and sensors on.
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

/// Judgement of the work with pressures after a stand.
fn after_a_stand(size: Size, seed: u64) -> Tally {
    let work = working(size, seed, true);
    let mut estimator = Estimator::of(&work);
    let mut n = 0;
    let mut step = |row: &Row| {
        let judged = estimator.step(n as f64 * 0.01, row);
        n += 1;
        (n, judged)
    };
    let mut rows = work.clone();
    let is_at_rest =
        |row: &Row| row.truth.velocity == 0.0 && row.truth.payload < 0.1 * work.size().rated;
    let held = loop {
        let row = rows.next().expect("a row");
        let (n, _) = step(&row);
        if n >= SHIFT && is_at_rest(&row) {
            break row;
        }
    };
    let mut noise = Noise::new(seed);
    for _ in 0..STAND {
        step(&stands(&work, &held, &mut noise));
    }
    let mut tally = Tally::default();
    for row in rows.take(SHIFT) {
        tally.push(&step(&row).1);
    }
    tally
}

#[test]
fn a_machine_that_stands_with_its_engine_on_is_trusted_when_it_works_again() {
    for (size, seed) in MACHINES {
        let tally = after_a_stand(size(), seed);
        assert_is_trusted(&tally, &format!("seed {seed}: {tally:?}"));
    }
}

/// Number of rows before a fault, during it and after it. Rows later than [`SHIFT`] after its end are judged.
const BEFORE: usize = 60_000;
const FAULT: usize = 18_000;
const AFTER: usize = 90_000;

/// Falsifies a sensor in a row.
type Fault = fn(&mut Row);

/// Faults, and whether the machine has pressures.
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

/// Judgement of the work while a sensor is wrong, and after that.
fn with_fault(work: Work, fault: Fault) -> [Tally; 2] {
    let mut estimator = Estimator::of(&work);
    let [mut during, mut after] = [Tally::default(), Tally::default()];
    for (n, mut row) in work.take(BEFORE + FAULT + AFTER).enumerate() {
        let is_wrong = (BEFORE..BEFORE + FAULT).contains(&n);
        if is_wrong {
            fault(&mut row);
        }
        let judged = estimator.step(row.time, &row);
        if is_wrong {
            during.push(&judged);
        } else if n > BEFORE + FAULT + SHIFT {
            after.push(&judged);
        }
    }
    [during, after]
}

#[test]
fn a_fault_that_passes_does_not_end_trust() {
    for (name, has_pressures, fault) in FAULTS {
        for (size, seed) in MACHINES {
            let work = working(size(), seed, has_pressures);
            let [during, after] = with_fault(work, fault);
            let said = format!("{name}, seed {seed}: {during:?}, {after:?}");
            assert!(during.trusted() * during.wrong() < 0.1, "{said}");
            assert_is_trusted(&after, &said);
        }
    }
}

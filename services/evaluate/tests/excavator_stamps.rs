//! Jitter of the time stamps, or rows in bursts: no wrong estimate is trusted, and trust is not lost.

mod estimates;

use estimation::excavator::{Estimate, Method, Settings};
use evaluate::excavator::honesty_lines::described;
use sim::excavator::{Effects, Row, Size, Work};

/// A minute of work [rows].
const ROWS: usize = 6000;
/// Rows of a burst, and the time between them [s].
const BURST: usize = 4;
const CLOSE: f64 = 2e-4;

/// Estimates of the rows of a machine with new time stamps.
fn estimates(seed: u64, jitter: f64, stamped: impl Fn(usize, f64) -> f64) -> Vec<(Row, Estimate)> {
    let sizes = [Size::t13(), Size::t22(), Size::t36(), Size::reference()];
    let effects = Effects {
        jitter,
        ..Effects::default()
    };
    let work = Work::new(sizes[seed as usize % 4], effects, seed);
    let settings = Settings::of(&described(&work));
    let rows = work.take(ROWS).enumerate().map(|(k, row)| Row {
        time: stamped(k, row.time),
        ..row
    });
    estimates::estimates(rows, &settings, Method::Auto)
}

fn trusted(estimates: &[(Row, Estimate)]) -> usize {
    estimates.iter().filter(|(_, e)| e.flags.trusted()).count()
}

#[test]
fn stamps_that_jitter_or_come_in_bursts_are_no_times() {
    for seed in 0..4 {
        let steady = trusted(&estimates(seed, 0.0, |_, time| time));
        let burst = |k: usize, _| (k / BURST * BURST) as f64 * 0.01 + (k % BURST) as f64 * CLOSE;
        for (kind, estimates) in [
            ("jitter", estimates(seed, 0.01, |_, time| time)),
            ("bursts", estimates(seed, 0.0, burst)),
        ] {
            let share = trusted(&estimates) as f64 / steady as f64;
            assert!(share > 0.9, "seed {seed}, {kind}: {share}");
            let outside = estimates.iter().filter(|(row, e)| {
                let away = (e.inertia - row.truth.inertia).abs();
                e.flags.trusted() && away > 1.96 * e.inertia_std
            });
            let wrong = outside.count() as f64 / trusted(&estimates) as f64;
            assert!(wrong < 0.05, "seed {seed}, {kind}: {wrong}");
        }
    }
}

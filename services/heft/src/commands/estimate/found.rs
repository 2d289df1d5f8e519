//! What the estimates of one input say in sum, as JSON: what a table of many inputs is made of.

use std::path::Path;

use serde_json::{Value, json};
use view::estimate::Estimate;

use crate::failure::Failure;
use crate::results;

/// What is reported of one quantity.
#[derive(Clone, Copy, Default)]
struct HeadlineTally {
    /// Rows that were trusted; of those in motion.
    trusted: [usize; 2],
    /// Time \[s\], value and standard deviation of the last that was trusted.
    last: Option<[f64; 3]>,
}

/// Counts while estimates are made.
pub struct InputSummary<E: Estimate> {
    rows: usize,
    moving: usize,
    /// Time that has passed; none does where a clock is set back \[s\].
    seconds: f64,
    last: E,
    tally: Vec<HeadlineTally>,
}

impl<E: Estimate> InputSummary<E> {
    pub fn new() -> Self {
        Self {
            rows: 0,
            moving: 0,
            seconds: 0.0,
            last: E::default(),
            tally: E::headlines().map(|_| HeadlineTally::default()).collect(),
        }
    }

    pub fn add(&mut self, estimate: &E) {
        let time = estimate.stamp().time;
        if self.rows > 0 {
            self.seconds += (time - self.last.stamp().time).max(0.0);
        }
        let moves = estimate.motion().abs() >= E::MOTION_NAME.1;
        self.rows += 1;
        self.moving += usize::from(moves);
        self.last = *estimate;
        for (tally, p) in self.tally.iter_mut().zip(E::headlines()) {
            if estimate.flags() & p.trusted != 0 {
                tally.trusted[0] += 1;
                tally.trusted[1] += usize::from(moves);
                tally.last = Some([time, p.value(estimate), p.std(estimate)]);
            }
        }
    }

    /// Writes the summary. A number that does not exist is null; `made_by` tells another run whether it would say the same,
    /// `guessed` what makes all loads wide, and `doubt` why the result is no good one.
    pub fn write(
        &self,
        path: &Path,
        refused: usize,
        made_by: &str,
        guessed: Option<&str>,
        doubt: Option<&Failure>,
    ) -> Result<(), Failure> {
        let doubt = doubt.map(ToString::to_string);
        let summary = self.json(refused, guessed, doubt.as_deref());
        results::json(path, &[], "estimate", made_by, &summary)
    }

    fn json(&self, refused: usize, guessed: Option<&str>, doubt: Option<&str>) -> Value {
        let share = |n: usize, of: usize| (of > 0).then(|| n as f64 / of as f64);
        let quantities = self.tally.iter().zip(E::headlines()).map(|(tally, p)| {
            let [time, value, std] = tally.last.unwrap_or([f64::NAN; 3]);
            json!({
                "key": p.key, "label": p.label, "unit": p.unit,
                "value": p.value(&self.last), "std": p.std(&self.last),
                "trusted": self.last.flags() & p.trusted != 0,
                "last_trusted": tally.last.map(|_| json!({"time": time, "value": value, "std": std})),
                "trusted_share": share(tally.trusted[0], self.rows),
                "trusted_share_in_motion": share(tally.trusted[1], self.moving),
            })
        });
        json!({
            "machine": E::MACHINE.name(),
            "rows": self.rows,
            "refused": refused,
            "doubt": doubt,
            "guessed": guessed,
            "seconds": self.seconds,
            "quantities": quantities.collect::<Vec<_>>(),
            "verdict": view::words::verdict(&self.last),
        })
    }
}

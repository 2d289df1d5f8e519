//! Summary of the estimates of one input as JSON: the source of a table of many inputs.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};
use view::Judgement;
use view::estimate::Estimate;

use crate::failure::Failure;
use crate::results;

/// Share of trusted rows below which the reason is reported.
const FEW: f64 = 0.9;

/// Summary of one quantity.
#[derive(Clone)]
struct HeadlineTally<E> {
    /// Trusted rows, and those of them in motion.
    trusted: [usize; 2],
    /// Time \[s\], value and standard deviation of the last trusted row.
    last: Option<[f64; 3]>,
    /// Rows in motion that were not trusted, by reason and flags, each with the latest estimate.
    doubts: BTreeMap<[u32; 2], (usize, E)>,
}

impl<E: Estimate> HeadlineTally<E> {
    /// Judgement of the most frequent kind of rows in motion without trust; `i`: index of the quantity among the headlines.
    fn main_doubt(&self, i: usize) -> Option<Judgement> {
        // A reason is sufficient; without one the conditions that do not hold are reported.
        let kind = |[reason, flags]: [u32; 2]| [reason, if reason == 0 { flags } else { 0 }];
        let mut kinds = BTreeMap::<_, usize>::new();
        for (&of, (rows, _)) in &self.doubts {
            *kinds.entry(kind(of)).or_default() += rows;
        }
        let (most, _) = kinds.into_iter().max_by_key(|(_, rows)| *rows)?;
        let alike = self.doubts.iter().filter(|(of, _)| kind(**of) == most);
        let (_, (_, latest)) = alike.max_by_key(|(_, (rows, _))| *rows)?;
        Some(latest.judgements().swap_remove(i))
    }
}

fn share(part: usize, of: usize) -> Option<f64> {
    (of > 0).then(|| part as f64 / of as f64)
}

/// Accumulates the estimates of an input.
pub struct InputSummary<E: Estimate> {
    rows: usize,
    moving: usize,
    /// Elapsed time \[s\]; a clock that is set back adds none.
    seconds: f64,
    last: E,
    tally: Vec<HeadlineTally<E>>,
}

impl<E: Estimate> InputSummary<E> {
    pub fn new() -> Self {
        Self {
            rows: 0,
            moving: 0,
            seconds: 0.0,
            last: E::default(),
            tally: E::headlines()
                .map(|_| HeadlineTally {
                    trusted: [0; 2],
                    last: None,
                    doubts: BTreeMap::new(),
                })
                .collect(),
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
            } else if moves {
                let codes = estimate.codes();
                let all = E::CONDITIONS.iter().fold(0, |all, (_, bit)| all | bit);
                let doubt = tally.doubts.entry([codes.reason, codes.flags & all]);
                let (rows, latest) = doubt.or_insert((0, *estimate));
                (*rows, *latest) = (*rows + 1, *estimate);
            }
        }
    }

    /// Of each quantity the share of the motion that was trusted; if it is small, the reason for the rest and the remedy.
    pub fn in_words(&self) -> Vec<String> {
        let words = self.tally.iter().zip(E::headlines()).enumerate();
        let words = words.map(|(i, (tally, p))| {
            let Some(share) = share(tally.trusted[1], self.moving) else {
                return format!("{}: no row was in motion.", p.label);
            };
            let trusted = format!(
                "{}: trusted in {:.0} % of the motion",
                p.label,
                100.0 * share
            );
            match tally.main_doubt(i).filter(|_| share < FEW) {
                Some(doubt) => format!(
                    "{trusted}; the rest mostly not, because {}. {}",
                    doubt.reasons.join(" and "),
                    doubt.what_to_do()
                ),
                None => format!("{trusted}."),
            }
        });
        words.map(|words| words.trim_end().to_owned()).collect()
    }

    /// Writes the summary. A number that does not exist is null. `made_by` identifies the computation, so that it is not repeated.
    /// `guessed` is the cause of wide intervals of all loads, `doubt` the reason why the result is doubtful.
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
        let quantities = self.tally.iter().zip(E::headlines()).enumerate();
        let quantities = quantities.map(|(i, (tally, p))| {
            let doubt = tally.main_doubt(i);
            let [time, value, std] = tally.last.unwrap_or([f64::NAN; 3]);
            json!({
                "key": p.key, "label": p.label, "unit": p.unit,
                "value": p.value(&self.last), "std": p.std(&self.last),
                "trusted": self.last.flags() & p.trusted != 0,
                "last_trusted": tally.last.map(|_| json!({"time": time, "value": value, "std": std})),
                "trusted_share": share(tally.trusted[0], self.rows),
                "trusted_share_in_motion": share(tally.trusted[1], self.moving),
                "main_reason": doubt.as_ref().map(|doubt| doubt.reasons.join("; ")),
                "what_to_do": doubt.map(|doubt| doubt.advice),
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

//! Rows of several machines or recordings in one table, whose column has another name than `machine`.

use std::collections::BTreeMap;

use super::cells::Record;
use super::dialect;
use crate::Finding;

/// Most and fewest names in a column that parts the rows; a counter has more.
const NAMES: std::ops::RangeInclusive<usize> = 2..=64;
/// Fewest rows of a name.
const ROWS: usize = 3;
/// Ratio of the squared steps between neighbouring rows and between those of one name, above which a signal shows several machines.
/// Of one machine it is at most 1: two rows of one name are further apart than two neighbours.
const RATIO: f64 = 4.0;
/// Names that are shown.
const SHOWN: usize = 3;

/// What shows that a column parts the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// Steps of the signals.
    Values,
    /// Times that go back.
    Times,
}

/// Rows of one name.
#[derive(Debug, Default)]
struct Part {
    rows: usize,
    time: f64,
    values: Vec<f64>,
}

/// What a column that is no signal would say if it named the machine of each row.
#[derive(Debug)]
struct Candidate {
    at: usize,
    parts: BTreeMap<Vec<u8>, Part>,
    /// Rows of a name whose time is not behind that of the row before them with that name.
    back: usize,
    /// Squared steps of each signal between rows of one name, and their number.
    steps: Vec<[f64; 2]>,
}

/// Looks for a column that parts the rows.
#[derive(Debug)]
pub(super) struct Several {
    candidates: Vec<Candidate>,
    time: f64,
    values: Vec<f64>,
    back: usize,
    steps: Vec<[f64; 2]>,
}

impl Several {
    /// Of a table with these columns that are no signals, and this number of signals.
    pub(super) fn of(unused: impl Iterator<Item = usize>, signals: usize) -> Self {
        let candidate = |at| Candidate {
            at,
            parts: BTreeMap::new(),
            back: 0,
            steps: vec![[0.0; 2]; signals],
        };
        Self {
            candidates: unused.map(candidate).collect(),
            time: f64::NEG_INFINITY,
            values: vec![f64::NAN; signals],
            back: 0,
            steps: vec![[0.0; 2]; signals],
        }
    }

    /// Whether a column may still part the rows.
    pub(super) fn is_open(&self) -> bool {
        !self.candidates.is_empty()
    }

    /// Takes a row: its cells, its time, and its signals.
    pub(super) fn take(&mut self, record: &Record, time: f64, values: &[f64]) {
        self.back += usize::from(time <= self.time);
        self.time = time;
        add_steps(&mut self.steps, &self.values, values);
        self.values.copy_from_slice(values);
        self.candidates.retain_mut(|candidate| {
            let name = record.get(candidate.at).unwrap_or_default();
            if !candidate.parts.contains_key(name) {
                candidate.parts.insert(name.to_vec(), Part::default());
            }
            let Some(part) = candidate.parts.get_mut(name) else {
                return false;
            };
            if part.rows == 0 {
                part.values = vec![f64::NAN; values.len()];
            } else {
                candidate.back += usize::from(time <= part.time);
            }
            add_steps(&mut candidate.steps, &part.values, values);
            part.rows += 1;
            part.time = time;
            part.values.copy_from_slice(values);
            candidate.parts.len() <= *NAMES.end()
        });
    }

    /// The column that parts the rows, and its names: by their values; or, where the times are out of order, by times that go back
    /// between its parts and never within one.
    pub(super) fn found(&self, header: &[String], by: By) -> Option<Finding> {
        let parts = self.candidates.iter().find(|candidate| {
            let is_enough = candidate.parts.values().all(|part| part.rows >= ROWS);
            let is_named = !candidate.parts.keys().any(Vec::is_empty);
            NAMES.contains(&candidate.parts.len())
                && is_enough
                && is_named
                && match by {
                    By::Values => candidate.differ_from(&self.steps),
                    By::Times => self.back > 0 && candidate.back == 0,
                }
        })?;
        let names = parts
            .parts
            .keys()
            .take(SHOWN)
            .map(|name| dialect::text(name));
        let mut names: Vec<String> = names.collect();
        if parts.parts.len() > SHOWN {
            names.push("...".into());
        }
        let column = &header[parts.at];
        Some(Finding::new(
            format!(
                "the rows seem to be of several machines or recordings, by the column {column}: {}",
                names.join(", ")
            ),
            format!(
                "give the rows of one; or rename {column} to machine, and give the table to heft serve. If they are of one machine in the order of time, remove the column"
            ),
        ))
    }
}

impl Candidate {
    /// Whether most signals have far smaller steps within the parts than these between neighbouring rows.
    fn differ_from(&self, neighbours: &[[f64; 2]]) -> bool {
        let mean = |[sum, count]: [f64; 2]| sum / count.max(1.0);
        let both = self.steps.iter().zip(neighbours);
        let moving = both.filter(|(_, all)| all[0] > 0.0);
        let (moved, differ) = moving.fold((0, 0), |(moved, differ), (within, all)| {
            let is_so = mean(*all) > RATIO * mean(*within);
            (moved + 1, differ + usize::from(is_so))
        });
        differ > 1 && 2 * differ > moved
    }
}

/// Adds the squared step of each signal.
fn add_steps(sums: &mut [[f64; 2]], before: &[f64], now: &[f64]) {
    for ([sum, count], (before, now)) in sums.iter_mut().zip(before.iter().zip(now)) {
        let square = (now - before).powi(2);
        if square.is_finite() {
            *sum += square;
            *count += 1.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::cells::Cells;
    use super::super::dialect::Dialect;
    use super::*;

    fn of(rows: impl Iterator<Item = (f64, [f64; 2], String)>) -> Option<String> {
        let header = ["t", "a", "b", "Asset"].map(String::from);
        let mut several = Several::of([3].into_iter(), 2);
        let mut cells = Cells::new(Dialect { separator: b',' });
        for (time, values, name) in rows {
            let record = cells.split(format!("0,0,0,{name}").as_bytes()).clone();
            several.take(&record, time, &values);
        }
        let by = [By::Values, By::Times].map(|by| several.found(&header, by));
        by.into_iter().flatten().next().map(|found| found.what)
    }

    /// A row of a machine that swings about this angle.
    fn row(i: u32, angle: f64, name: &str) -> (f64, [f64; 2], String) {
        let time = 0.01 * f64::from(i);
        (time, [angle + time.sin(), angle + time.cos()], name.into())
    }

    #[test]
    fn rows_of_two_machines_are_told_by_values_or_by_times() {
        let in_turn = (0..400).map(|i| row(i, f64::from(i % 2), ["EX1", "EX2"][i as usize % 2]));
        let found = of(in_turn).expect("two machines");
        assert!(found.contains("by the column Asset: EX1, EX2"), "{found}");
        let first = (0..400).map(|i| row(i, 0.0, "EX1"));
        let one_behind_the_other = first.chain((0..400).map(|i| row(i, 0.0, "EX2")));
        assert!(of(one_behind_the_other).is_some());
    }

    #[test]
    fn states_counters_and_heartbeats_of_one_machine_are_none() {
        let gear = |i: u32| ["F1", "F2", "R"][i as usize / 50 % 3];
        assert_eq!(of((0..400).map(|i| row(i, 0.0, gear(i)))), None);
        assert_eq!(
            of((0..400).map(|i| row(i, 0.0, &(i % 16).to_string()))),
            None
        );
        assert_eq!(of((0..400).map(|i| row(i, 0.0, &i.to_string()))), None);
        // A clock that was set back by 1 s.
        let set_back = (0..400).map(|i| row(i - 100 * u32::from(i > 200), 0.0, gear(i)));
        assert_eq!(of(set_back), None);
    }
}

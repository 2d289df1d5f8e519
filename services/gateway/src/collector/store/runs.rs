//! Runs of machines. A random id names a run. Runs are ordered by their first contact, by the collector's clock. A machine's
//! clock and its count of runs are reported but order nothing, because they may be wrong.

use std::collections::HashMap;
use std::time::Instant;

use rusqlite::params;

use super::Store;
use crate::status::Status;
use crate::wall_ms;

/// Limit of new runs of a machine: burst, and sustained period [s]. A real run lasts longer.
const BURST: f64 = 20.0;
const PAUSE_S: f64 = 2.0;
/// Clock error [ms] below which a clock counts as right: the error includes the transit time of a status.
const RIGHT_MS: i64 = 10_000;

/// A run in memory.
pub(super) struct Run {
    /// Its number in the store, in order of first contact.
    pub id: i64,
    /// Number of runs that the machine had counted; 0 if it does not count them.
    pub count: i64,
    /// Largest lead of its clock over ours in a status [ms]: that of the status with the least delay.
    clock_ms: Option<i64>,
    /// By its status, it ended in order.
    pub ended: bool,
}

/// Token bucket of a machine's new runs.
pub(super) struct Begun {
    left: f64,
    at: Instant,
}

impl Begun {
    pub fn new() -> Self {
        Self {
            left: BURST,
            at: Instant::now(),
        }
    }

    fn may(&mut self) -> bool {
        self.left = (self.left + self.at.elapsed().as_secs_f64() / PAUSE_S).min(BURST);
        self.at = Instant::now();
        let may = self.left >= 1.0;
        if may {
            self.left -= 1.0;
        }
        may
    }
}

/// Runs by machine and id.
pub(super) type Runs = HashMap<(i64, i64), Run>;

impl Store {
    /// Reads the runs of the file.
    pub(super) fn load_runs(&mut self) -> rusqlite::Result<()> {
        let mut query = self
            .sql
            .prepare("SELECT id, machine, run, count, clock_ms, ended FROM run")?;
        let mut rows = query.query([])?;
        while let Some(row) = rows.next()? {
            let run = Run {
                id: row.get(0)?,
                count: row.get(3)?,
                clock_ms: row.get(4)?,
                ended: row.get(5)?,
            };
            self.runs.insert((row.get(1)?, row.get(2)?), run);
        }
        Ok(())
    }

    /// The run's number here; `None` where a machine begins runs faster than the limit.
    pub(super) fn run(&mut self, machine: i64, run: i64) -> rusqlite::Result<Option<i64>> {
        if let Some(known) = self.runs.get(&(machine, run)) {
            return Ok(Some(known.id));
        }
        let begun = self.begun.entry(machine).or_insert_with(Begun::new);
        if !begun.may() {
            return Ok(None);
        }
        let insert = "INSERT INTO run (machine, run, first_ms) VALUES (?, ?, ?) RETURNING id";
        let values = params![machine, run, wall_ms() as i64];
        let id: i64 = self.sql.query_row(insert, values, |row| row.get(0))?;
        let new = Run {
            id,
            count: 0,
            clock_ms: None,
            ended: false,
        };
        self.runs.insert((machine, run), new);
        Ok(Some(id))
    }

    /// Stores the count, the end and the clock error of a known run from a status.
    pub(super) fn reported_run(
        &mut self,
        machine: i64,
        run: i64,
        status: &Status,
        ahead_ms: i64,
    ) -> rusqlite::Result<()> {
        let Some(known) = self.runs.get_mut(&(machine, run)) else {
            return Ok(());
        };
        let count = i64::try_from(status.count).unwrap_or(0);
        let ahead = known.clock_ms.map_or(ahead_ms, |was| was.max(ahead_ms));
        if (known.count, known.clock_ms, known.ended) == (count, Some(ahead), status.ended) {
            return Ok(());
        }
        (known.count, known.clock_ms, known.ended) = (count, Some(ahead), status.ended);
        let off = if ahead.abs() < RIGHT_MS { 0 } else { ahead };
        let update = "UPDATE run SET count = ?, clock_ms = ?, off_ms = ?, ended = ? WHERE id = ?";
        self.sql
            .execute(update, params![count, ahead, off, status.ended, known.id])
            .map(|_| ())
    }

    /// Runs that were counted by a machine between two received runs, and of which nothing arrived, by machine.
    pub(super) fn unheard(&self) -> HashMap<i64, u64> {
        let mut counts: HashMap<i64, Vec<(i64, i64)>> = HashMap::new();
        for ((machine, _), run) in &self.runs {
            if run.count > 0 {
                let its = counts.entry(*machine).or_default();
                its.push((run.id, run.count));
            }
        }
        let sum = |mut its: Vec<(i64, i64)>| {
            its.sort_unstable();
            // A falling count restarts: the machine's state was lost.
            let pairs = its
                .windows(2)
                .map(|two| (two[1].1.saturating_sub(two[0].1) - 1).max(0) as u64);
            pairs.fold(0, u64::saturating_add)
        };
        counts
            .into_iter()
            .map(|(machine, its)| (machine, sum(its)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::MachineId;
    use crate::status;

    #[test]
    fn a_run_that_ended_in_order_has_ended_also_after_a_start_and_in_a_history_of_before() {
        let folder = tempfile::tempdir().expect("a folder");
        let db = folder.path().join("fleet.sqlite");
        let mut store = Store::open(&db).expect("a history");
        let machine = MachineId::new("north", "ex-1").expect("names");
        let head = status::Stream {
            head: 0,
            per_period: 1.0,
        };
        let status = Status {
            kind: "excavator".into(),
            run: 7,
            wall_ms: wall_ms(),
            ended: true,
            streams: [("estimate/inertia_ukf".to_owned(), head)].into(),
            ..Status::default()
        };
        store.status(&machine, &status).expect("room");
        let message = format!(
            "INSERT INTO message SELECT id, 0, -1, 0, {}, x'' FROM stream",
            wall_ms()
        );
        store.sql.execute_batch(&message).expect("room");
        let ended = |store: &Store| store.fleet().expect("it").machines[&machine].ended;
        let store = Store::open(&db).expect("a history");
        assert!(ended(&store));
        let before = "ALTER TABLE run DROP COLUMN ended";
        store.sql.execute_batch(before).expect("room");
        drop(store);
        assert!(!ended(&Store::open(&db).expect("a history of before")));
    }

    #[test]
    fn of_runs_of_long_ago_nothing_stays_but_what_counts_the_later_ones() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut store = Store::open(&folder.path().join("fleet.sqlite")).expect("a history");
        let machine = MachineId::new("north", "ex-1").expect("names");
        for count in 1..=6_u64 {
            let (head, per_period) = (9, 1.0);
            let name = "estimate/inertia_ukf".to_owned();
            let status = Status {
                kind: "excavator".into(),
                run: 100 - count,
                count,
                streams: [(name, status::Stream { head, per_period })].into(),
                ..Status::default()
            };
            store.status(&machine, &status).expect("room");
        }
        // All but the last two began long ago; a message of the third is left.
        let make = format!(
            "UPDATE run SET first_ms = 0 WHERE count <= 4;
             INSERT INTO message SELECT id, 0, -1, 0, {}, x'' FROM stream WHERE run = 97;",
            wall_ms()
        );
        store.sql.execute_batch(&make).expect("room");
        let runs = |store: &Store| {
            let mut counts: Vec<i64> = store.runs.values().map(|run| run.count).collect();
            counts.sort_unstable();
            (counts, store.streams.len(), store.ids.len())
        };
        store.forget(1.0).expect("room");
        assert_eq!(runs(&store), (vec![3, 4, 5, 6], 4, 4));
        assert!(store.unheard().values().all(|runs| *runs == 0));
        // The latest run of a machine is retained, however long it was silent.
        let old = "UPDATE run SET first_ms = 0; UPDATE message SET received_ms = 0";
        store.sql.execute_batch(old).expect("room");
        store.forget(1.0).expect("room");
        assert_eq!(runs(&store), (vec![6], 1, 1));
        store.forget(1.0).expect("again");
    }
}

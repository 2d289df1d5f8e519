//! The history: SQLite with a write-ahead log, written by one thread, read by page and queries meanwhile.
//!
//! A message has its place by machine, run, stream and number: what comes twice is there once. What is missing:
//! [`gaps`].

mod gaps;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::time::{Duration, Instant};

use rusqlite::{Connection, OptionalExtension, params};

use super::alarm::Alarm;
use super::intake::{Taken, decode};
use super::live::Fleet;
use crate::key::MachineId;
use crate::label::Label;
use crate::status::Status;
use crate::wall_ms;
use gaps::Stream;

const SCHEMA: &str = "
    PRAGMA journal_mode = WAL;
    PRAGMA synchronous = NORMAL;
    CREATE TABLE IF NOT EXISTS machine (
        id INTEGER PRIMARY KEY, site TEXT NOT NULL, name TEXT NOT NULL,
        kind TEXT NOT NULL DEFAULT '', version TEXT NOT NULL DEFAULT '', UNIQUE (site, name));
    CREATE TABLE IF NOT EXISTS stream (
        id INTEGER PRIMARY KEY, machine INTEGER NOT NULL REFERENCES machine, epoch INTEGER NOT NULL, name TEXT NOT NULL,
        good INTEGER NOT NULL DEFAULT -1, head INTEGER NOT NULL DEFAULT -1, lost INTEGER NOT NULL DEFAULT 0,
        per_period REAL NOT NULL DEFAULT 0, UNIQUE (machine, epoch, name));
    CREATE TABLE IF NOT EXISTS message (
        stream INTEGER NOT NULL REFERENCES stream, number INTEGER NOT NULL, after INTEGER,
        wall_ms INTEGER NOT NULL, received_ms INTEGER NOT NULL, payload BLOB NOT NULL,
        PRIMARY KEY (stream, number)) WITHOUT ROWID;
    CREATE INDEX IF NOT EXISTS message_time ON message (wall_ms);
    CREATE TABLE IF NOT EXISTS alarm (
        at_ms INTEGER NOT NULL, site TEXT NOT NULL, name TEXT NOT NULL, kind TEXT NOT NULL, text TEXT NOT NULL);
";

/// Least time between two new runs of a machine.
const RUNS: Duration = Duration::from_secs(2);

/// The history, to write.
pub struct Store {
    sql: Connection,
    machines: HashMap<MachineId, Owner>,
    ids: HashMap<(i64, i64, String), i64>,
    streams: BTreeMap<i64, Stream>,
}

struct Owner {
    id: i64,
    /// The latest run that was heard of, and since when.
    epoch: i64,
    since: Option<Instant>,
    told: (String, String),
}

fn failed(error: rusqlite::Error) -> String {
    crate::error(
        format!("the history: {error}"),
        "--db",
        "check the path, the permissions and the free space",
    )
}

impl Store {
    /// Opens or makes the file.
    ///
    /// # Errors
    /// It cannot be written, or is no history.
    pub fn open(file: &Path) -> Result<Self, String> {
        let sql = Connection::open(file).map_err(failed)?;
        sql.busy_timeout(Duration::from_secs(10)).map_err(failed)?;
        sql.execute_batch(SCHEMA).map_err(failed)?;
        let mut store = Self {
            sql,
            machines: HashMap::new(),
            ids: HashMap::new(),
            streams: BTreeMap::new(),
        };
        store.load().map_err(failed)?;
        Ok(store)
    }

    /// Reads what is known of machines and streams.
    fn load(&mut self) -> rusqlite::Result<()> {
        let mut query = self.sql.prepare(
            "SELECT s.id, s.machine, m.site, m.name, m.kind, m.version, s.epoch, s.name, s.good, s.head, s.lost, s.per_period,
             (SELECT max(number) FROM message WHERE stream = s.id) FROM stream s JOIN machine m ON m.id = s.machine",
        )?;
        let mut rows = query.query([])?;
        while let Some(row) = rows.next()? {
            let (id, owner): (i64, i64) = (row.get(0)?, row.get(1)?);
            let (site, name): (String, String) = (row.get(2)?, row.get(3)?);
            let machine = MachineId {
                site,
                machine: name,
            };
            let epoch: i64 = row.get(6)?;
            let name: String = row.get(7)?;
            let known = self.machines.entry(machine.clone()).or_insert(Owner {
                id: owner,
                epoch,
                since: None,
                told: (row.get(4)?, row.get(5)?),
            });
            known.epoch = known.epoch.max(epoch);
            self.ids.insert((owner, epoch, name.clone()), id);
            let mut stream = Stream::new(machine, name, epoch);
            (stream.good, stream.head, stream.lost) = (row.get(8)?, row.get(9)?, row.get(10)?);
            stream.per_period = row.get(11)?;
            stream.newest = row.get::<_, Option<i64>>(12)?.unwrap_or(-1);
            stream.is_written = true;
            self.streams.insert(id, stream);
        }
        Ok(())
    }

    /// The fleet as the history knows it: the latest message of each stream of each machine's latest run.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn fleet(&self) -> Result<Fleet, String> {
        let mut fleet = Fleet::default();
        for (id, owner) in &self.machines {
            fleet.known(id, &owner.told.0, &owner.told.1);
        }
        let mut query = self
            .sql
            .prepare("SELECT after, wall_ms, payload FROM message WHERE stream = ? AND number = ?")
            .map_err(failed)?;
        for (id, stream) in &self.streams {
            if self.machines[&stream.machine].epoch != stream.epoch || stream.newest < 0 {
                continue;
            }
            let found = query.query_row(params![id, stream.newest], |row| {
                let after: Option<i64> = row.get(0)?;
                Ok((after, row.get::<_, i64>(1)?, row.get::<_, Vec<u8>>(2)?))
            });
            let Some((after, wall_ms, payload)) = found.optional().map_err(failed)? else {
                continue;
            };
            if let Some(envelope) = decode(&stream.name, &payload) {
                let label = Label {
                    machine: stream.machine.machine.clone(),
                    epoch: stream.epoch as u64,
                    number: stream.newest as u64,
                    after,
                    wall_ms: wall_ms as u64,
                };
                let id = stream.machine.clone();
                let stream = stream.name.clone();
                fleet.message(&Taken {
                    id,
                    stream,
                    label,
                    payload,
                    envelope,
                });
            }
        }
        fleet.forget_when();
        Ok(fleet)
    }

    /// Begins a transaction.
    ///
    /// # Errors
    /// The disk takes no more.
    pub fn begin(&mut self) -> Result<(), String> {
        self.sql.execute_batch("BEGIN").map_err(failed)
    }

    /// Ends it.
    ///
    /// # Errors
    /// The disk takes no more.
    pub fn commit(&mut self) -> Result<(), String> {
        let mut update = self
            .sql
            .prepare_cached(
                "UPDATE stream SET good = ?, head = ?, lost = ?, per_period = ? WHERE id = ?",
            )
            .map_err(failed)?;
        for (id, s) in self.streams.iter_mut().filter(|(_, s)| !s.is_written) {
            s.is_written = true;
            let values = params![s.good, s.head, s.lost, s.per_period, id];
            update.execute(values).map_err(failed)?;
        }
        drop(update);
        self.sql.execute_batch("COMMIT").map_err(failed)
    }

    fn owner(&mut self, id: &MachineId) -> Result<i64, String> {
        if let Some(owner) = self.machines.get(id) {
            return Ok(owner.id);
        }
        let insert = "INSERT INTO machine (site, name) VALUES (?, ?) ON CONFLICT DO UPDATE SET name = name RETURNING id";
        let number = self
            .sql
            .query_row(insert, [&id.site, &id.machine], |row| row.get(0));
        let number = number.map_err(failed)?;
        let owner = Owner {
            id: number,
            epoch: -1,
            since: None,
            told: Default::default(),
        };
        self.machines.insert(id.clone(), owner);
        Ok(number)
    }

    /// The stream of a run; `None` where a machine begins runs faster than any machine does.
    fn stream(&mut self, id: &MachineId, epoch: u64, name: &str) -> Result<Option<i64>, String> {
        let number = self.owner(id)?;
        let epoch = epoch as i64;
        let key = (number, epoch, name.to_owned());
        if let Some(stream) = self.ids.get(&key) {
            return Ok(Some(*stream));
        }
        if let Some(owner) = self.machines.get_mut(id)
            && owner.epoch != epoch
        {
            if epoch < owner.epoch || owner.since.is_some_and(|s| s.elapsed() < RUNS) {
                return Ok(None);
            }
            (owner.epoch, owner.since) = (epoch, Some(Instant::now()));
        }
        let insert = "INSERT INTO stream (machine, epoch, name) VALUES (?, ?, ?) RETURNING id";
        let stream = self
            .sql
            .query_row(insert, params![number, epoch, name], |row| row.get(0));
        let stream: i64 = stream.map_err(failed)?;
        self.ids.insert(key, stream);
        self.streams
            .insert(stream, Stream::new(id.clone(), name.to_owned(), epoch));
        Ok(Some(stream))
    }

    /// Stores a message; false if it was here already.
    ///
    /// # Errors
    /// The disk takes no more.
    pub fn insert(&mut self, taken: &Taken) -> Result<bool, String> {
        let label = &taken.label;
        let Some(id) = self.stream(&taken.id, label.epoch, &taken.stream)? else {
            return Ok(false);
        };
        let number = label.number as i64;
        // Who has seen all samples in between knows better what was before.
        let mut insert = self
            .sql
            .prepare_cached(
                "INSERT INTO message VALUES (?1, ?2, ?3, ?4, ?5, ?6) ON CONFLICT DO UPDATE SET after = excluded.after
                 WHERE after IS NULL AND excluded.after IS NOT NULL",
            )
            .map_err(failed)?;
        let received = wall_ms() as i64;
        let values = params![
            id,
            number,
            label.after,
            label.wall_ms as i64,
            received,
            taken.payload
        ];
        let changed = insert.execute(values).map_err(failed)?;
        drop(insert);
        if let Some(stream) = self.streams.get_mut(&id) {
            let is_newest = number > stream.newest;
            stream.newest = stream.newest.max(number);
            stream.head = stream.head.max(number);
            stream.is_written = false;
            if number > stream.good && label.after.is_some_and(|after| after <= stream.good) {
                stream.good = number;
                if !is_newest {
                    self.advance(id)?;
                }
            }
        }
        Ok(changed > 0)
    }

    /// Takes in how far a machine says it is.
    ///
    /// # Errors
    /// The disk takes no more.
    pub fn status(&mut self, id: &MachineId, status: &Status) -> Result<(), String> {
        for (name, told) in &status.streams {
            // Only what messages have made known, or would.
            if told.head < 0 || !super::intake::is_stream(name) {
                continue;
            }
            let Some(number) = self.stream(id, status.epoch, name)? else {
                continue;
            };
            if let Some(stream) = self.streams.get_mut(&number) {
                stream.is_written &=
                    stream.head >= told.head && stream.per_period == told.per_period;
                stream.head = stream.head.max(told.head);
                stream.per_period = told.per_period;
            }
        }
        self.owner(id)?;
        if let Some(owner) = self.machines.get_mut(id)
            && (&owner.told.0, &owner.told.1) != (&status.kind, &status.version)
        {
            owner.told = (status.kind.clone(), status.version.clone());
            let update = "UPDATE machine SET kind = ?, version = ? WHERE id = ?";
            let values = params![status.kind, status.version, owner.id];
            self.sql.execute(update, values).map_err(failed)?;
        }
        Ok(())
    }

    /// Notes an alarm.
    ///
    /// # Errors
    /// The disk takes no more.
    pub fn alarm(&self, alarm: &Alarm) -> Result<(), String> {
        let values = params![
            wall_ms() as i64,
            alarm.id.site,
            alarm.id.machine,
            alarm.kind,
            alarm.text
        ];
        let insert = "INSERT INTO alarm VALUES (?, ?, ?, ?, ?)";
        self.sql.execute(insert, values).map_err(failed).map(|_| ())
    }

    /// Removes what is older than so many days.
    ///
    /// # Errors
    /// The disk takes no more.
    pub fn forget(&mut self, days: f64) -> Result<(), String> {
        let limit = wall_ms() as i64 - (days.max(0.0) * 86_400_000.0) as i64;
        for delete in [
            "DELETE FROM message WHERE wall_ms < ?",
            "DELETE FROM alarm WHERE at_ms < ?",
        ] {
            self.sql.execute(delete, [limit]).map_err(failed)?;
        }
        Ok(())
    }
}

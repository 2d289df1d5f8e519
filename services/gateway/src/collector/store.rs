//! The history: SQLite with a write-ahead log; one thread writes it, page and queries read it meanwhile.
//!
//! A message is identified by machine, run, stream and number, so a repeated message is stored once. Missing messages: [`gaps`].

mod gaps;
mod runs;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::time::Duration;

use rusqlite::{Connection, OpenFlags, OptionalExtension, params};

use super::alarm::Alarm;
use super::intake::{StreamMessage, decode};
use super::live::Fleet;
use crate::key::MachineId;
use crate::label::Label;
use crate::status::Status;
use crate::{MACHINES, wall_ms};
use gaps::Stream;
use runs::{Begun, Run, Runs};

const SCHEMA: &str = "
    PRAGMA journal_mode = WAL;
    PRAGMA synchronous = NORMAL;
    CREATE TABLE IF NOT EXISTS machine (
        id INTEGER PRIMARY KEY, site TEXT NOT NULL, name TEXT NOT NULL,
        kind TEXT NOT NULL DEFAULT '', version TEXT NOT NULL DEFAULT '', UNIQUE (site, name));
    CREATE TABLE IF NOT EXISTS run (
        id INTEGER PRIMARY KEY AUTOINCREMENT, machine INTEGER NOT NULL REFERENCES machine, run INTEGER NOT NULL,
        first_ms INTEGER NOT NULL, count INTEGER NOT NULL DEFAULT 0, clock_ms INTEGER, off_ms INTEGER NOT NULL DEFAULT 0,
        ended INTEGER NOT NULL DEFAULT 0, UNIQUE (machine, run));
    CREATE TABLE IF NOT EXISTS refused (
        machine INTEGER NOT NULL REFERENCES machine, why TEXT NOT NULL, messages INTEGER NOT NULL, PRIMARY KEY (machine, why));
    CREATE TABLE IF NOT EXISTS stream (
        id INTEGER PRIMARY KEY, machine INTEGER NOT NULL REFERENCES machine, run INTEGER NOT NULL, name TEXT NOT NULL,
        good INTEGER NOT NULL DEFAULT -1, head INTEGER NOT NULL DEFAULT -1, lost INTEGER NOT NULL DEFAULT 0,
        per_period REAL NOT NULL DEFAULT 0, UNIQUE (machine, run, name));
    CREATE TABLE IF NOT EXISTS message (
        stream INTEGER NOT NULL REFERENCES stream, number INTEGER NOT NULL, after INTEGER,
        wall_ms INTEGER NOT NULL, received_ms INTEGER NOT NULL, payload BLOB NOT NULL,
        PRIMARY KEY (stream, number)) WITHOUT ROWID;
    DROP INDEX IF EXISTS message_time;
    CREATE INDEX IF NOT EXISTS message_received ON message (received_ms);
    CREATE TABLE IF NOT EXISTS alarm (
        at_ms INTEGER NOT NULL, site TEXT NOT NULL, name TEXT NOT NULL, kind TEXT NOT NULL, text TEXT NOT NULL);
";

/// Silence after which a machine is not shown after a start [ms]; for one without a reported kind, the second value.
const DAYS_MS: i64 = 3 * 86_400_000;
const MOMENT_MS: i64 = 60_000;

/// Migration: older histories do not record which runs have ended.
const WITHOUT_END: &str = "ALTER TABLE run ADD COLUMN ended INTEGER NOT NULL DEFAULT 0";

/// Migration: older histories name runs by the machine's clock at their start.
const OLD: &str = "
    ALTER TABLE stream RENAME COLUMN epoch TO run;
    INSERT OR IGNORE INTO run (machine, run, first_ms) SELECT DISTINCT machine, run, run FROM stream ORDER BY run;
";

/// Deletes machines without a reported kind and without messages.
const FORGET_NAMES: &str = "
    CREATE TEMP TABLE gone AS SELECT id FROM machine m WHERE kind = ''
        AND NOT EXISTS (SELECT 1 FROM message e JOIN stream s ON s.id = e.stream WHERE s.machine = m.id);
    DELETE FROM stream WHERE machine IN gone;
    DELETE FROM run WHERE machine IN gone;
    DELETE FROM refused WHERE machine IN gone;
    DELETE FROM machine WHERE id IN gone;
    DROP TABLE gone;
";

/// The first run to retain of each machine: one with messages, begun since `?`, or the latest. Earlier runs are deleted with
/// their streams. Runs after it are all retained, because a deleted one would count as never received.
const FIRST_RUNS: &str = "
    CREATE TEMP TABLE first AS SELECT machine, min(id) AS id FROM (
        SELECT machine, id FROM run r WHERE first_ms >= ? OR EXISTS (
            SELECT 1 FROM stream s JOIN message e ON e.stream = s.id WHERE s.machine = r.machine AND s.run = r.run)
        UNION ALL SELECT machine, max(id) FROM run GROUP BY machine) GROUP BY machine";
const FORGET_RUNS: &str = "
    CREATE TEMP TABLE over AS SELECT r.machine, run FROM run r JOIN first f ON f.machine = r.machine WHERE r.id < f.id;
    DELETE FROM stream WHERE (machine, run) IN over;
    DELETE FROM run WHERE (machine, run) IN over;
    DROP TABLE over;
    DROP TABLE first;
";

/// Whether a machine is present.
pub type IsHere<'a> = dyn Fn(&MachineId) -> bool + 'a;

/// Outcome of storing a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StoreOutcome {
    /// It is new; the value is the place of its run among all.
    New(i64),
    /// It was stored already.
    Known,
    /// Its machine begins runs faster than the limit.
    Refused,
}

/// The history, open for writing.
pub struct Store {
    sql: Connection,
    machines: HashMap<MachineId, Owner>,
    ids: HashMap<(i64, i64, String), i64>,
    streams: BTreeMap<i64, Stream>,
    runs: Runs,
    begun: HashMap<i64, Begun>,
    /// Streams to request, in order.
    waiting: Vec<i64>,
    /// Answering side of each request under way, and the stream requested last.
    under_way: HashMap<i64, MachineId>,
    last_asked: i64,
}

struct Owner {
    id: i64,
    reported: (String, String),
}

/// Error text for a history that cannot be read or written.
pub fn failed(error: &rusqlite::Error, db: &Path) -> String {
    use rusqlite::ErrorCode::{DatabaseCorrupt, NotADatabase};
    let remedy = match error.sqlite_error_code() {
        Some(DatabaseCorrupt) => {
            "it is damaged: move it away; a new one asks the machines for what they still have, and `sqlite3 FILE .recover` prints what can be read of it"
        }
        Some(NotADatabase) => "name a file of its own: --db FILE",
        _ => "check the path, the permissions and the free space",
    };
    crate::error(format!("the history: {error}"), db.display(), remedy)
}

/// Opens a history or an empty file. Rejects another program's database unchanged, and does not wait for a pipe.
pub(super) fn connect(file: &Path, flags: OpenFlags) -> rusqlite::Result<Connection> {
    let none = || {
        let code = rusqlite::ffi::Error::new(rusqlite::ffi::SQLITE_NOTADB);
        rusqlite::Error::SqliteFailure(code, Some("this is no history of a fleet".into()))
    };
    if file.metadata().is_ok_and(|about| !about.is_file()) {
        return Err(none());
    }
    let sql = Connection::open_with_flags(file, flags)?;
    sql.busy_timeout(Duration::from_secs(10))?;
    let tables =
        "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite_%'";
    let ours = "SELECT count(*) FROM pragma_table_info('machine') WHERE name IN ('site', 'kind')";
    let count = |text| sql.query_row(text, [], |row| row.get::<_, i64>(0));
    let is_ours = count(tables)? == 0 || count(ours)? == 2;
    if is_ours { Ok(sql) } else { Err(none()) }
}

impl Store {
    /// Opens or makes the file.
    ///
    /// # Errors
    /// It cannot be written, or is no history.
    pub fn open(file: &Path) -> rusqlite::Result<Self> {
        let sql = connect(file, OpenFlags::default())?;
        sql.execute_batch(SCHEMA)?;
        let has = |table: &str, column: &str| {
            let look = "SELECT count(*) FROM pragma_table_info(?) WHERE name = ?";
            sql.query_row(look, [table, column], |row| row.get::<_, i64>(0))
                .map(|n| n > 0)
        };
        if has("stream", "epoch")? {
            sql.execute_batch(OLD)?;
        }
        if !has("run", "ended")? {
            sql.execute_batch(WITHOUT_END)?;
        }
        let mut store = Self {
            sql,
            machines: HashMap::new(),
            ids: HashMap::new(),
            streams: BTreeMap::new(),
            runs: Runs::new(),
            begun: HashMap::new(),
            waiting: Vec::new(),
            under_way: HashMap::new(),
            last_asked: 0,
        };
        store.load_runs()?;
        store.load()?;
        Ok(store)
    }

    /// Reads the machines and streams of the file.
    fn load(&mut self) -> rusqlite::Result<()> {
        let mut query = self.sql.prepare(
            "SELECT s.id, s.machine, m.site, m.name, m.kind, m.version, s.run, s.name, s.good, s.head, s.lost, s.per_period,
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
            let run: i64 = row.get(6)?;
            let name: String = row.get(7)?;
            self.machines.entry(machine.clone()).or_insert(Owner {
                id: owner,
                reported: (row.get(4)?, row.get(5)?),
            });
            self.ids.insert((owner, run, name.clone()), id);
            let mut stream = Stream::new(machine, name, run);
            (stream.good, stream.head, stream.lost) = (row.get(8)?, row.get(9)?, row.get(10)?);
            stream.per_period = row.get(11)?;
            stream.newest = row.get::<_, Option<i64>>(12)?.unwrap_or(-1);
            stream.is_written = true;
            self.streams.insert(id, stream);
        }
        Ok(())
    }

    /// The fleet by the history: the latest message of each stream of each machine's latest run.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn fleet(&self) -> rusqlite::Result<Fleet> {
        let mut fleet = Fleet::default();
        let mut latest: HashMap<i64, &Run> = HashMap::new();
        for ((machine, _), run) in &self.runs {
            let known = latest.entry(*machine).or_insert(run);
            if run.id > known.id {
                *known = run;
            }
        }
        let mut query = self
            .sql
            .prepare("SELECT after, wall_ms, payload, received_ms FROM message WHERE stream = ? AND number = ?")?;
        let now = wall_ms() as i64;
        for (id, stream) in &self.streams {
            let machine = &self.machines[&stream.machine];
            let order = self.runs.get(&(machine.id, stream.run)).map_or(0, |r| r.id);
            let latest = latest.get(&machine.id).filter(|run| run.id == order);
            let Some(ended) = latest.map(|run| run.ended).filter(|_| stream.newest >= 0) else {
                continue;
            };
            let found = query.query_row(params![id, stream.newest], |row| {
                let after: Option<i64> = row.get(0)?;
                let message: (i64, Vec<u8>) = (row.get(1)?, row.get(2)?);
                Ok((after, message.0, message.1, row.get::<_, i64>(3)?))
            });
            let Some((after, wall_ms, payload, received)) = found.optional()? else {
                continue;
            };
            // Machines that were silent for days, or that never reported a kind, stay in the history only.
            let stays = if machine.reported.0.is_empty() {
                MOMENT_MS
            } else {
                DAYS_MS
            };
            if now.saturating_sub(received) > stays || fleet.machines.len() >= MACHINES {
                continue;
            }
            let (kind, version) = &machine.reported;
            fleet.known(&stream.machine, kind, version, ended);
            if let Some(envelope) = decode(&stream.name, &payload) {
                let label = Label {
                    machine: stream.machine.machine.clone(),
                    run: stream.run as u64,
                    number: stream.newest as u64,
                    after,
                    wall_ms: wall_ms as u64,
                };
                let id = stream.machine.clone();
                let stream = stream.name.clone();
                let taken = StreamMessage {
                    id,
                    stream,
                    label,
                    payload,
                    envelope,
                };
                fleet.message(&taken, order);
            }
        }
        drop(query);
        let refused = "SELECT m.site, m.name, r.why, r.messages FROM refused r JOIN machine m ON m.id = r.machine";
        let mut query = self.sql.prepare(refused)?;
        let mut rows = query.query([])?;
        while let Some(row) = rows.next()? {
            let [site, machine, why]: [String; 3] = [row.get(0)?, row.get(1)?, row.get(2)?];
            let messages: i64 = row.get(3)?;
            let id = MachineId { site, machine };
            if fleet.machines.contains_key(&id) {
                fleet.refused(&id, &why, messages as u64);
            }
        }
        drop(rows);
        fleet.forget_when();
        Ok(fleet)
    }

    /// Begins a transaction.
    ///
    /// # Errors
    /// The disk cannot be written.
    pub fn begin(&mut self) -> rusqlite::Result<()> {
        self.sql.execute_batch("BEGIN")
    }

    /// Ends it.
    ///
    /// # Errors
    /// The disk cannot be written.
    pub fn commit(&mut self) -> rusqlite::Result<()> {
        let mut update = self.sql.prepare_cached(
            "UPDATE stream SET good = ?, head = ?, lost = ?, per_period = ? WHERE id = ?",
        )?;
        for (id, s) in self.streams.iter_mut().filter(|(_, s)| !s.is_written) {
            s.is_written = true;
            let values = params![s.good, s.head, s.lost, s.per_period, id];
            update.execute(values)?;
        }
        drop(update);
        self.sql.execute_batch("COMMIT")
    }

    /// Rolls back an open transaction, if there is one.
    pub fn roll_back(&self) {
        let _ = self.sql.execute_batch("ROLLBACK");
    }

    /// Tests whether the disk can be written again.
    ///
    /// # Errors
    /// It cannot.
    pub fn probe(&self) -> rusqlite::Result<()> {
        let probe = "BEGIN IMMEDIATE; CREATE TABLE probe (bytes BLOB); INSERT INTO probe VALUES (zeroblob(65536)); ROLLBACK";
        let tried = self.sql.execute_batch(probe);
        if tried.is_err() {
            self.roll_back();
        }
        tried
    }

    fn owner(&mut self, id: &MachineId) -> rusqlite::Result<i64> {
        if let Some(owner) = self.machines.get(id) {
            return Ok(owner.id);
        }
        let insert = "INSERT INTO machine (site, name) VALUES (?, ?) ON CONFLICT DO UPDATE SET name = name RETURNING id";
        let number = self
            .sql
            .query_row(insert, [&id.site, &id.machine], |row| row.get(0));
        let number = number?;
        let owner = Owner {
            id: number,
            reported: Default::default(),
        };
        self.machines.insert(id.clone(), owner);
        Ok(number)
    }

    /// The stream of a run.
    fn stream(
        &mut self,
        id: &MachineId,
        number: i64,
        run: i64,
        name: &str,
    ) -> rusqlite::Result<i64> {
        let key = (number, run, name.to_owned());
        if let Some(stream) = self.ids.get(&key) {
            return Ok(*stream);
        }
        let insert = "INSERT INTO stream (machine, run, name) VALUES (?, ?, ?) RETURNING id";
        let stream = self
            .sql
            .query_row(insert, params![number, run, name], |row| row.get(0));
        let stream: i64 = stream?;
        self.ids.insert(key, stream);
        self.streams
            .insert(stream, Stream::new(id.clone(), name.to_owned(), run));
        Ok(stream)
    }

    /// Stores a message.
    ///
    /// # Errors
    /// The disk cannot be written.
    pub fn insert(&mut self, taken: &StreamMessage) -> rusqlite::Result<StoreOutcome> {
        let label = &taken.label;
        let (owner, run) = (self.owner(&taken.id)?, label.run as i64);
        let Some(order) = self.run(owner, run)? else {
            return Ok(StoreOutcome::Refused);
        };
        let id = self.stream(&taken.id, owner, run, &taken.stream)?;
        let number = label.number as i64;
        // A known predecessor replaces an unknown one: its sender has seen all samples in between.
        let mut insert = self
            .sql
            .prepare_cached(
                "INSERT INTO message VALUES (?1, ?2, ?3, ?4, ?5, ?6) ON CONFLICT DO UPDATE SET after = excluded.after
                 WHERE after IS NULL AND excluded.after IS NOT NULL",
            )?;
        let received = wall_ms() as i64;
        let values = params![
            id,
            number,
            label.after,
            label.wall_ms as i64,
            received,
            taken.payload
        ];
        let changed = insert.execute(values)?;
        drop(insert);
        if let Some(stream) = self.streams.get_mut(&id) {
            let is_newest = number > stream.newest;
            stream.newest = stream.newest.max(number);
            stream.head = stream.head.max(number);
            stream.is_written = false;
            if number > stream.good && stream.follows(label.after) {
                stream.good = number;
                if !is_newest {
                    self.advance(id)?;
                }
            }
        }
        Ok(if changed > 0 {
            StoreOutcome::New(order)
        } else {
            StoreOutcome::Known
        })
    }

    /// Takes in a machine's progress from its status. Returns the place of its run among all, `None` if the run was refused.
    ///
    /// # Errors
    /// The disk cannot be written.
    pub fn status(&mut self, id: &MachineId, status: &Status) -> rusqlite::Result<Option<i64>> {
        let (owner, run) = (self.owner(id)?, status.run as i64);
        let Some(order) = self.run(owner, run)? else {
            return Ok(None);
        };
        let ahead = (status.wall_ms as i64).saturating_sub(wall_ms() as i64);
        self.reported_run(owner, run, status, ahead)?;
        for (name, reported) in &status.streams {
            // Only streams that a message could create as well.
            if reported.head < 0 || !super::intake::is_stream(name) {
                continue;
            }
            let number = self.stream(id, owner, run, name)?;
            if let Some(stream) = self.streams.get_mut(&number) {
                stream.is_written &=
                    stream.head >= reported.head && stream.per_period == reported.per_period;
                stream.head = stream.head.max(reported.head);
                stream.per_period = reported.per_period;
            }
        }
        if let Some(owner) = self.machines.get_mut(id)
            && (&owner.reported.0, &owner.reported.1) != (&status.kind, &status.version)
        {
            owner.reported = (status.kind.clone(), status.version.clone());
            let update = "UPDATE machine SET kind = ?, version = ? WHERE id = ?";
            let values = params![status.kind, status.version, owner.id];
            self.sql.execute(update, values)?;
        }
        Ok(Some(order))
    }

    /// Stores an alarm.
    ///
    /// # Errors
    /// The disk cannot be written.
    pub fn alarm(&self, alarm: &Alarm) -> rusqlite::Result<()> {
        let values = params![
            wall_ms() as i64,
            alarm.id.site,
            alarm.id.machine,
            alarm.kind,
            alarm.text
        ];
        let insert = "INSERT INTO alarm VALUES (?, ?, ?, ?, ?)";
        self.sql.execute(insert, values).map(|_| ())
    }

    /// Adds refused messages of a machine.
    ///
    /// # Errors
    /// The disk cannot be written.
    pub fn refused(&mut self, id: &MachineId, why: &str, messages: u64) -> rusqlite::Result<()> {
        let Some(owner) = self.machines.get(id) else {
            return Ok(());
        };
        let add = "INSERT INTO refused VALUES (?1, ?2, ?3) ON CONFLICT DO UPDATE SET messages = messages + ?3";
        let values = params![owner.id, why, i64::try_from(messages).unwrap_or(i64::MAX)];
        self.sql.execute(add, values).map(|_| ())
    }

    /// Deletes messages received more than `days` ago by our clock, then the runs and machines that are left empty.
    ///
    /// # Errors
    /// The disk cannot be written.
    pub fn forget(&mut self, days: f64) -> rusqlite::Result<()> {
        let limit = wall_ms() as i64 - (days * 86_400_000.0) as i64;
        for delete in [
            "DELETE FROM message WHERE received_ms < ?",
            "DELETE FROM alarm WHERE at_ms < ?",
            FIRST_RUNS,
        ] {
            self.sql.execute(delete, [limit])?;
        }
        self.sql.execute_batch(FORGET_RUNS)?;
        self.sql.execute_batch(FORGET_NAMES)?;
        (self.machines, self.ids) = (HashMap::new(), HashMap::new());
        (self.runs, self.begun, self.streams) = (Runs::new(), HashMap::new(), BTreeMap::new());
        self.load_runs().and_then(|()| self.load())
    }
}

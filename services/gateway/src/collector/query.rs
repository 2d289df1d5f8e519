//! `heft fleet query`: the history as a table.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use rusqlite::{Connection, OpenFlags, params};
use serde_json::json;

use super::intake::decode;
use super::store;
use super::table::{Format, Table};
use crate::{Failure, error, wall_ms};

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum What {
    /// One row for each swing or drive.
    Loads,
    /// What was in the bucket, load by load, and what the trucks hold.
    Ledger,
    /// Estimates.
    Estimates,
    /// Estimates that a site has made of a machine's samples.
    Site,
    /// How the processes were.
    Health,
    /// Changes of the processes' state.
    Events,
    /// What was raised.
    Alarms,
    /// What the machines have learnt, and who stands out among its like.
    Parameters,
}

/// `heft fleet query`
#[derive(Debug, Clone, clap::Args)]
pub struct QueryArgs {
    /// The history (SQLite)
    #[arg(long, default_value = "fleet.sqlite", value_name = "FILE")]
    pub db: PathBuf,
    /// The site; all if absent
    #[arg(long)]
    pub site: Option<String>,
    /// The machine; all if absent
    #[arg(long)]
    pub machine: Option<String>,
    /// How far back, such as 30m, 8h, 7d
    #[arg(long, default_value = "8h", value_parser = milliseconds)]
    pub since: i64,
    /// What
    #[arg(long, value_enum, default_value = "loads")]
    pub what: What,
    /// How
    #[arg(long, value_enum, default_value = "csv")]
    pub format: Format,
}

/// "8h" in milliseconds.
pub(super) fn milliseconds(text: &str) -> Result<i64, String> {
    view::duration::of(text, None).map(|time| (1e3 * time) as i64)
}

/// Opens a history for reading; a collector may write it meanwhile.
///
/// # Errors
/// There is no such history.
pub fn open(db: &Path) -> Result<Connection, String> {
    if !db.exists() {
        let remedy = "`heft fleet --db FILE` makes it";
        return Err(error("there is no history", db.display(), remedy));
    }
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let sql = store::connect(db, flags).and_then(|sql| {
        sql.query_row("SELECT count(*) FROM machine", [], |_| Ok(()))?;
        Ok(sql)
    });
    sql.map_err(|e| store::failed(&e, db))
}

/// Writes the requested table.
///
/// # Errors
/// There is no history.
pub fn query(args: &QueryArgs, out: &mut impl Write) -> Result<(), Failure> {
    let sql = open(&args.db)?;
    is_known(&sql, args)?;
    let done = match args.what {
        What::Alarms => alarms(&sql, args, out),
        What::Parameters => parameters(&sql, args, out),
        What::Loads => messages(&sql, args, "loads/", out),
        What::Ledger => messages(&sql, args, "ledger/", out),
        What::Estimates => messages(&sql, args, "estimate/", out),
        What::Site => messages(&sql, args, "site/", out),
        What::Health => messages(&sql, args, "health/", out),
        What::Events => messages(&sql, args, "events/", out),
    };
    done.map_err(|e| match e {
        QueryError::Sql(e) => store::failed(&e, &args.db).into(),
        QueryError::Damaged { bad, all } => error(
            format!("{bad} of {all} messages are damaged; they are left out"),
            args.db.display(),
            "`sqlite3 FILE 'PRAGMA integrity_check'` says more",
        )
        .into(),
        QueryError::Io(e) => Failure::not_written(&e),
    })
}

/// Refuses a site or a machine that the history does not have: a misspelt one.
fn is_known(sql: &Connection, args: &QueryArgs) -> Result<(), Failure> {
    let failed = |e| store::failed(&e, &args.db);
    let sql_text = "SELECT EXISTS (SELECT 1 FROM machine WHERE (?1 IS NULL OR site = ?1) AND (?2 IS NULL OR name = ?2))";
    let found = sql.query_row(sql_text, params![args.site, args.machine], |row| row.get(0));
    if (args.site.is_none() && args.machine.is_none()) || found.map_err(failed)? {
        return Ok(());
    }
    let place = [("--site", &args.site), ("--machine", &args.machine)];
    let place = place
        .iter()
        .filter_map(|(option, name)| Some(format!("{option} {}", name.as_ref()?)));
    Err(error(
        "the history has no such machine",
        place.collect::<Vec<_>>().join(" "),
        known(sql).map_err(failed)?,
    )
    .into())
}

/// Machines of a history that are named where nothing fits.
const MOST_NAMED: usize = 10;

/// Which machines a history has, for whoever asks for another one.
fn known(sql: &Connection) -> rusqlite::Result<String> {
    let mut query = sql.prepare("SELECT site, name FROM machine ORDER BY site, name")?;
    let names = query.query_map([], |row| {
        Ok(format!(
            "{}/{}",
            row.get::<_, String>(0)?,
            row.get::<_, String>(1)?
        ))
    })?;
    let names: Vec<String> = names.collect::<Result<_, _>>()?;
    let more = names.len().saturating_sub(MOST_NAMED);
    let first = names[..names.len() - more].join(", ");
    Ok(match (names.len(), more) {
        (0, _) => "there is no machine in it yet".into(),
        (_, 0) => format!("it has {first}"),
        _ => format!("it has {first} and {more} more"),
    })
}

enum QueryError {
    Sql(rusqlite::Error),
    Io(io::Error),
    /// Number of messages that do not decode as their stream.
    Damaged {
        bad: usize,
        all: usize,
    },
}

impl From<rusqlite::Error> for QueryError {
    fn from(error: rusqlite::Error) -> Self {
        Self::Sql(error)
    }
}

impl From<io::Error> for QueryError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Compares all machines, even if only one is printed.
fn parameters(sql: &Connection, args: &QueryArgs, out: &mut impl Write) -> Result<(), QueryError> {
    let since = wall_ms() as i64 - args.since;
    let mut compared = super::parameters::compare(sql, since, args.site.as_deref())?;
    if let Some(name) = &args.machine {
        for machines in compared.values_mut() {
            machines.retain(|m| m.names[1] == *name);
        }
    }
    Ok(super::parameters::write(&compared, args.format, out)?)
}

/// Messages of the streams of a kind.
fn messages(
    sql: &Connection,
    args: &QueryArgs,
    kind: &str,
    out: &mut impl Write,
) -> Result<(), QueryError> {
    let mut query = sql.prepare(
        // The message is selected by its time of reception; the time of measurement by our clock follows from the machine's
        // status.
        "SELECT m.site, m.name, s.run, s.name, e.wall_ms, e.payload, r.first_ms FROM message e JOIN stream s ON s.id = e.stream
         JOIN machine m ON m.id = s.machine JOIN run r ON r.machine = s.machine AND r.run = s.run
         WHERE substr(s.name, 1, length(?1)) = ?1 AND e.received_ms >= ?2 AND e.wall_ms - r.off_ms >= ?2
           AND (?3 IS NULL OR m.site = ?3) AND (?4 IS NULL OR m.name = ?4)
         ORDER BY m.site, m.name, r.id, s.name, e.number",
    )?;
    let since = wall_ms() as i64 - args.since;
    let mut rows = query.query(params![kind, since, args.site, args.machine])?;
    let mut table = Table::new(args.format);
    let (mut bad, mut all) = (0, 0);
    while let Some(row) = rows.next()? {
        all += 1;
        let words: [String; 2] = [row.get(0)?, row.get(1)?];
        let (run, stream, wall): (i64, String, i64) = (row.get(2)?, row.get(3)?, row.get(4)?);
        let Some(message) = decode(&stream, &row.get::<_, Vec<u8>>(5)?) else {
            bad += 1;
            continue;
        };
        let first: i64 = row.get(6)?;
        let said = [
            ("site", json!(words[0])),
            ("machine", json!(words[1])),
            ("run", json!(run)),
            ("run_first_received_ms", json!(first)),
            // Former name of the column, retained for one version.
            ("run_heard_ms", json!(first)),
            ("stream", json!(stream)),
            ("wall_ms", json!(wall)),
        ];
        table.row(out, &said, &message)?;
    }
    if all == 0 {
        let known = known(sql)?;
        eprintln!("nothing in the history fits --what, --site, --machine and --since; {known}");
    }
    match bad {
        0 => Ok(()),
        bad => Err(QueryError::Damaged { bad, all }),
    }
}

fn alarms(sql: &Connection, args: &QueryArgs, out: &mut impl Write) -> Result<(), QueryError> {
    let mut query = sql.prepare(
        "SELECT at_ms, site, name, kind, text FROM alarm
         WHERE at_ms >= ?1 AND (?2 IS NULL OR site = ?2) AND (?3 IS NULL OR name = ?3) ORDER BY at_ms",
    )?;
    let since = wall_ms() as i64 - args.since;
    let mut rows = query.query(params![since, args.site, args.machine])?;
    if args.format == Format::Csv {
        writeln!(out, "wall_ms,site,machine,alarm,text")?;
    }
    while let Some(row) = rows.next()? {
        let at: i64 = row.get(0)?;
        let [site, name, kind, text]: [String; 4] =
            [row.get(1)?, row.get(2)?, row.get(3)?, row.get(4)?];
        match args.format {
            Format::Json => {
                let object = json!({"wall_ms": at, "site": site, "machine": name, "alarm": kind, "text": text});
                writeln!(out, "{object}")?;
            }
            Format::Csv => writeln!(
                out,
                "{at},{site},{name},{kind},\"{}\"",
                text.replace('"', "\"\"")
            )?,
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(db: &Path) -> Result<(), String> {
        asked_of(db, &[])
    }

    fn asked_of(db: &Path, more: &[&str]) -> Result<(), String> {
        use clap::Parser;
        #[derive(clap::Parser)]
        struct Cli {
            #[command(flatten)]
            args: QueryArgs,
        }
        let db = db.to_str().expect("UTF-8");
        let all = ["query", "--db", db, "--what", "estimates"];
        let cli = Cli::parse_from(all.iter().chain(more));
        query(&cli.args, &mut Vec::new()).map_err(|failure| failure.error)
    }

    #[test]
    fn whoever_asks_for_another_machine_is_told_which_there_are() {
        let sql = Connection::open_in_memory().expect("a database");
        let made = sql.execute_batch("CREATE TABLE machine (site TEXT, name TEXT)");
        made.expect("a table");
        assert_eq!(known(&sql).expect("read"), "there is no machine in it yet");
        for k in 10..22 {
            let name = format!("ex-{k}");
            let added = sql.execute("INSERT INTO machine VALUES ('north', ?1)", params![name]);
            added.expect("a row");
        }
        let said = known(&sql).expect("read");
        assert!(said.starts_with("it has north/ex-10, "), "{said}");
        assert!(said.ends_with("north/ex-19 and 2 more"), "{said}");
    }

    #[test]
    fn what_is_no_history_is_reported_and_left_unchanged() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        let words = |name: &str| asked(&path(name)).expect_err(name);
        assert!(words("none").contains("`heft fleet --db FILE` makes it"));
        let made = std::process::Command::new("mkfifo")
            .arg(path("pipe"))
            .status();
        assert!(made.is_ok_and(|status| status.success()));
        std::fs::create_dir(path("folder")).expect("a folder");
        std::fs::write(path("table.csv"), "t,speed\n0,1\n").expect("written");
        for name in ["pipe", "folder", "table.csv"] {
            let said = words(name);
            assert!(said.contains(name) && said.contains("--db"), "{said}");
        }
        for table in ["x (a)", "machine (a)"] {
            let file = path("other.sqlite");
            let sql = Connection::open(&file).expect("a database");
            let made = sql.execute_batch(&format!("DROP TABLE IF EXISTS x; CREATE TABLE {table}"));
            made.expect("a table");
            drop(sql);
            let before = std::fs::read(&file).expect("bytes");
            assert!(words("other.sqlite").contains("no history of a fleet"));
            assert!(store::Store::open(&file).is_err(), "{table}");
            assert_eq!(std::fs::read(&file).expect("bytes"), before, "{table}");
        }
    }

    #[test]
    fn a_damaged_message_of_a_history_is_reported() {
        let folder = tempfile::tempdir().expect("a folder");
        let db = folder.path().join("fleet.sqlite");
        drop(store::Store::open(&db).expect("a history"));
        assert_eq!(asked(&db), Ok(()));
        let sql = Connection::open(&db).expect("a database");
        let now = wall_ms();
        let filled = sql.execute_batch(&format!(
            "INSERT INTO machine (id, site, name) VALUES (1, 'north', 'ex-1');
             INSERT INTO run (machine, run, first_ms) VALUES (1, 7, {now});
             INSERT INTO stream (id, machine, run, name) VALUES (1, 1, 7, 'estimate/inertia_ukf');
             INSERT INTO message VALUES (1, 1, NULL, {now}, {now}, x'ffff');"
        ));
        filled.expect("a message");
        for unknown in [["--site", "nroth"], ["--machine", "ex-2"]] {
            let said = asked_of(&db, &unknown).expect_err("no such machine");
            assert!(said.contains("it has north/ex-1"), "{said}");
            assert!(said.contains(&unknown.join(" ")), "{said}");
        }
        let said = asked_of(&db, &["--site", "north"]).expect_err("damage");
        assert!(said.contains("1 of 1 messages are damaged"), "{said}");
    }

    #[test]
    fn how_far_back_is_a_number_and_a_unit() {
        assert_eq!(milliseconds("8h"), Ok(28_800_000));
        assert_eq!(milliseconds("1.5m"), Ok(90_000));
        assert_eq!(milliseconds("8 h"), Ok(28_800_000), "as everywhere");
        for bad in ["", "8", "h", "-1h", "NaNh", "1e9d", "é"] {
            assert!(milliseconds(bad).is_err(), "{bad}");
        }
    }
}

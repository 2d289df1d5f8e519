//! Processes of a fleet for tests: a router in this process, and all other programs as processes of their own.

pub mod relay;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use gateway::link;
use zenoh::{Session, Wait};

/// A process that is killed at the end of the test.
pub struct Process(pub Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Process {
    fn start(command: &mut Command) -> Self {
        Self(command.spawn().expect("the program is built"))
    }

    /// Sends SIGTERM, and waits for the end.
    pub fn end(mut self) {
        let pid = rustix::process::Pid::from_raw(self.0.id() as i32).expect("a process");
        let _ = rustix::process::kill_process(pid, rustix::process::Signal::TERM);
        let _ = self.0.wait();
    }

    /// Waits until it ends by itself.
    pub fn wait(mut self) {
        let _ = self.0.wait();
    }
}

/// The router of a test, in this process: the same code as `zenohd`, without its plug-ins.
pub struct Router {
    pub address: String,
    session: Option<Session>,
}

impl Router {
    pub fn start() -> Self {
        let port = TcpListener::bind("127.0.0.1:0")
            .and_then(|l| l.local_addr())
            .expect("a port")
            .port();
        let mut router = Self {
            address: format!("tcp/127.0.0.1:{port}"),
            session: None,
        };
        router.up();
        router
    }

    pub fn up(&mut self) {
        let begun = Instant::now();
        while self.session.is_none() {
            // The port may still be in use for a short time.
            self.session = link::router(Some(&self.address), None).ok();
            assert!(
                begun.elapsed() < Duration::from_secs(30),
                "the router starts"
            );
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Closes the router: all connections break, and new ones are refused.
    pub fn down(&mut self) {
        if let Some(session) = self.session.take() {
            session.close().wait().expect("the router ends");
        }
    }

    pub fn client(&self) -> Session {
        let link = link::LinkArgs {
            connect: self.address.clone(),
            zenoh_config: None,
        };
        link::client(&link, &[]).expect("a session")
    }
}

/// A machine, with the stand-in in place of its pipeline.
pub struct Machine {
    pub domain: String,
    pub folder: tempfile::TempDir,
    pub process: Process,
}

/// `parts`: bytes of a part of the recording, and bytes retained.
pub fn machine(rate: f64, seconds: f64, parts: Option<(u64, u64)>) -> Machine {
    let parts = parts.map_or_else(Vec::new, |(part, kept)| {
        vec![part.to_string(), kept.to_string()]
    });
    stand_in(rate, seconds, &parts)
}

/// A machine that also has the samples of a file.
pub fn machine_with_samples(rate: f64, seconds: f64, file: &Path) -> Machine {
    stand_in(rate, seconds, &[format!("samples={}", file.display())])
}

fn stand_in(rate: f64, seconds: f64, more: &[String]) -> Machine {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let domain = format!(
        "fleet-{}-{}",
        std::process::id(),
        COUNT.fetch_add(1, Ordering::Relaxed)
    );
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(beside("examples/stand_in"));
    command
        .arg(&domain)
        .arg(folder.path())
        .arg(rate.to_string())
        .arg(seconds.to_string())
        .args(more);
    let mut process = Process::start(command.stdout(Stdio::piped()));
    let mut line = String::new();
    let out = process.0.stdout.take().expect("piped");
    BufReader::new(out).read_line(&mut line).expect("it speaks");
    assert_eq!(line, "ready\n");
    Machine {
        domain,
        folder,
        process,
    }
}

impl Machine {
    /// Waits for the end of its pipeline; its recording is retained.
    pub fn until_it_ends(mut self) -> Self {
        let _ = self.process.0.wait();
        self
    }
}

/// The path of a program that cargo has built with the tests.
pub fn beside(name: &str) -> PathBuf {
    Path::new(env!("CARGO_BIN_EXE_heft-gateway")).with_file_name(name)
}

/// A gateway that sends ten estimates a second.
pub fn gateway(machine: &Machine, id: &str, router: &str) -> Process {
    gateway_with(machine, id, router, &[])
}

/// The same with more arguments.
pub fn gateway_with(machine: &Machine, id: &str, router: &str, more: &[&str]) -> Process {
    let mut command = Command::new(env!("CARGO_BIN_EXE_heft-gateway"));
    command
        .args([
            "--domain",
            &machine.domain,
            "--connect",
            router,
            "--site",
            "north",
        ])
        .args(more);
    Process::start(command.args(["--machine-id", id, "--rate", "10", "--linger", "60"]))
}

/// A collector.
pub struct Collector {
    pub db: PathBuf,
    pub page: String,
    pub process: Process,
}

pub fn collector(router: &str, db: &Path, more: &[&str]) -> Collector {
    let mut command = Command::new(env!("CARGO_BIN_EXE_heft-fleet"));
    command
        .args(["--connect", router, "--page", "127.0.0.1:0", "--db"])
        .arg(db)
        .args(more);
    let mut process = Process::start(command.stderr(Stdio::piped()));
    let mut lines = BufReader::new(process.0.stderr.take().expect("piped")).lines();
    let first = lines.next().expect("a line").expect("text");
    // Later messages must not fill the pipe.
    std::thread::spawn(move || {
        lines.for_each(|line| eprintln!("collector: {}", line.unwrap_or_default()))
    });
    Collector {
        db: db.to_owned(),
        page: first
            .strip_prefix("fleet: http://")
            .expect("its address")
            .to_owned(),
        process,
    }
}

impl Collector {
    /// A page, with its head.
    pub fn get(&self, path: &str, host: &str) -> String {
        let mut stream = TcpStream::connect(&self.page).expect("it listens");
        write!(
            stream,
            "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
        )
        .expect("sent");
        let mut page = String::new();
        stream.read_to_string(&mut page).expect("a page");
        page
    }

    /// What `heft fleet query` prints, as JSON.
    pub fn query(&self, what: &str) -> Vec<serde_json::Value> {
        query(&self.db, what)
    }

    /// Numbers of a stream, in order.
    pub fn numbers(&self, machine: &str, stream: &str) -> Vec<u64> {
        let kind = if stream.starts_with("estimate") {
            "estimates"
        } else {
            stream.split('/').next().unwrap_or_default()
        };
        let all = self.query(kind);
        let its = all
            .iter()
            .filter(|m| m["machine"] == machine && m["stream"] == stream);
        its.map(|m| m["sequence"].as_u64().expect("a number"))
            .collect()
    }

    /// Waits until this number of messages of a stream has arrived and no stream of the machine has a gap. A failure names the
    /// missing numbers.
    pub fn until_whole(&self, machine: &str, stream: &str, messages: usize) {
        let begun = Instant::now();
        loop {
            let (here, gaps) = (self.numbers(machine, stream).len(), self.gaps(machine));
            if here >= messages && gaps.is_empty() {
                return;
            }
            assert!(
                begun.elapsed() < LIMIT,
                "the history is whole: {here} of {messages} of {stream}; gaps (good, head, lost): {gaps:?}"
            );
            sleep(0.2);
        }
    }

    /// Streams of a machine with a gap: last number without a gap, last number, and count of lost messages.
    fn gaps(&self, machine: &str) -> Vec<(String, [i64; 3])> {
        let sql = gateway::collector::query::open(&self.db).expect("a history");
        let text = "SELECT s.name, good, head, lost FROM stream s JOIN machine m ON m.id = s.machine WHERE m.name = ? AND good < head";
        let mut query = sql.prepare(text).expect("a query");
        let all = query.query_map([machine], |row| {
            Ok((row.get(0)?, [row.get(1)?, row.get(2)?, row.get(3)?]))
        });
        let all = all.expect("rows");
        all.map(|stream| stream.expect("a stream")).collect()
    }

    /// Number of lost messages, and of streams with a gap, of a machine.
    pub fn account(&self, machine: &str) -> (i64, i64) {
        let sql = gateway::collector::query::open(&self.db).expect("a history");
        let text = "SELECT coalesce(sum(lost), 0), coalesce(sum(good < head), 0) FROM stream s JOIN machine m ON m.id = s.machine WHERE m.name = ?";
        sql.query_row(text, [machine], |row| Ok((row.get(0)?, row.get(1)?)))
            .expect("a sum")
    }
}

pub fn query(db: &Path, what: &str) -> Vec<serde_json::Value> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_heft-fleet"));
    let out = command
        .args(["query", "--what", what, "--format", "json", "--db"])
        .arg(db)
        .output();
    let out = out.expect("it runs");
    assert!(
        out.status.success(),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
    let text = String::from_utf8(out.stdout).expect("text");
    text.lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect()
}

/// Longest wait for a condition.
const LIMIT: Duration = Duration::from_secs(120);

/// Waits until a condition holds.
pub fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < LIMIT, "{what}");
        std::thread::sleep(Duration::from_millis(200));
    }
}

pub fn sleep(seconds: f64) {
    std::thread::sleep(Duration::from_secs_f64(seconds));
}

/// A file of the repository.
pub fn of_repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(path)
}

/// The program heft, from the variable HEFT or a build of the main workspace. Reports if there is none.
pub fn heft() -> Option<PathBuf> {
    let own = std::env::var_os("HEFT").map(PathBuf::from);
    let built = ["target/debug/heft", "target/release/heft"].map(of_repository);
    let mut all = own.into_iter().chain(built);
    let heft = all
        .find(|p| p.is_file())
        .and_then(|p| p.canonicalize().ok());
    if heft.is_none() {
        println!("left out: there is no heft; `cargo build`, or name it as HEFT");
    }
    heft
}

/// The numbers of the estimates that a stand-in's gateway sends in this number of seconds: ten per second. The verdict
/// changes at multiples of five seconds, which are among them.
pub fn expected(rate: u64, seconds: u64) -> Vec<u64> {
    (0..seconds * 10).map(|i| i * rate / 10).collect()
}

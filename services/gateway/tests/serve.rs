//! `heft fleet serve`: machines send their samples, and the estimates of the site equal those of `heft estimate`.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::channel;
use std::time::Duration;

use crate::common::{
    Machine, Router, collector, gateway_with, heft, machine_with_samples, of_repository, until,
};
use zenoh::Wait;

const STREAM: &str = "site/inertia_ukf";
/// The compared columns.
const COLUMNS: [&str; 6] = [
    "t",
    "inertia",
    "inertia_std",
    "payload",
    "payload_std",
    "velocity",
];

/// Parent and arguments of every process.
fn processes() -> BTreeMap<u32, (u32, String)> {
    let all = std::fs::read_dir("/proc").expect("/proc").flatten();
    let all = all.filter_map(|e| e.file_name().to_str()?.parse::<u32>().ok());
    let look = |pid: u32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        let (_, rest) = stat.rsplit_once(") ")?;
        let parent = rest.split(' ').nth(1)?.parse().ok()?;
        let said = std::fs::read(format!("/proc/{pid}/cmdline")).ok()?;
        Some((pid, (parent, String::from_utf8_lossy(&said).into_owned())))
    };
    all.filter_map(look).collect()
}

/// A site that estimates every sample, in two processes.
fn site(heft: &Path, router: &Router) -> crate::common::Process {
    let mut command = Command::new(env!("CARGO_BIN_EXE_heft-fleet"));
    command.args(["serve", "excavator", "--site", "north", "--every", "0"]);
    command
        .args(["--connect", &router.address, "--heft"])
        .arg(heft);
    command.args(["--", "--shards", "2"]);
    let site = command.stderr(Stdio::piped()).spawn().expect("it starts");
    crate::common::Process(site)
}

/// The shards of the site: children of its `heft serve`.
fn shards(site: &Child) -> Vec<u32> {
    let all = processes();
    let is_of = |parent: u32| all.get(&parent).is_some_and(|(p, _)| *p == site.id());
    let shards = all
        .iter()
        .filter(|(_, (p, said))| is_of(*p) && said.contains("--shard\0"));
    shards.map(|(pid, _)| *pid).collect()
}

/// The rows of a table, by column.
fn rows(text: &str) -> Vec<BTreeMap<&str, &str>> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let row = |line| names.iter().copied().zip(str::split(line, ',')).collect();
    lines.map(row).collect()
}

/// The output of a program.
fn printed(command: &mut Command) -> String {
    let out = command.output().expect("it runs");
    assert!(
        out.status.success(),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
    String::from_utf8(out.stdout).expect("text")
}

/// The table that `heft estimate` writes for the samples in a recording.
fn alone(heft: &Path, machine: &Machine) -> String {
    let out = machine.folder.path().join("alone.csv");
    let mut command = Command::new(heft);
    command
        .arg("estimate")
        .arg(machine.folder.path().join("run.mcap"));
    printed(command.args(["--machine", "excavator", "-o"]).arg(&out));
    std::fs::read_to_string(out).expect("estimates")
}

/// Asserts that the rows are equal, bit for bit.
fn assert_same(found: &[BTreeMap<&str, &str>], expected: &[BTreeMap<&str, &str>]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        for column in COLUMNS {
            let number = |row: &BTreeMap<&str, &str>| row[column].parse::<f64>().ok();
            match number(expected) {
                Some(x) => assert_eq!(number(found).map(f64::to_bits), Some(x.to_bits())),
                // The method does not estimate the quantity, or not yet.
                None => assert_eq!((expected[column], found[column]), ("", ""), "{column}"),
            }
        }
    }
}

#[test]
fn the_site_estimates_what_heft_estimate_does_bit_for_bit_also_when_its_processes_die() {
    let Some(heft) = heft() else { return };
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    let mut site = site(&heft, &router);
    let files = ["excavator_input_two_swings.csv", "excavator_input_drop.csv"];
    let files = files.map(|f| of_repository("tests/golden").join(f));
    // The longer one takes 17 s.
    let machines = files.map(|f| machine_with_samples(100.0, 20.0, &f));
    let names = ["ex-1", "ex-2"];
    let _gateways: Vec<_> = machines
        .iter()
        .zip(names)
        .map(|(m, name)| gateway_with(m, name, &router.address, &["--samples"]))
        .collect();
    until("it answers", || centre.numbers("ex-1", STREAM).len() > 100);
    let old = shards(&site.0);
    assert_eq!(old.len(), 2);
    for pid in &old {
        let pid = rustix::process::Pid::from_raw(*pid as i32).expect("a process");
        rustix::process::kill_process(pid, rustix::process::Signal::KILL).expect("it is there");
    }
    until("others go on", || {
        let new = shards(&site.0);
        new.len() == 2 && new.iter().all(|pid| !old.contains(pid))
    });
    let machines = machines.map(Machine::until_it_ends);
    let (mut rows_in_all, mut is_trusted) = (0, false);
    for (machine, name) in machines.iter().zip(names) {
        let expected = alone(&heft, machine);
        let expected = rows(&expected);
        assert!(expected.len() > 400, "{}", expected.len());
        rows_in_all += expected.len();
        until("all is answered", || {
            centre.numbers(name, STREAM).len() >= expected.len()
        });
        // Not as JSON, because its readers round.
        let mut query = Command::new(env!("CARGO_BIN_EXE_heft-fleet"));
        query.args(["query", "--what", "site", "--machine", name, "--db"]);
        let found = printed(query.arg(&centre.db));
        let found = rows(&found);
        assert_same(&found, &expected);
        is_trusted |= expected.iter().any(|row| row["trusted"] == "1");
        let values: std::collections::BTreeSet<&str> =
            expected.iter().map(|row| row["inertia"]).collect();
        assert!(values.len() > 100, "not all alike");
        until("nothing is missing", || centre.account(name) == (0, 0));
    }
    assert!(is_trusted, "one of the two is trusted somewhere");
    assert!(
        centre
            .get("/north/ex-1", "localhost")
            .contains("At the site")
    );
    assert!(
        centre
            .get("/north/ex-1", "localhost")
            .contains("samples for the site")
    );
    let pid = rustix::process::Pid::from_raw(site.0.id() as i32).expect("a process");
    rustix::process::kill_process(pid, rustix::process::Signal::INT).expect("it is there");
    let mut said = String::new();
    let mut stderr = site.0.stderr.take().expect("piped");
    stderr.read_to_string(&mut said).expect("text");
    let ended = site.0.wait().expect("its end");
    assert!(ended.success(), "{said}");
    let counted =
        format!("2 machines, {rows_in_all} samples, {rows_in_all} estimates; 0 samples missing");
    assert!(said.contains(&counted), "{said}");
    assert!(said.contains("2 processes replaced"), "{said}");
}

#[test]
fn a_collector_that_was_away_asks_the_site_for_its_estimates() {
    let Some(heft) = heft() else { return };
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let db = folder.path().join("fleet.sqlite");
    let centre = collector(&router.address, &db, &[]);
    let _site = site(&heft, &router);
    let file = of_repository("tests/golden/excavator_input_drop.csv");
    let machine = machine_with_samples(100.0, 15.0, &file);
    let _gateway = gateway_with(&machine, "ex-1", &router.address, &["--samples"]);
    until("it answers", || centre.numbers("ex-1", STREAM).len() > 50);
    drop(centre);
    let machine = machine.until_it_ends();
    let expected = alone(&heft, &machine);
    let count = rows(&expected).len();
    // Messages still to arrive: the repeated last estimate, and the answers of the site to queries.
    let centre = collector(&router.address, &db, &[]);
    let before = centre.numbers("ex-1", STREAM).len();
    assert!(before < count, "{before}: it was away in vain");
    until("the site has answered", || {
        centre.numbers("ex-1", STREAM).len() >= count
    });
    until("nothing is missing", || centre.account("ex-1") == (0, 0));
}

#[test]
fn what_a_site_did_not_estimate_while_it_was_away_is_a_hole_in_the_history() {
    let Some(heft) = heft() else { return };
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    let file = of_repository("tests/golden/excavator_input_two_swings.csv");
    let machine = machine_with_samples(100.0, 20.0, &file);
    let _gateway = gateway_with(&machine, "ex-1", &router.address, &["--samples"]);
    let first = site(&heft, &router);
    until("it answers", || centre.numbers("ex-1", STREAM).len() > 50);
    assert_eq!(centre.account("ex-1").0, 0);
    drop(first);
    let before = centre.numbers("ex-1", STREAM).len();
    crate::common::sleep(2.0);
    let _second = site(&heft, &router);
    until("another goes on", || {
        centre.numbers("ex-1", STREAM).len() > before + 50
    });
    until("the hole is counted", || centre.account("ex-1") == (1, 0));
    until("the page says so", || {
        let page = centre.get("/north/ex-1", "localhost");
        page.contains("not complete: 1 messages lost")
    });
}

#[test]
fn a_machine_that_was_not_asked_sends_no_samples() {
    let router = Router::start();
    let file = of_repository("tests/golden/excavator_input_drop.csv");
    let session = router.client();
    let names = ["shy", "open"];
    let heard = names.map(|name| {
        let (say, heard) = channel();
        let subscriber = session.declare_subscriber(format!("heft/v1/north/{name}/sample/**"));
        let subscriber = subscriber.callback(move |_| {
            let _ = say.send(());
        });
        (subscriber.wait().expect("it listens"), heard)
    });
    let machines = names.map(|_| machine_with_samples(100.0, 12.0, &file));
    let _shy = gateway_with(&machines[0], "shy", &router.address, &[]);
    let _open = gateway_with(&machines[1], "open", &router.address, &["--samples"]);
    for _ in 0..5 {
        let limit = Duration::from_secs(60);
        heard[1].1.recv_timeout(limit).expect("samples are sent");
    }
    assert!(heard[0].1.try_recv().is_err(), "it sends samples too");
}

/// Exit status of a site with this script in place of `heft serve`.
fn status_with(router: &Router, script: &str) -> Option<i32> {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let heft = folder.path().join("heft");
    std::fs::write(&heft, format!("#!/bin/sh\n{script}\n")).expect("a script");
    std::fs::set_permissions(&heft, std::fs::Permissions::from_mode(0o700)).expect("ours");
    let mut command = Command::new(env!("CARGO_BIN_EXE_heft-fleet"));
    command.args(["serve", "excavator", "--site", "north", "--heft"]);
    command.arg(heft).args(["--connect", &router.address]);
    command.status().expect("it runs").code()
}

#[test]
fn a_site_that_cannot_go_on_ends_with_1_where_another_start_may_help() {
    let router = Router::start();
    assert_eq!(status_with(&router, "exit 2"), Some(2), "wrong use");
    assert_eq!(status_with(&router, "exit 0"), Some(1), "it has ended");
    // An unreadable answer, and then a regular end.
    let unreadable = format!("printf '{}'; cat > /dev/null", r"\377".repeat(16));
    assert_eq!(status_with(&router, &unreadable), Some(1));
}

#[test]
fn a_history_that_cannot_be_written_now_ends_the_collector_with_1() {
    let run = |page: &str, db: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_heft-fleet"));
        command.args(["--connect", "tcp/127.0.0.1:1", "--page", page, "--db", db]);
        command.status().expect("it runs").code()
    };
    let folder = tempfile::tempdir().expect("a folder");
    let away = folder.path().join("away/fleet.sqlite");
    assert_eq!(run("127.0.0.1:0", &away.display().to_string()), Some(1));
    assert_eq!(run("0.0.0.0:0", &away.display().to_string()), Some(2));
}

#[test]
fn what_cannot_be_served_is_said() {
    let run = |args: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_heft-fleet"));
        let out = command.arg("serve").args(args).output().expect("it runs");
        assert_eq!(out.status.code(), Some(2));
        String::from_utf8_lossy(&out.stderr).into_owned()
    };
    let said = run(&["crane", "--site", "north"]);
    assert!(
        said.contains("there is no machine `crane`") && said.contains("loader"),
        "{said}"
    );
    let said = run(&["loader", "--site", "north", "--method", "x"]);
    assert!(said.contains("there is no method `x`"), "{said}");
    let said = run(&["loader", "--site", "a/b"]);
    assert!(said.contains("cannot name a site"), "{said}");
    let said = run(&["loader", "--site", "north", "--heft", "/nowhere/heft"]);
    assert!(said.contains("cannot start heft"), "{said}");
}

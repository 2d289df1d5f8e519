//! Guarantees of a fleet, with a real router, gateways and collectors. Live messages arrive at most once. The history is complete
//! after the link is restored, and lost messages are counted at both ends.

use crate::common::{Router, collector, expected, gateway, machine, sleep, until};

const UKF: &str = "estimate/inertia_ukf";

#[test]
fn two_machines_are_on_the_page_and_in_the_history() {
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    // Three swings: a live message arrives at most once, and a busy computer subscribes late.
    let machines = [machine(100.0, 34.0, None), machine(100.0, 34.0, None)];
    let gateways = [
        gateway(&machines[0], "ex-1", &router.address),
        gateway(&machines[1], "ex-2", &router.address),
    ];
    until("both are trusted, and have moved a load", || {
        let page = centre.get("/", "127.0.0.1");
        page.matches(">trusted<").count() == 2 && page.matches("Payload").count() == 2
    });
    let page = centre.get("/", &centre.page);
    for word in [
        "ex-1",
        "ex-2",
        "north",
        "excavator",
        "Swing inertia",
        "Payload",
        "stand-in",
    ] {
        assert!(page.contains(word), "{word}");
    }
    assert!(page.contains("default-src 'none'"), "its policy");
    assert!(centre.get("/", "evil.example").starts_with("HTTP/1.1 403"));
    let one = centre.get("/north/ex-1", "localhost");
    assert!(
        one.contains("<svg") && one.contains("heft trusts"),
        "its own page"
    );
    assert!(
        centre
            .get("/north/ex-3", "localhost")
            .starts_with("HTTP/1.1 404")
    );
    for machine in machines {
        machine.process.wait();
    }
    let whole = expected(100, 34);
    for id in ["ex-1", "ex-2"] {
        centre.until_whole(id, UKF, whole.len());
        assert_eq!(centre.numbers(id, UKF), whole, "{id}");
        // A swing from 2 to 5 s of every 10 s, reported by its last estimate.
        let loads = centre.numbers(id, "loads/inertia_ukf");
        assert_eq!(loads, [499, 1499, 2499], "{id}");
        assert_eq!(centre.account(id), (0, 0), "{id}");
    }
    drop(gateways);
}

#[test]
fn after_a_cut_longer_than_the_cache_the_history_is_complete() {
    let mut router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    let other = collector(&router.address, &folder.path().join("other.sqlite"), &[]);
    let machine = machine(100.0, 30.0, None);
    let _gateway = gateway(&machine, "ex-1", &router.address);
    until("it is heard", || !centre.numbers("ex-1", UKF).is_empty());
    sleep(2.0);
    router.down();
    sleep(10.0);
    let before = centre.numbers("ex-1", UKF).len();
    router.up();
    machine.process.wait();
    let whole = expected(100, 30);
    assert!(
        before < whole.len() - 40,
        "{before} of {} came before the cut",
        whole.len()
    );
    for centre in [&centre, &other] {
        centre.until_whole("ex-1", UKF, whole.len());
        assert_eq!(centre.numbers("ex-1", UKF), whole);
        assert_eq!(
            centre.numbers("ex-1", "loads/inertia_ukf"),
            [499, 1499, 2499]
        );
        assert_eq!(centre.account("ex-1"), (0, 0));
    }
}

#[test]
fn a_gateway_that_is_killed_and_started_again_leaves_no_gap() {
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    let machine = machine(100.0, 20.0, None);
    let first = gateway(&machine, "ex-1", &router.address);
    until("it is heard", || centre.numbers("ex-1", UKF).len() > 20);
    drop(first); // kill -9
    sleep(4.0);
    let _second = gateway(&machine, "ex-1", &router.address);
    machine.process.wait();
    let whole = expected(100, 20);
    centre.until_whole("ex-1", UKF, whole.len());
    assert_eq!(centre.numbers("ex-1", UKF), whole);
    assert_eq!(centre.account("ex-1"), (0, 0));
}

#[test]
fn a_run_that_was_killed_or_gave_up_is_reported_and_one_that_ended_in_order_is_not() {
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    let machines = ["ended", "killed", "gave-up"].map(|id| {
        let seconds = if id == "killed" { 600.0 } else { 8.0 };
        let machine = machine(100.0, seconds, None);
        let gateway = gateway(&machine, id, &router.address);
        until("it is heard", || !centre.numbers(id, UKF).is_empty());
        (machine, gateway)
    });
    let [(ended, _first), (killed, _second), (gave_up, third)] = machines;
    drop(killed); // kill -9
    let pid = rustix::process::Pid::from_raw(third.0.id() as i32).expect("a process");
    rustix::process::kill_process(pid, rustix::process::Signal::HUP).expect("it is there");
    let broken = || -> Vec<String> {
        let all = centre.query("alarms");
        let its = all.iter().filter(|alarm| alarm["alarm"] == "broken");
        let machine = |alarm: &serde_json::Value| alarm["machine"].as_str().map(str::to_owned);
        its.filter_map(machine).collect()
    };
    ended.process.wait();
    gave_up.process.wait();
    let is_broken = |id: &str| broken().iter().any(|machine| machine == id);
    until("both are broken", || {
        is_broken("killed") && is_broken("gave-up")
    });
    until("the page says so", || {
        centre.get("/", &centre.page).matches(">broke off<").count() == 2
    });
    // Longer than the permitted silence of a machine without a gateway.
    sleep(9.0);
    let all = centre.query("alarms");
    let others = all.iter().filter(|alarm| alarm["machine"] == "ended");
    let kinds: Vec<_> = others.map(|alarm| &alarm["alarm"]).collect();
    assert!(
        !kinds.iter().any(|k| *k == "broken" || *k == "silent"),
        "{kinds:?}"
    );
}

#[test]
fn a_collector_that_was_away_asks_for_what_it_missed() {
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let db = folder.path().join("fleet.sqlite");
    let machine = machine(100.0, 20.0, None);
    let _gateway = gateway(&machine, "ex-1", &router.address);
    sleep(3.0);
    let first = collector(&router.address, &db, &[]);
    until("it is heard", || first.numbers("ex-1", UKF).len() > 20);
    first.process.end();
    sleep(5.0);
    let centre = collector(&router.address, &db, &[]);
    machine.process.wait();
    let whole = expected(100, 20);
    centre.until_whole("ex-1", UKF, whole.len());
    assert_eq!(centre.numbers("ex-1", UKF), whole);
}

#[test]
fn what_the_recording_has_dropped_is_counted_at_both_ends() {
    let mut router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    // Parts of 100 kB, of which three are retained: some seconds.
    let machine = machine(200.0, 40.0, Some((100_000, 300_000)));
    let _gateway = gateway(&machine, "ex-1", &router.address);
    until("it is heard", || !centre.numbers("ex-1", UKF).is_empty());
    router.down();
    sleep(25.0);
    router.up();
    machine.process.wait();
    until("all that can be had is there", || {
        let newest = centre.numbers("ex-1", UKF).last().copied();
        newest == Some(expected(200, 40)[399]) && centre.account("ex-1").1 == 0
    });
    let here = centre.numbers("ex-1", UKF).len();
    let sql = gateway::collector::query::open(&centre.db).expect("a history");
    let lost: i64 = sql
        .query_row("SELECT lost FROM stream WHERE name = ?", [UKF], |row| {
            row.get(0)
        })
        .expect("a stream");
    assert!(lost > 0, "something was dropped");
    assert_eq!(here as i64 + lost, 400, "{here} here");
    // The page shows the losses of all streams, counted by the collector and by the machine.
    let page = || centre.get("/north/ex-1", "localhost");
    let said = |words: &str| -> Option<i64> {
        let page = page();
        let (before, _) = page.split_once(words)?;
        before
            .rsplit(|c: char| !c.is_ascii_digit())
            .next()?
            .parse()
            .ok()
    };
    sleep(3.0);
    let (ours, theirs) = (
        said(" messages lost"),
        said(" asked for and no longer recorded"),
    );
    assert_eq!(ours, Some(centre.account("ex-1").0));
    // The machine may report more lost messages, never fewer: Zenoh's cache may have provided some.
    assert!(theirs >= ours, "{theirs:?} at the machine, {ours:?} here");
}

#[test]
fn every_estimate_comes_on_request_until_the_time_is_over() {
    let router = Router::start();
    let machine = machine(100.0, 15.0, None);
    let _gateway = gateway(&machine, "ex-1", &router.address);
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_heft-fleet"));
    command.args([
        "full",
        "--connect",
        &router.address,
        "--site",
        "north",
        "--machine",
        "ex-1",
        "--for",
        "4s",
    ]);
    let out = command.output().expect("it runs");
    let (rows, said) = (
        String::from_utf8_lossy(&out.stdout),
        String::from_utf8_lossy(&out.stderr),
    );
    assert!(out.status.success(), "{said}");
    let numbers = |stream: &str| -> Vec<u64> {
        let its = rows.lines().filter(|l| l.starts_with(stream));
        its.filter_map(|l| l.split(',').nth(2)?.parse().ok())
            .collect()
    };
    for stream in ["estimate/inertia_ukf", "estimate/inertia_rls"] {
        let numbers = numbers(stream);
        assert!(numbers.len() > 100, "{} of {stream}", numbers.len());
        assert!(
            numbers.len() < 600,
            "{} of {stream}: it has an end",
            numbers.len()
        );
        assert!(
            numbers.windows(2).all(|w| w[1] == w[0] + 1),
            "none is missing"
        );
    }
    assert!(said.contains(" 0 missing"), "{said}");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_heft-fleet"));
    command.args([
        "full",
        "--connect",
        &router.address,
        "--site",
        "north",
        "--machine",
        "ex-9",
        "--for",
        "4s",
    ]);
    let out = command.output().expect("it runs");
    assert_eq!(out.status.code(), Some(2), "nobody is there");
}

#[test]
fn a_router_that_is_away_holds_up_neither_machine_nor_collector() {
    let mut router = Router::start();
    router.down();
    let folder = tempfile::tempdir().expect("a folder");
    let db = folder.path().join("fleet.sqlite");
    let first = collector(&router.address, &db, &[]);
    first.process.end();
    let centre = collector(&router.address, &db, &[]);
    let machine = machine(100.0, 12.0, None);
    let gateway = gateway(&machine, "ex-1", &router.address);
    sleep(8.0);
    router.up();
    machine.process.wait();
    let whole = expected(100, 12);
    centre.until_whole("ex-1", UKF, whole.len());
    assert_eq!(centre.numbers("ex-1", UKF), whole);
    router.down();
    gateway.end();
}

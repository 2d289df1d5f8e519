//! A closed site: mutual TLS, and a router that permits a machine to write only its own keys, both set up by
//! `examples/fleet`. Needs `openssl` and `python3`.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use crate::common::{collector, gateway_with, machine, sleep, until};
use gateway::label::Label;
use gateway::link::{self, LinkArgs};
use gateway::wall_ms;
use messages::{ExcavatorEstimate, Message};
use zenoh::{Session, Wait};

const UKF: &str = "estimate/inertia_ukf";

fn keys(folder: &Path, listen: &str, days: &str, machines: &[&str]) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/fleet/keys.sh");
    let mut command = Command::new(script);
    command.arg(folder).arg("north").args(machines);
    let done = command
        .env("LISTEN", listen)
        .env("DAYS", days)
        .output()
        .expect("it runs");
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
}

/// An address with a free port for a router.
fn address() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").and_then(|l| l.local_addr());
    format!("tls/127.0.0.1:{}", listener.expect("a port").port())
}

/// A session, if the router accepts it within some seconds.
fn client(address: &str, config: PathBuf) -> Option<Session> {
    let link = LinkArgs {
        connect: address.to_owned(),
        zenoh_config: Some(config),
    };
    let begun = Instant::now();
    link::client_unless(&link, &[], || begun.elapsed() > Duration::from_secs(8))
        .expect("its configuration is good")
}

/// Publishes an estimate of a machine over a session, which may have another identity.
fn say(session: &Session, machine: &str) {
    let mut payload = Vec::new();
    let message = ExcavatorEstimate::default();
    assert_eq!(message.stamp().sequence, 0);
    recording::payload::encode(&message, &mut payload);
    let label = Label {
        machine: machine.to_owned(),
        run: 1_700_000_000_000,
        number: 0,
        after: Some(-1),
        wall_ms: wall_ms(),
    };
    let key = format!("heft/v1/north/{machine}/{UKF}");
    // The collector shows whether the message passes.
    let _ = session
        .put(key, payload)
        .attachment(label.to_string())
        .wait();
}

#[test]
fn a_machine_writes_its_own_keys_only_and_one_without_a_valid_certificate_none() {
    let address = address();
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(format!("{name}.json5"));
    // Valid for 0 days: expired at once.
    keys(folder.path(), &address, "30", &["ex-1", "ex-2"]);
    keys(folder.path(), &address, "0", &["ex-late"]);
    let _router = link::router(None, Some(&at("router"))).expect("the router starts");
    let config = at("collector").display().to_string();
    let centre = collector(
        &address,
        &folder.path().join("fleet.sqlite"),
        &["--zenoh-config", &config],
    );
    let one = client(&address, at("ex-1")).expect("it is let in");
    let late = client(&address, at("ex-late"));
    assert!(late.is_none(), "its certificate has expired");
    let bare = client(&address, {
        let file = at("bare");
        let ca = folder.path().join("ca.pem");
        let text = format!("{{transport:{{link:{{tls:{{root_ca_certificate:{ca:?}}}}}}}}}");
        std::fs::write(&file, text).expect("written");
        file
    });
    assert!(bare.is_none(), "it has no certificate");
    until("the machine is heard", || {
        say(&one, "ex-1");
        centre.numbers("ex-1", UKF) == [0]
    });
    for _ in 0..5 {
        say(&one, "ex-2");
        sleep(0.2);
    }
    sleep(1.0);
    assert!(
        centre.numbers("ex-2", UKF).is_empty(),
        "others spoke in its name"
    );
    let two = client(&address, at("ex-2")).expect("it is let in");
    until("the other is heard when it speaks itself", || {
        say(&two, "ex-2");
        centre.numbers("ex-2", UKF) == [0]
    });
}

#[test]
fn a_gateway_sends_answers_and_recovers_behind_such_a_router() {
    let address = address();
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(format!("{name}.json5"));
    keys(folder.path(), &address, "30", &["ex-1"]);
    let router = link::router(None, Some(&at("router"))).expect("the router starts");
    let config = at("collector").display().to_string();
    let centre = collector(
        &address,
        &folder.path().join("fleet.sqlite"),
        &["--zenoh-config", &config],
    );
    let machine = machine(100.0, 20.0, None);
    let _gateway = gateway_with(
        &machine,
        "ex-1",
        &address,
        &["--zenoh-config", &at("ex-1").display().to_string()],
    );
    until("it is heard", || centre.numbers("ex-1", UKF).len() > 10);
    router.close().wait().expect("closed");
    sleep(6.0);
    let again = || link::router(None, Some(&at("router"))).ok();
    let mut router = again();
    until("the router starts again", || {
        router = router.take().or_else(again);
        router.is_some()
    });
    machine.process.wait();
    let whole = crate::common::expected(100, 20);
    centre.until_whole("ex-1", UKF, whole.len());
    assert_eq!(centre.numbers("ex-1", UKF), whole);
    assert_eq!(centre.account("ex-1"), (0, 0));
}

#[test]
fn a_site_behind_such_a_router_is_asked_for_its_estimates_and_for_nothing_else() {
    let address = address();
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(format!("{name}.json5"));
    keys(folder.path(), &address, "30", &["ex-1"]);
    let _router = link::router(None, Some(&at("router"))).expect("the router starts");
    let site = client(&address, at("server")).expect("it is let in");
    let centre = client(&address, at("collector")).expect("it is let in");
    let its = ["site/inertia_ukf", "estimate/inertia_ukf"];
    let _answers = its.map(|stream| {
        let answer = move |query: zenoh::query::Query| {
            let _ = query.reply(query.key_expr().clone(), "here").wait();
        };
        let key = format!("heft/v1/north/*/{stream}");
        let queryable = site.declare_queryable(key).callback(answer).wait();
        queryable.expect("declared")
    });
    let answers = |stream: &str| {
        let asked = centre.get(format!("heft/v1/north/ex-1/{stream}"));
        let replies = asked.timeout(Duration::from_secs(2)).wait().expect("asked");
        replies.iter().filter(|r| r.result().is_ok()).count()
    };
    until("the site answers", || answers(its[0]) == 1);
    assert_eq!(answers(its[1]), 0, "it spoke for the machine");
}

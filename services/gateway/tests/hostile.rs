//! A machine can send false data only about itself: none of its messages is attributed to another machine, and none
//! harms the collector.

use crate::common::{Router, collector, sleep, until};
use gateway::label::Label;
use gateway::status::{Status, Stream};
use gateway::wall_ms;
use messages::{ExcavatorEstimate, Message};
use zenoh::{Session, Wait};

const STREAM: &str = "estimate/inertia_ukf";

fn put(session: &Session, key: &str, payload: Vec<u8>, label: &str) {
    let put = session.put(key, payload).attachment(label);
    put.congestion_control(zenoh::qos::CongestionControl::Block)
        .wait()
        .expect("the router takes it");
}

fn message(number: u64, inertia: f64) -> Vec<u8> {
    let mut message = ExcavatorEstimate {
        inertia,
        inertia_std: 1.0,
        ..ExcavatorEstimate::default()
    };
    message.stamp.sequence = number;
    let mut bytes = Vec::new();
    recording::payload::encode(&message, &mut bytes);
    assert!(ExcavatorEstimate::index("inertia").is_some());
    bytes
}

fn label(machine: &str, number: u64, after: i64) -> String {
    let now = wall_ms();
    Label {
        machine: machine.into(),
        run: now - 1000,
        number,
        after: Some(after),
        wall_ms: now,
    }
    .to_string()
}

#[test]
fn what_a_machine_may_not_say_is_refused_and_counted_under_its_own_name() {
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    let session = router.client();
    let own = format!("heft/v1/north/bad/{STREAM}");
    let good = label("bad", 0, -1);
    until("the collector listens", || {
        put(&session, &own, message(0, 1.0), &good);
        !centre.numbers("bad", STREAM).is_empty()
    });
    let lies: Vec<(&str, Vec<u8>, String)> = vec![
        (&own, message(7, 1.0), label("good", 7, -1)),
        (&own, message(8, f64::NAN), label("bad", 8, -1)),
        (&own, message(9, f64::INFINITY), label("bad", 9, -1)),
        (&own, message(10, 1.0), label("bad", 11, -1)),
        (&own, vec![0xff; 100], label("bad", 12, -1)),
        (&own, vec![0; 1 << 20], label("bad", 13, -1)),
        (&own, message(14, 1.0), "bad 1 2".into()),
        (&own, message(15, 1.0), format!("bad {} 15 -1 0", u64::MAX)),
        (
            "heft/v1/north/bad/estimate/nothing",
            message(17, 1.0),
            label("bad", 17, -1),
        ),
        ("heft/v1/north/bad/status", b"{}".to_vec(), String::new()),
        (
            "heft/v1/north/bad/status",
            vec![b'['; 100_000],
            String::new(),
        ),
    ];
    let number = lies.len();
    for (key, payload, label) in lies {
        put(&session, key, payload, &label);
    }
    let status = Status {
        machine: "good".into(),
        kind: "<script>alert(1)</script>".into(),
        ..Status::default()
    };
    let json = |s: &Status| serde_json::to_vec(s).expect("plain data");
    put(&session, "heft/v1/north/bad/status", json(&status), "");
    // It may claim any state of itself, and is still not queried without end.
    let mut own_status = Status {
        machine: "bad".into(),
        run: wall_ms() - 500,
        ..status
    };
    let far = Stream {
        head: i64::MAX,
        per_period: 0.5,
    };
    own_status.streams.insert(STREAM.into(), far);
    own_status.streams.insert("estimate/nothing".into(), far);
    let refused = format!("<td>{}</td>", number + 1);
    until("all are counted", || {
        put(&session, "heft/v1/north/bad/status", json(&own_status), "");
        centre.get("/", "localhost").contains(&refused)
    });
    let page = centre.get("/", "localhost");
    assert!(
        !page.contains("<script>alert") && page.contains("&lt;script"),
        "its words are words"
    );
    assert!(
        !page.contains(">good<"),
        "nothing was taken for the other machine"
    );
    assert_eq!(centre.numbers("bad", STREAM), [0]);
    assert!(centre.numbers("good", STREAM).is_empty());
}

#[test]
fn a_flood_of_one_machine_is_thinned_and_another_is_received() {
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    let (session, quiet) = (router.client(), router.client());
    let own = format!("heft/v1/north/loud/{STREAM}");
    let label_of = label("loud", 0, -1);
    let run = label_of.split(' ').nth(1).expect("the run").to_owned();
    until("the collector listens", || {
        put(&session, &own, message(0, 1.0), &label_of);
        !centre.numbers("loud", STREAM).is_empty()
    });
    for i in 1..20_000u64 {
        let label = format!("loud {run} {i} {} {}", i - 1, wall_ms());
        put(&session, &own, message(i, 1.0), &label);
    }
    // Live messages may be lost, so the honest machine repeats its message until it arrives.
    let (other, label_of_other) = (
        format!("heft/v1/north/quiet/{STREAM}"),
        label("quiet", 0, -1),
    );
    until("the other is heard", || {
        put(&quiet, &other, message(0, 1.0), &label_of_other);
        centre.numbers("quiet", STREAM) == [0]
    });
    sleep(1.0);
    let taken = centre.numbers("loud", STREAM).len();
    assert!((1..10_000).contains(&taken), "{taken} of 20 000 were taken");
    assert!(
        centre
            .get("/north/loud", "localhost")
            .contains("too many messages")
    );
}

//! Messages of many senders that arrive at a router in mixed order: the collector stores all of them.

use crate::common::{Collector, Router, collector, until};
use gateway::label::Label;
use gateway::wall_ms;
use messages::ExcavatorEstimate;
use zenoh::Wait;

/// Its publisher has no sequence numbers of Zenoh: the router's clock stamps its messages.
const STREAM: &str = "site/inertia_ukf";
const SENDERS: usize = 8;
/// Largest number of messages that a machine may send at once.
const MESSAGES: u64 = 900;

/// Number of messages of the stream in the history.
fn stored(centre: &Collector) -> u64 {
    let sql = gateway::collector::query::open(&centre.db).expect("a history");
    let text = "SELECT count(*) FROM message e JOIN stream s ON s.id = e.stream WHERE s.name = ?";
    sql.query_row(text, [STREAM], |row| row.get(0))
        .expect("a count")
}

/// Sends messages with these numbers over a session of their own, as fast as the router accepts them.
fn send(router: &Router, machine: &str, numbers: std::ops::Range<u64>) {
    let session = router.client();
    let key = format!("heft/v1/north/{machine}/{STREAM}");
    for number in numbers {
        let mut message = ExcavatorEstimate::default();
        message.stamp.sequence = number;
        let mut bytes = Vec::new();
        recording::payload::encode(&message, &mut bytes);
        let label = Label {
            machine: machine.to_owned(),
            run: 1,
            number,
            after: Some(number as i64 - 1),
            wall_ms: wall_ms(),
        };
        let put = session.put(&key, bytes).attachment(label.to_string());
        let put = put.congestion_control(zenoh::qos::CongestionControl::Block);
        put.wait().expect("the router takes it");
    }
    session.close().wait().expect("all is on its way");
}

#[test]
fn none_of_many_messages_that_cross_at_the_router_is_lost() {
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    until("the collector listens", || {
        send(&router, "first", 0..1);
        stored(&centre) == 1
    });
    let names: Vec<String> = (0..SENDERS).map(|i| format!("ex-{i}")).collect();
    std::thread::scope(|scope| {
        for name in &names {
            scope.spawn(|| send(&router, name, 0..MESSAGES));
        }
    });
    let sent = SENDERS as u64 * MESSAGES + 1;
    until("all are stored", || stored(&centre) == sent);
    for name in &names {
        assert_eq!(centre.account(name), (0, 0), "{name}");
    }
}

//! Guarantees of a fleet over links that are slow, lossy, or interrupted.

use crate::common::relay::{LTE, Quality, Relay, SATELLITE};
use crate::common::{Collector, Router, collector, expected, gateway, machine, sleep, until};

const UKF: &str = "estimate/inertia_ukf";

/// Time from the creation of a message to its arrival [ms], minimum and median.
fn ages(centre: &Collector) -> [i64; 2] {
    let sql = gateway::collector::query::open(&centre.db).expect("a history");
    let text = "SELECT received_ms - e.wall_ms FROM message e JOIN stream s ON s.id = e.stream WHERE s.name = ? ORDER BY 1";
    let mut query = sql.prepare(text).expect("a query");
    let all = query.query_map([UKF], |row| row.get(0)).expect("rows");
    let all: Vec<i64> = all.map(|age| age.expect("a number")).collect();
    [all[0], all[all.len() / 2]]
}

/// Runs a machine behind a link of this quality, which is cut for `cut` seconds in the middle.
fn over(quality: Quality, seconds: u64, cut: f64) -> [i64; 2] {
    let router = Router::start();
    let relay = Relay::to(&router.address, quality);
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    let machine = machine(100.0, seconds as f64, None);
    let _gateway = gateway(&machine, "ex-1", &relay.address);
    until("it is heard", || !centre.numbers("ex-1", UKF).is_empty());
    if cut > 0.0 {
        sleep(2.0);
        relay.cut();
        sleep(cut);
        relay.mend();
    }
    machine.process.wait();
    let whole = expected(100, seconds);
    centre.until_whole("ex-1", UKF, whole.len());
    assert_eq!(centre.numbers("ex-1", UKF), whole);
    assert_eq!(centre.account("ex-1"), (0, 0));
    let ages = ages(&centre);
    println!(
        "ages: {} ms at least, {} ms in the median",
        ages[0], ages[1]
    );
    ages
}

#[test]
fn over_a_mobile_network_everything_arrives() {
    assert!(over(LTE, 20, 0.0)[0] >= 39, "the link is in between");
}

#[test]
fn the_last_message_before_the_end_of_a_run_arrives() {
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    // Every sample is a message, and the run ends with the last one: between two reads of the gateway.
    let machine = machine(10.0, 8.0, None);
    let _gateway = gateway(&machine, "ex-1", &router.address);
    machine.process.wait();
    let whole = expected(10, 8);
    centre.until_whole("ex-1", UKF, whole.len());
    assert_eq!(centre.numbers("ex-1", UKF), whole);
    assert_eq!(centre.account("ex-1"), (0, 0));
}

#[test]
fn over_a_satellite_everything_arrives() {
    assert!(over(SATELLITE, 20, 0.0)[0] >= 499, "the link is in between");
}

#[test]
fn a_link_that_is_silent_for_5_s_loses_nothing() {
    over(LTE, 20, 5.0);
}

#[test]
fn a_link_that_is_silent_for_30_s_loses_nothing() {
    over(LTE, 45, 30.0);
}

#[test]
#[ignore = "takes 11 minutes"]
fn a_link_that_is_silent_for_10_minutes_loses_nothing() {
    over(LTE, 640, 600.0);
}

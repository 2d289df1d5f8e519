//! Machines with wrong clocks, invented names, and a full disk: every message that a machine sends is in
//! the history, or is counted.

use std::time::Instant;

use crate::common::{Collector, Router, collector, sleep, until};
use gateway::label::Label;
use gateway::question::{AnswerSummary, END};
use gateway::status::{Status, Stream};
use gateway::wall_ms;
use messages::ExcavatorEstimate;
use zenoh::{Session, Wait};

const STREAM: &str = "estimate/inertia_ukf";
const HOUR_MS: i64 = 3_600_000;
/// Default time for which a gateway remains after its run [s].
const LINGER: u64 = 20;

/// A session that claims to be a machine.
struct Speaker<'a> {
    session: &'a Session,
    name: &'a str,
    run: u64,
    count: u64,
    /// Its clock minus that of the host [ms].
    ahead_ms: i64,
}

impl Speaker<'_> {
    fn clock(&self) -> u64 {
        u64::try_from(wall_ms() as i64 + self.ahead_ms).expect("after 1970")
    }

    fn put(&self, what: &str, payload: Vec<u8>, label: &str) {
        let key = format!("heft/v1/north/{}/{what}", self.name);
        let put = self.session.put(key, payload).attachment(label);
        let put = put.congestion_control(zenoh::qos::CongestionControl::Block);
        put.wait().expect("the router takes it");
    }

    fn message(&self, number: u64) {
        let mut message = ExcavatorEstimate {
            inertia: 1.0,
            inertia_std: 1.0,
            ..ExcavatorEstimate::default()
        };
        message.stamp.sequence = number;
        let mut bytes = Vec::new();
        recording::payload::encode(&message, &mut bytes);
        let label = Label {
            machine: self.name.into(),
            run: self.run,
            number,
            after: Some(number as i64 - 1),
            wall_ms: self.clock(),
        };
        self.put(STREAM, bytes, &label.to_string());
    }

    fn status(&self, head: i64, ended: bool) {
        let stream = Stream {
            head,
            per_period: 1.0,
        };
        let status = Status {
            machine: self.name.into(),
            kind: "excavator".into(),
            version: "test".into(),
            run: self.run,
            count: self.count,
            wall_ms: self.clock(),
            ended,
            streams: [(STREAM.to_owned(), stream)].into(),
            ..Status::default()
        };
        self.put(
            "status",
            serde_json::to_vec(&status).expect("plain data"),
            "",
        );
    }

    /// Sends a run of this number of messages.
    fn speak(&self, messages: u64) {
        for number in 0..messages {
            self.message(number);
        }
        self.status(messages as i64 - 1, false);
    }
}

/// Message numbers of each run of a machine, in the order of the query.
fn by_run(centre: &Collector, machine: &str) -> Vec<(u64, Vec<u64>)> {
    let mut runs: Vec<(u64, Vec<u64>)> = Vec::new();
    for message in centre.query("estimates") {
        if message["machine"] != machine || message["stream"] != STREAM {
            continue;
        }
        let run = message["run"].as_u64().expect("a run");
        if runs.last().is_none_or(|(last, _)| *last != run) {
            runs.push((run, Vec::new()));
        }
        let numbers = &mut runs.last_mut().expect("one").1;
        numbers.push(message["sequence"].as_u64().expect("a number"));
    }
    runs
}

#[test]
fn a_run_is_stored_with_any_clock() {
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let db = folder.path().join("fleet.sqlite");
    let centre = collector(&router.address, &db, &[]);
    let session = router.client();
    let listen = Speaker {
        session: &session,
        name: "hello",
        run: 1,
        count: 0,
        ahead_ms: 0,
    };
    until("the collector listens", || {
        listen.message(0);
        !by_run(&centre, "hello").is_empty()
    });
    let since_1970 = 60_000 - wall_ms() as i64;
    // Clocks: correct, an hour slow, 20 hours fast, three days fast, 1970, correct. The ids carry no information about the order.
    let clocks = [0, -HOUR_MS, 20 * HOUR_MS, 72 * HOUR_MS, since_1970, 0];
    let ids = [50, 7, 901, 3, 66, 12];
    let runs = || clocks.iter().zip(ids).enumerate();
    let whole: Vec<u64> = (0..15).collect();
    for (k, (ahead_ms, run)) in runs() {
        let count = 1 + k as u64;
        Speaker {
            session: &session,
            name: "ex-9",
            run,
            count,
            ahead_ms: *ahead_ms,
        }
        .speak(15);
        until("the run is here", || {
            by_run(&centre, "ex-9")
                .iter()
                .any(|(r, n)| *r == run && n.len() == 15)
        });
    }
    let expected: Vec<(u64, Vec<u64>)> = ids.iter().map(|id| (*id, whole.clone())).collect();
    assert_eq!(by_run(&centre, "ex-9"), expected);
    assert_eq!(centre.account("ex-9"), (0, 0));
    sleep(1.5);
    let page = centre.get("/north/ex-9", "localhost");
    assert!(
        page.contains("complete: 0 messages lost") && !page.contains("not complete"),
        "nothing is missing"
    );
    // A restarted collector has the same history, and continues it.
    centre.process.end();
    let centre = collector(&router.address, &db, &[]);
    let next = Speaker {
        session: &session,
        name: "ex-9",
        run: 4,
        count: 9,
        ahead_ms: 0,
    };
    until("the next run is here", || {
        next.speak(15);
        by_run(&centre, "ex-9").last() == Some(&(4, whole.clone()))
    });
    // No message of runs 7 and 8 arrived: the history is not complete.
    until("runs that were not heard are counted", || {
        let page = centre.get("/north/ex-9", "localhost");
        page.contains("not complete") && page.contains("2 runs not received")
    });
}

#[test]
fn a_forged_status_blocks_nobody_and_what_is_refused_is_counted_for_good() {
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let db = folder.path().join("fleet.sqlite");
    let centre = collector(&router.address, &db, &[]);
    let session = router.client();
    let forger = |run, ahead_ms| Speaker {
        session: &session,
        name: "victim",
        run,
        count: 1 << 40,
        ahead_ms,
    };
    let victim = Speaker {
        session: &session,
        name: "victim",
        run: 5,
        count: 3,
        ahead_ms: 0,
    };
    until("the collector listens", || {
        forger(1 << 51, 22 * HOUR_MS).status(1_000_000, false);
        centre.get("/", "localhost").contains("victim")
    });
    victim.speak(15);
    let whole: Vec<u64> = (0..15).collect();
    until("the victim's run is here", || {
        by_run(&centre, "victim") == [(5, whole.clone())]
    });
    // Runs that begin faster than those of any machine are counted. They delay the victim for seconds, not for a day.
    for run in 100..160 {
        forger(run, 0).message(0);
    }
    let refused = |centre: &Collector| {
        let page = centre.get("/north/victim", "localhost");
        page.contains("begins runs too fast") && page.contains("not complete")
    };
    until("what is refused is on the page", || refused(&centre));
    let later = Speaker {
        session: &session,
        name: "victim",
        run: 6,
        count: 4,
        ahead_ms: 0,
    };
    until("a run of the victim after the flood is here", || {
        later.speak(15);
        by_run(&centre, "victim").contains(&(6, whole.clone()))
    });
    sleep(1.5);
    centre.process.end();
    let centre = collector(&router.address, &db, &[]);
    assert!(refused(&centre), "also after a start");
}

#[test]
fn twenty_thousand_made_up_names_do_not_keep_out_an_honest_machine() {
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    let session = router.client();
    let hello = Speaker {
        session: &session,
        name: "hello",
        run: 1,
        count: 0,
        ahead_ms: 0,
    };
    until("the collector listens", || {
        hello.message(0);
        !by_run(&centre, "hello").is_empty()
    });
    for i in 0..25_000 {
        let name = format!("made-up-{i}");
        Speaker {
            session: &session,
            name: &name,
            run: 1,
            count: 0,
            ahead_ms: 0,
        }
        .put("status", b"{}".to_vec(), "");
    }
    let honest = Speaker {
        session: &session,
        name: "honest",
        run: 1,
        count: 1,
        ahead_ms: 0,
    };
    until("the honest machine is heard", || {
        honest.speak(15);
        by_run(&centre, "honest")
            .first()
            .is_some_and(|(_, n)| n.len() == 15)
    });
    sleep(1.0);
    let page = centre.get("/", "localhost");
    assert!(page.contains("honest"), "and on the page");
}

#[test]
fn a_lost_query_is_repeated_before_the_gateway_of_an_ended_run_has_left() {
    let router = Router::start();
    let folder = tempfile::tempdir().expect("a folder");
    let centre = collector(&router.address, &folder.path().join("fleet.sqlite"), &[]);
    let session = router.client();
    let machine = Speaker {
        session: &session,
        name: "mute",
        run: 1,
        count: 1,
        ahead_ms: 0,
    };
    // It holds the first query open without an answer. To later queries it answers that the messages are lost.
    let (asked, questions) = std::sync::mpsc::channel();
    let first = std::sync::Mutex::new(None);
    let key = format!("heft/v1/north/mute/{STREAM}");
    let its = key.clone();
    let _answers = session
        .declare_queryable(key)
        .callback(move |query| {
            let _ = asked.send(Instant::now());
            let mut first = first.lock().expect("its own");
            if first.is_none() {
                *first = Some(query);
                return;
            }
            let served = AnswerSummary {
                upto: 14,
                messages: 0,
                lost: 10,
            };
            let served = serde_json::to_vec(&served).expect("plain data");
            let _ = query.reply(&its, served).attachment(END).wait();
        })
        .wait()
        .expect("a key");
    until("what it does not have is lost", || {
        machine.speak(5);
        machine.status(14, true);
        centre.account("mute") == (10, 0)
    });
    let times: Vec<Instant> = questions.try_iter().collect();
    let between = times[1] - times[0];
    assert!(between.as_secs() < LINGER, "{between:?}");
}

//! The page over real sockets: what viewers receive, and that they cannot delay the feeder.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use messages::{Health, LoaderEstimate, LoaderTruth, Stamp, channels, loader_bits as bits};

use super::connections::{MAX_CONNECTIONS, REQUEST_LIMIT};
use super::server::serve_every;
use super::{Feed, MAX_VIEWERS, Server, serve};

const ANY: &str = "127.0.0.1:0";

fn any_port() -> SocketAddr {
    ANY.parse().expect("a constant")
}

fn estimate(n: u64) -> LoaderEstimate {
    let stamp = Stamp {
        sequence: n,
        time: n as f64 * 1e-3,
        ..Default::default()
    };
    LoaderEstimate {
        stamp,
        cg_ratio: 0.42,
        cg_ratio_std: 0.01,
        nis: 1.0,
        estimated: bits::STATE,
        ..Default::default()
    }
}

/// One sample of every channel of a loader run.
fn push_all(feed: &Feed, n: u64) {
    let stamp = estimate(n).stamp;
    feed.push(&channels::LOADER_CG_EKF, &estimate(n));
    feed.push(&channels::LOADER_CG_UKF, &estimate(n));
    feed.push(
        &channels::LOADER_TRUTH,
        &LoaderTruth {
            stamp,
            known: 0xff,
            ..Default::default()
        },
    );
    feed.push(
        &channels::HEALTH,
        &Health {
            stamp,
            process: (n % 5) as u32,
            steps: n,
            ..Default::default()
        },
    );
}

fn request(server: &Server, path: &str, host: &str) -> TcpStream {
    let mut stream = TcpStream::connect(server.address()).expect("the server listens");
    stream
        .set_read_timeout(Some(Duration::from_secs(5)))
        .expect("a timeout can be set");
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").expect("sent");
    stream
}

/// Reads until all of `wanted` has arrived, or fails.
fn read_until(stream: &mut TcpStream, wanted: &[&str]) -> String {
    let (mut text, mut part) = (String::new(), [0; 65536]);
    while !wanted.iter().all(|w| text.contains(w)) {
        let n = stream.read(&mut part).unwrap_or(0);
        assert!(n > 0, "ended after {} bytes without {wanted:?}", text.len());
        text.push_str(&String::from_utf8_lossy(&part[..n]));
    }
    text
}

fn wait_for(what: &str, mut holds: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(20);
    while !holds() {
        assert!(Instant::now() < end, "{what} within 20 s");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_viewer_gets_the_page_the_past_the_numbers_and_the_words() {
    let feed = Feed::new(vec!["sensor".into(), "ukf".into()]);
    let server = serve(any_port(), feed.clone()).expect("served");
    let page = read_until(&mut request(&server, "/", "127.0.0.1"), &["</html>"]);
    assert!(
        page.starts_with("HTTP/1.1 200")
            && page
                .to_lowercase()
                .contains("content-security-policy: default-src 'none'")
    );
    push_all(&feed, 0);
    std::thread::sleep(Duration::from_millis(100));
    let later = read_until(&mut request(&server, "/", "127.0.0.1"), &["</html>"]);
    assert!(
        later.contains("behind the front axle"),
        "the verdict is in the page itself"
    );
    let mut events = request(&server, "/events", "localhost:1234");
    read_until(&mut events, &["event: history", "loader/cg_ukf"]);
    push_all(&feed, 1);
    let text = read_until(
        &mut events,
        &[
            "event: series",
            "event: status",
            "behind the front axle",
            "\"name\":\"ukf\"",
        ],
    );
    assert!(text.contains("\"t\":0.001"));
    assert_eq!(server.viewers(), 1);
    drop(events);
    let mut n = 2;
    wait_for("the seat is free again", || {
        push_all(&feed, n);
        n += 1;
        server.viewers() == 0
    });
}

#[test]
fn another_name_for_this_host_and_one_viewer_too_many_are_refused() {
    let server = serve(any_port(), Feed::default()).expect("served");
    for path in ["/", "/events"] {
        let refused = read_until(&mut request(&server, path, "evil.example"), &["\r\n\r\n"]);
        assert!(refused.starts_with("HTTP/1.1 403"), "{refused}");
    }
    let mut seats: Vec<_> = (0..MAX_VIEWERS)
        .map(|_| request(&server, "/events", "[::1]:80"))
        .collect();
    for seat in &mut seats {
        read_until(seat, &["event: history"]);
    }
    let full = read_until(&mut request(&server, "/events", "localhost"), &["\r\n\r\n"]);
    assert!(full.starts_with("HTTP/1.1 503"), "{full}");
}

/// More half requests than there are places, and one whole request after them.
#[test]
fn a_request_that_is_never_finished_loses_its_place() {
    let server = serve(any_port(), Feed::default()).expect("served");
    let mut half: Vec<TcpStream> = (0..MAX_CONNECTIONS + 10)
        .map(|_| request_begun(&server))
        .collect();
    let began = Instant::now();
    let mut whole = request(&server, "/", "localhost");
    whole
        .set_read_timeout(Some(2 * REQUEST_LIMIT))
        .expect("a timeout can be set");
    read_until(&mut whole, &["</html>"]);
    assert!(began.elapsed() < REQUEST_LIMIT + Duration::from_secs(3));
    let mut rest = Vec::new();
    // Closed or reset: in both cases nothing more arrives.
    let _ = half[0].read_to_end(&mut rest);
    assert!(!rest.starts_with(b"HTTP/1.1 200"));
}

fn request_begun(server: &Server) -> TcpStream {
    let mut stream = TcpStream::connect(server.address()).expect("the server listens");
    stream.write_all(b"GET / HTTP/1.1\r\nHo").expect("sent");
    stream
}

/// Ten stalled viewers and 1 000 frames a second, 30 times the real rate: pushes stay short. The viewer that reads sees the
/// newest frame. So does a stalled one that resumes, having skipped the oldest.
#[test]
fn stalled_viewers_do_not_delay_the_feeder_nor_each_other() {
    let feed = Feed::default();
    let server = serve_every(Duration::from_millis(1), any_port(), feed.clone()).expect("served");
    let mut stalled: Vec<_> = (0..10)
        .map(|_| request(&server, "/events", "localhost"))
        .collect();
    let reader = request(&server, "/events", "localhost");
    wait_for("all viewers are admitted", || server.viewers() == 11);
    let reading = std::thread::spawn(move || read_to_end(reader));
    let (start, mut times) = (Instant::now(), Vec::new());
    while start.elapsed() < Duration::from_secs(6) {
        let before = Instant::now();
        push_all(&feed, times.len() as u64);
        times.push(before.elapsed());
        std::thread::sleep(Duration::from_micros(500));
    }
    let newest = format!(
        "\"t\":{}",
        serde_json::json!((times.len() - 1) as f64 * 1e-3)
    );
    times.sort_unstable();
    let (p50, p99, max) = (
        times[times.len() / 2],
        times[times.len() * 99 / 100],
        times[times.len() - 1],
    );
    println!(
        "4 pushes beside 10 stalled viewers: p50 {p50:?}, p99 {p99:?}, max {max:?} of {}",
        times.len()
    );
    // A push waits for the assembly of one frame at most (some 50 µs); the margin is for a loaded test machine. Waiting for a
    // viewer would take seconds.
    assert!(p99 < Duration::from_millis(20), "p99 {p99:?}");
    read_until(&mut stalled[0], &[&newest]);
    assert!(
        server.skipped() > 100,
        "{} frames skipped",
        server.skipped()
    );
    let began = Instant::now();
    drop(server);
    assert!(
        began.elapsed() < Duration::from_secs(2),
        "stalled viewers do not hold up the end"
    );
    let seen = reading.join().expect("the reader ends with the server");
    assert!(
        seen.contains(&newest),
        "the viewer that reads has the newest frame {newest}"
    );
}

fn read_to_end(mut stream: TcpStream) -> String {
    let (mut part, mut all) = ([0; 65536], Vec::new());
    while let Ok(n @ 1..) = stream.read(&mut part) {
        all.extend_from_slice(&part[..n]);
    }
    String::from_utf8_lossy(&all).into_owned()
}

#[test]
fn the_loads_panel_shows_a_load_and_a_button_of_another_site_moves_no_truck() {
    use messages::{ExcavatorEstimate, excavator_bits};
    use steps::loads::{LoadCounter, Options};

    use super::SharedLoads;

    let options = Options {
        target: Some(5000.0),
        ..Options::default()
    };
    let machine = "[machine]\nkind = \"excavator\"\noperating_mass = 21500\n";
    let counter = LoadCounter::of_text(machine, options).expect("a description");
    let loads = SharedLoads::new(counter);
    for i in 0..900u32 {
        let estimate = ExcavatorEstimate {
            stamp: Stamp {
                time: f64::from(i) * 0.01,
                ..Stamp::default()
            },
            payload: if (200..600).contains(&i) { 900.0 } else { 10.0 },
            payload_std: 20.0,
            estimated: excavator_bits::PAYLOAD,
            flags: excavator_bits::TRUSTED,
            ..ExcavatorEstimate::default()
        };
        loads.lock().see(&messages::Message::envelope(&estimate));
    }
    let server = serve(any_port(), Feed::default().with_loads(loads)).expect("a page");
    let mut json = request(&server, "/loads.json", "localhost");
    let text = read_until(&mut json, &["remaining"]);
    assert!(
        ["\"target\":5000.0", "\"loads\":1", "boom_pin"]
            .iter()
            .all(|part| text.contains(part)),
        "{text}"
    );
    let mut page = request(&server, "/loads", "localhost");
    read_until(&mut page, &["Next truck", "dumped, provisional"]);
    let press = |with: &str| {
        let mut stream = TcpStream::connect(server.address()).expect("the server listens");
        stream
            .set_read_timeout(Some(Duration::from_secs(5)))
            .expect("a timeout");
        let head = "POST /next-truck HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n";
        write!(stream, "{head}{with}\r\n").expect("sent");
        stream
    };
    read_until(&mut press(""), &["403"]);
    let text = read_until(&mut press("x-heft: next-truck\r\n"), &["remaining"]);
    assert!(text.contains("\"truck\":2"), "{text}");
}

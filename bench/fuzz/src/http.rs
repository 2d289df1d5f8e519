//! Target: the live page over a real socket.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Duration for which a client reads a stream, and longest time for an answer of the page.
const LOOK: Duration = Duration::from_millis(100);
const PATIENCE: Duration = Duration::from_secs(10);

/// After any input the page answers the next client, and a client that left occupies no place.
pub fn http(input: &[u8]) {
    static SERVER: OnceLock<view::live::Server> = OnceLock::new();
    let server = SERVER.get_or_init(|| {
        let feed = view::live::Feed::new(Vec::new());
        let any = ([127, 0, 0, 1], 0).into();
        view::live::serve(any, feed).expect("a port")
    });
    let connect = || TcpStream::connect(server.address()).expect("the page lets a client in");
    // One client in eight does not end its input: an incomplete request is left after 20 ms, a stream after `LOOK`.
    look(connect(), input, input.len().is_multiple_of(8));
    let begun = Instant::now();
    let (answer, ended) = answer(connect());
    assert!(
        answer.starts_with(b"HTTP/1.1 404"),
        "the next client is not answered: {} bytes came, then {ended} after {:?}; {} viewers; they begin {:?}",
        answer.len(),
        begun.elapsed(),
        server.viewers(),
        String::from_utf8_lossy(&answer[..answer.len().min(80)]),
    );
    let begun = Instant::now();
    while server.viewers() > view::live::MAX_VIEWERS / 2 {
        assert!(
            begun.elapsed() < PATIENCE,
            "{} seats are still taken {PATIENCE:?} after their clients went",
            server.viewers()
        );
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Sends the input, reads the answer for a while, and closes. Errors of the client are ignored: the page may close the
/// connection before it has read everything.
fn look(mut stream: TcpStream, input: &[u8], stays: bool) {
    stream.set_read_timeout(Some(LOOK / 5)).expect("a limit");
    let _ = stream.write_all(input);
    if !stays {
        let _ = stream.shutdown(Shutdown::Write);
    }
    let (begun, mut some) = (Instant::now(), [0; 4096]);
    while stream.read(&mut some).is_ok_and(|n| n > 0) && begun.elapsed() < LOOK {}
}

/// Requests a missing page. Returns the received bytes, and how the connection ended.
fn answer(mut stream: TcpStream) -> (Vec<u8>, String) {
    let request = b"GET /nothing HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    stream.set_read_timeout(Some(PATIENCE)).expect("a limit");
    let mut answer = Vec::new();
    if let Err(e) = stream.write_all(request) {
        return (answer, format!("the request could not be sent: {e}"));
    }
    let ended = match stream.read_to_end(&mut answer) {
        Ok(_) => "the end".into(),
        Err(e) => e.to_string(),
    };
    (answer, ended)
}

/// Requests of browsers and unusual requests, in sequence on one connection.
pub fn requests() -> Vec<u8> {
    b"GET / HTTP/1.1\r\nHost: localhost\r\nAccept: */*\r\n\r\n\
      POST / HTTP/1.1\r\nHost: 127.0.0.1:8440\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n0\r\n\r\n\
      PUT /events HTTP/1.1\r\nHost: [::1]\r\nContent-Length: 12\r\nExpect: 100-continue\r\n\r\nhello, world\
      GET /events HTTP/1.0\r\nHost: elsewhere\r\nConnection: keep-alive\r\n\r\n\
      OPTIONS * HTTP/1.1\r\nHost: localhost\r\nConnection: upgrade, http2-settings\r\nUpgrade: h2c\r\n\r\n\
      GET /events HTTP/1.1\r\nHost: localhost\r\nLast-Event-ID: 7\r\n\r\n"
        .to_vec()
}

//! The live page over a real socket.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Whatever comes, the page answers the next one, and who went leaves no seat taken.
pub fn http(input: &[u8]) {
    const LOOK: Duration = Duration::from_millis(100);
    const PATIENCE: Duration = Duration::from_secs(10);
    static SERVER: OnceLock<view::live::Server> = OnceLock::new();
    let server = SERVER.get_or_init(|| {
        let feed = view::live::Feed::new(Vec::new());
        let any = ([127, 0, 0, 1], 0).into();
        view::live::serve(any, feed).expect("a port")
    });
    let ask = |request: &[u8], limit: Duration, patience: Duration, stays: bool| {
        let mut stream = TcpStream::connect(server.address()).expect("it listens");
        stream.set_read_timeout(Some(patience)).expect("a limit");
        // It may close before everything was said.
        let _ = stream.write_all(request);
        if !stays {
            let _ = stream.shutdown(Shutdown::Write);
        }
        let (begun, mut answer) = (Instant::now(), [0; 4096]);
        let head = stream.read(&mut answer).map_or(0, |n| n);
        let mut rest = [0; 4096];
        while begun.elapsed() < limit && stream.read(&mut rest).is_ok_and(|n| n > 0) {}
        answer[..head].to_vec()
    };
    // One in eight waits for more: it is left after a moment, what is streamed after a look.
    ask(input, LOOK, LOOK / 5, input.len().is_multiple_of(8));
    let request = b"GET /nothing HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    let answer = ask(request, PATIENCE, PATIENCE, true);
    assert!(answer.starts_with(b"HTTP/1.1 404"), "it does not answer");
    let begun = Instant::now();
    while server.viewers() > view::live::MAX_VIEWERS / 2 {
        assert!(begun.elapsed() < PATIENCE, "seats stay taken");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// What browsers ask, and what they do not, one after the other on a connection.
pub fn requests() -> Vec<u8> {
    b"GET / HTTP/1.1\r\nHost: localhost\r\nAccept: */*\r\n\r\n\
      POST / HTTP/1.1\r\nHost: 127.0.0.1:8440\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n0\r\n\r\n\
      PUT /events HTTP/1.1\r\nHost: [::1]\r\nContent-Length: 12\r\nExpect: 100-continue\r\n\r\nhello, world\
      GET /events HTTP/1.0\r\nHost: elsewhere\r\nConnection: keep-alive\r\n\r\n\
      OPTIONS * HTTP/1.1\r\nHost: localhost\r\nConnection: upgrade, http2-settings\r\nUpgrade: h2c\r\n\r\n\
      GET /events HTTP/1.1\r\nHost: localhost\r\nLast-Event-ID: 7\r\n\r\n"
        .to_vec()
}

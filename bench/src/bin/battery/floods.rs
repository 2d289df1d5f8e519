//! Incomplete requests on every connection of the live page, while services are killed.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use rustix::process::Signal;

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::{Ground, RATE, SERVICES};

pub struct Flood;

/// More than the page's places and the kernel's queue.
const CONNECTIONS: usize = 300;

impl Attack for Flood {
    fn name(&self) -> String {
        "half requests while services die".into()
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        let run = ground.run(9.0, &["--view", "127.0.0.1:0"])?;
        run.wait_for_all()?;
        let text = run.text();
        let address: SocketAddr = text
            .split("http://")
            .nth(1)
            .and_then(|rest| rest.split([',', '/']).next().map(str::trim))
            .and_then(|address| address.parse().ok())
            .ok_or_else(|| format!("no address: {text}"))?;
        let mut held = Vec::new();
        for _ in 0..CONNECTIONS {
            if let Ok(mut stream) = TcpStream::connect_timeout(&address, Duration::from_millis(20))
            {
                let _ = stream.write_all(b"GET / HTTP/1.1\r\nHost: loc");
                held.push(stream);
            }
        }
        for victim in rng.some(&SERVICES, 3) {
            run.signal(victim, Signal::KILL);
            std::thread::sleep(Duration::from_millis(150));
        }
        // Each incomplete request loses its place after five seconds; then others are served.
        drop(held);
        let begun = Instant::now();
        while !answers(address) {
            if begun.elapsed() > Duration::from_secs(6) {
                return Err(format!("the page does not answer: {}", run.text()));
            }
        }
        let remains = run.remains(Duration::from_secs(15))?;
        let gap = remains.check(2 * RATE)?;
        Ok(Outcome::Survived { gap })
    }
}

fn answers(address: SocketAddr) -> bool {
    let Ok(mut stream) = TcpStream::connect_timeout(&address, Duration::from_secs(1)) else {
        return false;
    };
    let _ = stream.set_read_timeout(Some(Duration::from_secs(1)));
    let mut word = [0; 12];
    stream
        .write_all(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
        .is_ok()
        && stream.read_exact(&mut word).is_ok()
        && word.ends_with(b"200")
}

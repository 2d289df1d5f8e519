//! A link with faults between a gateway and its router: bytes arrive late and in order, or not at all during an interruption.
//! (Network namespaces with `tc netem` would simulate this below TCP, if the kernel has netem.)

use std::collections::VecDeque;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

/// Properties of the link in each direction.
#[derive(Clone, Copy)]
pub struct Quality {
    /// Mean delay, and its largest deviation [s].
    pub delay: f64,
    pub jitter: f64,
    /// Share of lost packets. TCP sends a lost packet again after 0.2 s, and later packets wait for it.
    pub loss: f64,
}

pub const LTE: Quality = Quality {
    delay: 0.06,
    jitter: 0.02,
    loss: 0.01,
};
pub const SATELLITE: Quality = Quality {
    delay: 0.5,
    jitter: 0.0,
    loss: 0.0,
};
/// Time until TCP sends a lost packet again [s].
const AGAIN: f64 = 0.2;

/// The link.
pub struct Relay {
    /// Address to which a gateway connects.
    pub address: String,
    is_cut: Arc<AtomicBool>,
}

impl Relay {
    /// A link to `router` ("tcp/HOST:PORT").
    pub fn to(router: &str, quality: Quality) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = format!("tcp/{}", listener.local_addr().expect("an address"));
        let is_cut = Arc::new(AtomicBool::new(false));
        let (target, cut) = (router.trim_start_matches("tcp/").to_owned(), is_cut.clone());
        std::thread::spawn(move || {
            for inner in listener.incoming().flatten() {
                let Ok(outer) = TcpStream::connect(&target) else {
                    continue;
                };
                for (from, to) in [(&inner, &outer), (&outer, &inner)] {
                    let ends = (from.try_clone(), to.try_clone());
                    if let (Ok(from), Ok(to)) = ends {
                        way(from, to, quality, cut.clone());
                    }
                }
            }
        });
        Self { address, is_cut }
    }

    /// Stops all traffic without notice: both ends wait, as with a dead radio.
    pub fn cut(&self) {
        self.is_cut.store(true, Ordering::Relaxed);
    }

    /// Resumes the traffic, including the waiting bytes.
    pub fn mend(&self) {
        self.is_cut.store(false, Ordering::Relaxed);
    }
}

/// Packets in transit, each with the time of its arrival; an empty one is the end.
type Queue = Arc<(Mutex<VecDeque<(Instant, Vec<u8>)>>, Condvar)>;

fn way(mut from: TcpStream, mut to: TcpStream, quality: Quality, is_cut: Arc<AtomicBool>) {
    let queue: Queue = Arc::default();
    let sender = queue.clone();
    std::thread::spawn(move || {
        let (mut bytes, mut last) = ([0; 1400], Instant::now());
        loop {
            let count = from.read(&mut bytes).unwrap_or(0);
            let lost = if chance() < quality.loss { AGAIN } else { 0.0 };
            let late = quality.delay + quality.jitter * (2.0 * chance() - 1.0) + lost;
            last = last.max(Instant::now() + Duration::from_secs_f64(late));
            let (packets, rings) = &*sender;
            packets
                .lock()
                .expect("whole")
                .push_back((last, bytes[..count].to_vec()));
            rings.notify_one();
            if count == 0 {
                return;
            }
        }
    });
    std::thread::spawn(move || {
        loop {
            let (packets, rings) = &*queue;
            let waiting = rings.wait_while(packets.lock().expect("whole"), |p| p.is_empty());
            let (due, bytes) = waiting.expect("whole").pop_front().expect("not empty");
            while Instant::now() < due || is_cut.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
            }
            if bytes.is_empty() || to.write_all(&bytes).is_err() {
                let _ = to.shutdown(Shutdown::Both);
                return;
            }
        }
    });
}

/// A number from 0 to 1 (splitmix64).
fn chance() -> f64 {
    static STATE: AtomicU64 = AtomicU64::new(7);
    let mut z = STATE.fetch_add(0x9e37_79b9_7f4a_7c15, Ordering::Relaxed);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

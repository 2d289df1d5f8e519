//! A bus for tests: senders, a recorder that writes as candump does, and access to a kernel that
//! supports one.
#![allow(dead_code, reason = "each test uses its own part")]

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, UNIX_EPOCH};

use socketcan::{
    CanFdSocket, CanFrame, EmbeddedFrame, ExtendedId, Id, Socket, SocketOptions, StandardId,
};

/// Runs the tests of this file that need a bus, on a kernel that has one, if `HEFT_CAN` is set: they play
/// in real time, which a kernel in user mode keeps up only on an idle machine.
pub fn run_ignored_tests() {
    if std::env::var_os("HEFT_CAN").is_none() {
        let _ = writeln!(
            std::io::stderr(),
            "skipped: set HEFT_CAN=1 for the tests on a bus (three minutes, on a quiet machine)"
        );
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let status = Command::new(root.join("tests/tools/with-can"))
        .arg(std::env::current_exe().expect("this test"))
        .args(["--ignored", "--test-threads=1", "--nocapture"])
        .env("WITH_CAN_LIMIT", "900")
        .current_dir(root)
        .stdin(Stdio::null())
        .status();
    match status.map(|s| s.code()) {
        Ok(Some(125)) | Err(_) => drop(writeln!(
            std::io::stderr(),
            "skipped: no CAN stack here (see tests/tools/with-can)"
        )),
        Ok(code) => assert_eq!(code, Some(0), "a test on the bus failed, see above"),
    }
}

/// A frame and the time to send it [s].
#[derive(Debug, Clone)]
pub struct Frame {
    pub time: f64,
    pub id: u32,
    pub extended: bool,
    pub data: Vec<u8>,
}

/// A sender.
pub struct Talker(CanFdSocket);

impl Talker {
    pub fn open(interface: &str) -> Self {
        Self(CanFdSocket::open(interface).expect("the interface"))
    }

    /// Sends a frame now; waits where the interface is busy.
    pub fn say(&mut self, frame: &Frame) {
        let id: Id = if frame.extended {
            ExtendedId::new(frame.id).expect("29 bits").into()
        } else {
            StandardId::new(frame.id as u16).expect("11 bits").into()
        };
        let out = CanFrame::new(id, &frame.data).expect("a frame");
        while self.0.write_frame(&out).is_err() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Sends frames at their times, the first now.
    pub fn play(&mut self, frames: impl Iterator<Item = Frame>) {
        let begun = Instant::now();
        let mut first = None;
        for frame in frames {
            let due = frame.time - *first.get_or_insert(frame.time);
            let due = Duration::from_secs_f64(due.max(0.0));
            std::thread::sleep(due.saturating_sub(begun.elapsed()));
            self.say(&frame);
            // After a delay many frames are sent at once: a listener on the same core gets its turn before its queue is full.
            std::thread::yield_now();
        }
    }
}

/// The frames of a log of `candump`.
pub fn frames_of_log(log: &Path) -> Vec<Frame> {
    let text = std::fs::read_to_string(log).expect("a log");
    let frame = |line: &str| {
        let mut words = line.split_whitespace();
        let time = words.next()?.trim_matches(['(', ')']).parse().ok()?;
        let id = words.nth(1)?;
        let _length = words.next()?;
        let byte = |word: &str| u8::from_str_radix(word, 16).ok();
        Some(Frame {
            time,
            id: u32::from_str_radix(id, 16).ok()?,
            extended: id.len() == 8,
            data: words.map_while(byte).collect(),
        })
    };
    text.lines().filter_map(frame).collect()
}

/// Writes received frames as `candump -L` does.
pub struct Recorder(JoinHandle<String>, Arc<AtomicBool>);

impl Recorder {
    pub fn start(interface: &'static str) -> Self {
        let socket = CanFdSocket::open(interface).expect("the interface");
        socket.set_recv_timestamp(true).expect("timestamps");
        let patience = Duration::from_millis(100);
        socket.set_read_timeout(patience).expect("a limit");
        let stop = Arc::new(AtomicBool::new(false));
        let its = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let mut lines = String::new();
            loop {
                let Ok((frame, time)) = socket.read_frame_with_timestamp() else {
                    if its.load(Ordering::Relaxed) {
                        return lines;
                    }
                    continue;
                };
                let us = time.duration_since(UNIX_EPOCH).expect("a time").as_micros();
                let (id, width) = match frame.id() {
                    Id::Standard(id) => (u32::from(id.as_raw()), 3),
                    Id::Extended(id) => (id.as_raw(), 8),
                };
                let bytes = frame.data().iter().map(|b| format!("{b:02X}"));
                let bytes: String = bytes.collect();
                let (s, us) = (us / 1_000_000, us % 1_000_000);
                let _ = writeln!(lines, "({s}.{us:06}) {interface} {id:0width$X}#{bytes}");
            }
        });
        Self(thread, stop)
    }

    /// The text received up to now.
    pub fn stop(self) -> String {
        std::thread::sleep(Duration::from_millis(300));
        self.1.store(true, Ordering::Relaxed);
        self.0.join().expect("a log")
    }
}

/// Takes an interface down or up.
pub fn set_interface(name: &str, state: &str) {
    let mut ip = Command::new("ip");
    let done = ip.args(["link", "set", name, state]).status();
    assert!(
        done.is_ok_and(|s| s.success()),
        "ip link set {name} {state}"
    );
}

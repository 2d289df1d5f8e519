//! The host's monotonic clock, and processor time.

use std::time::{Duration, SystemTime};

use rustix::time::{ClockId, Timespec, clock_gettime};

/// Nanoseconds on the host's monotonic clock; the same for every process.
pub fn now_ns() -> u64 {
    let t = clock_gettime(ClockId::Monotonic);
    // The monotonic clock counts from boot: never negative, 584 years until it overflows.
    t.tv_sec as u64 * 1_000_000_000 + t.tv_nsec as u64
}

/// Time since 1970; 0 where the clock is before that.
pub fn since_1970() -> Duration {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    now.unwrap_or_default()
}

/// Sleeps until `deadline_ns` on the same clock; returns early on a signal.
pub fn sleep_until(deadline_ns: u64) {
    let request = Timespec {
        tv_sec: (deadline_ns / 1_000_000_000) as i64,
        tv_nsec: (deadline_ns % 1_000_000_000) as _,
    };
    // An early return is harmless: every caller reads the clock again.
    let _ = rustix::thread::clock_nanosleep_absolute(ClockId::Monotonic, &request);
}

/// Processor time of this process.
pub fn processor_time() -> Duration {
    let t = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(t.tv_sec as u64, t.tv_nsec as u32)
}

/// Processor time of the first thread of another process, also after its end until it is waited for.
/// Zero if the system does not report it.
pub fn processor_time_of(pid: u32) -> Duration {
    Duration::from_nanos(thread_ns(&format!("/proc/{pid}")))
}

/// Processor time of the thread with this folder in `/proc` [ns].
pub(crate) fn thread_ns(folder: &str) -> u64 {
    let text = std::fs::read_to_string(format!("{folder}/schedstat")).unwrap_or_default();
    let first = text.split(' ').next().unwrap_or("");
    first.parse().unwrap_or(0)
}

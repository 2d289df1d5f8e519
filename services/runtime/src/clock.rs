//! The host's monotonic clock.

use rustix::time::{ClockId, Timespec, clock_gettime};

/// Nanoseconds on the host's monotonic clock; the same for every process.
#[must_use]
pub fn now_ns() -> u64 {
    let t = clock_gettime(ClockId::Monotonic);
    // The monotonic clock counts from boot: never negative, 584 years until it overflows.
    t.tv_sec as u64 * 1_000_000_000 + t.tv_nsec as u64
}

/// Sleeps until `deadline_ns` on the same clock; returns early on a signal.
pub fn sleep_until(deadline_ns: u64) {
    let request = Timespec {
        tv_sec: (deadline_ns / 1_000_000_000) as i64,
        tv_nsec: (deadline_ns % 1_000_000_000) as _,
    };
    // An early return is harmless: every caller looks at the clock again.
    let _ = rustix::thread::clock_nanosleep_absolute(ClockId::Monotonic, &request);
}

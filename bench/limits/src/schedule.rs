//! Clock, cores and priority of a stage.

use rustix::thread::{
    ClockId, CpuSet, clock_nanosleep_absolute, sched_getaffinity, sched_setaffinity,
};
use rustix::time::{Timespec, clock_gettime};
use std::io;
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// Priority of the first stage (of 99); each one downstream is one higher, so a sample in flight goes before a new one.
const FIRST_PRIORITY: u8 = 20;

/// CLOCK_MONOTONIC [ns].
pub fn now_ns() -> u64 {
    let now = clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// Sleeps until a time of CLOCK_MONOTONIC [ns]; one that has passed returns at once.
pub fn sleep_until(deadline_ns: u64) {
    let deadline = Timespec {
        tv_sec: (deadline_ns / 1_000_000_000) as i64,
        tv_nsec: (deadline_ns % 1_000_000_000) as i64,
    };
    while clock_nanosleep_absolute(ClockId::Monotonic, &deadline) == Err(rustix::io::Errno::INTR) {}
}

/// Burns time without a system call, as a step would.
pub fn work_for(duration_ns: u64) {
    if duration_ns > 0 {
        let end = now_ns() + duration_ns;
        while now_ns() < end {
            std::hint::spin_loop();
        }
    }
}

/// The cores this process may use.
pub fn permitted_cores() -> io::Result<Vec<usize>> {
    let set = sched_getaffinity(None)?;
    Ok((0..CpuSet::MAX_CPU)
        .filter(|core| set.is_set(*core))
        .collect())
}

/// Pins the calling thread to one core.
pub fn pin(core: usize) -> io::Result<()> {
    let mut set = CpuSet::new();
    if core < CpuSet::MAX_CPU {
        set.set(core);
    }
    Ok(sched_setaffinity(None, &set)?)
}

/// Puts the calling thread under SCHED_FIFO; whether that was permitted.
pub fn become_fifo(stage: usize) -> bool {
    let priority = FIRST_PRIORITY
        .saturating_add(u8::try_from(stage).unwrap_or(u8::MAX))
        .min(90);
    let Ok(value) = ThreadPriorityValue::try_from(priority) else {
        return false;
    };
    set_thread_priority_and_policy(
        thread_native_id(),
        ThreadPriority::Crossplatform(value),
        ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo),
    )
    .is_ok()
}

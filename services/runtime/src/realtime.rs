//! Real-time set-up of the thread that steps: scheduling class, core, locked memory.

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use thread_priority::unix::{
    RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy,
    thread_native_id,
};
use thread_priority::{ThreadPriority, ThreadPriorityValue};

/// What the real-time set-up of a worker achieved.
#[derive(Debug, Clone, Default)]
pub struct Realtime {
    /// SCHED_FIFO is in force.
    pub fifo: bool,
    /// Pages are locked.
    pub locked: bool,
    /// What was refused, and the command that permits it.
    pub refused: Vec<String>,
}

/// Puts the calling thread under SCHED_FIFO at `priority` (1-99), on `core` if one is given, and
/// locks all memory. What the system refuses is said, and the thread runs on normally.
pub fn enter(priority: u8, core: Option<usize>) -> Realtime {
    let mut result = Realtime::default();
    if let Some(core) = core {
        let mut set = CpuSet::new();
        set.set(core);
        if let Err(e) = sched_setaffinity(None, &set) {
            result.refused.push(format!(
                "core {core}: {e}; choose one of the cores that `nproc` and the cpuset of this container allow"
            ));
        }
    }
    match mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE) {
        Ok(()) => result.locked = true,
        Err(e) => result.refused.push(format!(
            "locked memory: {e}; `ulimit -l unlimited`, or LimitMEMLOCK=infinity in the unit"
        )),
    }
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let value = ThreadPriorityValue::try_from(priority).map(ThreadPriority::Crossplatform);
    let set = value.map_err(|e| e.to_string()).and_then(|value| {
        set_thread_priority_and_policy(thread_native_id(), value, policy)
            .map_err(|e| format!("{e:?}"))
    });
    match set {
        Ok(()) => result.fifo = true,
        Err(e) => result.refused.push(format!(
            "SCHED_FIFO: {e}; `ulimit -r 90`, `sudo setcap cap_sys_nice+ep $(which heft)`, or LimitRTPRIO=90 in the unit"
        )),
    }
    result
}

/// The cores that this process may run on, in ascending order; empty if the system does not tell.
#[must_use]
pub fn cores() -> Vec<usize> {
    let set = sched_getaffinity(None).unwrap_or_default();
    (0..CpuSet::MAX_CPU).filter(|&c| set.is_set(c)).collect()
}

/// Whether SCHED_FIFO would be permitted; the calling thread stays as it is.
#[must_use]
pub fn permitted() -> bool {
    std::thread::spawn(|| {
        let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        let Ok(value) = ThreadPriorityValue::try_from(1u8) else {
            return false;
        };
        set_thread_priority_and_policy(
            thread_native_id(),
            ThreadPriority::Crossplatform(value),
            policy,
        )
        .is_ok()
    })
    .join()
    .unwrap_or(false)
}

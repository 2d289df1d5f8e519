//! Real-time set-up of the thread that steps: scheduling class, core, locked memory.

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use thread_priority::unix::{
    RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy,
    thread_native_id,
};
use thread_priority::{ThreadPriority, ThreadPriorityValue};

/// Result of the real-time set-up of a worker.
#[derive(Debug, Clone, Default)]
pub struct Realtime {
    /// SCHED_FIFO is in force.
    pub fifo: bool,
    /// Pages are locked.
    pub locked: bool,
    /// Refused settings, each with the command that permits it.
    pub refused: Vec<String>,
}

impl Realtime {
    fn pin(&mut self, core: usize) {
        if let Err(e) = keep_to(&[core]) {
            self.refused.push(format!(
                "core {core}: {e}; choose one of the cores that `nproc` and the cpuset of this container allow"
            ));
        }
    }

    fn lock(&mut self) {
        match mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE) {
            Ok(()) => self.locked = true,
            Err(e) => self.refused.push(format!(
                "locked memory: {e}; `ulimit -l unlimited`, or LimitMEMLOCK=infinity in the unit"
            )),
        }
    }
}

/// Pins the calling thread to `core` and locks all memory, for a thread that has its core to itself and so needs no
/// priority. Refused settings are reported.
pub fn enter_core(core: usize) -> Realtime {
    let mut result = Realtime::default();
    result.pin(core);
    result.lock();
    result
}

/// Puts the calling thread under SCHED_FIFO at `priority` (1-99), on `core` if one is given, and
/// locks all memory. Refused settings are reported, and the thread continues normally.
pub fn enter(priority: u8, core: Option<usize>) -> Realtime {
    let mut result = Realtime::default();
    if let Some(core) = core {
        result.pin(core);
    }
    result.lock();
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

/// The cores that this process may run on, in ascending order; empty if the system does not report them.
pub fn cores() -> Vec<usize> {
    let set = sched_getaffinity(None).unwrap_or_default();
    (0..CpuSet::MAX_CPU).filter(|&c| set.is_set(c)).collect()
}

/// The cores that the kernel leaves free of all threads that are not pinned to them (`isolcpus`), in ascending order.
pub fn isolated_cores() -> Vec<usize> {
    let list = std::fs::read_to_string("/sys/devices/system/cpu/isolated").unwrap_or_default();
    core_list(&list)
}

/// Cores of a list as the kernel writes it: `2-4,7`.
fn core_list(text: &str) -> Vec<usize> {
    let range = |part: &str| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        Some(first.parse().ok()?..=last.parse().ok()?)
    };
    text.trim().split(',').filter_map(range).flatten().collect()
}

/// Restricts the calling thread, and those it starts from now on, to these cores.
///
/// # Errors
/// None of them may be used.
pub fn keep_to(cores: &[usize]) -> std::io::Result<()> {
    let mut set = CpuSet::new();
    cores.iter().for_each(|core| set.set(*core));
    Ok(sched_setaffinity(None, &set)?)
}

/// Whether SCHED_FIFO would be permitted; does not change the calling thread.
pub fn permitted() -> bool {
    let body = || {
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
    };
    let thread = std::thread::Builder::new().spawn(body);
    thread.is_ok_and(|thread| thread.join().unwrap_or(false))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_of_cores_is_read_as_the_kernel_writes_it() {
        assert_eq!(core_list("2-4,7\n"), [2, 3, 4, 7]);
        assert_eq!(core_list("3\n"), [3]);
        assert!(core_list("\n").is_empty());
    }
}

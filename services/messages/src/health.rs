//! Health reports of the processes.

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::message::message;
use crate::{Entry, Words};

/// State of a process, [`Health::state`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum State {
    /// Opens its ports.
    Starting = 0,
    /// Runs and receives samples.
    Running = 1,
    /// Runs, but no sample came within the deadline.
    Waiting = 2,
    /// Has ended in order.
    Ended = 3,
    /// Has been at the same sample for too long.
    Hanging = 4,
}

/// Codes of [`Health::fault`].
pub mod fault {
    /// No fault so far.
    pub const NONE: u32 = 0;
    /// Samples were lost before this process.
    pub const LOST: u32 = 1;
    /// No sample came within the deadline.
    pub const DEADLINE: u32 = 2;
    /// A message could not be sent.
    pub const SEND: u32 = 3;
    /// The disk took no more of the recording.
    pub const DISK: u32 = 4;

    /// The fault in words.
    pub fn text(code: u32) -> &'static str {
        match code {
            NONE => "none",
            LOST => "samples lost",
            DEADLINE => "no sample within the deadline",
            SEND => "a message could not be sent",
            DISK => "the recording could not be written",
            _ => "unknown",
        }
    }
}

const STATES: &[Entry] = &[
    entry(0, "starting", "Opens its ports."),
    entry(1, "running", "Runs and receives samples."),
    entry(2, "waiting", "No sample came within the deadline."),
    entry(3, "ended", "Has ended in order."),
    entry(4, "hanging", "Is at the same sample for too long."),
];
const FAULTS: &[Entry] = &[
    entry(fault::NONE, "", ""),
    entry(
        fault::LOST,
        "lost",
        "Samples were lost before this process.",
    ),
    entry(
        fault::DEADLINE,
        "deadline",
        "No sample came within the deadline.",
    ),
    entry(fault::SEND, "send", "A message could not be sent."),
    entry(
        fault::DISK,
        "disk",
        "The disk took no more of the recording.",
    ),
];
const HEALTH_WORDS: &[(&str, Words)] = &[
    ("state", Words::Codes(STATES)),
    ("fault", Words::Codes(FAULTS)),
];

const fn entry(number: u32, name: &'static str, doc: &'static str) -> Entry {
    Entry { number, name, doc }
}

message! {
    /// Three times a second: how a process is doing. Counts are since its start.
    pub struct Health, "Health", size 168, words HEALTH_WORDS {
        /// Position of the process in the table of processes.
        process: u32, "";
        /// Process id.
        pid: u32, "";
        /// See `State`.
        state: u32, "";
        /// Restarts by the supervisor before this one.
        restarts: u32, "";
        /// Last fault, see `fault`.
        fault: u32, "";
        /// 1 where the real-time scheduling class is in force.
        realtime: u32, "";
        /// Samples handled.
        steps: u64, "";
        /// Samples that were later than one period.
        late: u64, "";
        /// Samples that never arrived (gaps in the sequence).
        lost: u64, "";
        /// Median time of a step.
        step_p50_ns: u64, "ns";
        /// 99th percentile of the time of a step.
        step_p99_ns: u64, "ns";
        /// Longest step.
        step_max_ns: u64, "ns";
        /// Median age of a sample when this process published its answer.
        age_p50_ns: u64, "ns";
        /// 99th percentile of that age.
        age_p99_ns: u64, "ns";
        /// 99.9th percentile of that age.
        age_p999_ns: u64, "ns";
        /// Largest age.
        age_max_ns: u64, "ns";
    }
}

message! {
    /// How far the logger has got; a lossless source waits for it.
    pub struct Credit, "Credit", size 72 {
        /// Number of samples that have passed through every channel.
        through: u64, "";
    }
}

//! Under which conditions the chain is measured.

use std::process::{Child, Command};

use crate::cli::LatencyArgs;
use crate::failure::Failure;

/// One set of conditions.
#[derive(Debug, Clone, Copy)]
pub struct Conditions {
    /// Sampling rate [Hz].
    pub rate: f64,
    /// SCHED_FIFO on one core instead of normal scheduling.
    pub realtime: bool,
    /// A spinner occupies every core.
    pub loaded: bool,
}

/// Every set of conditions that the arguments ask for, the quiet ones first.
pub fn conditions(args: &LatencyArgs, permitted: bool) -> Vec<Conditions> {
    let rates = args
        .rate
        .map_or(vec![100.0, 1_000.0, 10_000.0], |rate| vec![rate]);
    let mut all = Vec::new();
    for loaded in [false, true] {
        for realtime in [true, false] {
            let wanted = if realtime {
                permitted
            } else {
                !args.rt || !permitted
            };
            if wanted && (!loaded || args.load) {
                all.extend(rates.iter().map(|&rate| Conditions {
                    rate,
                    realtime,
                    loaded,
                }));
            }
        }
    }
    all
}

/// Processes that occupy every core until dropped.
pub struct Load(Vec<Child>);

impl Load {
    /// A spinner for every core.
    pub fn start() -> Result<Self, Failure> {
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let spin = || {
            Command::new("sh")
                .args(["-c", "while :; do :; done"])
                .spawn()
        };
        (0..cores)
            .map(|_| spin())
            .collect::<Result<_, _>>()
            .map(Self)
            .map_err(Failure::internal)
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        for child in &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

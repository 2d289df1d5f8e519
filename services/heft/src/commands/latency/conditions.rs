//! Conditions of a latency measurement.

use std::process::{Child, Command};

use runtime::realtime;

use super::LatencyArgs;
use crate::failure::Failure;

/// One set of conditions.
#[derive(Debug, Clone)]
pub struct Conditions {
    /// Sampling rate \[Hz\].
    pub rate: f64,
    /// SCHED_FIFO instead of normal scheduling.
    pub realtime: bool,
    /// Cores of the processes, in turn along the chain; none without SCHED_FIFO: nothing is pinned.
    pub pinned: Vec<usize>,
    /// A busy process occupies every core.
    pub loaded: bool,
    /// Processes that spin instead of sleeping, as `--spin` names them.
    pub spin: Option<String>,
}

impl Conditions {
    /// Number of cores that the processes may use.
    pub fn cores(&self) -> usize {
        if self.realtime {
            self.pinned.len()
        } else {
            realtime::cores().len()
        }
    }
}

/// All sets of conditions of the arguments, those without load first, for a chain of this many processes.
pub fn conditions(
    args: &LatencyArgs,
    permitted: bool,
    processes: usize,
) -> Result<Vec<Conditions>, Failure> {
    let cores = last_cores(args.cores, processes)?;
    let rates = args
        .rate
        .map_or(vec![100.0, 1_000.0, 10_000.0], |rate| vec![rate]);
    let mut all = Vec::new();
    for loaded in [false, true] {
        for realtime in [true, false] {
            let wanted = if realtime {
                permitted && args.spin.is_none()
            } else {
                !args.rt || !permitted
            };
            if wanted && (!loaded || args.load) {
                all.extend(rates.iter().map(|&rate| Conditions {
                    rate,
                    realtime,
                    pinned: if realtime { cores.clone() } else { Vec::new() },
                    loaded,
                    spin: args.spin.clone(),
                }));
            }
        }
    }
    Ok(all)
}

/// The last `wanted` of the cores that this process may use.
fn last_cores(wanted: usize, processes: usize) -> Result<Vec<usize>, Failure> {
    let cores = realtime::cores();
    let most = cores.len().min(processes);
    if !(1..=most).contains(&wanted) {
        return Err(Failure::input(
            format!(
                "the {processes} processes of the chain can be spread over 1 to {most} cores here, not {wanted}"
            ),
            "--cores",
            "`nproc` tells how many cores this program may use",
        ));
    }
    Ok(cores[cores.len() - wanted..].to_vec())
}

/// Processes that occupy every core until dropped.
pub struct Load(Vec<Child>);

impl Load {
    /// Starts a busy process for every core.
    pub fn start() -> Result<Self, Failure> {
        let spin = || {
            Command::new("sh")
                .args(["-c", "while :; do :; done"])
                .spawn()
        };
        (0..realtime::cores().len())
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

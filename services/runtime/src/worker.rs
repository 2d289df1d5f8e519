//! Life cycle of a worker, a process or a thread: receive the bells, open the ports, report `ready`, loop, end.

use std::os::fd::OwnedFd;
use std::sync::Arc;

use messages::Snapshot;

use crate::control::Handed;
use crate::requests::{self, Begin, Requests};
use crate::telemetry::{Identity, Reporter};
use crate::{Bell, Control, Error, Ports, realtime};

/// Run settings of a worker.
#[derive(Debug, Clone, Copy)]
pub struct Setup {
    /// Its identity.
    pub identity: Identity,
    /// SCHED_FIFO priority and core, where real time was requested.
    pub realtime: Option<(u8, Option<usize>)>,
    /// The core of its own on which it polls for messages instead of sleeping until its bell rings.
    pub spins_on: Option<usize>,
    /// Sampling period \[ns\]: a sample with a larger age on arrival is late.
    pub period_ns: u64,
}

/// A worker that has its bells and can open ports.
#[derive(Debug)]
pub struct Worker {
    pub(crate) setup: Setup,
    pub(crate) control: Arc<Control>,
    pub(crate) bell: Bell,
    pub(crate) readers: Vec<Bell>,
    input: Option<OwnedFd>,
    pub(crate) ports: Ports,
    pub(crate) requests: Arc<Requests>,
    pub(crate) reporter: Reporter,
    /// The last state of this process before it died.
    pub(crate) before: Option<Snapshot>,
}

impl Worker {
    /// Receives the bells from the supervisor over `control` and announces the service to iceoryx2; the domain
    /// must have been entered before.
    ///
    /// # Errors
    /// There is no supervisor, or iceoryx2 refuses.
    pub fn start(setup: Setup, control: Control) -> Result<Self, Error> {
        let control = Arc::new(control);
        let Handed {
            bell,
            readers,
            before,
            input,
        } = control.receive_bells()?;
        let ports = Ports::new(setup.identity.name)?;
        let requests = requests::listen(Arc::clone(&control), bell.try_clone()?)?;
        let reporter = Reporter::start(setup.identity, setup.period_ns);
        Ok(Self {
            setup,
            control,
            bell,
            readers,
            input,
            ports,
            requests,
            reporter,
            before,
        })
    }

    /// The ports of this process.
    pub fn ports(&self) -> &Ports {
        &self.ports
    }

    /// Standard input of the run, if the supervisor handed it over; once.
    pub fn take_input(&mut self) -> Option<OwnedFd> {
        self.input.take()
    }

    /// Makes the calling thread a real-time one if requested, reports `ready` and waits for `go`.
    /// Returns the start; `None` if the run ended before it.
    pub(crate) fn begin(&mut self) -> Option<Begin> {
        let entered = match (self.setup.spins_on, self.setup.realtime) {
            (Some(core), _) => Some(realtime::enter_core(core)),
            (None, Some((priority, core))) => Some(realtime::enter(priority, core)),
            (None, None) => None,
        };
        if let Some(result) = entered {
            self.reporter.realtime(result.fifo);
            for refused in &result.refused {
                tracing::warn!("real time: {refused}");
            }
        }
        self.control.say("ready");
        let begin = loop {
            if self.requests.wants_exit() {
                return None;
            }
            if let Some(begin) = self.requests.begin() {
                break begin;
            }
            self.bell.wait();
        };
        self.reporter.run_begins();
        tracing::debug!(first = begin.first, "started");
        // Samples may have arrived, and rung, while this process still waited for `go`.
        self.bell.ring();
        Some(begin)
    }

    /// Waits for the bell; a process that spins returns at once, without a system call.
    pub(crate) fn wait(&self) {
        match self.setup.spins_on {
            Some(_) => std::hint::spin_loop(),
            None => self.bell.wait(),
        }
    }

    /// Rings the bells of all readers, next stage first.
    pub(crate) fn ring(&self) {
        for bell in &self.readers {
            bell.ring();
        }
    }
}

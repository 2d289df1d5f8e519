//! Restart of a worker that dies or hangs.

use std::time::{Duration, Instant};

use super::Supervisor;
use crate::fault::Fault;

/// Longest wait for the resources of dead processes, which are usually freed within a millisecond.
const CLEAN_UP_LIMIT: Duration = Duration::from_millis(200);

impl Supervisor {
    /// Notices a death and restarts; `Err` with the reason when a restart is pointless.
    pub(super) fn keep_alive(&mut self, i: usize) -> Result<(), String> {
        let worker = &mut self.workers[i];
        if let Some(due) = worker.due() {
            return if due <= Instant::now() {
                self.restart(i)
            } else {
                Ok(())
            };
        }
        let Some(status) = worker.died() else {
            return Ok(());
        };
        let service = worker.process.name;
        let hung = worker.hung;
        worker.plan_restart(status, self.owner.domain())?;
        self.watch.note(match hung {
            Some(silence) => Fault::Hung {
                service,
                silence,
                again: true,
            },
            None => {
                tracing::warn!(service, %status, "a service died; it is started again");
                let how = status.to_string();
                Fault::Died { service, how }
            }
        });
        Ok(())
    }

    /// Ends hanging workers; their deaths are then noticed as any other.
    pub(super) fn end_hanging(&mut self) {
        for worker in &mut self.workers {
            let service = worker.process.name;
            if let Some(silence) = worker.hangs(self.watch.processes().health(service)) {
                tracing::warn!(service, ?silence, "a service hangs; it is ended");
                worker.hung = Some(silence);
                worker.kill();
            }
        }
    }

    pub(super) fn restart(&mut self, i: usize) -> Result<(), String> {
        self.spare.release();
        // The ports and samples of the dead process would otherwise count against the limits of the channels.
        if !self.cleaner.clean_up(CLEAN_UP_LIMIT) {
            tracing::warn!(
                "what the dead held is not free yet; the service is started all the same"
            );
        }
        self.taps.drain(&mut self.watch);
        let run = (self.owner.domain(), &self.plan);
        let restarted = self.workers[i].restart(run);
        self.said_seen = None;
        if restarted.is_ok() && self.workers[i].due().is_none() {
            tracing::info!(service = self.workers[i].process.name, "started again");
            self.hand_over(i);
        }
        self.spare.fill();
        restarted
    }
}

//! The part of a run for one machine, without its types.

use messages::{Machine, Message};

use super::{Page, machine, verdicts};
use crate::estimate::Estimate;
use crate::panels::{self, Panel};
use crate::run::{MachineRun, Run};
use crate::words::run_judgements;

/// A machine's part of a run, for a page.
pub(super) trait Part {
    /// Its machine.
    fn machine(&self) -> Machine;
    /// Whether the run has no data of it.
    fn is_empty(&self) -> bool;
    /// Whether its estimates were made from simulated samples.
    fn is_simulated(&self) -> bool;
    /// Time from the first estimate to the last [s].
    fn seconds(&self) -> Option<f64>;
    /// Time of the value of its first verdict [s].
    fn reported_at(&self) -> Option<f64>;
    /// Writes the verdicts at the top.
    fn verdicts(&self, body: &mut String);
    /// Writes all sections.
    fn sections(&self, page: &mut Page, run: &Run);
    /// The headline estimate, over time.
    fn history(&self) -> Vec<Panel>;
}

impl<E: Estimate> Part for MachineRun<E> {
    fn machine(&self) -> Machine {
        E::MACHINE
    }

    fn is_empty(&self) -> bool {
        self.estimators.is_empty()
    }

    fn is_simulated(&self) -> bool {
        let mut last = self.estimators.iter().filter_map(|e| e.estimates.last());
        last.any(Message::is_simulated)
    }

    fn seconds(&self) -> Option<f64> {
        let estimates = &self.primary()?.estimates;
        Some(estimates.last()?.stamp().time - estimates.first()?.stamp().time)
    }

    fn reported_at(&self) -> Option<f64> {
        let judgements = run_judgements(&self.primary()?.estimates);
        Some(judgements.first()?.time)
    }

    fn verdicts(&self, body: &mut String) {
        verdicts::verdicts(body, self);
    }

    fn sections(&self, page: &mut Page, run: &Run) {
        machine(page, run, self);
    }

    fn history(&self) -> Vec<Panel> {
        panels::history::panels(self)
    }
}

macro_rules! all {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// The part of each machine.
        pub(super) fn all(run: &Run) -> [&dyn Part; Machine::ALL.len()] {
            [$( &run.parts.$module ),*]
        }
    };
}

messages::machines!(all);

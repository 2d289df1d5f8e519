//! Sends the complete state of a step twice a second, after its answer, see [`messages::keyframe`].

use messages::channels::KEYFRAME;
use messages::keyframe::{LONGEST, Owner, pieces};
use messages::{Keyframe, Snapshot, Stamp};

use crate::step::Step;
use crate::telemetry::Identity;
use crate::{Error, Output, Ports};

/// Least time between two states [ns], and the same in the time of the data [s].
const PERIOD_NS: u64 = 450_000_000;
const PERIOD: f64 = 0.45;

/// The states of one process.
pub(crate) struct Keyframes {
    owner: Owner,
    output: Output<Keyframe>,
    state: Vec<u8>,
    /// Time at which the last one was sent [ns], and the time of its sample [s].
    last: Option<(u64, f64)>,
}

impl Keyframes {
    /// `fits`: build, method and description of the step as one number.
    pub(crate) fn open(ports: &Ports, who: Identity, fits: u64) -> Result<Self, Error> {
        Ok(Self {
            owner: Owner {
                process: who.process,
                restarts: who.restarts,
                identity: fits,
            },
            output: ports.output(&KEYFRAME)?,
            state: vec![0; LONGEST],
            last: None,
        })
    }

    /// Restores the state that the process had before it died; false if it does not fit.
    pub(crate) fn resume<S: Step>(&self, step: &mut S, before: &Snapshot) -> bool {
        let resumes = before.owner.identity == self.owner.identity && step.restore(&before.bytes);
        if resumes {
            step.resume();
        }
        resumes
    }

    /// Sends the state when one is due.
    pub(crate) fn after<S: Step>(&mut self, step: &S, stamp: &Stamp, now_ns: u64) {
        let is_due = self.last.is_none_or(|(at, time)| {
            let is_near = (stamp.time - time).abs() < PERIOD; // false for a time that is NaN
            now_ns.saturating_sub(at) >= PERIOD_NS || !is_near
        });
        if is_due {
            self.last = Some((now_ns, stamp.time));
            self.emit(step, stamp);
        }
    }

    /// Sends the state after the sample of this stamp.
    pub(crate) fn emit<S: Step>(&mut self, step: &S, stamp: &Stamp) {
        let Some(length) = step.save(&mut self.state) else {
            return;
        };
        for piece in pieces(self.owner, stamp, &self.state[..length]) {
            self.output.send(&piece);
        }
        self.output.notify();
    }

    /// Connects to the readers that exist now.
    pub(crate) fn connect(&self) {
        self.output.connect();
    }
}

//! Drives a [`Step`]: waits for the bell (or spins), answers every waiting message.

use messages::channels::ChannelOf;
use messages::{Hop, Message, fault};

use crate::clock::now_ns;
use crate::keyframes::Keyframes;
use crate::step::{Step, answer};
use crate::telemetry::Event;
use crate::{Error, Input, Output, Worker};

/// Runs `step` from `input` to `output` until the supervisor ends it. `fits`: a number that a state must
/// match to be restored into this step.
///
/// # Errors
/// A channel cannot be opened.
pub fn run_stage<S: Step>(
    mut worker: Worker,
    input: &ChannelOf<S::Input>,
    output: &ChannelOf<S::Output>,
    hop: Hop,
    fits: u64,
    mut step: S,
) -> Result<(), Error> {
    let mut keyframes = Keyframes::open(&worker.ports, worker.setup.identity, fits)?;
    let before = worker.before.take();
    let before = before.filter(|before| keyframes.resume(&mut step, before));
    let mut input = worker.ports.input::<S::Input>(input, input.depth)?;
    let mut output = worker.ports.output::<S::Output>(output)?;
    input.connect();
    output.connect();
    let Some(begin) = worker.begin() else {
        return Ok(());
    };
    input.count_from(begin.first);
    input.connect();
    output.connect();
    keyframes.connect();
    if let Some(before) = before {
        keyframes.emit(&step, &before.stamp);
    }
    while !worker.requests.wants_exit() {
        worker.wait();
        let draining = worker.requests.take_drain();
        let ends = (&mut input, &mut output);
        answer_all(&mut worker, ends, hop, &mut step, &mut keyframes);
        if draining {
            worker.control.say("drained");
        }
    }
    Ok(())
}

fn answer_all<S: Step>(
    worker: &mut Worker,
    (input, output): (&mut Input<S::Input>, &mut Output<S::Output>),
    hop: Hop,
    step: &mut S,
    keyframes: &mut Keyframes,
) {
    while let Some((message, lost)) = input.receive() {
        let received = now_ns();
        worker.reporter.begin();
        let mut out = answer(step, &message);
        worker.reporter.end();
        let published = now_ns();
        let restarts = worker.setup.identity.restarts;
        out.hops_mut().mark(hop, published, restarts);
        if !output.send(&out) {
            worker.reporter.fault(fault::SEND);
        }
        worker.ring();
        output.notify();
        output.prepare();
        let measured = message.stamp().measured_ns;
        worker.reporter.sample(Event {
            age_ns: published.saturating_sub(measured),
            step_ns: published.saturating_sub(received),
            lost,
            late: received.saturating_sub(measured) > worker.setup.period_ns,
        });
        keyframes.after(step, message.stamp(), published);
    }
}

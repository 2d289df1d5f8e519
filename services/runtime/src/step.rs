use messages::Message;

/// Work of a service: one message in, one message out, always an answer.
///
/// A step does not allocate, block, log, or read a clock; it reports faults in the answer. The same
/// value runs in a process, in `heft estimate` and in the tests, with bit-identical results.
pub trait Step {
    /// Message that it reads.
    type Input: Message;
    /// Message that it answers with.
    type Output: Message;

    /// Answers one message. Stamp and hops of the answer are filled in by [`answer`].
    fn step(&mut self, input: &Self::Input) -> Self::Output;

    /// Writes its complete state, bit by bit, without allocation, and returns its length in bytes;
    /// `None` if there is no room, or no state.
    fn save(&self, _into: &mut [u8]) -> Option<usize> {
        None
    }

    /// Restores a written state; false, and unchanged, if the state is not one of this step.
    fn restore(&mut self, _state: &[u8]) -> bool {
        false
    }

    /// Notifies the step that it was restored in a new process, and that samples were missed.
    fn resume(&mut self) {}
}

/// The answer of `step` to `input`, with the identity of the input; it is marked as simulated where the
/// input is.
pub fn answer<S: Step>(step: &mut S, input: &S::Input) -> S::Output {
    let mut output = step.step(input);
    *output.stamp_mut() = *input.stamp();
    *output.hops_mut() = *input.hops();
    if input.is_simulated() {
        output.mark_simulated();
    }
    output
}

/// Source of samples: a simulator, a recording, a bus.
pub trait Source {
    /// Sensor samples.
    type Sensors: Message;
    /// Truth of the samples; empty where none is known.
    type Truth: Message;

    /// The next sample with `stamp.{machine, sequence, time}` filled in; `None` at the end.
    fn next(&mut self) -> Option<(Self::Sensors, Self::Truth)>;
}

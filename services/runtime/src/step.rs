use messages::Message;

/// A service's work: one message in, one message out, always an answer.
///
/// A step does not allocate, block, log, or read a clock; trouble is said in the answer. The same
/// value runs in a process, in `heft estimate` and in the tests, with the same bits as result.
pub trait Step {
    /// What it reads.
    type Input: Message;
    /// What it answers.
    type Output: Message;

    /// Answers one message. Stamp and hops of the answer are filled in by [`answer`].
    fn step(&mut self, input: &Self::Input) -> Self::Output;

    /// Writes its complete state, bit by bit, without allocation, and returns how many bytes that took;
    /// `None` if there is no room, or nothing to keep.
    fn save(&self, _into: &mut [u8]) -> Option<usize> {
        None
    }

    /// Becomes what it was when it wrote this state; false, and unchanged, if this is no state of its own.
    fn restore(&mut self, _state: &[u8]) -> bool {
        false
    }

    /// Is notified that it was restored in a new process, and that samples were missed.
    fn resume(&mut self) {}
}

/// The answer of `step` to `input`, with the identity of the input; what is made from simulated
/// samples says so.
pub fn answer<S: Step>(step: &mut S, input: &S::Input) -> S::Output {
    let mut output = step.step(input);
    *output.stamp_mut() = *input.stamp();
    *output.hops_mut() = *input.hops();
    if input.is_simulated() {
        output.mark_simulated();
    }
    output
}

/// Where samples come from: a simulator, a recording, a bus.
pub trait Source {
    /// What the sensors measured.
    type Sensors: Message;
    /// The truth behind it; empty where none is known.
    type Truth: Message;

    /// The next sample with `stamp.{machine, sequence, time}` filled in; `None` at the end.
    fn next(&mut self) -> Option<(Self::Sensors, Self::Truth)>;
}

//! Compares recorded answers with recomputed ones, one by one in constant memory.
//!
//! A stage answers each sample that reached it, in order. Between two recorded answers some may be
//! missing, and the recording does not contain the reason: the stage may have lost the samples, or answered
//! them while the logger lost the answers. Each case leaves the stage in another state, so both are
//! tried, and the next answer decides bit for bit. That answer may be equal in both cases; then a later one decides. If no case agrees
//! the state is unknown: the following answers are not checked, and are not counted as differences, until a keyframe gives the state.

use std::collections::VecDeque;
use std::iter::Peekable;

use messages::Snapshot;

/// Identity of a sample: life of the source, sequence number.
pub type Place = (u32, u64);

/// Operations on a stage for its replay.
pub trait Replay {
    /// Message that it reads.
    type Input;
    /// Message that it answers.
    type Answer;
    /// The stage itself.
    type Step;

    /// The stage in its initial state.
    fn begin(&self) -> Self::Step;
    /// The stage in a recorded state; `None` if the state is of another build.
    fn restore(&self, state: &Snapshot) -> Option<Self::Step>;
    /// A copy of it.
    fn fork(&self, step: &Self::Step) -> Self::Step;
    /// Its answer; `None` for an input that it cannot read.
    fn answer(&self, step: &mut Self::Step, input: &Self::Input) -> Option<Self::Answer>;
    /// Identity of an input's sample.
    fn place(&self, input: &Self::Input) -> Place;
    /// Identity of the sample that an answer belongs to, and number of restarts of the stage.
    fn place_and_life(&self, answer: &Self::Answer) -> (Place, u32);
    /// Name of the first field that differs.
    fn difference(&self, a: &Self::Answer, b: &Self::Answer) -> Option<&'static str>;
}

/// Result of the comparison.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Compared {
    /// Recorded answers.
    pub answers: usize,
    /// Answers that are identical bit for bit.
    pub identical: usize,
    /// Sequence number and field of the first difference.
    pub first_difference: Option<(u64, &'static str)>,
    /// Answers that cannot be checked, because the state before them is unknown.
    pub unknown: usize,
    /// Answers to samples after the last recorded one: an active logger writes a chunk with the
    /// answer before the chunk with its sample.
    pub ahead: usize,
}

impl Compared {
    /// Answers that differ.
    pub fn different(&self) -> usize {
        self.answers - self.identical - self.unknown - self.ahead
    }

    /// Adds the counts of another stage.
    pub fn add(&mut self, other: &Self) {
        self.answers += other.answers;
        self.identical += other.identical;
        self.unknown += other.unknown;
        self.ahead += other.ahead;
    }
}

/// Recorded states of one stage, in the order of their places.
struct States<I: Iterator<Item = Snapshot>> {
    rest: Peekable<I>,
    /// The latest state before the present answer.
    latest: Option<Snapshot>,
}

impl<I: Iterator<Item = Snapshot>> States<I> {
    /// The last state of this life of the stage before the sample at `place`.
    fn before(&mut self, place: Place, life: u32) -> Option<&Snapshot> {
        let earlier = |s: &Snapshot| (s.owner.restarts, place_of(s)) < (life, place);
        while let Some(state) = self.rest.next_if(earlier) {
            self.latest = Some(state);
        }
        self.latest.as_ref().filter(|s| s.owner.restarts == life)
    }
}

fn place_of(state: &Snapshot) -> Place {
    (state.stamp.epoch, state.stamp.sequence)
}

/// Number of stored samples without an answer: more than any channel holds.
const WAITING: usize = 1024;

/// Recomputes every answer. Inputs, answers and states come in the order of their places.
pub fn compare<R: Replay>(
    replay: &R,
    inputs: impl Iterator<Item = R::Input>,
    answers: impl Iterator<Item = R::Answer>,
    states: impl Iterator<Item = Snapshot>,
) -> Compared {
    let mut inputs = inputs.peekable();
    let mut states = States {
        rest: states.peekable(),
        latest: None,
    };
    let mut result = Compared::default();
    let mut step = Some(replay.begin());
    // Whether the state is certain, and not only consistent with every answer up to now.
    let mut sure = true;
    let (mut last, mut last_life): (Option<Place>, u32) = (None, 0);
    for recorded in answers {
        result.answers += 1;
        let (place, life) = replay.place_and_life(&recorded);
        let state = states.before(place, life);
        let is_new = life != last_life;
        if is_new {
            (step, last_life, sure) = (Some(replay.begin()), life, true);
        }
        // The state from which the stage continued after a restart, or one that makes it certain again. It must not be from before
        // the answers that could not be checked.
        let is_near = |s: &&Snapshot| last.is_some_and(|last| place_of(s) >= last);
        let restored = state.filter(|s| is_new || (step.is_none() || !sure) && is_near(s));
        let restored = restored.and_then(|state| Some((replay.restore(state)?, place_of(state))));
        // Samples without a recorded answer.
        let mut waiting = VecDeque::new();
        let mut passed = 0;
        while let Some(input) = inputs.next_if(|input| replay.place(input) < place) {
            passed += 1;
            if waiting.len() == WAITING {
                waiting.pop_front();
            }
            waiting.push_back(input);
        }
        // The state from which a restarted stage continued is not recorded.
        let lost = is_new && life > 0 && restored.is_none();
        if let Some((state, seen)) = restored {
            waiting.retain(|input| replay.place(input) > seen);
            (step, sure) = (Some(state), true);
        }
        let first = last.map_or(0, |(_, n)| n + 1);
        let follows = last.is_none_or(|(epoch, _)| epoch == place.0) && place.1 == first;
        last = Some(place);
        let sample = inputs.next_if(|input| replay.place(input) == place);
        let is_ahead = sample.is_none() && inputs.peek().is_none();
        let (Some(sample), Some(before)) = (sample, step.take()) else {
            result.ahead += usize::from(is_ahead);
            result.unknown += usize::from(!is_ahead);
            continue;
        };
        let gap = passed > 0 || !follows || lost;
        match explain(replay, before, &waiting, &sample, &recorded) {
            Ok(after) => {
                result.identical += 1;
                sure &= !gap;
                step = Some(after);
            }
            // The state before it was certain, and therefore the state after it too.
            Err((field, after)) if !gap && sure => {
                result.first_difference.get_or_insert((place.1, field));
                step = Some(after);
            }
            Err(_) => result.unknown += 1,
        }
    }
    result
}

/// The state after the recorded answer: that of the first case that reproduces it. `Err` if no case
/// does: the field that differs, and the state if no sample is missing.
fn explain<R: Replay>(
    replay: &R,
    before: R::Step,
    waiting: &VecDeque<R::Input>,
    sample: &R::Input,
    recorded: &R::Answer,
) -> Result<R::Step, (&'static str, R::Step)> {
    let try_out = |mut step: R::Step, skipped: usize| {
        for input in waiting.iter().skip(skipped) {
            let _ = replay.answer(&mut step, input);
        }
        let answer = replay.answer(&mut step, sample);
        let field = answer.map_or(Some("type"), |a| replay.difference(&a, recorded));
        (field, step)
    };
    // Cases: none of the waiting samples reached the stage; all did; the oldest were lost before it.
    let n = waiting.len();
    let cases = [n].into_iter().chain(0..n);
    let mut first = None;
    for skipped in cases {
        match try_out(replay.fork(&before), skipped) {
            (None, after) => return Ok(after),
            (Some(field), after) => first = first.or(Some((field, after))),
        }
    }
    Err(first.unwrap_or(("type", before)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums its inputs: every sample that it saw or missed shows in all later answers.
    struct Sum;

    type Answer = (Place, u32, u64);

    impl Replay for Sum {
        type Input = Place;
        type Answer = Answer;
        type Step = u64;

        fn begin(&self) -> u64 {
            7
        }
        fn restore(&self, state: &Snapshot) -> Option<u64> {
            Some(u64::from_le_bytes(state.bytes.clone().try_into().ok()?))
        }
        fn fork(&self, step: &u64) -> u64 {
            *step
        }
        fn answer(&self, step: &mut u64, input: &Place) -> Option<Answer> {
            *step = step.wrapping_mul(31).wrapping_add(input.1);
            Some((*input, 0, *step))
        }
        fn place(&self, input: &Place) -> Place {
            *input
        }
        fn place_and_life(&self, answer: &Answer) -> (Place, u32) {
            (answer.0, answer.1)
        }
        fn difference(&self, a: &Answer, b: &Answer) -> Option<&'static str> {
            (a.2 != b.2).then_some("sum")
        }
    }

    /// The answers of a stage to the samples that reach it; restarted before each of `restarts`.
    fn answers(samples: &[Place], reached: impl Fn(u64) -> bool, restarts: &[u64]) -> Vec<Answer> {
        let (mut step, mut life) = (Sum.begin(), 0);
        let mut out = Vec::new();
        for sample in samples.iter().filter(|s| reached(s.1)) {
            if restarts.contains(&sample.1) {
                (step, life) = (Sum.begin(), life + 1);
            }
            let answer = Sum.answer(&mut step, sample).expect("an answer");
            out.push((answer.0, life, answer.2));
        }
        out
    }

    fn samples(n: u64) -> Vec<Place> {
        (0..n).map(|i| (0, i)).collect()
    }

    fn check(inputs: &[Place], answers: &[Answer]) -> Compared {
        check_with(inputs, answers, &[])
    }

    fn check_with(inputs: &[Place], answers: &[Answer], states: &[Snapshot]) -> Compared {
        let (inputs, answers) = (inputs.iter().copied(), answers.iter().copied());
        compare(&Sum, inputs, answers, states.iter().cloned())
    }

    /// The state after an answer.
    fn state(answer: &Answer) -> Snapshot {
        let mut state = Snapshot {
            bytes: answer.2.to_le_bytes().to_vec(),
            ..Snapshot::default()
        };
        (state.stamp.epoch, state.stamp.sequence) = answer.0;
        state.owner.restarts = answer.1;
        state
    }

    #[test]
    fn behind_a_gap_the_check_goes_on_at_the_next_state() {
        let inputs = samples(1000);
        let all = answers(&inputs, |_| true, &[]);
        let recorded = |n: u64| !(300..400).contains(&n);
        let logged: Vec<_> = all.iter().copied().filter(|a| recorded(a.0.1)).collect();
        let seen: Vec<_> = inputs.iter().copied().filter(|s| recorded(s.1)).collect();
        let every_50: Vec<_> = logged.iter().step_by(50).map(state).collect();
        let compared = check_with(&seen, &logged, &every_50);
        // From 400 on: that answer cannot be checked itself, but its state is recorded.
        assert_eq!((compared.identical, compared.unknown), (899, 1));
        let late: Vec<_> = logged.iter().skip(10).step_by(50).map(state).collect();
        let compared = check_with(&seen, &logged, &late);
        assert_eq!((compared.identical, compared.unknown), (889, 11));
        // Unfit states neither help nor harm.
        let foreign = Snapshot::default();
        let compared = check_with(&seen, &logged, &[foreign]);
        assert_eq!((compared.identical, compared.unknown), (300, 600));
    }

    #[test]
    fn a_stage_that_went_on_from_an_earlier_state_is_followed() {
        let inputs = samples(400);
        let mut all = answers(&inputs[..200], |_| true, &[]);
        // It died after 199, restarted at 220 with its state of 150, and reports that before its first answer.
        let mut resumed = state(&all[150]);
        resumed.owner.restarts = 1;
        let mut step = Sum.restore(&resumed).expect("a state");
        for input in &inputs[220..] {
            let answer = Sum.answer(&mut step, input).expect("an answer");
            all.push((answer.0, 1, answer.2));
        }
        let states = [state(&all[100]), state(&all[150]), resumed];
        let compared = check_with(&inputs, &all, &states);
        assert_eq!((compared.identical, compared.unknown), (380, 0));
        let compared = check_with(&inputs, &all, &states[..2]);
        assert_eq!(compared.identical, 200, "{compared:?}");
    }

    #[test]
    fn samples_lost_before_a_stage_and_answers_lost_behind_it_are_distinguished() {
        let inputs = samples(1000);
        // Of 200 to 699 the oldest 300 never reached the stage; of the answers to the rest 100 are lost.
        let stage = answers(&inputs, |n| !(200..500).contains(&n), &[]);
        let logged: Vec<_> = stage
            .into_iter()
            .filter(|a| !(500..600).contains(&a.0.1))
            .collect();
        let compared = check(&inputs, &logged);
        assert_eq!(
            (compared.identical, compared.unknown),
            (600, 0),
            "{compared:?}"
        );
        // All answers of a stretch lost, all samples lost.
        let all = answers(&inputs, |_| true, &[]);
        let logged: Vec<_> = all
            .into_iter()
            .filter(|a| !(300..340).contains(&a.0.1))
            .collect();
        assert_eq!(check(&inputs, &logged).identical, 960);
        let some = answers(&inputs, |n| n % 10 != 3, &[]);
        assert_eq!(check(&inputs, &some).identical, 900);
    }

    #[test]
    fn a_stage_whose_source_was_dead_has_no_gap() {
        // Numbers 300 to 349 were never generated: neither samples nor answers exist.
        let inputs: Vec<_> = samples(1000)
            .into_iter()
            .filter(|s| !(300..350).contains(&s.1))
            .collect();
        assert_eq!(
            check(&inputs, &answers(&inputs, |_| true, &[])).identical,
            950
        );
        // A source that was restarted begins a new life, with numbers that may repeat.
        let twice: Vec<Place> = (0..500)
            .map(|n| (0, n))
            .chain((480..900).map(|n| (1, n)))
            .collect();
        assert_eq!(
            check(&twice, &answers(&twice, |_| true, &[])).identical,
            920
        );
    }

    #[test]
    fn after_a_gap_of_the_recording_nothing_is_claimed_until_the_stage_restarts() {
        let inputs = samples(1000);
        let all = answers(&inputs, |_| true, &[700]);
        // The logger was dead from 300 to 399.
        let recorded = |n: u64| !(300..400).contains(&n);
        let logged: Vec<_> = all.iter().copied().filter(|a| recorded(a.0.1)).collect();
        let seen: Vec<_> = inputs.iter().copied().filter(|s| recorded(s.1)).collect();
        let compared = check(&seen, &logged);
        assert_eq!((compared.identical, compared.unknown), (600, 300));
        assert_eq!(compared.first_difference, None, "no wolf");
    }

    #[test]
    fn answers_behind_the_last_recorded_sample_are_ahead_and_not_behind_a_gap() {
        let inputs = samples(100);
        let all = answers(&inputs, |_| true, &[]);
        let compared = check(&inputs[..97], &all);
        let counts = (compared.identical, compared.unknown, compared.ahead);
        assert_eq!(counts, (97, 0, 3));
        // A missing sample with later samples after it is a gap.
        let seen: Vec<_> = inputs[..97].iter().copied().filter(|s| s.1 != 50).collect();
        let compared = check(&seen, &all);
        let counts = (compared.identical, compared.unknown, compared.ahead);
        assert_eq!(counts, (50, 47, 3));
    }

    #[test]
    fn one_changed_answer_is_a_difference_and_the_rest_is_still_checked() {
        let inputs = samples(100);
        let mut all = answers(&inputs, |_| true, &[]);
        all[40].2 += 1;
        let compared = check(&inputs, &all);
        assert_eq!((compared.identical, compared.unknown), (99, 0));
        assert_eq!(compared.first_difference, Some((40, "sum")));
    }
}

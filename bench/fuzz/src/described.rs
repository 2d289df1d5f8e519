//! Targets: descriptions, and all steps on descriptions and samples.

use config::Description;
use messages::channels::Visitor;
use messages::{Envelope, Machine, Message, Receiver, channels};
use steps::chain::{Chain, chain};
use steps::stages::Pipeline;

use crate::recorded::{Wild, assert_finite};

/// A description that is read prints itself, and the steps that accept it work with it.
pub fn description(input: &[u8]) {
    let text = String::from_utf8_lossy(input);
    for machine in [None, Some(Machine::Excavator), Some(Machine::Loader)] {
        let Ok(read) = Description::parse(&text, "input", machine) else {
            continue;
        };
        let printed = read.to_toml();
        let again =
            Description::parse(&printed, "printed", None).expect("what it prints, it reads");
        assert_eq!(again.to_toml(), printed, "printing is a fixed point");
        answer(&read, &Wild::new(&[0, 5]));
    }
}

/// Samples with extreme numbers through every step with every method.
pub fn estimate(input: &[u8]) {
    let samples = Wild::new(input);
    answer(&Description::default_of(samples.machine), &samples);
}

/// Asserts that every number from a step is finite.
fn answer(description: &Description, samples: &Wild) {
    let pipeline = Pipeline::of(description.machine());
    let source = pipeline.sensors().expect("a source");
    let place = channels::of_machine(description.machine())
        .position(|c| c.name == source.name)
        .expect("the channel of the samples");
    let samples: Vec<Envelope> = (0..samples.rows)
        .map(|row| {
            source.payload.visit(Make {
                samples,
                place,
                row,
            })
        })
        .collect();
    for stage in pipeline.stages {
        for method in stage.methods() {
            let Ok(mut chain) = chain(description, method) else {
                continue;
            };
            for sample in &samples {
                follow(&mut chain, *sample);
            }
        }
    }
}

/// Passes a sample through the steps. All answers must be finite.
fn follow(chain: &mut Chain, mut message: Envelope) {
    for (_, step) in chain {
        let Some(answer) = step.answer(&message) else {
            return;
        };
        answer.open(Finite);
        message = answer;
    }
}

struct Make<'a> {
    samples: &'a Wild,
    place: usize,
    row: u64,
}

impl Visitor for Make<'_> {
    type Output = Envelope;

    fn visit<M: Message>(self) -> Envelope {
        self.samples.message::<M>(self.place, self.row).envelope()
    }
}

struct Finite;

impl Receiver for Finite {
    type Output = ();

    fn receive<M: Message>(self, message: &M) {
        assert_finite(message);
    }
}

/// A description with all keys for each machine.
pub fn whole_descriptions() -> Vec<Vec<u8>> {
    let whole = |machine| Description::default_of(machine).to_toml().into_bytes();
    Machine::ALL.map(whole).into()
}

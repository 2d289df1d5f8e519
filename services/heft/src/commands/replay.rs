//! `heft replay`: recomputes every estimate of a recording from the recorded inputs of its process, see
//! [`crate::compare`].

use std::path::{Path, PathBuf};

use clap::Args;
use config::Description;
use messages::channels::KEYFRAME;
use messages::keyframe::Collector;
use messages::{Envelope, HEAD, Hop, Keyframe, Machine, Snapshot};
use recording::{Metadata, Reader};
use steps::stages::{AnyStep, Pipeline, Stage};

use crate::build;
use crate::compare::{Compared, Place, Replay, compare};
use crate::failure::Failure;
use crate::parts::{self, envelopes};
use crate::plan::{method_key, state_identity};

/// `heft replay`
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// The recording, or its folder
    pub file: PathBuf,
    /// Compare every estimate bit for bit; exit 1 if one differs or cannot be checked
    #[arg(long)]
    pub verify: bool,
}

/// `heft replay`
pub fn replay(args: &ReplayArgs) -> Result<(), Failure> {
    let reader = parts::open(&args.file)?;
    let metadata = reader.metadata();
    let other_build = build::difference(metadata);
    if let Some(builds) = &other_build {
        println!("{builds}");
    }
    let description = description(metadata, &args.file)?;
    let mut all = Compared::default();
    for (stage, row) in Pipeline::of(description.machine()).rows() {
        let method = method(metadata, stage, &args.file)?;
        let text = metadata.get("description").map_or("", String::as_str);
        let replay = OfRow {
            fits: state_identity(text, stage.name, method),
            fresh: row.start(&description, method)?,
            hop: row.hop(),
            recorded: names(&reader, row.output().name),
        };
        let inputs = envelopes(&reader, row.input())?;
        let recorded = envelopes(&reader, row.output())?;
        let pipeline = Pipeline::of(description.machine());
        let mine = |piece: &Keyframe| pipeline.process_name(piece.process) == stage.name;
        let mut collector = Collector::default();
        let pieces = reader.stream::<Keyframe>(KEYFRAME.name)?.filter(mine);
        let states = pieces.filter_map(|piece| collector.take(&piece));
        let mut result = compare(&replay, inputs, recorded, states);
        if !reader.is_being_written() {
            // The recording is finished: the samples will not be written any more.
            result.unknown += std::mem::take(&mut result.ahead);
        }
        if result.answers > 0 {
            println!("{}", line(row.output().name, &result));
        }
        all.add(&result);
    }
    if all.answers == 0 {
        return Err(Failure::input(
            "this recording holds no estimates",
            args.file.display(),
            "replay a recording that `heft run` has made",
        ));
    }
    tell(&all);
    if args.verify && all.different() > 0 {
        return Err(differ(&all, other_build.as_deref(), &args.file));
    }
    parts::check_whole(&reader)?;
    if args.verify && all.unknown > 0 {
        return Err(Failure::answer_is_no(format!(
            "{} of {} estimates were not checked; all others are identical\n  where: {}\n  \
             what to do: nothing, where a process was restarted or the recording has a gap; else look for its other parts",
            all.unknown,
            all.answers,
            args.file.display()
        )));
    }
    Ok(())
}

/// Prints the sums of all stages.
fn tell(all: &Compared) {
    let Compared {
        answers,
        identical,
        unknown,
        ahead,
        ..
    } = all;
    println!("{identical} of {answers} estimates are bit-identical");
    if *unknown > 0 {
        println!(
            "{unknown} cannot be checked: the recording has a gap between them and the next state"
        );
    }
    if *ahead > 0 {
        println!("{ahead} came before the logger had written their samples: the run goes on");
    }
}

/// The failure of estimates that differ; `builds`: the builds, if another one made the recording.
fn differ(all: &Compared, builds: Option<&str>, file: &Path) -> Failure {
    let different = all.different();
    Failure::answer_is_no(match builds {
        Some(builds) => format!(
            "{different} estimates differ: {builds}\n  where: {}\n  what to do: replay it with the build that made it; another one may compute otherwise",
            file.display()
        ),
        None => format!("{different} estimates differ, though the same build made them"),
    })
}

fn line(channel: &str, result: &Compared) -> String {
    let mut text = format!(
        "{:<24} {} of {} bit-identical",
        channel, result.identical, result.answers
    );
    if let Some((sequence, field)) = result.first_difference {
        text += &format!("; the first difference is in `{field}` of sample {sequence}");
    }
    if result.unknown > 0 {
        text += &format!("; {} behind a gap of the recording", result.unknown);
    }
    if result.ahead > 0 {
        text += &format!("; {} ahead of their samples", result.ahead);
    }
    text
}

/// The description in the recording; prints a note if it was changed after the run.
fn description(metadata: &Metadata, file: &Path) -> Result<Description, Failure> {
    let name = metadata.get("machine");
    let machine = name.and_then(|name| Machine::from_name(name));
    let machine = machine.ok_or_else(|| missing("machine", file))?;
    let text = metadata
        .get("description")
        .ok_or_else(|| missing("description", file))?;
    if metadata.get("description.sha256") != Some(&recording::sha256(text)) {
        println!("the machine file in the recording was changed after the run");
    }
    Ok(Description::parse(
        text,
        "the machine file in the recording",
        Some(machine),
    )?)
}

fn missing(key: &str, file: &Path) -> Failure {
    Failure::input(
        format!("the recording does not say its {key}"),
        file.display(),
        "replay a recording that `heft run` has made",
    )
}

/// Method of a stage by the recording; empty where there is no choice.
fn method<'a>(metadata: &'a Metadata, stage: &Stage, file: &Path) -> Result<&'a str, Failure> {
    if stage.methods().is_empty() {
        return Ok("");
    }
    // Names of the methods of both estimating processes in recordings of version 0.1.
    let old = if stage.name == "ukf" {
        "second_method"
    } else {
        "first_method"
    };
    let key = method_key(stage.name);
    let value = metadata.get(&key).or_else(|| metadata.get(old));
    value.map(String::as_str).ok_or_else(|| missing(&key, file))
}

fn names(reader: &Reader, channel: &str) -> Vec<String> {
    let fields = reader.fields(channel).into_iter();
    fields.map(|field| field.name).collect()
}

/// A stage under comparison.
struct OfRow {
    /// Identity that a recorded state must have.
    fits: u64,
    fresh: Box<dyn AnyStep>,
    hop: Hop,
    /// Names of the recorded fields: another version may have more.
    recorded: Vec<String>,
}

impl Replay for OfRow {
    type Input = Envelope;
    type Answer = Envelope;
    type Step = Box<dyn AnyStep>;

    fn begin(&self) -> Self::Step {
        self.fresh.fork()
    }

    fn restore(&self, state: &Snapshot) -> Option<Self::Step> {
        let mut step = self.begin();
        let fits = state.owner.identity == self.fits && step.restore(&state.bytes);
        fits.then_some(step)
    }

    fn fork(&self, step: &Self::Step) -> Self::Step {
        step.fork()
    }

    fn answer(&self, step: &mut Self::Step, input: &Envelope) -> Option<Envelope> {
        step.answer(input)
    }

    fn place(&self, input: &Envelope) -> Place {
        (input.stamp().epoch, input.stamp().sequence)
    }

    fn place_and_life(&self, answer: &Envelope) -> (Place, u32) {
        (self.place(answer), answer.hops().restarts(self.hop))
    }

    /// Compares the fields of the message itself, as far as they were recorded.
    fn difference(&self, a: &Envelope, b: &Envelope) -> Option<&'static str> {
        let same = |i: usize| match (a.get(i), b.get(i)) {
            (Some(a), Some(b)) => a.same_bits(b),
            (a, b) => a.is_none() && b.is_none(),
        };
        let fields = a.fields();
        (HEAD..fields.len())
            .filter(|&i| self.recorded.iter().any(|name| name == fields[i].name))
            .find(|&i| !same(i))
            .map(|i| fields[i].name)
    }
}

//! `heft replay`: recomputes every estimate of a recording from what its process read.
//!
//! A process answers each sample that reached it, in order, and begins with a new state when it is
//! restarted. The recording tells both, by the sequence numbers of the answers and by the life of
//! the stage that made them. So losses and restarts replay too. Only where the recording itself has
//! a gap (its logger was killed) the state behind the gap is unknown: what a stage answered after
//! it, until it began anew, cannot be checked, and is counted as such.

use std::collections::HashMap;
use std::path::Path;

use config::Description;
use messages::{Envelope, HEAD, Machine};
use recording::{Metadata, Reader};
use steps::stages::{AnyStep, Pipeline, Row, Stage};

use crate::cli::ReplayArgs;
use crate::failure::Failure;
use crate::parts::envelopes;
use crate::plan::method_key;

/// Comparison of one channel.
struct Compared {
    channel: &'static str,
    answers: usize,
    identical: usize,
    /// Sequence number and field of the first difference.
    first_difference: Option<(u64, &'static str)>,
    /// Answers behind a gap of the recording.
    unknown: usize,
}

/// `heft replay`
pub fn replay(args: &ReplayArgs) -> Result<(), Failure> {
    super::recover::mend(&args.file)?;
    let reader = Reader::open(&args.file)?;
    let metadata = reader.metadata();
    let version = metadata.get("heft.version").map_or("?", String::as_str);
    if version != env!("CARGO_PKG_VERSION") {
        println!(
            "recorded by heft {version}, replayed by heft {}",
            env!("CARGO_PKG_VERSION")
        );
    }
    let description = description(metadata, &args.file)?;
    let mut results = Vec::new();
    for (stage, row) in Pipeline::of(description.machine()).rows() {
        let method = method(metadata, stage, &args.file)?;
        let new = || Ok(row.start(&description, method)?);
        results.push(compare(&reader, row, new)?);
    }
    let (mut answers, mut identical, mut unknown) = (0, 0, 0);
    for result in results.iter().filter(|r| r.answers > 0) {
        println!("{}", line(result));
        answers += result.answers;
        identical += result.identical;
        unknown += result.unknown;
    }
    if answers == 0 {
        return Err(Failure::input(
            "this recording holds no estimates",
            args.file.display(),
            "replay a recording that `heft run` has made",
        ));
    }
    println!("{identical} of {answers} estimates are bit-identical");
    if unknown > 0 {
        println!("{unknown} cannot be checked: the recording has a gap before them");
    }
    let different = answers - identical - unknown;
    if args.verify && different > 0 {
        return Err(Failure::answer_is_no(format!(
            "{different} estimates differ"
        )));
    }
    Ok(())
}

fn line(result: &Compared) -> String {
    let mut text = format!(
        "{:<24} {} of {} bit-identical",
        result.channel, result.identical, result.answers
    );
    if let Some((sequence, field)) = result.first_difference {
        text += &format!("; the first difference is in `{field}` of sample {sequence}");
    }
    if result.unknown > 0 {
        text += &format!("; {} behind a gap of the recording", result.unknown);
    }
    text
}

/// The description that the recording carries; a change since then is named.
fn description(metadata: &Metadata, file: &Path) -> Result<Description, Failure> {
    let name = metadata.get("machine");
    let machine = name.and_then(|name| Machine::from_name(name));
    let machine = machine.ok_or_else(|| missing("machine", file))?;
    let text = metadata
        .get("description")
        .ok_or_else(|| missing("description", file))?;
    if metadata.get("description.sha256") != Some(&recording::sha256(text)) {
        println!("the description in the recording was changed after the run");
    }
    Ok(Description::parse(
        text,
        "the description in the recording",
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

/// Method of a stage, as the recording tells it: empty where there is no choice.
fn method<'a>(metadata: &'a Metadata, stage: &Stage, file: &Path) -> Result<&'a str, Failure> {
    if stage.methods().is_empty() {
        return Ok("");
    }
    // What recordings of version 0.1 call the methods of the two estimating processes.
    let old = if stage.name == "ukf" {
        "second_method"
    } else {
        "first_method"
    };
    let key = method_key(stage.name);
    let told = metadata.get(&key).or_else(|| metadata.get(old));
    told.map(String::as_str).ok_or_else(|| missing(&key, file))
}

fn compare(
    reader: &Reader,
    row: &dyn Row,
    new: impl Fn() -> Result<Box<dyn AnyStep>, Failure>,
) -> Result<Compared, Failure> {
    let samples = envelopes(reader, row.input())?;
    let recorded = envelopes(reader, row.output())?;
    let by_number: HashMap<u64, &Envelope> =
        samples.iter().map(|m| (m.stamp().sequence, m)).collect();
    let mut result = Compared {
        channel: row.output().name,
        answers: recorded.len(),
        identical: 0,
        first_difference: None,
        unknown: 0,
    };
    let life = |answered: &Envelope| answered.hops().restarts(row.hop());
    let mut step = new()?;
    let mut current = 0;
    let mut known = true;
    let mut previous: Option<&Envelope> = None;
    for answered in &recorded {
        if life(answered) != current {
            current = life(answered);
            step = new()?;
            // Its first answers may be in the gap too.
            known = !gap(previous, answered, &by_number);
        } else if gap(previous, answered, &by_number) {
            known = false;
        }
        previous = Some(answered);
        let sample = by_number.get(&answered.stamp().sequence).filter(|_| known);
        let answer = sample.and_then(|sample| step.answer(sample));
        let Some(answer) = answer else {
            result.unknown += 1;
            continue;
        };
        match difference(&answer, answered) {
            None => result.identical += 1,
            Some(field) => {
                result
                    .first_difference
                    .get_or_insert((answered.stamp().sequence, field));
            }
        }
    }
    Ok(result)
}

/// Whether samples are missing from the recording between two answers, which the stage may have
/// read: neither they nor their answers are there, and it was not the source that was restarted.
fn gap(previous: Option<&Envelope>, next: &Envelope, inputs: &HashMap<u64, &Envelope>) -> bool {
    let first = previous.map_or(0, |p| p.stamp().sequence + 1);
    let same_source = previous.is_none_or(|p| p.stamp().epoch == next.stamp().epoch);
    same_source && (first..next.stamp().sequence).any(|number| !inputs.contains_key(&number))
}

/// Name of the first field of the message itself whose bits differ.
fn difference(a: &Envelope, b: &Envelope) -> Option<&'static str> {
    let same = |i: usize| match (a.get(i), b.get(i)) {
        (Some(a), Some(b)) => a.same_bits(b),
        (a, b) => a.is_none() && b.is_none(),
    };
    let fields = a.fields();
    (HEAD..fields.len())
        .find(|&i| !same(i))
        .map(|i| fields[i].name)
}

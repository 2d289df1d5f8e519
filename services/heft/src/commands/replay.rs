//! `heft replay`: recomputes every estimate of a recording from what its process read.
//!
//! A process answers each sample that reached it, in order, and begins with a new state when it is
//! restarted. The recording tells both, by the sequence numbers of the answers and by the life of
//! the stage that made them. So losses and restarts replay too. Only where the recording itself has
//! a gap (its logger was killed) the state behind the gap is unknown: what a stage answered after
//! it, until it began anew, cannot be checked, and is counted as such.

use std::collections::HashMap;
use std::path::Path;

use config::{Description, Kind};
use messages::channels::{
    Channel, EXCAVATOR_INERTIA_RLS, EXCAVATOR_INERTIA_UKF, EXCAVATOR_MOTION, EXCAVATOR_SENSORS,
    LOADER_CG_EKF, LOADER_CG_UKF, LOADER_SENSORS,
};
use messages::{HEAD, Hops, Message};
use recording::{Metadata, Reader};
use runtime::{Step, answer};

use crate::build;
use crate::cli::ReplayArgs;
use crate::failure::Failure;
use crate::parts;
use crate::pipeline;

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
    let reader = parts::open(&args.file)?;
    let metadata = reader.metadata();
    let other_build = build::difference(metadata);
    if let Some(builds) = &other_build {
        println!("{builds}");
    }
    let results = match description(metadata, &args.file)? {
        Description::Excavator(d) => excavator(&reader, metadata, &d)?,
        Description::Loader(d) => loader(&reader, metadata, &d)?,
    };
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
        return Err(Failure::answer_is_no(match other_build {
            Some(builds) => format!(
                "{different} estimates differ: {builds}\n  where: {}\n  what to do: replay it with the build that made it; another one may compute otherwise",
                args.file.display()
            ),
            None => format!("{different} estimates differ, though the same build made them"),
        }));
    }
    parts::tell_damage(&reader)
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
    let missing = |key: &str| {
        Failure::input(
            format!("the recording does not say its {key}"),
            file.display(),
            "replay a recording that `heft run` has made",
        )
    };
    let machine = metadata.get("machine").ok_or_else(|| missing("machine"))?;
    let kind = Kind::from_name(machine).ok_or_else(|| missing("machine"))?;
    let text = metadata
        .get("description")
        .ok_or_else(|| missing("description"))?;
    if metadata.get("description.sha256") != Some(&recording::sha256(text)) {
        println!("the description in the recording was changed after the run");
    }
    Ok(Description::parse(
        text,
        "the description in the recording",
        Some(kind),
    )?)
}

fn method<'a>(metadata: &'a Metadata, key: &str, default: &'a str) -> &'a str {
    metadata.get(key).map_or(default, String::as_str)
}

fn excavator(
    reader: &Reader,
    metadata: &Metadata,
    d: &config::Excavator,
) -> Result<Vec<Compared>, Failure> {
    let first = method(metadata, "first_method", "svf-rls");
    let second = method(metadata, "second_method", "auto");
    Ok(vec![
        compare(
            reader,
            &EXCAVATOR_SENSORS,
            &EXCAVATOR_MOTION,
            life_of_filter,
            || pipeline::excavator_filter(d),
        )?,
        compare(
            reader,
            &EXCAVATOR_MOTION,
            &EXCAVATOR_INERTIA_RLS,
            life_of_estimator,
            || pipeline::excavator_regression(d, first),
        )?,
        compare(
            reader,
            &EXCAVATOR_SENSORS,
            &EXCAVATOR_INERTIA_UKF,
            life_of_estimator,
            || pipeline::excavator_estimator(d, second),
        )?,
    ])
}

fn loader(
    reader: &Reader,
    metadata: &Metadata,
    d: &config::Loader,
) -> Result<Vec<Compared>, Failure> {
    let second = method(metadata, "second_method", "full");
    Ok(vec![
        compare(
            reader,
            &LOADER_SENSORS,
            &LOADER_CG_EKF,
            life_of_estimator,
            || pipeline::loader_baseline(d),
        )?,
        compare(
            reader,
            &LOADER_SENSORS,
            &LOADER_CG_UKF,
            life_of_estimator,
            || pipeline::loader_estimator(d, second),
        )?,
    ])
}

fn life_of_filter(hops: &Hops) -> u32 {
    hops.filter_restarts
}

fn life_of_estimator(hops: &Hops) -> u32 {
    hops.estimate_restarts
}

fn compare<S: Step>(
    reader: &Reader,
    input: &Channel,
    output: &'static Channel,
    life: fn(&Hops) -> u32,
    new: impl Fn() -> Result<S, Failure>,
) -> Result<Compared, Failure> {
    let samples: Vec<S::Input> = reader.messages(input.name)?;
    let recorded: Vec<S::Output> = reader.messages(output.name)?;
    let by_number: HashMap<u64, &S::Input> =
        samples.iter().map(|m| (m.stamp().sequence, m)).collect();
    let mut result = Compared {
        channel: output.name,
        answers: recorded.len(),
        identical: 0,
        first_difference: None,
        unknown: 0,
    };
    let mut step = new()?;
    let mut current = 0;
    let mut known = true;
    let mut previous: Option<&S::Output> = None;
    for answered in &recorded {
        if life(answered.hops()) != current {
            current = life(answered.hops());
            step = new()?;
            // Its first answers may be in the gap too.
            known = !gap(previous, answered, &by_number);
        } else if gap(previous, answered, &by_number) {
            known = false;
        }
        previous = Some(answered);
        let sample = by_number.get(&answered.stamp().sequence).filter(|_| known);
        let Some(sample) = sample else {
            result.unknown += 1;
            continue;
        };
        match difference(&answer(&mut step, sample), answered) {
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
fn gap<I, O: Message>(previous: Option<&O>, next: &O, inputs: &HashMap<u64, &I>) -> bool {
    let first = previous.map_or(0, |p| p.stamp().sequence + 1);
    let same_source = previous.is_none_or(|p| p.stamp().epoch == next.stamp().epoch);
    same_source && (first..next.stamp().sequence).any(|number| !inputs.contains_key(&number))
}

/// Name of the first field of the message itself whose bits differ.
fn difference<M: Message>(a: &M, b: &M) -> Option<&'static str> {
    let same = |i: usize| match (a.get(i), b.get(i)) {
        (Some(a), Some(b)) => a.same_bits(b),
        (a, b) => a.is_none() && b.is_none(),
    };
    (HEAD..M::FIELDS.len())
        .find(|&i| !same(i))
        .map(|i| M::FIELDS[i].name)
}

//! Golden data through C give the bits of the steps that the processes run.

mod common;

use config::{Excavator as ExcavatorDescription, Loader as LoaderDescription};
use heft_c::{Answer, Excavator, Loader, Machine};
use messages::{
    ExcavatorEstimate, ExcavatorSensors, LoaderEstimate, LoaderSensors, Message, Value,
};
use runtime::{Step, answer};
use steps::{excavator, loader};

fn golden(name: &str) -> String {
    format!(
        "{}/../../tests/golden/{name}.csv",
        env!("CARGO_MANIFEST_DIR")
    )
}

/// The rows as C takes them: NaN where the sample lacks a signal.
fn rows<M: Machine, S: Message>(messages: &[S]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for message in messages {
        let bits = message.bits_of("valid");
        for (i, signal) in M::SIGNALS.iter().enumerate() {
            let there = i == 0 || bits & 1 << (i - 1) != 0;
            let number = match message.number(signal.name) {
                Some(value) if there => value,
                // The boom's motion is a bit alone.
                None if there => 1.0,
                _ => f64::NAN,
            };
            bytes.extend(number.to_le_bytes());
        }
    }
    bytes
}

fn columns<S: Message>(messages: &[S]) -> u32 {
    messages[0].bits_of("columns")
}

/// What C answered, number by number, must be what the steps answered.
fn compare<M: Machine, E: Message, const N: usize>(bytes: &[u8], expected: &[E], what: &str) {
    let size = size_of::<Answer<N>>();
    assert_eq!(
        bytes.len(),
        size * expected.len(),
        "{what}: one answer per row"
    );
    let field = |e: &E, name: &str| e.field(name).expect("a field");
    for (row, (raw, message)) in bytes.chunks_exact(size).zip(expected).enumerate() {
        let word = |at: usize| u64::from_le_bytes(raw[at..at + 8].try_into().expect("8 bytes"));
        let half = |at: usize| u32::from_le_bytes(raw[at..at + 4].try_into().expect("4 bytes"));
        for (i, value) in M::VALUES.iter().enumerate() {
            let ours = f64::from_bits(word(8 * i));
            let theirs = field(message, value.name);
            // A time that is no number is refused; C gets 0 in its place.
            let no_time = value.name == "t" && !theirs.as_f64().is_finite() && ours == 0.0;
            let same = no_time || theirs.same_bits(Value::F64(ours));
            assert!(
                same && ours.is_finite(),
                "{what}: {} in row {row}: {ours} {theirs:?}",
                value.name
            );
        }
        assert_eq!(
            Value::U64(word(8 * N)),
            field(message, "refused"),
            "{what}: row {row}"
        );
        for (i, name) in ["flags", "estimated", "method", "reason"]
            .into_iter()
            .enumerate()
        {
            let ours = half(8 * N + 8 + 4 * i);
            assert_eq!(
                Value::U32(ours),
                field(message, name),
                "{what}: {name} in row {row}"
            );
        }
    }
}

fn through_c<M: Machine, S: Message>(
    program: &std::path::Path,
    method: &str,
    messages: &[S],
) -> Vec<u8> {
    let method = M::METHODS
        .iter()
        .position(|m| *m == method)
        .expect("a method");
    let arguments = [
        M::NAME.to_owned(),
        method.to_string(),
        columns(messages).to_string(),
    ];
    let output = common::run(program, &arguments, rows::<M, S>(messages));
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    output.stdout
}

fn all<S: Step>(mut step: S, inputs: &[S::Input]) -> Vec<S::Output>
where
    S::Input: Message,
    S::Output: Message,
{
    inputs
        .iter()
        .map(|input| answer(&mut step, input))
        .collect()
}

fn excavator_steps(method: &str, rows: &[ExcavatorSensors]) -> Vec<ExcavatorEstimate> {
    let d = ExcavatorDescription::default();
    if method.ends_with("rls") {
        let motions = all(excavator::FilterStep::new(&d).expect("a filter"), rows);
        let step = excavator::RegressionStep::new(&d, method).expect("a regression");
        all(step, &motions)
    } else {
        all(
            excavator::EstimatorStep::new(&d, method).expect("an estimator"),
            rows,
        )
    }
}

fn loader_steps(method: &str, rows: &[LoaderSensors]) -> Vec<LoaderEstimate> {
    let d = LoaderDescription::default();
    all(
        loader::EstimatorStep::new(&d, method).expect("an estimator"),
        rows,
    )
}

#[test]
fn every_excavator_method_gives_the_bits_of_the_processes() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = common::compile("tests/filter.c", folder.path());
    for file in [
        "excavator_input_base_case2",
        "excavator_input_bad",
        "excavator_input_drop",
    ] {
        let rows =
            recording::load::<messages::ExcavatorSensors>(golden(file), None).expect("golden data");
        let rows: Vec<ExcavatorSensors> = rows.into_iter().map(|(sensors, _)| sensors).collect();
        for method in Excavator::METHODS {
            let ours = through_c::<Excavator, _>(&program, method, &rows);
            let expected = excavator_steps(method, &rows);
            compare::<Excavator, _, { Excavator::VALUES.len() }>(
                &ours,
                &expected,
                &format!("{method} on {file}"),
            );
        }
    }
}

#[test]
fn every_loader_method_gives_the_bits_of_the_processes() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = common::compile("tests/filter.c", folder.path());
    for file in [
        "loader_input_S4_tierB",
        "loader_input_S6_60s_tierA",
        "loader_input_bad_20s",
    ] {
        let rows =
            recording::load::<messages::LoaderSensors>(golden(file), None).expect("golden data");
        let rows: Vec<LoaderSensors> = rows.into_iter().map(|(sensors, _)| sensors).collect();
        for method in Loader::METHODS {
            let ours = through_c::<Loader, _>(&program, method, &rows);
            let expected = loader_steps(method, &rows);
            compare::<Loader, _, { Loader::VALUES.len() }>(
                &ours,
                &expected,
                &format!("{method} on {file}"),
            );
        }
    }
}
